"""The joint fit of all numerators: exact on exact data, blind to what cancels, honest about its scatter."""

from __future__ import annotations

import numpy as np
import pytest

from antires_rs import FitOptions
from antires_rs.identification.identify import identify_antiresonances
from antires_rs.identification.lines import Lines
from antires_rs.identification.numerators import NumeratorFit, NumeratorSweep, likeliest
from antires_rs.identification.scores import shared
from antires_rs.identification.selection import Influence
from antires_rs.signals.recording import Recording
from antires_rs.signals.spectra import Segments, channel_noise, noise_power
from reference.virtual_records import (
    accelerance,
    chain8_matrices,
    chain_matrices,
    random_record,
    true_antiresonances,
)

STIFFNESS, MASS = chain_matrices([1.0, 0.8, 1.2, 0.9], [4e4, 3e4, 5e4])
FREQ = np.linspace(2.0, 70.0, 500)
BAND8 = (3.0, 130.0)


def vectors():
    """Accelerances of a four-mass chain at the lines, (n_freq, 4), 1 % damping."""
    return accelerance(STIFFNESS, MASS, 0, FREQ, 0.01).T


def exact_zeros(row):
    """Zeros of H_row0 with its damping, rad/s: numerator polynomial from the modal sum."""
    import scipy.linalg

    lam, phi = scipy.linalg.eigh(STIFFNESS, MASS)
    w = np.sqrt(np.maximum(lam, 0.0))
    w[0] = 0.0
    factors = [np.array([1.0, 2 * 0.01 * wr, wr**2]) for wr in w]
    total = np.zeros(1)
    for r in range(len(w)):
        product = np.ones(1)
        for q in range(len(w)):
            if q != r:
                product = np.polymul(product, factors[q])
        total = np.polyadd(total, phi[row, r] * phi[0, r] * product)
    s = np.roots(total)
    s = s[(s.imag > 1.0) & (np.abs(s) < 2 * np.pi * 70)]
    return s[np.argsort(np.abs(s))]


def covariance_of(x):
    return x[:, :, None] * x[:, None, :].conj()


def fit_of(covariance, order):
    largest = np.linalg.eigvalsh(covariance)[:, -1]
    return NumeratorFit(FREQ, covariance.__getitem__, largest, 1.0 / largest, order)


def nearest(roots, wanted):
    return np.array([np.abs(roots / s - 1.0).min() for s in wanted])


@pytest.mark.parametrize("kind", ["low", "likeliest"])
def test_exact_data_give_the_exact_zeros(kind):
    fit = fit_of(covariance_of(vectors()), 6)
    c = fit.low(6) if kind == "low" else fit.likeliest(6)[0]
    assert [exact_zeros(row).size for row in range(4)] == [3, 2, 1, 0]
    for row in range(3):
        assert nearest(fit.zeros(c[:, row]), exact_zeros(row)).max() < 1e-7


def test_force_and_resonances_cancel():
    """A factor at every line, whatever it is, changes the weights at most."""
    rng = np.random.default_rng(0)
    factor = np.exp(2j * np.pi * rng.random(FREQ.size)) * rng.uniform(0.5, 2.0, FREQ.size)
    for x in (vectors(), vectors() * factor[:, None]):
        fit = fit_of(covariance_of(x), 6)
        assert nearest(fit.zeros(fit.likeliest(6)[0][:, 0]), exact_zeros(0)).max() < 1e-7


def test_superfluous_roots_are_shared_and_own_nothing():
    fit = fit_of(covariance_of(vectors()), 20)
    c = fit.low(20)
    roots = [fit.zeros(c[:, row]) for row in range(4)]
    for row in range(3):
        true = np.array([roots[row][np.argmin(np.abs(roots[row] - s))] for s in exact_zeros(row)])
        others = [k for k in range(4) if k != row]
        assert fit.dominances(c, row, true, others).min() > 0.9
        assert not shared(true, [roots[k] for k in others]).any()
        inside = roots[row][
            (np.abs(roots[row].imag) > 2 * np.pi * 5)
            & (np.abs(roots[row]) < 2 * np.pi * 60)
            & (np.abs(roots[row].real) < 0.1 * np.abs(roots[row]))
            & (roots[row].imag > 0)
        ]
        left = [s for s in inside if np.abs(exact_zeros(row) / s - 1.0).min() > 1e-3]
        assert all(fit.dominances(c, row, np.array([s]), others)[0] < 0.05 for s in left)


def test_orders_solved_together_are_those_solved_alone():
    rng = np.random.default_rng(1)
    noisy = vectors() + 1e-3 * (
        rng.standard_normal((FREQ.size, 4)) + 1j * rng.standard_normal((FREQ.size, 4))
    )
    fit = fit_of(covariance_of(noisy), 20)
    for order, c in zip((7, 3, 20), fit.likeliest(7, 3, 20), strict=True):
        (alone,) = fit.likeliest(order)
        assert c.shape == alone.shape == (order + 1, 4)
        assert np.allclose(c, alone, rtol=0.0, atol=1e-9)


def test_dominances_of_many_orders_at_once_are_those_of_each():
    fit = fit_of(covariance_of(vectors()), 14)
    solutions = {}
    sweeps = [NumeratorSweep(fit, row, [k for k in range(4) if k != row], solutions) for row in range(4)]
    sweeps[1].companions = [sweeps[0], sweeps[2], sweeps[3]]
    roots = {order: sweeps[1].roots(order) for order in (14, 6, 9)}
    orders, s = (
        np.repeat(list(roots), [one.size for one in roots.values()]),
        np.concatenate([*roots.values()]),
    )
    alone = [sweeps[1].dominances(order, np.array([root]))[0] for order, root in zip(orders, s, strict=True)]
    together = sweeps[1].dominances(orders, s)
    assert 0.0 < np.mean(together == 0.0) < 1.0
    assert np.allclose(together, alone, rtol=1e-6, atol=0.0)


def test_two_rows_share_nothing_that_can_be_told():
    s = np.array([1j, 2j])
    assert not shared(s, [s]).any()
    assert shared(s, [s, np.array([1j])]).tolist() == [True, False]


def draw(rng, level, count=40):
    """Segments x = a h + noise, (n_freq, 4, count), in units of the noise."""
    h = vectors() / level
    a = (rng.standard_normal((FREQ.size, count)) + 1j * rng.standard_normal((FREQ.size, count))) / np.sqrt(2)
    e = rng.standard_normal((FREQ.size, 4, count)) + 1j * rng.standard_normal((FREQ.size, 4, count))
    return h[:, :, None] * a[:, None, :] + e / np.sqrt(2)


def lines_of(x):
    covariance = x @ x.conj().transpose(0, 2, 1) / x.shape[2]
    values, vector = np.linalg.eigh(covariance)
    return Lines(FREQ, vector[:, :, -1].T, values[:, -1], segments=Segments.of(x))


@pytest.mark.parametrize("level", [0.01, 0.1])
def test_the_order_is_that_of_the_structure(level):
    """Three modes and a rigid body seen by four sensors: numerators of order six."""
    covariances = [lines_of(draw(np.random.default_rng(seed), level)).covariance for seed in range(5)]
    orders = [likeliest(FREQ, covariance, 1e4, 1.0, 30).order for covariance in covariances]
    assert orders == [6] * 5


def test_predicted_scatter_is_the_observed_one():
    """Forty experiments: errors over their own standard deviations have unit variance and no bias."""
    scores = []
    for seed in range(40):
        lines = lines_of(draw(np.random.default_rng(100 + seed), 0.1))
        best = likeliest(FREQ, lines.covariance, 1e4, 1.0, 12)
        influence = Influence(best.fit, best.coefficients, best.misfit, lines)
        for row in range(3):
            true = exact_zeros(row)
            roots = best.fit.zeros(best.coefficients[:, row])
            near = np.array([roots[np.argmin(np.abs(roots - s))] for s in true])
            std = influence.standard_deviations(row, near)
            scores.append((np.abs(near) - np.abs(true)) / (2 * np.pi) / std)
    scores = np.concatenate(scores)
    # 240 scores: their mean scatters by 0.065, their standard deviation by 0.046; four of each.
    assert abs(scores.mean()) < 0.26
    assert 0.82 < scores.std() < 1.18


def test_channel_noise_is_told_in_any_unit():
    rng = np.random.default_rng(3)
    # (A channel far quieter than all others is hidden behind their noise: no estimate can tell it.)
    level = np.array([1.0, 3.0, 2.0, 10.0])
    a = rng.standard_normal((FREQ.size, 1, 60)) + 1j * rng.standard_normal((FREQ.size, 1, 60))
    x = vectors()[:, :, None] * a
    x = x + 0.02 * level[:, None] * (
        rng.standard_normal((FREQ.size, 4, 60)) + 1j * rng.standard_normal((FREQ.size, 4, 60))
    )
    gain = np.array([1.0, 1e3, 1e-2, 5.0])  # within a factor of two in power
    for unit in (np.ones(4), gain):
        y = x * unit[:, None]
        matrix = (y.conj() @ y.transpose(0, 2, 1)) / 60
        noise = channel_noise(matrix, noise_power(matrix, 60)) / unit**2
        assert np.allclose(np.log(noise / noise[0]), np.log(level**2), atol=0.7)


def test_what_no_reference_alone_shows():
    """At 10 % noise a joint fit over one reference misses the lowest antiresonances; this one has all."""
    stiffness, mass = chain8_matrices()
    responses, _ = random_record(stiffness, mass, duration_s=200.0, noise=0.1, seed=14)
    rec = Recording(responses, 512.0)
    counts = {}
    for formulation in ("numerators", "joint"):
        found = identify_antiresonances(
            rec, excitation=0, band_hz=BAND8, fit=FitOptions(formulation=formulation)
        )
        counts[formulation] = 0
        for dof in range(8):
            true = true_antiresonances(stiffness, mass, dof, 0)
            near = [np.abs(found[dof] / f - 1.0).min(initial=np.inf) < 0.01 for f in true]
            counts[formulation] += sum(near)
            assert found[dof].size == sum(near)
    assert counts["numerators"] == 28
    assert counts["joint"] < 28


def test_only_averaged_records_have_standard_deviations_of_segments():
    stiffness, mass = chain8_matrices()
    responses, _ = random_record(stiffness, mass, duration_s=64.0, noise=0.01, seed=15)
    found = identify_antiresonances(Recording(responses, 512.0), excitation=0, band_hz=BAND8)
    assert all(found.std_hz[dof].size == found[dof].size for dof in found)
    for dof in found:
        assert (found.std_hz[dof] > 0).all()
        assert (found.std_hz[dof] < 0.005 * found[dof]).all()


@pytest.mark.parametrize("options", [{"fit": FitOptions(keep_common=True)}, {"channels": 2}])
def test_light_damping_without_a_third_witness(options):
    """Whether all rows share a root cannot be asked: what stays over the orders is still found."""
    stiffness, mass = chain8_matrices()
    responses, _ = random_record(stiffness, mass, duration_s=64.0, noise=0.001, damping_ratio=0.0003, seed=16)
    rec = Recording(responses[: options.pop("channels", 8)], 512.0)
    found = identify_antiresonances(rec, excitation=0, band_hz=BAND8, check="off", **options)
    for dof in found:
        true = true_antiresonances(stiffness, mass, dof, 0)
        near = [np.abs(found[dof] / f - 1.0).min(initial=np.inf) < 0.01 for f in true]
        assert sum(near) >= len(true) - 2


def test_exact_rank_one_has_no_noise_to_tell():
    x = vectors()
    noise = channel_noise(x.conj()[:, :, None] * x[:, None, :])
    assert np.isfinite(noise).all()
    assert (noise > 0.0).all()
