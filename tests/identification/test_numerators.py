"""The joint fit of all numerators: exact on exact data, blind to what cancels, honest about its scatter."""

from __future__ import annotations

import numpy as np

import antires_rs as ar
from antires_rs.identification.lines import Lines
from antires_rs.identification.numerators import Influence, likeliest
from antires_rs.signals.spectra import Segments
from reference.structures import structure
from reference.virtual_records import accelerance, chain_matrices, random_record
from tests.support import checked_records as eight
from tests.support.checked_records import BAND

STIFFNESS, MASS = chain_matrices([1.0, 0.8, 1.2, 0.9], [4e4, 3e4, 5e4])
FREQ = np.linspace(2.0, 70.0, 500)


def draw(rng, level, count=40):
    """Segments x = a h + noise, (n_freq, 4, count), in units of the noise."""
    h = accelerance(STIFFNESS, MASS, 0, FREQ, 0.01).T / level
    a = (rng.standard_normal((FREQ.size, count)) + 1j * rng.standard_normal((FREQ.size, count))) / np.sqrt(2)
    e = rng.standard_normal((FREQ.size, 4, count)) + 1j * rng.standard_normal((FREQ.size, 4, count))
    return h[:, :, None] * a[:, None, :] + e / np.sqrt(2)


def lines_of(x):
    values, vector = np.linalg.eigh(x @ x.conj().transpose(0, 2, 1) / x.shape[2])
    return Lines(FREQ, vector[:, :, -1].T, values[:, -1], segments=Segments.of(x))


def test_predicted_scatter_is_the_observed_one():
    """Forty experiments: errors over their own standard deviations have unit variance and no bias."""
    zeros = [structure(STIFFNESS, MASS).damped_zeros(row) for row in range(3)]
    zeros = [each[np.abs(each) < 2 * np.pi * 70] for each in zeros]
    scores = []
    for seed in range(40):
        lines = lines_of(draw(np.random.default_rng(100 + seed), 0.1))
        best = likeliest(FREQ, lines.covariance, 1e4, 1.0, 12)
        influence = Influence(best, lines)
        for row in range(3):
            true = zeros[row]
            roots = best.fit.zeros(best.coefficients[:, row])
            near = np.array([roots[np.argmin(np.abs(roots - s))] for s in true])
            std = influence.standard_deviations(row, near)
            scores.append((np.abs(near) - np.abs(true)) / (2 * np.pi) / std)
    scores = np.concatenate(scores)
    assert abs(scores.mean()) < 0.26
    assert 0.82 < scores.std() < 1.18


def test_what_no_reference_alone_shows():
    responses, _ = random_record(eight.STIFFNESS, eight.MASS, duration_s=200.0, noise=0.1, seed=14)
    rec = ar.Recording(responses, 512.0)
    counts = {}
    for formulation in ("numerators", "joint"):
        fit = ar.FitOptions(formulation=formulation)
        found = ar.identify_antiresonances(rec, excitation=0, band_hz=BAND, fit=fit)
        counts[formulation] = 0
        for dof in range(8):
            near = [np.abs(found[dof] / f - 1.0).min(initial=np.inf) < 0.01 for f in eight.TRUTH[dof]]
            counts[formulation] += sum(near)
            assert found[dof].size == sum(near)
    assert counts["numerators"] == 28
    assert counts["joint"] < 28
