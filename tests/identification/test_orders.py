"""Exact rational functions of order 10 to 60: the numerics of the fit, see benchmarks/rational_orders.py."""

import numpy as np
import pytest

from antires_rs.identification.rational_fit import fit_rational
from reference.rational_curves import FAMILIES, draw, fit_errors, sweep_counts


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("order", [10, 20, 30, 40])
def test_poles_and_zeros_to_order_40(family, order):
    # The bar is 1e-8; measured 7e-15 or less (five draws each), two decades of frequency included.
    assert max(fit_errors(family, order, seed=13)) < 1e-12


@pytest.mark.parametrize("family", ["spread", "two decades"])
def test_poles_and_zeros_at_order_60(family):
    assert max(fit_errors(family, 60, seed=13)) < 1e-10


@pytest.mark.parametrize(("family", "order"), [("spread", 10), ("spread", 40), ("light", 20)])
def test_the_sweep_finds_all_and_nothing_else(family, order):
    true, found, false = sweep_counts(family, order, seed=13, max_order=order + 24)
    assert (true, found, false) == (order // 2, order // 2, 0)


def test_an_order_above_the_true_one_does_not_lose_the_poles():
    freq, values, poles, _ = draw("spread", 20, 13)
    found = fit_rational(freq, values, 26).poles.s
    assert np.max(np.abs(found - poles[:, None]).min(axis=1) / np.abs(poles)) < 1e-10


def test_noise_costs_accuracy_in_proportion():
    """The first guess puts the fit where reweighting converges, in noise as well.

    Beyond 1e-7 the bias of a linear fit shows: errors grow faster than the noise.
    """
    freq, values, poles, _ = draw("spread", 20, 13)
    rng = np.random.default_rng(13)
    noise = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    errors = []
    for level in (1e-10, 1e-8, 1e-4):
        found = fit_rational(freq, values + level * noise, 20).poles.s
        errors.append(np.median(np.abs(found - poles[:, None]).min(axis=1) / np.abs(poles)))
    assert errors[0] < 1e-10
    assert errors[1] / errors[0] == pytest.approx(100.0, rel=0.05)
    assert errors[2] < 1e-5
