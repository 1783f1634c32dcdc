"""Sensors that fail are told from damage."""

import numpy as np
import pytest

import antires_rs as ar
from tests.watch.drawn_tests import chain, drawn, exact, many

INTACT = exact(chain())


@pytest.fixture
def sets():
    return many(INTACT, 70, np.random.default_rng(41))


def checked(one, name, dof):
    """The set with a finding of the data check."""
    finding = ar.Finding(name, "warning", (dof,), 1.0, 0.0, "Seen.", "Look.")
    check = ar.DataCheck((finding,), {}, tuple(one), 0, (1.0, 100.0))
    return ar.AntiresonanceSet.from_tables(0, one.tables, data_check=check)


def test_a_response_that_is_lost(sets):
    rng = np.random.default_rng(42)
    sets[65] = drawn(INTACT, rng, without=(3,))
    watched = ar.monitor(sets, baseline=60)
    assert not watched.alarm[65]
    assert [fault.dof for fault in watched.faults[65]] == [3]
    assert watched.statistic[65] == watched.statistic[65]
    assert "sensor fault: dof 3, not in this test" in str(watched)


def test_antiresonances_lost_by_one_response_alone(sets):
    rng = np.random.default_rng(43)
    sets[65] = drawn(INTACT | {1: np.array([7.0, 21.0])}, rng)
    watched = ar.monitor(sets, baseline=60)
    assert not watched.alarm[65]
    assert [fault.dof for fault in watched.faults[65]] == [1]


def test_a_channel_that_the_data_check_names(sets):
    rng = np.random.default_rng(44)
    wrong = drawn(INTACT | {1: INTACT[1] * 1.01}, rng)
    sets[65], sets[66] = checked(wrong, "spikes", 1), wrong
    watched = ar.monitor(sets, baseline=60)
    assert watched.faults[65][0].text == "data check: spikes"
    assert not watched.alarm[65]
    assert watched.alarm[66], "without the finding nothing tells it from damage"


def test_what_the_baseline_has_too_is_no_fault(sets):
    sets = [checked(one, "signal_to_noise", 1) for one in sets]
    assert not ar.monitor(sets, baseline=60).faults


def test_damage_that_moves_one_response_alone_is_damage(sets):
    """With the force on the first mass, the first spring moves the antiresonances of that mass only."""
    rng = np.random.default_rng(45)
    local = exact(chain(0.02, spring=0))
    moved = {dof: float(np.abs(local[dof] / INTACT[dof] - 1.0).max(initial=0.0)) for dof in INTACT}
    assert moved[0] > 1e-3
    assert max(moved[dof] for dof in range(1, 6)) < 1e-9
    watched = ar.monitor(sets + many(local, 10, rng), baseline=60)
    assert watched.alarm[70:].all()
    assert not watched.faults


def test_where_most_sensors_fail_nothing_is_judged(sets):
    sets[65] = drawn(INTACT, np.random.default_rng(46), without=(1, 2, 3, 4))
    watched = ar.monitor(sets, baseline=60)
    assert not watched.alarm[65]
    assert np.isnan(watched.statistic[65])
    assert {fault.dof for fault in watched.faults[65]} == set(INTACT)
    assert np.flatnonzero(watched.unjudged).tolist() == [65]
    assert "not judged, most responses being at fault: 1 tests" in str(watched)


@pytest.mark.parametrize("spring", [0, 1, 3])
def test_damage_of_any_size_alarms_and_is_no_fault(sets, spring):
    """Large damage moves the antiresonances of a response beyond reach; it has as many as before."""
    rng = np.random.default_rng(47)
    later = [drawn(exact(chain(loss, spring=spring)), rng) for loss in (0.05, 0.35, 0.7, 0.9, 0.95)]
    watched = ar.monitor(sets[:60] + later, baseline=60)
    assert watched.alarm[60:].all()
    assert not watched.faults
