"""What two states have in common, tests of one state that contradict each other, and what reports say."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.hypotheses import loss
from antires_rs.figures.report_parts import damage_rows, hypothesis_rows
from tests.support.wrong_chains import NOMINAL, chain, measured, truth


def only(sets, dofs):
    return [
        ar.AntiresonanceSet(s.excitation, {d: s[d] for d in dofs}, std_hz={d: s.std_hz[d] for d in dofs})
        for s in sets
    ]


def states(seed, losses=(0, 0, 0.3, 0, 0), n_intact=1):
    rng, factors = truth(seed)
    intact = [each for _ in range(n_intact) for each in measured(chain(factors), rng)]
    return intact, measured(chain(factors, losses), rng), rng, factors


def test_responses_of_one_state_only_are_told():
    before, now, _, _ = states(60)
    notes = ar.assess_damage(NOMINAL, only(now, range(4)), baseline=only(before, range(1, 5))).notes
    assert any(
        note.startswith("Measured now only: mass 0 (force at mass 0), mass 0 (force") for note in notes
    )
    assert any(note.startswith("Measured intact only: mass 4") for note in notes)
    told = ar.assess_damage(NOMINAL, now, baseline=before).notes
    assert not any("only:" in note for note in told)


def test_states_with_no_response_in_common_are_refused():
    before, now, _, _ = states(61)
    with pytest.raises(ar.InvalidInputError, match="mass 3.*wanted values at some of the dofs of measured"):
        ar.assess_damage(NOMINAL, only(now, (0, 1, 2)), baseline=only(before, (3, 4)))


@pytest.mark.parametrize(("seed", "odd", "loss"), [(62, 0, 0.1), (63, 1, 0.3), (64, 2, 0.7)])
def test_the_odd_one_of_three_intact_tests_is_named(seed, odd, loss):
    before, now, rng, factors = states(seed, n_intact=3)
    before[2 * odd : 2 * odd + 2] = measured(chain(factors, [0, loss, 0, 0, 0]), rng)
    result = ar.assess_damage(NOMINAL, now, baseline=before)
    assert {nth // 2 for nth in result.assessment.odd_baselines} == {odd}
    nth = result.assessment.odd_baselines[0]
    assert result.headline.startswith(f"The baseline contradicts itself: baseline set {nth} differs")


def test_of_two_that_disagree_none_is_named_alone():
    before, now, rng, factors = states(65)
    before = [before[0], measured(chain(factors, [0, 0.3, 0, 0, 0]), rng)[0]]
    result = ar.assess_damage(NOMINAL, now[:1], baseline=before)
    assert result.assessment.odd_baselines == (0, 1)
    assert "which of them is wrong cannot be told" in result.headline


@pytest.mark.parametrize("seed", range(66, 76))
def test_ordinary_scatter_between_tests_is_no_contradiction(seed):
    before, now, rng, factors = states(seed, n_intact=2)
    third = measured(chain(factors), rng, std=1e-3)  # three times as noisy
    assert ar.assess_damage(NOMINAL, now, baseline=[*before, *third]).assessment.odd_baselines == ()


def test_what_explains_but_was_no_candidate_is_in_the_table_and_nothing_is_left_unexplained():
    before, now, _, _ = states(30)
    result = ar.assess_damage(NOMINAL, now, baseline=before, elements=[0, 1, 3, 4])
    assert result.assessment.explained
    last = damage_rows(result, {2: 0.3})[-1]
    assert last["name"] == "spring 2, no candidate"
    assert abs(float(last["value"]) - 30.0) < 3.0
    assert (last["truth"], last["damaged"]) == ("30.0", True)
    told = " ".join(result.notes)
    assert "Left unexplained" not in told
    assert "Largest changes against the intact structure, which no candidate explains" in told
    all_of_them = ar.assess_damage(NOMINAL, now, baseline=before)
    assert [row["name"] for row in damage_rows(all_of_them, None)] == [f"spring {n}" for n in range(5)]


def test_a_change_of_unknown_kind_is_not_called_unexplained_by_the_damage():
    rng, factors = truth(31)
    shifted = measured(chain(factors), rng)
    shifted = [
        ar.AntiresonanceSet(
            s.excitation,
            {d: s[d] * (1.0 + 0.05 * np.sin(7.0 * d + np.arange(s[d].size))) for d in s},
            std_hz={d: s.std_hz[d] for d in s},
        )
        for s in shifted
    ]
    result = ar.assess_damage(NOMINAL, shifted, baseline=measured(chain(factors), rng))
    assert result.hypotheses[0].unknown
    assert not result.assessment.explained
    assert any("which no element explains" in note for note in result.notes)
    assert not any("Left unexplained" in note for note in result.notes)


def test_what_cannot_be_told_apart_stands_side_by_side_in_the_tables():
    """Two equal springs in parallel: none of them is printed as the answer with the other at 0."""
    chain_of_four = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    halves = []
    for n in range(3):
        half = np.zeros((4, 4))
        half[n : n + 2, n : n + 2] = 250.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        halves += [half, half]
    model = ar.MatrixModel(chain_of_four.stiffness(), chain_of_four.mass(), stiffness_terms=halves)
    hurt = ar.MassSpringChain(np.ones(4), [500.0, 400.0, 500.0])
    before, now = (
        ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances(range(4), 0)))) for m in (chain_of_four, hurt)
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


def test_a_loss_is_printed_within_its_interval():
    assert loss(0.0004, 0.0001, 0.0011) == "0.04 (0.01 to 0.11)"
    assert loss(0.3996, 0.3991, 0.4000, " %") == "39.96 % (39.91 to 40.00)"
