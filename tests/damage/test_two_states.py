"""What two states have in common, what changes that are no damage look like, and what reports say of them."""

import re
from itertools import product

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.inference import Search
from antires_rs.figures.report_parts import damage_rows, hypothesis_rows
from tests.damage.test_modes import measured as modes
from tests.support.campaign import some_of
from tests.support.wrong_chains import NOMINAL, N, chain, changed, measured, states, truth


def assess(now, before, **options):
    return ar.assess_damage(NOMINAL, now, baseline=before, **options)


def has_note(result, beginning):
    return any(note.startswith(beginning) for note in result.notes)


# -- Responses of one state only
def test_responses_of_one_state_only_are_told():
    before, now = states(60)
    result = assess(changed(now, dofs=range(4)), changed(before, dofs=range(1, 5)))
    assert has_note(result, "Measured now only: mass 0 (force at mass 0), mass 0 (force")
    assert has_note(result, "Measured intact only: mass 4")
    assert not any("only:" in note for note in assess(now, before).notes)


def test_states_with_no_response_in_common_are_refused():
    before, now = states(61)
    with pytest.raises(ar.InvalidInputError, match="mass 3.*wanted values at some of the dofs of measured"):
        assess(changed(now, dofs=(0, 1, 2)), changed(before, dofs=(3, 4)))


# -- Tests of the intact structure that contradict each other, scatter, or are one record
@pytest.mark.parametrize(("seed", "odd", "loss"), some_of([(62, 0, 0.1), (63, 1, 0.3), (64, 2, 0.7)]))
def test_the_odd_one_of_three_intact_tests_is_named(seed, odd, loss):
    rng, factors = truth(seed)
    before = [measured(chain(factors), rng) for _ in range(3)]
    before[odd] = measured(chain(factors, [0, loss, 0, 0, 0]), rng)
    result = assess(
        measured(chain(factors, (0, 0, 0.3, 0, 0)), rng), [each for test in before for each in test]
    )
    assert {nth // 2 for nth in result.assessment.odd_baselines} == {odd}
    nth = result.assessment.odd_baselines[0]
    assert result.headline.startswith(f"The baseline contradicts itself: baseline set {nth} differs")


def test_of_two_that_disagree_none_is_named_alone():
    rng, factors = truth(65)
    before = [measured(chain(factors, losses), rng)[0] for losses in (None, [0, 0.3, 0, 0, 0])]
    result = assess(measured(chain(factors, (0, 0, 0.3, 0, 0)), rng)[:1], before)
    assert result.assessment.odd_baselines == (0, 1)
    assert "which of them is wrong cannot be told" in result.headline


def test_baselines_that_are_scaled_give_no_confident_damage():
    before, now = states(91, (0, 0, 0, 0, 0.3))
    headline = assess(now, [*before, *changed(before, 1.03)]).headline
    assert headline.startswith("The baseline contradicts itself")
    assert "If the baseline can be trusted at all, " in headline
    assert "Probability" not in headline
    assert "%" not in headline.split("If the baseline")[1]


@pytest.mark.parametrize("seed", some_of(range(66, 76), 3))
def test_ordinary_scatter_between_tests_is_no_contradiction(seed):
    rng, factors = truth(seed)
    # The third is three times as noisy.
    before = [each for std in (3e-4, 3e-4, 1e-3) for each in measured(chain(factors), rng, std=std)]
    now = measured(chain(factors, (0, 0, 0.3, 0, 0)), rng)
    assert assess(now, before).assessment.odd_baselines == ()


NOTE = "[1] repeats the values of "
SMALL = (0, 0.02, 0, 0, 0)


def of_modes(model, rng):
    found = model.modes()
    hz = found.freq_hz * (1.0 + 3e-4 * rng.standard_normal(N))
    return ar.ModalSet(hz, found.shapes, range(N), std_hz=3e-4 * hz)


def of_zeros(model, rng):
    return measured(model, rng, forces=(0,))[0]


@pytest.fixture(scope="module", params=[of_zeros, of_modes])
def tests(request):
    """An intact test, one of a small damage, and another one of the same damage."""
    rng, factors = truth(611)
    return [request.param(chain(factors, losses), rng) for losses in (None, SMALL, SMALL)]


def figures(result):
    return [(one.elements, one.probability, one.severities) for one in result.hypotheses]


def test_one_record_given_twice_counts_once_and_two_tests_twice(tests):
    before, now, again = tests
    once, twice, repeated = (assess(sets, before) for sets in ([now], [now, now], [now, again]))
    assert figures(twice) == figures(once) != figures(repeated)
    assert has_note(twice, "measured" + NOTE)
    assert not any(NOTE in note for note in [*once.notes, *repeated.notes])
    assert twice.table.measured_hz.size == once.table.measured_hz.size
    assert twice.assessment.n_values == once.assessment.n_values
    assert repeated.assessment.n_values == 2 * once.assessment.n_values
    twice = assess(now, [before, before])
    assert figures(twice) == figures(once)
    assert has_note(twice, "baseline" + NOTE)
    assert twice.assessment.n_baselines == 1
    if isinstance(now, ar.AntiresonanceSet):
        assessor = ar.Assessor(NOMINAL, baseline=before, workers=1)
        once, twice, repeated = (assessor.assess(sets) for sets in ([now], [now, now], [now, again]))
        assert figures(twice) == figures(once) != figures(repeated)
        assert has_note(twice, "zeros" + NOTE)


def test_one_record_cut_into_overlapping_sets():
    """The response that both have is of one record; the others count."""
    before, now = states(611, SMALL)
    parts = [*changed(now[:1], dofs=(0, 1, 2)), *changed(now[:1], dofs=(2, 3, 4, 5))]
    cut, whole = assess(parts, before), assess(now[0], before)
    assert cut.assessment.n_values == whole.assessment.n_values == sum(map(len, now[0].values()))
    assert figures(cut)[0][1] == pytest.approx(figures(whole)[0][1], abs=1e-6)


# -- Changes that are no damage
@pytest.mark.parametrize(("seed", "by"), [(81, -0.008), (82, 0.005)])
def test_all_values_moved_alike_is_temperature_or_clock(seed, by):
    before, now = states(seed, np.zeros(N - 1))
    result = assess(changed(now, 1.0 + by), before)
    way = "higher" if by > 0.0 else "lower"
    assert result.damaged == []
    assert result.hypotheses[0].unknown
    (note,) = (each for each in result.notes if each.startswith("All values are"))
    assert abs(float(note.split()[3]) - 100.0 * abs(by)) < 0.05
    assert way in note
    assert result.headline.startswith("No damage found: all values are 0.")
    assert f"{way} than in the intact state, as another temperature or sampling clock" in result.headline
    damaged = assess(*reversed(states(seed, (0, 0, 0.2, 0, 0))))
    assert damaged.damaged == [2]
    assert not has_note(damaged, "All values")


QUESTION = "are the sets swapped, or has something been stiffened?"


@pytest.mark.parametrize(
    ("seed", "kind"),
    some_of(product((110, 111, 112), (measured, modes)), [(110, measured), (112, measured), (111, modes)]),
)
def test_swapped_sets_are_asked_about(seed, kind):
    loss = {110: 0.1, 111: 0.3, 112: 0.5}[seed]
    rng, factors = truth(seed)
    losses = loss * np.eye(5)[seed % 5]
    intact, hurt = kind(chain(factors), rng), kind(chain(factors, losses), rng)
    swapped = assess(intact, hurt)
    assert swapped.damaged == []
    assert QUESTION in swapped.headline
    assert swapped.assessment.n_risen >= 0.75 * swapped.assessment.n_moved > 0
    assert QUESTION not in assess(hurt, intact).headline


def test_a_mass_that_was_added_is_no_damage_and_lowers_values():
    rng, factors = truth(31)
    heavier = factors.copy()
    heavier[4] *= 1.3
    result = assess(measured(chain(heavier), rng), measured(chain(factors), rng))
    assert result.hypotheses[0].unknown or not result.assessment.explained
    assert result.probability_of_damage > 0.99
    assert QUESTION not in result.headline
    assert any("which no element explains" in note for note in result.notes)
    assert not any("Left unexplained" in note for note in result.notes)


# -- Roots that the model loses on the way to a damage
#: The cracked element of the exhaust, and the stiffness losses of a beam that its cracks come to.
CRACKED, EQUIVALENT = 30, {1: 0.881, 2: 0.934}


@pytest.mark.parametrize("level", some_of([1, 2]))
def test_the_likelihood_has_no_cliff_where_two_roots_of_the_model_meet(level):
    """At 85.8 % two roots of the model, never updated, vanish whose values are still measured."""
    case, sets = ar.cases.exhaust(), []
    for each in (0, level):
        rng, exact = np.random.default_rng(50 + each), case.exact(level=each)
        freq = {dof: f * (1.0 + 5e-4 * rng.standard_normal(len(f))) for dof, f in exact.items()}
        std = {dof: 5e-4 * f for dof, f in freq.items()}
        sets.append(ar.AntiresonanceSet(exact.excitation, freq, std_hz=std))
    result = ar.assess_damage(case.model, sets[1], baseline=sets[0], elements=[CRACKED])
    likelihood = result._question.prepared(1).likelihood
    grid = np.arange(0.80, 0.94, 0.005)
    betas = np.zeros((grid.size, likelihood.n))
    betas[:, 0] = grid
    found = np.array([view.log_likelihood for view in likelihood.views(betas)])
    assert np.abs(np.diff(found)).max() < 3.5  # 13 and more where values of lost roots were false ones
    assert found.max() - np.interp(EQUIVALENT[level], grid, found) < 5.5


# -- What tables and reports say
def test_what_explains_but_was_no_candidate_is_in_the_table_and_nothing_is_left_unexplained():
    before, now = states(30)
    result = assess(now, before, elements=[0, 1, 3, 4])
    assert (result.damaged, result.assessment.explained) == ([], True)
    assert max(result.probability.values()) < 0.1
    assert result.probability_elsewhere > 0.9
    assert "none of the candidates explains" in result.headline
    assert "spring 2" in result.headline.lower()
    last = damage_rows(result, {2: 0.3})[-1]
    assert last["name"] == "spring 2, no candidate"
    assert abs(float(last["value"]) - 30.0) < 3.0
    assert (last["truth"], last["damaged"]) == ("30.0", True)
    told = " ".join(result.notes)
    assert "Left unexplained" not in told
    assert "Largest changes against the intact structure, which no candidate explains" in told
    names = [row["name"] for row in damage_rows(assess(now, before), None)]
    assert names == [f"spring {n}" for n in range(5)]


def test_what_cannot_be_told_apart_stands_side_by_side_in_the_tables():
    """Two equal springs in parallel: none of them is printed as the answer with the other at 0."""
    intact, hurt = (ar.MassSpringChain(np.ones(4), [500.0, k, 500.0]) for k in (500.0, 400.0))
    halves = []
    for n in np.repeat(range(3), 2):
        half = np.zeros((4, 4))
        half[n : n + 2, n : n + 2] = 250.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        halves.append(half)
    model = ar.MatrixModel(intact.stiffness(), intact.mass(), stiffness_terms=halves)
    before, now = (
        ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances(range(4), 0)))) for m in (intact, hurt)
    )
    result = ar.assess_damage(model, now, baseline=before)
    assert sorted(one.elements for one in result.assessment.group) == [(2,), (3,)]
    rows = {row["name"]: row for row in damage_rows(result, None)}
    first, other = rows["element 2"], rows["element 3"]
    assert [first["damaged"], other["damaged"]] == [True, True]
    assert sorted(row["value"].startswith("or ") for row in (first, other)) == [False, True]
    assert first["interval"] == other["interval"] != ""
    hits = [row["name"] for row in hypothesis_rows(result.assessment)[0] if row["hit"]]
    assert sorted(hits) == ["element 2", "element 3"]


def test_a_search_that_ctrl_c_stops_says_so_first(monkeypatch, tmp_path):
    before, now = states(90)

    def ctrl_c(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "_refine", ctrl_c)
    stopped = assess(now, before)
    assert not stopped.success
    assert stopped.headline.startswith("The search was stopped: ")
    assert not re.search(r"probability [\d a]|above 99", stopped.headline)
    stopped.save(tmp_path / "run.npz")
    assert ar.DamageResult.load(tmp_path / "run.npz").headline == stopped.headline
