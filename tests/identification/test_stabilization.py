"""The order sweep keeps physical poles and nothing else."""

import numpy as np
import pytest

from antires_rs.identification.stabilization import stabilization
from tests.support.refusals import assert_refused

FREQ = np.linspace(2.0, 60.0, 1200)
POLES = np.array([9.0, 21.0, 22.0, 47.0])
DAMPING = np.array([0.02, 0.005, 0.01, 0.03])


def curves(noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    s = 1j * FREQ[:, None]
    terms = POLES**2 / (s**2 + 2 * DAMPING * POLES * s + POLES**2)
    values = np.array([[1.0, 0.4, -0.6, 0.3], [-0.5, 0.3, 0.5, 0.2], [0.1, -0.2, 0.3, 0.5]]) @ terms.T
    return values + noise * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))


@pytest.mark.parametrize(("noise", "tol"), [(1e-6, 1e-6), (1e-2, 1e-3)])
def test_poles_are_found_and_no_other(noise, tol):
    found = stabilization(FREQ, curves(noise), max_order=60)
    assert found.identified.size == 4
    assert np.abs(found.identified / POLES - 1.0).max() < tol
    assert np.abs(found.identified_damping - DAMPING).max() < 20 * tol * 0.03
    assert np.all(found.accepted.rows > 10)
    assert found.accepted.dominance.min() > 0.3


def test_diagram_is_consistent():
    found = stabilization(FREQ, curves(1e-2), max_order=40, min_order=4, band_hz=(5.0, 50.0))
    assert found.orders.tolist() == list(range(4, 41))
    assert len(found.freq_hz) == len(found.damping_ratio) == len(found.stable) == 37
    for freq, damping, stable in zip(found.freq_hz, found.damping_ratio, found.stable, strict=True):
        assert freq.shape == damping.shape == stable.shape
        assert np.all(np.diff(freq) >= 0)
        assert np.all((freq >= 5.0) & (freq <= 50.0) & (damping > 0) & (damping <= 0.1))
    assert not found.stable[0].any()  # nothing below the first order to be stable against
    assert found.background.shape == found.background_freq_hz.shape
    assert found.band_hz == (5.0, 50.0)
    with pytest.raises(ValueError, match="read-only"):
        found.identified[0] = 0.0


def test_noise_few_orders_and_cancelled_poles_give_nothing():
    rng = np.random.default_rng(4)
    values = rng.standard_normal((3, FREQ.size)) + 1j * rng.standard_normal((3, FREQ.size))
    assert stabilization(FREQ, values).identified.size == 0
    # The last pole appears at order 8 at the earliest: up to order 18 it can be stable ten times, not eleven.
    assert stabilization(FREQ, curves(1e-6), max_order=17).identified.size < 4
    assert stabilization(FREQ, curves(1e-6), max_order=17, min_rows=5).identified.size == 4
    # A pole with a residue of 1e-3 in a curve of order one is real in the data, but carries nothing.
    s = 1j * FREQ
    weak = curves(1e-7) + 1e-5 * 30.0**2 / (s**2 + 0.3 * s + 900.0)
    assert np.any(np.abs(stabilization(FREQ, weak, min_dominance=0.0).identified - 30.0) < 0.3)
    assert not np.any(np.abs(stabilization(FREQ, weak).identified - 30.0) < 0.3)


WRONG = {"freq_tol": 0.0, "damping_tol": -0.1, "min_rows": 0, "max_damping": np.nan, "min_dominance": -1.0}
WRONG = [*((name, {name: value}) for name, value in WRONG.items()), ("min_order", {"min_order": 0})]
WRONG += [("band_hz", {"band_hz": value}) for value in ((1.0, 30.0), 20.0)]
WRONG += [("max_order", {"band_hz": (20.0, 21.0)}), ("max_order", {"max_order": 12, "min_order": 4})]


@pytest.mark.parametrize(("argument", "given"), WRONG)
def test_bad_arguments_are_named(argument, given):
    assert_refused(argument, stabilization, FREQ, curves(), **given)
