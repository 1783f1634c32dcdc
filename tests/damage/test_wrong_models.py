"""Wrong units, exchanged matrices, wrong dofs: the first sentence says that the model explains nothing.

The limits were set on the structures SET_ON of reference/wrong_models.py; these are the others.
"""

import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.model_check import unit_hint
from reference.wrong_models import JUDGED_ON, MISTAKES, ONLY_FRAMES
from tests.support.wrong_chains import changed

SAID = "The model does not explain the measurement"
CHAIN, FRAME = JUDGED_ON
#: What the sentence has to name, by mistake.
NAMED = {
    "springs in N/mm, modulus in kPa": "N/mm for N/m",
    "masses in tonnes": "tonnes for kg",
    "frequencies in kHz": "kHz in place of Hz",
    "frequencies in rad/s": "rad/s in place of Hz",
    "frequencies in rpm": "revolutions per minute",
    "K and M swapped": "K and M swapped",
    "lengths in mm": "lengths in mm",
    "twice the sampling rate": "twice the true one",
}


def given(structure, mistake, seed=3):
    return MISTAKES[mistake](structure, *structure.states(seed, 0.03))


#: With a baseline no value of which is near a root of the model there is nothing to assess.
REFUSED = "got one that does not explain the measurement"
#: Mistakes after which that is so.
NOTHING_NEAR = {
    "springs in N/um, modulus in MPa",
    "masses in tonnes",
    "springs in N/mm, masses in tonnes",
    "frequencies in kHz",
    "lengths in mm",
    "K and M swapped",
}


def headline(model, now, **options):
    return ar.assess_damage(model, now, workers=1, **options).headline


@pytest.mark.parametrize("mistake", [each for each in MISTAKES if each not in ONLY_FRAMES])
def test_one_state_of_a_chain(mistake):
    model, _, now = given(CHAIN, mistake)
    said = headline(model, now, rng=0)
    assert said.startswith(SAID)
    assert "No damage found" not in said
    assert NAMED.get(mistake, "") in said


@pytest.mark.parametrize("mistake", MISTAKES)
def test_two_states_of_a_frame(mistake):
    model, before, now = given(FRAME, mistake)
    if mistake in NOTHING_NEAR:
        with pytest.raises(ar.exceptions.InvalidInputError, match=REFUSED) as raised:
            headline(model, now, baseline=before)
        assert raised.value.argument == "model"
        said = str(raised.value)
    else:
        said = headline(model, now, baseline=before)
        assert said.startswith(SAID)
    assert "No damage found" not in said
    assert NAMED.get(mistake, "") in said


@pytest.mark.parametrize("loss", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
def test_a_right_model_keeps_its_headline(structure, seed, loss):
    elements = structure.build().default_elements
    before, now = structure.states(seed, 0.05, {elements[2 * seed]: loss} if loss else None)
    for options in ({"baseline": before}, {"rng": 0}):
        assert SAID not in headline(structure.build(), now, **options)


def test_a_fifth_of_the_values_not_identified_and_a_tenth_false():
    def spoiled(each, dof):
        found = [f for i, f in enumerate(each[dof]) if (i + dof) % 5]
        return sorted(found + [61.0] * (dof in (2, 7)))

    before, now = (
        [ar.AntiresonanceSet(each.excitation, {dof: spoiled(each, dof) for dof in each}) for each in sets]
        for sets in CHAIN.states(5, 0.05)
    )
    for options in ({"baseline": before}, {"rng": 0}):
        assert SAID not in headline(CHAIN.build(), now, **options)


def test_tables_show_a_dash_and_not_nan():
    model, _, now = given(CHAIN, "masses in tonnes")
    result = ar.assess_damage(model, now, rng=0, workers=1)
    text = f"{result.summary()} {result!r} {result.table}"
    assert not re.search(r"\bnan\b", text)
    assert "none, no value has a partner in the model" in text
    assert text.startswith(SAID)


def test_updating_says_so_in_its_first_note():
    model, _, now = given(CHAIN, "springs in N/mm, modulus in kPa")
    springs = ar.stiffness_factor(list(range(8)), bounds=(0.7, 1.3))
    search = ar.IslandGA(max_evaluations=2000)
    result = ar.update(ar.UpdatingProblem(model, springs, now), optimizer=search, rng=0, workers=1)
    notes = [note for note in result.notes if not note.startswith("The search")]
    assert notes[0].startswith(SAID)
    assert "N/mm for N/m" in notes[0]
    right = ar.update(ar.UpdatingProblem(CHAIN.build(), springs, now), optimizer=search, rng=0, workers=1)
    assert not any(SAID in note for note in right.notes)


def test_modes_in_rad_per_s():
    truth = CHAIN.truth(np.random.default_rng(0), 0.03)
    modes = truth.modes(5)
    wrong = ar.ModalSet(6.283185307 * modes.freq_hz, modes.shapes, modes.dofs)
    assert headline(CHAIN.build(), wrong, rng=0).startswith(SAID)
    assert SAID not in headline(CHAIN.build(), modes, rng=0)
    assert "rad/s" in unit_hint(CHAIN.build(), {None: wrong.freq_hz})


def test_no_hint_where_nothing_is_constant_or_near_one():
    model, _, now = given(CHAIN, "dofs reversed")
    measured = {(dof, each.excitation): each[dof] for each in now for dof in each if len(each[dof])}
    assert unit_hint(model, measured) == ""
    freq = CHAIN.build().modes().freq_hz
    assert "times those of the model" in unit_hint(CHAIN.build(), {None: 1.25 * freq})
    assert [unit_hint(CHAIN.build(), {None: ratio * freq}) for ratio in (0.93, 1.0, 1.08)] == [""] * 3


@pytest.mark.parametrize(("factor", "named"), [(1e-3, "kHz"), (6.283185307, "rad/s"), (2.0, "sampling rate")])
@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
def test_a_mistake_with_the_values_of_now_alone(structure, factor, named):
    before, now = structure.states(4, 0.03)
    wrong = changed(now, factor, std=factor)
    model = structure.build()
    full = headline(model, wrong, baseline=before)
    for said in (full, ar.Assessor(model, baseline=before, workers=1).assess(wrong).headline):
        assert said.startswith(SAID)
        assert "of now are about" in said
        assert named in said
        assert "If the model can be trusted at all" in said


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_support_that_the_model_does_not_have(seed):
    """An L-shaped frame clamped at both ends, its model at one."""
    nodes = [(0.0, 0.5 * k) for k in range(5)] + [(0.4 * k, 2.0) for k in range(1, 5)]
    places = [(0.0, 0.0), *nodes[1:]]
    lines = [(k, k + 1) for k in range(8)]

    def build(fixed, factor=1.0):
        sections = [ar.Tube(0.06, 0.004, 2.1e11 * f, 7850.0) for f in np.broadcast_to(factor, 8)]
        return ar.FrameModel(np.array(places), lines, sections, fixed=fixed)

    rng, dofs = np.random.default_rng(seed), [1, 3, 6, 7, 9, 10, 13, 16, 18]
    truth = build([0, 8], 1.0 + 0.03 * rng.uniform(-1.0, 1.0, 8))
    exact = truth.antiresonances(dofs, 7, f_max_hz=500.0)
    before, now = (
        ar.AntiresonanceSet(
            7, {d: f * (1.0 + 3e-4 * rng.standard_normal(f.size)) for d, f in zip(dofs, exact, strict=True)}
        )
        for _ in range(2)
    )
    assert headline(build([0]), now, baseline=before).startswith(SAID)
    assert SAID not in headline(build([0, 8]), now, baseline=before)
