"""Records in which no antiresonance can be identified, and hits, made of a structure's exact responses."""

from __future__ import annotations

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference import structures

FS_HZ = structures.FS_HZ
DURATION_S = 60.0


def hit(one, seed, duration_s=8.0, rest_s=0.5, noise=1e-3, width_s=0.004, more=()):
    """Responses from rest to a half sine on the driven dof, and ``more`` of them (seconds after, size)."""
    rng = np.random.default_rng(seed)
    n = round(duration_s * FS_HZ)
    long, fine = 4 * n, 64  # so long that all has died; so fine that the half sine has its area
    t = np.arange(long)[:, None] / FS_HZ - rest_s + np.arange(fine) / fine / FS_HZ
    pulse = np.zeros(long)
    for after, size in ((0.0, 1.0), *more):
        u = (t - after) / width_s
        pulse += size * np.where((u > 0) & (u < 1), np.sin(np.pi * np.clip(u, 0, 1)), 0.0).mean(axis=1)
    freq = np.fft.rfftfreq(long, 1 / FS_HZ)
    keep = (freq > 0) & (freq < 0.45 * FS_HZ)
    spectrum = np.zeros((len(one.responses), freq.size), complex)
    spectrum[:, keep] = one.accelerance(freq[keep]) * np.fft.rfft(pulse)[keep]
    x = np.fft.irfft(spectrum, long)[:, :n]
    return x + noise * x.std(axis=1).mean() * rng.standard_normal(x.shape)


def free_decay(one, seed, duration_s=8.0):
    """From random displacements and velocities of all masses: the record begins after what set it off."""
    rng = np.random.default_rng(seed)
    n = len(one.mass)
    inverse = np.linalg.inv(one.mass)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ one.stiffness, -inverse @ one.damping]])
    step = scipy.linalg.expm(state / FS_HZ)
    y = np.concatenate([1e-4 * rng.standard_normal(n), 1e-2 * rng.standard_normal(n)])
    rows = []
    for _ in range(round(duration_s * FS_HZ)):
        rows.append((state @ y)[n:])
        y = step @ y
    x = np.array(rows).T[list(one.responses)]
    return x + 1e-3 * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)


def _random(seed, duration_s=DURATION_S, excitation=0):
    one = structures.random_chain(seed, excitation)
    return one.record(noise=0.01, seed=seed + 50 * excitation, duration_s=duration_s).responses


def _noise(seed):
    return np.random.default_rng(seed).standard_normal((8, round(DURATION_S * FS_HZ)))


def _shifted(seed):
    """Seconds apart: every recorder was started by hand."""
    starts = np.random.default_rng(seed).permutation(8) * round(1.3 * FS_HZ)
    x = _random(seed, DURATION_S + 10.0)
    return np.stack([row[s : s + round(DURATION_S * FS_HZ)] for row, s in zip(x, starts, strict=True)])


def _drifting(seed):
    """Clocks that differ by 300 parts per million from each channel to the next."""
    x = _random(seed, DURATION_S + 10.0)
    at, known = np.arange(round(DURATION_S * FS_HZ)), np.arange(x.shape[1])
    return np.stack([np.interp(at * (1 + 3e-4 * k), known, row) for k, row in enumerate(x)])


def _one_alive(seed):
    x = _random(seed)
    dead = 0.05 * x.std() * np.random.default_rng(seed).standard_normal(x.shape)
    dead[2] = x[2]
    return dead


def _clipped_hit(seed):
    x = hit(structures.random_chain(seed), seed)
    limit = 0.02 * np.abs(x).max(axis=1, keepdims=True)
    return np.clip(x, -limit, limit)


def _two_steps(seed):
    x = 0.8 * _random(seed)
    return np.round(x / np.abs(x).max(axis=1, keepdims=True))


def _one_signal(seed):
    x = _random(seed)[0]
    return np.linspace(0.5, 2.0, 8)[:, None] * x + 1e-4 * x.std() * _noise(seed)


def _sine(seed):
    shape = structures.random_chain(seed).accelerance(np.array([31.7]))
    turn = np.exp(2j * np.pi * 31.7 / FS_HZ * np.arange(round(DURATION_S * FS_HZ)))
    x = (shape * turn).real
    return x + 0.01 * x.std(axis=1).mean() * _noise(seed)


#: Responses by what is wrong with them; each takes a seed.
RECORDS = {
    "noise": _noise,
    "two forces": lambda seed: _random(seed) + _random(seed, excitation=5),
    "clocks apart": _shifted,
    "clocks that drift": _drifting,
    "one channel alive": _one_alive,
    "free decay": lambda seed: free_decay(structures.random_chain(seed), seed),
    "too short": lambda seed: _random(seed)[:, 1000:1064],
    "clipped": _clipped_hit,
    "two steps": _two_steps,
    "one signal": _one_signal,
    "sine": _sine,
}


def record(name, seed=1):
    """The record of one of the cases."""
    return ar.Recording(RECORDS[name](seed), FS_HZ)
