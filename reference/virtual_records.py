"""Independent simulation of measured records, for the tests of the signal side.

Nothing of antires_rs is used here: modes by scipy, frequency-domain synthesis of a record longer
than wanted, of which a window is cut out, so that the record is not periodic in its own length.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

CHAIN8_MASSES = np.array([0.5593] + [0.4194] * 7)
CHAIN8_SPRINGS = np.full(7, 56.7e3)


def chain_matrices(masses, springs):
    """Stiffness and mass of a free-free chain; spring i joins masses i and i + 1."""
    n = len(masses)
    stiffness = np.zeros((n, n))
    for i, k in enumerate(springs):
        stiffness[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return stiffness, np.diag(np.asarray(masses, float))


def chain8_matrices():
    """Stiffness and mass of the eight-mass chain."""
    return chain_matrices(CHAIN8_MASSES, CHAIN8_SPRINGS)


def true_antiresonances(stiffness, mass, response, excitation, f_max_hz=np.inf):
    """Real positive roots (Hz) of det(K_ik - w^2 M_ik) = 0 by scipy's QZ."""
    k = np.delete(np.delete(stiffness, response, 0), excitation, 1)
    m = np.delete(np.delete(mass, response, 0), excitation, 1)
    alpha, beta = scipy.linalg.eig(k, m, right=False, homogeneous_eigvals=True)
    keep = np.abs(beta) > 1e-10 * np.abs(beta).max()
    lam = alpha[keep] / beta[keep]
    lam = lam[(np.abs(lam.imag) < 1e-6 * np.abs(lam)) & (lam.real > 0)].real
    freq = np.sort(np.sqrt(lam)) / (2 * np.pi)
    return freq[(freq > 0.5) & (freq < f_max_hz)]


def accelerance(stiffness, mass, excitation, freq_hz, damping_ratio):
    """Accelerance of every dof, (n_dofs, n_freq), modal damping; rigid-body modes without damping."""
    lam, phi = scipy.linalg.eigh(stiffness, mass)
    wn = np.sqrt(np.maximum(lam, 0.0))
    wn[wn < 1e-3 * wn.max()] = 0.0
    w = 2 * np.pi * np.asarray(freq_hz)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -(w**2) / (wn[:, None] ** 2 - w**2 + 2j * damping_ratio * wn[:, None] * w)
    q[:, w == 0] = (wn == 0)[:, None]
    return (phi * phi[excitation]) @ q


def _add_noise(responses, noise, rng):
    rms = responses.std(axis=1, keepdims=True)
    return responses + noise * rms * rng.standard_normal(responses.shape)


def random_record(
    stiffness,
    mass,
    *,
    excitation=0,
    fs_hz=512.0,
    duration_s=256.0,
    damping_ratio=0.01,
    noise=0.0,
    seed=0,
    f_max_hz=200.0,
):
    """(responses, force) under a band-limited white force; noise is a fraction of each channel's rms."""
    rng = np.random.default_rng(seed)
    n = round(duration_s * fs_hz)
    n_long = 2 * n
    freq = np.fft.rfftfreq(n_long, 1 / fs_hz)
    spectrum = rng.standard_normal(freq.size) + 1j * rng.standard_normal(freq.size)
    spectrum[freq > f_max_hz] = 0
    x = np.fft.irfft(accelerance(stiffness, mass, excitation, freq, damping_ratio) * spectrum, n_long)
    f = np.fft.irfft(spectrum, n_long)
    start = n // 3
    return _add_noise(x[:, start : start + n], noise, rng), f[start : start + n]


def hit_record(
    stiffness,
    mass,
    *,
    excitation=0,
    fs_hz=512.0,
    hit_times_s=(0.5,),
    duration_s=8.0,
    damping_ratio=0.01,
    noise=0.0,
    seed=0,
    pulse_s=4e-3,
):
    """Responses to half-sine hammer hits, from rest."""
    rng = np.random.default_rng(seed)
    # Long enough for the synthesis period to let the slowest mode die before it wraps around.
    n_long = round(16 * duration_s * fs_hz)
    t = np.arange(n_long) / fs_hz
    force = np.zeros(n_long)
    for hit in hit_times_s:
        inside = (t >= hit) & (t < hit + pulse_s)
        force[inside] += (0.8 + 0.4 * rng.random()) * np.sin(np.pi * (t[inside] - hit) / pulse_s)
    freq = np.fft.rfftfreq(n_long, 1 / fs_hz)
    x = np.fft.irfft(
        accelerance(stiffness, mass, excitation, freq, damping_ratio) * np.fft.rfft(force), n_long
    )
    n = round(duration_s * fs_hz)
    return _add_noise(x[:, :n], noise, rng), force[:n]
