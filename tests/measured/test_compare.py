"""Two sets compared: who is whose partner, and whether they differ."""

from functools import cache

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.measured.matching import paired

CASE = ar.cases.chain8()


@cache
def exact_of(model):
    return model.antiresonances(range(8), 0)


def drawn(model, rng, errors=2e-4, std=2e-4):
    exact = dict(enumerate(exact_of(model)))
    found = {dof: f * (1.0 + errors * rng.standard_normal(f.size)) for dof, f in exact.items()}
    return ar.AntiresonanceSet(0, found, std_hz={dof: std * f for dof, f in exact.items()})


def damaged(loss):
    springs = np.full(7, 56.7e3)
    springs[4] *= 1.0 - loss
    return ar.MassSpringChain([0.5593] + 7 * [0.4194], springs)


def test_no_value_serves_twice_the_nearest_do_not_steal_and_pairs_do_not_cross():
    # Both of a lie nearest to 10.2: together they are worth most as neighbours in order.
    a, b = np.array([10.0, 10.3]), np.array([10.2, 10.6])
    assert paired(a, b, 0.05) == [(0, 0), (1, 1)]
    assert paired(a, b[:1], 0.05) == [(1, 0)]
    assert paired(a, np.array([]), 0.05) == []
    assert paired(np.array([10.0]), np.array([10.6]), 0.05) == []
    assert paired(np.array([10.0]), np.array([10.6]), 0.05, np.array([[0.04]])) == [(0, 0)]
    known, seen = np.array([50.0]), np.array([50.5, 54.0])
    assert paired(known, seen, 0.12) == [(0, 0)]
    assert paired(known, seen, 0.12, worth=np.array([0.1, 1.0])) == [(0, 1)]
    rng = np.random.default_rng(1)
    for _ in range(50):
        a, b = (np.sort(rng.uniform(10.0, 20.0, n)) for n in rng.integers(1, 12, 2))
        pairs = paired(a, b, 0.05)
        assert [k for _, k in pairs] == sorted({k for _, k in pairs})
        assert all(abs(b[k] / a[i] - 1.0) < 0.06 for i, k in pairs)


def test_false_alarms_come_as_often_as_stated():
    rng = np.random.default_rng(2)
    compared = [ar.compare(drawn(CASE.model, rng), drawn(CASE.model, rng), alpha=0.1) for _ in range(100)]
    assert {len(c) for c in compared} == {28}
    # Exact deviations of normal errors: the test, made for deviations from 15 averages, is on the safe side.
    assert sum(c.different for c in compared) <= 15
    assert sum(c.changed.any() for c in compared) <= 15
    # Errors twice as large as they are said to be are found out, so that the test can fail.
    wrong = [ar.compare(drawn(CASE.model, rng), drawn(CASE.model, rng, 4e-4)) for _ in range(20)]
    assert sum(c.different for c in wrong) > 10


def test_damage_is_told_and_where():
    rng = np.random.default_rng(3)
    seen = ar.compare(drawn(CASE.model, rng), drawn(damaged(0.02), rng))
    assert seen.different
    truth = np.concatenate(exact_of(damaged(0.02))) / np.concatenate(exact_of(CASE.model)) - 1.0
    assert seen.changed[np.abs(truth) > 2e-3].all()
    assert not seen.changed[np.abs(truth) < 1e-5].any()
    assert np.allclose(seen.difference_percent, 100 * truth, atol=0.15)
    assert not ar.compare(drawn(CASE.model, rng), drawn(damaged(0.02), rng), std_between=5e-3).different


def test_what_has_no_partner_is_listed():
    a = ar.AntiresonanceSet(0, {0: [10.0, 20.0], 1: [15.0], 5: [9.0]})
    b = ar.AntiresonanceSet(0, {0: [10.1], 1: [15.0, 30.0]})
    with pytest.warns(
        ar.exceptions.AntiresWarning, match="other channels than a: 2 responses, a 3, of which 2"
    ):
        seen = ar.compare(a, b)
    assert seen.dof.tolist() == [0, 1]
    assert {dof: f.tolist() for dof, f in seen.unmatched_a.items()} == {0: [20.0]}
    assert {dof: f.tolist() for dof, f in seen.unmatched_b.items()} == {1: [30.0]}
    assert (seen.freedom, seen.different) == (0, False)
    assert "not tested" in str(seen)
    assert np.isnan(seen.z).all()
    assert ar.compare(ar.AntiresonanceSet(0, {0: a[0], 1: a[1]}), b, std_between=1e-3).different


def test_tables_of_a_comparison():
    pytest.importorskip("pandas")
    rng = np.random.default_rng(4)
    seen = ar.compare(drawn(CASE.model, rng), drawn(CASE.model, rng))
    frame = seen.to_dataframe()
    assert frame.shape == (28, 10)
    assert np.allclose(frame["difference_hz"] / frame["std_hz"], frame["z"])
    assert len(str(seen).splitlines()) == 31
    pytest.importorskip("xarray")
    assert seen.to_xarray().attrs["freedom"] == 28


ONE = ar.AntiresonanceSet(0, {0: [8.7], 1: [14.4]})


@cache
def shaken(stiffness=1.0):
    model = ar.MassSpringChain(np.ones(4), stiffness * np.full(3, 4e4), ground_first_n_per_m=2e4)
    made = {"excitation": 0, "fs_hz": 256.0, "duration_s": 120.0, "damping_ratio": 0.01}
    return model.simulate(**made, noise=0.01, rng=7).responses


@pytest.mark.parametrize(
    ("stronger", "stiffer", "told"), [(0.2, 1.03, True), (0.2, 1.0, False), (1.2, 1.03, False)]
)
def test_tests_of_other_strength_are_told_where_they_differ(stronger, stiffer, told):
    records = [ar.Recording(made, 256.0) for made in (shaken(), stronger * shaken(stiffer))]
    seen = ar.compare(*(ar.identify_antiresonances(rec, excitation=0, band_hz=(5, 80)) for rec in records))
    assert seen.level_ratio == pytest.approx(stronger, rel=0.1)
    assert seen.different is (stiffer != 1.0)
    assert ("times as strongly" in str(seen)) is told
    assert np.isnan(ar.compare(exact := ar.AntiresonanceSet(0, {0: [8.0]}), exact).level_ratio)
