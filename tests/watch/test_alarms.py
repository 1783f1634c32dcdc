"""Alarms: their rate, what they find, and that they end with the change.

Limits were set on random eight- and fourteen-mass chains of other seeds; here is a chain of six.
"""

import numpy as np
import pytest

import antires_rs as ar
from tests.watch.drawn_tests import STD, chain, drawn, exact, many

INTACT, DAMAGED = exact(chain()), exact(chain(0.01))


@pytest.fixture(scope="module")
def baseline_sets():
    """60 intact tests."""
    return many(INTACT, 60, np.random.default_rng(24))


@pytest.mark.parametrize(
    "options", [{}, {"tails": 4}, {"missed": 0.08}], ids=["normal", "heavy tails", "missing"]
)
def test_intact_tests_alarm_at_the_stated_rate(options):
    """Of 200 tests after two baselines: 2 % stated, one point more at most, and not never."""
    rng = np.random.default_rng(11)
    alarms = [
        ar.monitor(many(INTACT, 160, rng, **options), baseline=60, false_alarm_rate=0.02).alarm[60:]
        for _ in range(2)
    ]
    rate = np.mean(alarms)
    assert 0.0005 < rate < 0.03, rate


def test_the_rate_follows_the_argument():
    rng = np.random.default_rng(12)
    sets = many(INTACT, 260, rng)
    low, high = (ar.monitor(sets, baseline=100, false_alarm_rate=rate).alarm[100:] for rate in (0.005, 0.15))
    assert low.mean() < 0.015
    assert 0.05 < high.mean() < 0.2


def test_each_test_by_itself_and_not_latched():
    rng = np.random.default_rng(13)
    damaged = np.zeros(120, dtype=bool)
    damaged[60:80] = damaged[85:120:3] = True
    sets = [drawn(DAMAGED if loss else INTACT, rng) for loss in damaged]
    watched = ar.monitor(sets, baseline=slice(0, 60))
    assert watched.alarm[damaged].mean() > 0.95
    assert watched.alarm[60:][~damaged[60:]].sum() <= 2
    assert np.array_equal(watched.alarm, np.nan_to_num(watched.statistic) > watched.limit)
    assert np.all(watched.charts["T2"].ratio[damaged] > 0.5)


def test_small_changes_are_seen_by_the_mean():
    rng = np.random.default_rng(14)
    small = exact(chain(0.002))
    sets = many(INTACT, 60, rng) + many(small, 60, rng)
    watched = ar.monitor(sets, baseline=60)
    assert watched.charts["T2"].ratio[60:].max() < 2.0
    assert np.mean(watched.charts["T2"].ratio[60:] > 1.0) < 0.5
    assert watched.alarm[80:].mean() > 0.8
    assert "EWMA" in watched.why(119)


def test_baseline_may_be_anywhere():
    rng = np.random.default_rng(15)
    sets = many(INTACT, 70, rng) + many(DAMAGED, 5, rng)
    expected = ar.monitor(sets, baseline=slice(0, 60))
    for given in (60, range(60), np.arange(75) < 60):
        again = ar.monitor(sets, baseline=given)
        assert np.array_equal(again.statistic, expected.statistic)
    turned = ar.monitor(sets[::-1], baseline=slice(15, 75))
    assert turned.alarm[:5].all()
    assert turned.alarm[5:15].sum() <= 1


def test_failed_tests_are_false_and_listed():
    rng = np.random.default_rng(16)
    sets = many(INTACT, 55, rng) + [None] + many(DAMAGED, 3, rng)
    sets[3] = None
    watched = ar.monitor(sets, baseline=55)
    assert watched.alarm.shape == (59,)
    assert not watched.alarm[[3, 55]].any()
    assert set(watched.failed) == {3, 55}
    assert watched.alarm[56:].all()


@pytest.mark.parametrize("missed", [0.0, 0.05])
def test_a_value_that_vanishes_or_appears_alarms(missed):
    rng = np.random.default_rng(17)
    fewer = INTACT | {1: INTACT[1][:-1], 2: INTACT[2][:-1], 0: INTACT[0][1:]}
    more = INTACT | {4: np.append(INTACT[4], 75.0), 5: np.array([50.0]), 1: np.append(INTACT[1], 3.0)}
    parts = [
        many(values, count, rng, missed=missed) for values, count in ((INTACT, 320), (fewer, 5), (more, 5))
    ]
    watched = ar.monitor(sum(parts, []), baseline=120)
    assert watched.alarm[120:320].mean() < 0.03
    # From the second test on the same is missing again.
    assert watched.alarm[321:325].all()
    assert watched.alarm[326:330].all()
    assert all("events" in watched.why(i) for i in (322, 327))


def test_many_values_and_few_tests():
    """42 values, 30 tests: the sample covariance is singular."""
    rng = np.random.default_rng(18)
    n = 9
    springs, masses = 5e4 * rng.uniform(0.8, 1.2, n - 1), rng.uniform(0.8, 1.2, n)
    lost = springs.copy()
    lost[3] *= 0.98
    intact, damaged = (exact(ar.MassSpringChain(masses, k)) for k in (springs, lost))
    assert sum(map(len, intact.values())) > 30
    sets = many(intact, 230, rng) + many(damaged, 20, rng)
    with pytest.warns(ar.AntiresWarning, match=r"baseline of 30 tests is short for 1 %.*with 50"):
        watched = ar.monitor(sets, baseline=30)
    assert watched.needed == 50
    assert watched.alarm[30:230].mean() < 0.02
    assert watched.alarm[230:].all()


def test_poor_tests_do_not_alarm():
    """A test ten times as inaccurate that says so."""
    rng = np.random.default_rng(19)
    sets = many(INTACT, 60, rng) + many(INTACT, 40, rng, std=10 * STD)
    assert ar.monitor(sets, baseline=60).alarm[60:].mean() <= 0.05


def test_the_same_bits_again_and_from_a_series():
    rng = np.random.default_rng(20)
    sets = many(INTACT, 60, rng, tails=5, missed=0.05)
    one, two = ar.monitor(sets, baseline=50), ar.monitor(ar.Series.from_sets(sets), baseline=50)
    assert one.statistic.tobytes() == two.statistic.tobytes()
    with pytest.raises(ValueError, match="read-only"):
        one.alarm[0] = True


def test_what_is_wrong_is_said():
    sets = many(INTACT, 12, np.random.default_rng(21))
    for wrong, options in (
        ("8", {"baseline": 5}),
        ("baseline", {"baseline": slice(100, 200)}),
        ("series", {"series": 3, "baseline": 10}),
        (r"series\[0\]", {"series": [3], "baseline": 10}),
        ("false_alarm_rate", {"baseline": 10, "false_alarm_rate": 0.5}),
        ("baseline: got True", {"baseline": True}),
        ("baseline: got -5", {"baseline": -5}),
        ("baseline: got 13", {"baseline": 13}),
        ("conditions", {"baseline": 10, "conditions": {"t": [1.0]}}),
        (r"conditions\['t'\]\[2\]: got inf", {"baseline": 10, "conditions": {"t": [0, 1, np.inf] + [2] * 9}}),
        ("elementz: got an unknown option", {"baseline": 10, "model": chain(), "elementz": 1}),
        (r"elements\[0\]: got 99", {"baseline": 10, "model": chain(), "elements": [99]}),
        ("gamma1", {"baseline": 10, "model": chain(), "gamma1": 0.1}),
        ("prior", {"baseline": 10, "model": chain(), "prior": 3}),
        ("std_common", {"baseline": 10, "model": chain(), "std_common": 3.0}),
        ("model", {"baseline": 10, "model": "chain"}),
        ("elements", {"baseline": 10, "elements": [0]}),
    ):
        with pytest.raises(ar.exceptions.InvalidInputError, match=wrong):
            ar.monitor(**({"series": sets} | options))


@pytest.mark.parametrize("factor", [0.9, 0.8, 0.2, None], ids=["0.9", "0.8", "0.2", "no values"])
def test_nothing_near_its_place_is_an_alarm(baseline_sets, factor):
    """All values moved together beyond reach, or gone: no T2, but the chart of events."""
    gone = {dof: f[:0] if factor is None else f * factor for dof, f in INTACT.items()}
    later = many(gone, 3, np.random.default_rng(22))
    watched = ar.monitor(baseline_sets + later, baseline=60, model=chain() if factor is None else None)
    assert watched.alarm[60:].all()
    assert "events" in watched.why(61)
    assert not watched.faults
    assert not watched.assessments
    if factor in (0.9, None):
        assert np.isnan(watched.charts["T2"].statistic[60:]).all()
        assert np.array_equal(watched.statistic[60:], watched.charts["events"].ratio[60:])
    assert "3 of 3 tests outside the baseline alarm" in str(watched)


def test_the_mean_keeps_its_share_where_values_are_missing():
    """A fifth of 1 %; with 30 % of the values missing it was 4 %."""
    rng = np.random.default_rng(23)
    watched = ar.monitor(many(INTACT, 450, rng, missed=0.3), baseline=150)
    assert np.mean(watched.charts["EWMA"].ratio[150:] > 1.0) < 0.01
    assert watched.alarm[150:].mean() < 0.02
