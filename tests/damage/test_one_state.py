"""Without a baseline: what an answer rests on, and a factor on all stiffnesses told from many losses."""

import re
from itertools import product

import numpy as np
import pytest

import antires_rs as ar
from reference.wrong_chains import NOMINAL, chain, changed, measured, truth
from reference.wrong_models import JUDGED_ON, MISTAKES, ONLY_FRAMES
from tests.support.campaign import some_of

UNLIKE = "The model does not explain the measurement"
SAID = f"{UNLIKE}: every stiffness would have to be multiplied by 0."
CHAIN, FRAME = JUDGED_ON


def test_an_intact_chain_beside_the_model_is_not_said_to_be_damaged_without_reserve():
    rng, factors = truth(95, off=0.05)
    result = ar.assess_damage(NOMINAL, measured(chain(factors), rng), rng=0)
    assert result.damaged  # the model's errors
    assert result.headline.startswith("It cannot be told whether there is damage: the model misses values")
    assert all(f"spring {e} has lost" in result.headline for e in result.damaged)
    assert "an error of the model comes out as damage" in result.headline
    assert "nothing has changed" not in result.headline
    exact = measured(chain(np.ones(12)), np.random.default_rng(96), std=1e-7)
    result = ar.assess_damage(NOMINAL, exact, rng=0)
    assert result.damaged == []
    assert result.headline.startswith("No damage found. Without a baseline it is not known")


def assessed(structure, off, losses, seed):
    _, now = structure.states(seed, off, losses)
    return ar.assess_damage(structure.build(), now, rng=0, workers=1)


@pytest.mark.parametrize("structure", JUDGED_ON, ids=lambda each: each.name)
@pytest.mark.parametrize(
    ("loss", "spread", "off"), some_of([(0.4, 0.02, 0.03), (0.15, 0.01, 0.0), (0.75, 0.0, 0.02)])
)
def test_nearly_equal_losses_of_all(structure, loss, spread, off):
    rng = np.random.default_rng(7)
    losses = {e: loss + spread * rng.uniform(-1.0, 1.0) for e in structure.build().default_elements}
    result = assessed(structure, off, losses, 7)
    assert result.headline.startswith(SAID)
    factor = float(result.headline.removeprefix(SAID[:-2]).split(",")[0])
    assert factor == pytest.approx(1.0 - loss, abs=0.03)
    assert "which is no finding" in result.headline


@pytest.mark.parametrize(
    ("structure", "off"), some_of(product(JUDGED_ON, (0.0, 0.03)), [(CHAIN, 0.03), (FRAME, 0.0)])
)
def test_damage_of_half_of_them_is_damage(structure, off):
    rng = np.random.default_rng(8)
    half = rng.permutation(structure.build().default_elements)[:4].tolist()
    for losses in ({e: 0.3 for e in half}, {e: float(rng.uniform(0.1, 0.6)) for e in half}):
        result = assessed(structure, off, losses, 8)
        assert "every stiffness" not in result.headline
        assert {e for e in result.damaged if result.severity[e] > 0.08} == set(half)
    assert "every stiffness" not in assessed(structure, 0.08, None, 9).headline


def test_modes_too():
    rng = np.random.default_rng(10)
    for losses, told in (({e: 0.3 for e in range(8)}, True), ({1: 0.3, 4: 0.2, 6: 0.4}, False)):
        modes = CHAIN.truth(rng, 0.01, losses).modes()
        assert ar.assess_damage(CHAIN.build(), modes, rng=0, workers=1).headline.startswith(SAID) is told
    modes = CHAIN.truth(np.random.default_rng(0), 0.03).modes(5)
    in_rad_per_s = ar.ModalSet(2.0 * np.pi * modes.freq_hz, modes.shapes, modes.dofs)
    assert headline(CHAIN.build(), in_rad_per_s, rng=0).startswith(UNLIKE)
    assert UNLIKE not in headline(CHAIN.build(), modes, rng=0)


# -- Wrong units, exchanged matrices, wrong dofs
#: What the sentence has to name, by mistake.
NAMED = {"springs in N/mm, modulus in kPa": "N/mm for N/m", "masses in tonnes": "tonnes for kg"}
NAMED |= {"frequencies in kHz": "kHz in place of Hz", "frequencies in rad/s": "rad/s in place of Hz"}
NAMED |= {"frequencies in rpm": "revolutions per minute", "K and M swapped": "K and M swapped"}
NAMED |= {"lengths in mm": "lengths in mm", "twice the sampling rate": "twice the true one"}


def given(structure, mistake, seed=3):
    return MISTAKES[mistake](structure, *structure.states(seed, 0.03))


#: With a baseline what makes all values wrong by one factor is refused before the work.
REFUSED = "got one that does not explain the measurement"
#: What is wrong otherwise takes the work to be seen.
LATER = {"degrees for radians", "dofs reversed", "dofs one further", "force at another dof"}


def headline(model, now, **options):
    return ar.assess_damage(model, now, workers=1, **options).headline


@pytest.mark.parametrize("mistake", [each for each in MISTAKES if each not in ONLY_FRAMES])
def test_one_state_of_a_chain(mistake):
    model, _, now = given(CHAIN, mistake)
    said = headline(model, now, rng=0)
    assert said.startswith(UNLIKE)
    assert "No damage found" not in said
    assert NAMED.get(mistake, "") in said


@pytest.mark.filterwarnings("ignore:.*(softer than rubber|light as foam)")  # which is right of these moduli
@pytest.mark.parametrize("mistake", some_of(MISTAKES, set(MISTAKES) - {"force at another dof"}))
def test_two_states_of_a_frame(mistake):
    model, before, now = given(FRAME, mistake)
    if mistake not in LATER:
        with pytest.raises(ar.exceptions.InvalidInputError, match=REFUSED) as raised:
            headline(model, now, baseline=before)
        assert raised.value.argument == "model"
        said = str(raised.value)
    else:
        said = headline(model, now, baseline=before)
        assert said.startswith(UNLIKE)
    assert "No damage found" not in said
    assert NAMED.get(mistake, "") in said


def test_a_large_model_in_other_units_is_refused_before_the_work(monkeypatch):
    def build(youngs_modulus_pa, density=7850.0):
        section = ar.Rectangle(0.05, 0.01, youngs_modulus_pa, density)
        nodes = [(2.0 * k / 230, 0.0) for k in range(231)]
        return ar.FrameModel(nodes, [(k, k + 1) for k in range(230)], section, fixed=[0, 230])

    exact = build(2.1e11)
    zeros = {f"{k} v": exact.antiresonances(f"{k} v", "90 v", f_max_hz=200.0) for k in (30, 70, 150)}
    found = ar.AntiresonanceSet("90 v", zeros)
    monkeypatch.setattr("antires_rs.damage.assess.infer", None)  # nothing is searched
    with pytest.warns(ar.AntiresWarning, match="210000 Pa is softer than rubber"):
        in_mpa = build(2.1e5)
    with pytest.warns(ar.AntiresWarning, match="3.925 kg/m3 is as light as foam"):
        per_length = build(2.1e11, 3.925)
    for model, named in ((in_mpa, "modulus in MPa for Pa"), (per_length, "mass per length")):
        with pytest.raises(ar.InvalidInputError, match=rf"^model: {REFUSED}.*{named}"):
            ar.assess_damage(model, found, baseline=found)


def test_an_error_of_numpy_is_one_of_ours(monkeypatch):
    def singular(*_):
        raise np.linalg.LinAlgError("Matrix is not positive definite")

    monkeypatch.setattr("antires_rs.damage.assess.infer", singular)
    before, now = CHAIN.states(1, 0.03)
    with pytest.raises(ar.NumericalError, match=r"^assessing damage failed: Matrix is not.*units"):
        ar.assess_damage(CHAIN.build(), now, baseline=before)


FIRST = [(CHAIN, 1, 0.0), (CHAIN, 2, 0.7), (FRAME, 3, 0.0), (FRAME, 1, 0.3)]


@pytest.mark.parametrize(
    ("structure", "seed", "loss"), some_of(product(JUDGED_ON, (1, 2, 3), (0.0, 0.3, 0.7)), FIRST)
)
def test_a_right_model_keeps_its_headline(structure, seed, loss):
    elements = structure.build().default_elements
    before, now = structure.states(seed, 0.05, {elements[2 * seed]: loss} if loss else None)
    for options in ({"baseline": before}, {"rng": 0}):
        assert UNLIKE not in headline(structure.build(), now, **options)


def test_tables_show_a_dash_and_not_nan():
    model, _, now = given(CHAIN, "masses in tonnes")
    result = ar.assess_damage(model, now, rng=0, workers=1)
    text = f"{result.summary()} {result!r} {result.table}"
    assert not re.search(r"\bnan\b", text)
    assert "none, no value has a partner in the model" in text
    assert text.startswith(UNLIKE)


def test_updating_says_so_in_its_first_note():
    model, _, now = given(CHAIN, "springs in N/mm, modulus in kPa")
    springs = ar.stiffness_factor(list(range(8)), bounds=(0.7, 1.3))
    search = ar.IslandGA(max_evaluations=2000)
    result = ar.update(ar.UpdatingProblem(model, springs, now), optimizer=search, rng=0, workers=1)
    notes = [note for note in result.notes if not note.startswith("The search")]
    assert notes[0].startswith(UNLIKE)
    assert "N/mm for N/m" in notes[0]
    right = ar.update(ar.UpdatingProblem(CHAIN.build(), springs, now), optimizer=search, rng=0, workers=1)
    assert not any(UNLIKE in note for note in right.notes)


NOW_ALONE = {"kHz": 1e-3, "rad/s": 6.283185307, "sampling rate": 2.0}


@pytest.mark.parametrize(
    ("structure", "named"),
    some_of(product(JUDGED_ON, NOW_ALONE), [(FRAME, "kHz"), (CHAIN, "rad/s"), (CHAIN, "sampling rate")]),
)
def test_a_mistake_with_the_values_of_now_alone(structure, named):
    before, now = structure.states(4, 0.03)
    wrong = changed(now, NOW_ALONE[named], std=NOW_ALONE[named])
    model = structure.build()
    full = headline(model, wrong, baseline=before)
    for said in (full, ar.Assessor(model, baseline=before, workers=1).assess(wrong).headline):
        assert said.startswith(UNLIKE)
        assert "of now are about" in said
        assert named in said
        assert "If the model can be trusted at all" in said


@pytest.mark.parametrize("seed", some_of([1, 2, 3]))
def test_a_support_that_the_model_does_not_have(seed):
    places = [(0.0, 0.5 * k) for k in range(5)] + [(0.4 * k, 2.0) for k in range(1, 5)]
    lines = [(k, k + 1) for k in range(8)]

    def build(fixed, factor=1.0):
        sections = [ar.Tube(0.06, 0.004, 2.1e11 * f, 7850.0) for f in np.broadcast_to(factor, 8)]
        return ar.FrameModel(np.array(places), lines, sections, fixed=fixed)

    rng, dofs = np.random.default_rng(seed), [1, 3, 6, 7, 9, 10, 13, 16, 18]
    tested = build([0, 8], 1.0 + 0.03 * rng.uniform(-1.0, 1.0, 8))
    exact = dict(zip(dofs, tested.antiresonances(dofs, 7, f_max_hz=500.0), strict=True))
    noisy = [{d: f * (1.0 + 3e-4 * rng.standard_normal(f.size)) for d, f in exact.items()} for _ in range(2)]
    before, now = (ar.AntiresonanceSet(7, hz) for hz in noisy)
    assert headline(build([0]), now, baseline=before).startswith(UNLIKE)
    assert UNLIKE not in headline(build([0, 8]), now, baseline=before)
