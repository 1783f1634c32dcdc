"""Whether one fit of all numerators predicts what it has not seen, to the noise that the segments tell."""

from __future__ import annotations

import numpy as np

from ..exceptions import NumericalError
from ..signals.spectra import dominant
from ..support.checks import ComplexArray
from .lines import SNR_CAP, Lines
from .numerators import likeliest

#: Lines that are looked at, parts of the band, and the largest misfit of a part over what noise makes of it.
MOST_LINES, PARTS, LARGEST = 2400, 8, 2.5
#: Segments without which halves tell nothing.
LEAST_SEGMENTS = 4
#: Signal-to-noise power at the median line from which few impacts are as good as curves.
CLEAN = 3e4


def few(lines: Lines) -> bool:
    """Whether there are too few segments to hold some back."""
    return lines.segments is None or lines.segments.count < LEAST_SEGMENTS


def misfit_ahead(lines: Lines, max_order: int) -> float:
    """Misfit of held-back segments to the numerators fitted to the others, in the band's worst part.

    One is what noise makes of it: the directions of the held-back half scatter by (n - 1) / (K SNR) in power,
    K its independent averages. Infinite where the fit fails.
    """
    assert lines.segments is not None
    step = max(1, lines.freq_hz.size // MOST_LINES)
    part = slice(None, None, step)
    x = lines.segments.at(part)
    freq = lines.freq_hz[part]

    def covariance(half: ComplexArray) -> ComplexArray:
        return np.asarray(half @ half.conj().transpose(0, 2, 1) / half.shape[2])

    fitted, held = covariance(x[:, :, 0::2]), covariance(x[:, :, 1::2])
    try:
        best = likeliest(freq, fitted.__getitem__, SNR_CAP, min(1.0, lines.independent * step), max_order)
    except NumericalError:
        return np.inf
    n = best.fit.values(best.coefficients)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    largest, rest, v = dominant(held.conj(), np.ones(n.shape[1]))
    snr = largest / np.maximum(rest, 1e-12 * largest)
    count = x.shape[2] // 2 / lines.averages_ratio
    off = (1.0 - np.abs(np.sum(n.conj() * v, axis=1)) ** 2) * snr / (1.0 + snr / SNR_CAP)
    parts = [np.median(each) for each in np.array_split(off, PARTS) if each.size]
    return float(max(parts) * count / max(n.shape[1] - 1, 1))
