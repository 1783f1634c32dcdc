"""Errors of values that a test leads to expect, against least squares on simulated spectral lines."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.measured_states import LEAST_STD
from antires_rs.planning.placement import ExpectedErrors

CHAIN = ar.MassSpringChain([1.0, 0.7, 1.4, 0.9], [5e4, 7e4, 4e4])
BAND_HZ, DAMPING, LENGTH_S = 70.0, 0.02, 30.0


def expected(sensor, force, **options):
    errors = ExpectedErrors(
        **{"noise": 0.2, "duration_s": LENGTH_S, "damping_ratio": DAMPING, "std": None} | options
    )
    roots = CHAIN.antiresonances(sensor, force, f_max_hz=BAND_HZ)
    return roots, errors.of(CHAIN, [sensor], force, [roots], BAND_HZ)[0]


def moved(freq, curve, old, new):
    """The curve with one pair of zeros at another frequency."""
    w = freq * DAMPING * 2j
    return curve * (new**2 - freq**2 + w * new) / (old**2 - freq**2 + w * old)


@pytest.mark.parametrize(("sensor", "force"), [(0, 0), (1, 0), (1, 2)])
def test_they_are_those_of_least_squares_on_spectral_lines(sensor, force):
    roots, std = expected(sensor, force)
    freq = np.arange(1, int(BAND_HZ * LENGTH_S)) / LENGTH_S
    curve = CHAIN.frf(sensor, force, freq, damping_ratio=DAMPING)
    step = 1e-6
    columns = [(moved(freq, curve, f, f * (1 + step)) - curve) / step for f in roots] + [curve, 1j * curve]
    matrix = np.vstack([np.real(columns).T, np.imag(columns).T])
    # One line has the noise's power split into two halves, real and imaginary.
    sigma = 0.2 * np.sqrt(np.mean(np.abs(curve) ** 2) / 2.0)
    rng = np.random.default_rng(5)
    noise = sigma * rng.standard_normal((matrix.shape[0], 2000))
    found = np.linalg.lstsq(matrix, noise, rcond=None)[0][: roots.size].std(axis=1)
    np.testing.assert_allclose(found, std, rtol=0.08)


def test_they_grow_with_noise_and_shrink_with_the_root_of_time():
    base = expected(0, 0)[1]
    np.testing.assert_allclose(expected(0, 0, noise=0.4)[1], 2.0 * base, rtol=1e-9)
    np.testing.assert_allclose(expected(0, 0, duration_s=4.0 * LENGTH_S)[1], 0.5 * base, rtol=1e-9)


def test_no_value_is_known_better_than_two_tests_repeat():
    np.testing.assert_array_equal(expected(0, 0, noise=0.0)[1], LEAST_STD)


def test_a_std_that_is_given_is_taken():
    np.testing.assert_array_equal(expected(0, 0, std=1e-3)[1], 1e-3)
