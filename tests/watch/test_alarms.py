"""Alarms: their rate, what they find, that they end with the change, and that failed sensors make none.

Limits were set on random eight- and fourteen-mass chains of other seeds; here is a chain of six.
"""

from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from tests.support.snapshots import refusal, replay
from tests.watch.drawn_tests import STD, chain, drawn, exact, many

INTACT, DAMAGED = exact(chain()), exact(chain(0.01))


@pytest.fixture(scope="module")
def sets():
    return many(INTACT, 70, np.random.default_rng(41))


@pytest.mark.parametrize("options", [{}, {"tails": 4}, {"missed": 0.08}], ids=str)
def test_intact_tests_alarm_at_the_stated_rate(options):
    """Of 200 tests after two baselines: 2 % stated, one point more at most, and not never."""
    rng = np.random.default_rng(11)
    tests = [many(INTACT, 160, rng, **options) for _ in range(2)]
    rate = np.mean([ar.monitor(one, baseline=60, false_alarm_rate=0.02).alarm[60:] for one in tests])
    assert 0.0005 < rate < 0.03, rate


def test_the_rate_follows_the_argument():
    tests = many(INTACT, 260, np.random.default_rng(12))
    low, high = (ar.monitor(tests, baseline=100, false_alarm_rate=rate).alarm[100:] for rate in (0.005, 0.15))
    assert low.mean() < 0.015
    assert 0.05 < high.mean() < 0.2


def test_each_test_by_itself_and_not_latched():
    rng = np.random.default_rng(13)
    damaged = np.zeros(120, dtype=bool)
    damaged[60:80] = damaged[85:120:3] = True
    watched = ar.monitor([drawn(DAMAGED if loss else INTACT, rng) for loss in damaged], baseline=slice(0, 60))
    assert watched.alarm[damaged].mean() > 0.95
    assert watched.alarm[60:][~damaged[60:]].sum() <= 2
    assert np.array_equal(watched.alarm, np.nan_to_num(watched.statistic) > watched.limit)
    assert np.all(watched.charts["T2"].ratio[damaged] > 0.5)


def test_small_changes_are_seen_by_the_mean():
    rng = np.random.default_rng(14)
    watched = ar.monitor(many(INTACT, 60, rng) + many(exact(chain(0.002)), 60, rng), baseline=60)
    assert watched.charts["T2"].ratio[60:].max() < 2.0
    assert np.mean(watched.charts["T2"].ratio[60:] > 1.0) < 0.5
    assert watched.alarm[80:].mean() > 0.8
    assert "EWMA" in watched.why(119)


def test_a_baseline_may_be_anywhere_and_a_series_or_sets(sets):
    tests = sets + many(DAMAGED, 5, np.random.default_rng(15))
    expected = ar.monitor(tests, baseline=slice(0, 60))
    for given in (60, range(60), np.arange(75) < 60):
        again = ar.monitor(ar.Series.from_sets(tests), baseline=given)
        assert again.statistic.tobytes() == expected.statistic.tobytes()
    turned = ar.monitor(tests[::-1], baseline=slice(15, 75))
    assert turned.alarm[:5].all()
    assert turned.alarm[5:15].sum() <= 1
    with pytest.raises(ValueError, match="read-only"):
        turned.alarm[0] = True


@pytest.mark.parametrize("missed", [0.0, 0.05])
def test_a_value_that_vanishes_or_appears_alarms(missed):
    rng = np.random.default_rng(17)
    fewer = INTACT | {1: INTACT[1][:-1], 2: INTACT[2][:-1], 0: INTACT[0][1:]}
    more = INTACT | {4: np.append(INTACT[4], 75.0), 5: np.array([50.0]), 1: np.append(INTACT[1], 3.0)}
    states = ((INTACT, 320), (fewer, 5), (more, 5))
    tests = [one for values, count in states for one in many(values, count, rng, missed=missed)]
    watched = ar.monitor(tests, baseline=120)
    assert watched.alarm[120:320].mean() < 0.03
    # From the second test on the same is missing again.
    assert watched.alarm[[*range(321, 325), *range(326, 330)]].all()
    assert all("events" in watched.why(i) for i in (322, 327))


def test_many_values_and_few_tests():
    rng = np.random.default_rng(18)
    springs, masses = 5e4 * rng.uniform(0.8, 1.2, 8), rng.uniform(0.8, 1.2, 9)
    lost = np.where(np.arange(8) == 3, 0.98, 1.0)
    intact, damaged = (exact(ar.MassSpringChain(masses, springs * factor)) for factor in (1.0, lost))
    assert sum(map(len, intact.values())) > 30
    with pytest.warns(ar.AntiresWarning, match=r"baseline of 30 tests is short for 1 %.*with 50"):
        watched = ar.monitor(many(intact, 230, rng) + many(damaged, 20, rng), baseline=30)
    assert watched.needed == 50
    assert "30 tests, 50 are needed to rely on it" in str(watched)
    assert watched.alarm[30:230].mean() < 0.02
    assert watched.alarm[230:].all()


def test_poor_tests_do_not_alarm(sets):
    poor = many(INTACT, 40, np.random.default_rng(19), std=10 * STD)
    assert ar.monitor(sets[:60] + poor, baseline=60).alarm[60:].mean() <= 0.05


@pytest.mark.parametrize("factor", [0.9, 0.8, 0.2, None], ids=["0.9", "0.8", "0.2", "no values"])
def test_nothing_near_its_place_is_an_alarm(sets, factor):
    gone = {dof: f[:0] if factor is None else f * factor for dof, f in INTACT.items()}
    tests = sets[:60] + many(gone, 3, np.random.default_rng(22))
    watched = ar.monitor(tests, baseline=60, model=chain() if factor is None else None)
    assert watched.alarm[60:].all()
    assert "events" in watched.why(61)
    assert not watched.faults
    assert not watched.assessments
    if factor in (0.9, None):
        assert np.isnan(watched.charts["T2"].statistic[60:]).all()
        assert np.array_equal(watched.statistic[60:], watched.charts["events"].ratio[60:])
    assert "3 of 3 tests outside the baseline alarm" in str(watched)


# -- Sensors that fail are told from damage
def checked(one, name, dof):
    finding = ar.Finding(name, "warning", (dof,), 1.0, 0.0, "Seen.", "Look.")
    check = ar.DataCheck((finding,), {}, tuple(one), 0, (1.0, 100.0))
    return ar.AntiresonanceSet.from_tables(0, one.tables, data_check=check)


def drawn_again(**without):
    return drawn(INTACT, np.random.default_rng(42), **without)


WRONG = drawn(INTACT | {1: INTACT[1] * 1.01}, np.random.default_rng(44))
FEW = drawn(INTACT | {1: np.array([7.0, 21.0])}, np.random.default_rng(43))


@pytest.mark.parametrize(
    ("one", "dof", "text"),
    [(drawn_again(without=(3,)), 3, "not in this test"), (FEW, 1, "antiresonances")]
    + [(checked(WRONG, "spikes", 1), 1, "data check: spikes")],
)
def test_a_response_at_fault_is_left_out_and_told(sets, one, dof, text):
    watched = ar.monitor([*sets[:65], one, *sets[66:]], baseline=60)
    assert [fault.dof for fault in watched.faults[65]] == [dof]
    assert text in watched.faults[65][0].text
    assert f"sensor fault: dof {dof}, {watched.faults[65][0].text}" in str(watched)
    assert not watched.alarm[65]
    assert not np.isnan(watched.statistic[65])


def test_without_a_finding_nothing_tells_it_from_damage(sets):
    assert ar.monitor([*sets[:65], WRONG], baseline=60).alarm[65]
    found = ar.monitor([checked(one, "signal_to_noise", 1) for one in sets], baseline=60)
    assert not found.faults, "what the baseline has too is no fault"


def test_where_most_sensors_fail_nothing_is_judged(sets):
    watched = ar.monitor([*sets[:65], drawn_again(without=(1, 2, 3, 4))], baseline=60)
    assert not watched.alarm[65]
    assert np.isnan(watched.statistic[65])
    assert {fault.dof for fault in watched.faults[65]} == set(INTACT)
    assert np.flatnonzero(watched.unjudged).tolist() == [65]
    assert "cannot judge 1 tests: none of these antiresonances seen, or most" in str(watched)


@pytest.mark.parametrize("spring", [0, 1, 3])
def test_damage_of_any_size_alarms_and_is_no_fault(sets, spring):
    rng = np.random.default_rng(47)
    local = exact(chain(0.02, spring=0))
    assert [dof for dof in INTACT if np.abs(local[dof] - INTACT[dof]).max(initial=0.0) > 1e-6] == [0]
    later = [drawn(exact(chain(loss, spring=spring)), rng) for loss in (0.02, 0.05, 0.35, 0.7, 0.9, 0.95)]
    watched = ar.monitor(sets[:60] + later, baseline=60)
    assert watched.alarm[60:].all()
    assert not watched.faults


def test_what_is_wrong_is_said(sets):
    def said(options):
        return refusal(lambda: ar.monitor(**({"series": sets, "baseline": 10} | eval(options))))

    replay(Path(__file__).with_name("wrong_monitor.txt"), said)
