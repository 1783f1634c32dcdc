"""Exact rational functions in pole-zero form, and how exactly the fit and the order sweep find them again.

Three curves with common poles, 0.1 to 5 % damped, and zeros of their own, so that poles and zeros are known
to the last digit.
"""

from __future__ import annotations

import numpy as np

from antires_rs import fit_rational, stabilization

N_OUTPUTS = 3


def roots_of(freq_hz, damping):
    """Upper roots in rad/s."""
    return 2 * np.pi * freq_hz * (-damping + 1j * np.sqrt(1.0 - damping**2))


def curves(freq_hz, poles, zeros):
    """Curves (n_outputs, n_freq) of pole-zero form, each scaled to unit rms."""
    s = 2j * np.pi * freq_hz[:, None]

    def factors(roots):
        return (s - roots) * (s - roots.conj()) / np.abs(roots) ** 2

    below = factors(poles)
    values = []
    for own in zeros:
        above = factors(own)
        # Factor by factor: the products alone would overflow at high order.
        ratio = np.prod(above / below[:, : own.size], axis=1) / np.prod(below[:, own.size :], axis=1)
        values.append(ratio / np.sqrt(np.mean(np.abs(ratio) ** 2)))
    return np.array(values)


def log_uniform(rng, low, high, size):
    return 10 ** rng.uniform(np.log10(low), np.log10(high), size)


def between(rng, poles_hz):
    """One zero in each gap, damped 0.1 to 5 %."""
    share = rng.uniform(0.25, 0.75, poles_hz.size - 1)
    return roots_of(poles_hz[:-1] + share * np.diff(poles_hz), log_uniform(rng, 1e-3, 0.05, share.size))


def spread(rng, n, damping=(1e-3, 0.05), lines=2400, band=(1.0, 200.0)):
    """Poles evenly over the band, each moved by up to a fifth of a gap."""
    gap = (band[1] - band[0]) / (n + 1)
    hz = band[0] + gap * (np.arange(1, n + 1) + rng.uniform(-0.2, 0.2, n))
    return np.linspace(*band, lines), hz, log_uniform(rng, *damping, n)


def light(rng, n):
    """All of 0.1 % damping, with five lines or more in the narrowest half-power bandwidth."""
    _, hz, damping = spread(rng, n, (1e-3, 1e-3), 2, (40.0, 200.0))
    return np.arange(40.0, 200.0, 2e-3 * hz.min() / 5), hz, damping


def anywhere(rng, n):
    """Poles wherever they fall, so that some overlap within their damping."""
    return np.linspace(1.0, 200.0, 2400), np.sort(rng.uniform(8.0, 190.0, n)), log_uniform(rng, 1e-3, 0.05, n)


def two_decades(rng, n):
    """Poles spaced evenly on a logarithmic axis from 5 to 450 Hz, with a line every 0.05 Hz."""
    hz = np.geomspace(5.0, 450.0, n) * (1.0 + rng.uniform(-0.2, 0.2, n) * (90.0 ** (1.0 / n) - 1.0))
    return np.arange(1.0, 500.0, 0.05), hz, log_uniform(rng, 1e-3, 0.05, n)


def clusters(rng, n):
    """Pairs 0.5 % apart, damped 0.1 to 0.3 %."""
    _, middle, _ = spread(rng, n // 2)
    hz = np.sort(np.concatenate([middle * 0.9975, middle * 1.0025, [middle[-1] * 1.03] * (n % 2)]))
    return np.linspace(1.0, 200.0, 8000), hz, log_uniform(rng, 1e-3, 3e-3, hz.size)


FAMILIES = {
    "spread": spread,
    "light": light,
    "two decades": two_decades,
    "clusters": clusters,
    "anywhere": anywhere,
}


def draw(family, order, seed):
    """Lines, curves, poles and zeros of one random function; damping shuffled over the poles."""
    rng = np.random.default_rng([seed, order])
    freq, hz, damping = FAMILIES[family](rng, order // 2)
    zeros = [between(rng, hz) for _ in range(N_OUTPUTS)]
    poles = roots_of(hz, damping)
    return freq, curves(freq, poles, zeros), poles, zeros


def error(found, true):
    """Largest distance of a true root to the nearest found one, relative to its size."""
    if not found.size:
        return np.inf
    return float(np.max(np.abs(found - true[:, None]).min(axis=1) / np.abs(true)))


def fit_errors(family, order, seed):
    """(largest relative error of a pole, of a zero, relative residual); complex roots, so damping counts."""
    freq, values, poles, zeros = draw(family, order, seed)
    fit = fit_rational(freq, values, order)
    zero_error = max(error(fit.zeros[o].s, zeros[o]) for o in range(N_OUTPUTS))
    return error(fit.poles.s, poles), zero_error, fit.residual


def sweep_counts(family, order, seed, max_order):
    """(true poles, found within 0.1 %, false) of the stabilization diagram of the same data."""
    freq, values, poles, _ = draw(family, order, seed)
    found = stabilization(freq, values, max_order=max_order).identified
    true = np.abs(poles) / (2 * np.pi)
    near = np.abs(found[:, None] / true - 1.0) < 1e-3
    return true.size, int(near.any(axis=0).sum()), int((~near.any(axis=1)).sum())
