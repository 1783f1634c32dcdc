"""Damage against a baseline, the model wrong by some per cent: chains that nothing was tuned on."""

from __future__ import annotations

import numpy as np
import pytest

import antires_rs as ar
from tests.support.campaign import some_of
from tests.support.wrong_chains import NOMINAL, N, chain, measured, truth


@pytest.mark.parametrize("seed", range(4))
def test_an_intact_structure_is_intact_however_wrong_the_model(seed):
    rng, factors = truth(seed)
    result = ar.assess_damage(NOMINAL, measured(chain(factors), rng), baseline=measured(chain(factors), rng))
    assert result.damaged == []
    assert not result.x.any()
    assert result.probability_of_damage < 0.2
    assert result.headline.startswith("No damage found")


@pytest.mark.parametrize(("element", "loss"), [(0, 0.08), (1, 0.3), (2, 0.15), (3, 0.6), (4, 0.9)])
def test_one_damaged_spring_is_named_and_sized(element, loss):
    rng, factors = truth(10 + element)
    losses = np.zeros(N - 1)
    losses[element] = loss
    result = ar.assess_damage(
        NOMINAL, measured(chain(factors, losses), rng), baseline=measured(chain(factors), rng)
    )
    assert result.damaged == [element]
    assert result.probability[element] > 0.95
    low, high = result.interval[element]
    assert low < result.severity[element] < high < 1.0
    # Nine of ten intervals hold it; these are five, seen to hold with twice the width at least.
    assert abs(result.severity[element] - loss) < high - low
    assert high - low < 0.1


def test_two_and_three_damages_are_told_apart():
    for seed, damages in ((20, {1: 0.3, 4: 0.2}), (21, {0: 0.3, 2: 0.25, 3: 0.4})):
        rng, factors = truth(seed)
        losses = np.zeros(N - 1)
        losses[list(damages)] = list(damages.values())
        result = ar.assess_damage(
            NOMINAL, measured(chain(factors, losses), rng), baseline=measured(chain(factors), rng)
        )
        assert sorted(result.damaged) == sorted(damages)
        for element, loss in damages.items():
            assert abs(result.severity[element] - loss) < 0.03


def test_what_is_no_candidate_is_not_blamed_on_candidates():
    rng, factors = truth(30)
    now = measured(chain(factors, [0, 0, 0.3, 0, 0]), rng)
    result = ar.assess_damage(NOMINAL, now, baseline=measured(chain(factors), rng), elements=[0, 1, 3, 4])
    assert result.damaged == []
    assert max(result.probability.values()) < 0.1
    assert result.probability_elsewhere > 0.9
    assert "none of the candidates explains" in result.headline
    assert "spring 2" in result.headline.lower()


def test_a_change_that_no_stiffness_explains_is_unknown():
    rng, factors = truth(31)
    heavier = factors.copy()
    heavier[4] *= 1.3  # a mass was added
    result = ar.assess_damage(NOMINAL, measured(chain(heavier), rng), baseline=measured(chain(factors), rng))
    assert result.hypotheses[0].unknown or not result.assessment.explained
    assert result.probability_of_damage > 0.99


def test_probabilities_add_up_and_severities_are_those_of_the_first_hypothesis():
    rng, factors = truth(32)
    now = measured(chain(factors, [0, 0.1, 0, 0, 0]), rng)
    result = ar.assess_damage(NOMINAL, now, baseline=measured(chain(factors), rng))
    assert np.isclose(result.hypotheses.probability.sum(), 1.0, atol=1e-6)
    assert np.all(np.diff(result.hypotheses.probability) <= 0.0)
    best = result.hypotheses[0]
    found = dict(zip(best.elements, best.severities, strict=True))
    assert result.severity == {e: found.get(e, 0.0) for e in range(5)}
    assert result.chi_square < 3.0


def test_same_bits_for_any_number_of_workers():
    rng, factors = truth(33)
    sets = measured(chain(factors, [0.2, 0, 0, 0.1, 0]), rng), measured(chain(factors), rng)
    one, two = (
        ar.assess_damage(
            NOMINAL,
            sets[0],
            baseline=sets[1],
            search=ar.SearchOptions(false_alarm_rate=0.05),
            rng=1,
            workers=workers,
        )
        for workers in (1, 2)
    )
    assert one.x.tobytes() == two.x.tobytes()
    assert one.hypotheses.probability.tobytes() == two.hypotheses.probability.tobytes()
    assert one.assessment == two.assessment


# 0.2 of the tests, give or take three standard deviations.
@pytest.mark.parametrize(("tests", "fewest", "most"), some_of([(24, 1, 10), (60, 2, 21)]))
def test_a_rate_of_false_alarms_is_kept(tests, fewest, most):
    alarms = 0
    for seed in range(tests):
        rng, factors = truth(1000 + seed)
        before, now = measured(chain(factors), rng), measured(chain(factors), rng)
        result = ar.assess_damage(
            NOMINAL, now, baseline=before, search=ar.SearchOptions(false_alarm_rate=0.2), rng=seed
        )
        alarms += bool(result.damaged)
    assert fewest <= alarms <= most


# 0.9 of the tests less three standard deviations; all 60 would hold in one of 500 such runs.
@pytest.mark.parametrize(("tests", "fewest", "most"), some_of([(24, 18, 24), (60, 47, 59)]))
def test_intervals_hold_nine_of_ten(tests, fewest, most):
    held, widths = 0, []
    for seed in range(tests):
        rng, factors = truth(2000 + seed)
        losses = np.zeros(N - 1)
        element = seed % 5
        losses[element] = rng.uniform(0.1, 0.6)
        result = ar.assess_damage(
            NOMINAL, measured(chain(factors, losses), rng), baseline=measured(chain(factors), rng)
        )
        low, high = result.interval[element]
        held += low <= losses[element] <= high
        widths.append(high - low)
    assert fewest <= held <= most
    assert max(widths) < 0.01


def test_intact_tests_that_scatter_more_than_they_say_widen_everything():
    rng, factors = truth(40)
    tests = [measured(chain(factors), rng) for _ in range(3)]
    told = [
        ar.AntiresonanceSet(s.excitation, {d: s[d] for d in s}, std_hz={d: s.std_hz[d] / 5.0 for d in s})
        for test in tests
        for s in test
    ]
    now = [
        ar.AntiresonanceSet(s.excitation, {d: s[d] for d in s}, std_hz={d: s.std_hz[d] / 5.0 for d in s})
        for s in measured(chain(factors), rng)
    ]
    result = ar.assess_damage(NOMINAL, now, baseline=told)
    assert 3.5 < result.assessment.scatter < 7.0
    assert result.damaged == []


def test_options_of_the_other_way_are_refused():
    rng, factors = truth(50)
    sets = measured(chain(factors), rng)
    with pytest.raises(ar.InvalidInputError, match="gamma1"):
        ar.assess_damage(NOMINAL, sets, baseline=sets, search=ar.SearchOptions(gamma1=0.1))
    with pytest.raises(ar.InvalidInputError, match="false_alarm_rate"):
        ar.assess_damage(NOMINAL, sets, search=ar.SearchOptions(false_alarm_rate=0.05))
    with pytest.raises(ar.InvalidInputError, match="baseline"):
        ar.assess_damage(NOMINAL, sets, baseline=sets[:1])
    pairs_only = ar.DamagePrior(nothing=0.5, one=0.0, two=0.4, three=0.0, elsewhere=0.05, unknown=0.05)
    with pytest.raises(ar.InvalidInputError, match="false_alarm_rate.*one element alone"):
        ar.assess_damage(
            NOMINAL, sets, baseline=sets, prior=pairs_only, search=ar.SearchOptions(false_alarm_rate=0.05)
        )
    with pytest.raises(ar.InvalidInputError, match="prior"):
        ar.DamagePrior(nothing=0.9)
