"""Records in which no antiresonance can be identified, and why, each made of a structure's exact records."""

from __future__ import annotations

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference import structures

FS_HZ = structures.FS_HZ
DURATION_S = 60.0


def two_step(x):
    """Quantized to three values: more than two steps of a converter were not used."""
    return np.round(x / np.abs(x).max(axis=1, keepdims=True))


def free_decay(one, seed, duration_s=8.0):
    """From random displacements and velocities in all masses: the record begins after whatever set it off."""
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


def hit(one, seed, duration_s=8.0, rest_s=0.5, noise=1e-3, width_s=0.004, more=()):
    """A half sine on the driven dof, and ``more`` of them (seconds after it, size), from rest."""
    rng = np.random.default_rng(seed)
    n = round(duration_s * FS_HZ)
    long = 4 * n  # so long that the end has died
    t = np.arange(long) / FS_HZ - rest_s
    fine = 64  # the half sine is sampled finely and its mean is taken
    pulse = np.zeros(long)
    for after, size in ((0.0, 1.0), *more):
        u = (t[:, None] - after + np.arange(fine) / fine / FS_HZ) / width_s
        pulse += size * np.where((u > 0) & (u < 1), np.sin(np.pi * np.clip(u, 0, 1)), 0.0).mean(axis=1)
    freq = np.fft.rfftfreq(long, 1 / FS_HZ)
    keep = (freq > 0) & (freq < 0.45 * FS_HZ)
    spectrum = np.zeros((len(one.responses), freq.size), complex)
    spectrum[:, keep] = one.accelerance(freq[keep]) * np.fft.rfft(pulse)[keep]
    x = np.fft.irfft(spectrum, long)[:, :n]
    return x + noise * x.std(axis=1).mean() * rng.standard_normal(x.shape)


def records(seed=1):
    """(name, Recording) of the ten."""
    one = structures.random_chain(seed)
    rng = np.random.default_rng([seed, 9])
    random = one.record(noise=0.01, seed=seed, duration_s=DURATION_S)
    x = random.responses
    n, count = x.shape
    rec = lambda y: ar.Recording(np.ascontiguousarray(y), FS_HZ)
    other = structures.random_chain(seed, excitation=5).record(
        noise=0.01, seed=seed + 50, duration_s=DURATION_S
    )
    yield "noise", rec(rng.standard_normal((n, count)))
    yield "two_forces", rec(x + other.responses)
    long = one.record(noise=0.01, seed=seed, duration_s=2 * DURATION_S).responses
    starts = rng.permutation(np.arange(n)) * round(7.3 * FS_HZ)
    yield "clocks", rec(np.stack([row[s : s + count] for row, s in zip(long, starts)]))
    at = np.arange(count)
    yield (
        "drift",
        rec(
            np.stack(
                [
                    np.interp(at * (1 + 2e-3 * k / n), np.arange(long.shape[1]), row)
                    for k, row in enumerate(long)
                ]
            )
        ),
    )
    dead = 0.05 * x.std() * rng.standard_normal(x.shape)
    dead[2] = x[2]
    yield "one_alive", rec(dead)
    yield "free_decay", rec(free_decay(one, seed))
    yield "too_short", rec(x[:, 1000:1064])
    h = hit(one, seed)
    lim = 0.02 * np.abs(h).max(axis=1, keepdims=True)
    yield "overload", rec(np.clip(h, -lim, lim))
    yield "quantized", rec(two_step(x * 0.8))
    yield (
        "same",
        rec(x[:1] * np.linspace(0.5, 2, n)[:, None] + 1e-4 * x[0].std() * rng.standard_normal(x.shape)),
    )
    f0 = 31.7
    w = one.accelerance(np.array([f0]))[:, 0]
    t = np.arange(count) / FS_HZ
    sine = (w[:, None] * np.exp(2j * np.pi * f0 * t)).real
    yield "sine", rec(sine + 0.01 * sine.std(axis=1).mean() * rng.standard_normal(sine.shape))
