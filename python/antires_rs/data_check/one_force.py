r"""Does one force explain the responses?

Under one force and independent noise the spectral matrix, scaled to equal noise, has one large eigenvalue;
the others are noise and scatter as those of a Wishart matrix. A second, independent force lifts the second
eigenvalue. Two other things do so too and must not be taken for it: the scatter of few averages, whose mean
is known, and leakage. Within the width of the window the response changes its direction, so a segment's line
holds a mixture of neighbouring directions; the first vectors, spread by the window as the window spreads
power, tell how much second eigenvalue that makes. A line counts when its second eigenvalue stands above both,
and above a share of the first below which a second force does not matter.

References: K. Johansson, Commun. Math. Phys. 209 (2000) 437-476, and I. M. Johnstone, Ann. Stat. 29 (2001)
295-327 (largest eigenvalue of noise); C. Y. Shih et al., Mech. Syst. Signal Process. 2 (1988) 367-377
(singular values by line).
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .evidence import Evidence
from .findings import Finding, NotTested, Said, Severity, rounded

NAME = "one_force"
# Fewer independent averages than this leave no scatter to compare with.
LEAST_AVERAGES = 4.0
# A line counts if the second eigenvalue is twice what noise makes it on average ...
OVER_NOISE = 2.0
# ... three times what leakage makes it (measured: 0.5 to 1.0 times the prediction) ...
OVER_LEAKAGE = 3.0
# ... and this part of the first; a second force of 0.1 of the first makes 4e-3 at the median line, and
# one of 0.03 is the least that harmed an identification.
LEAST_SHARE = 1e-3
# Share of the lines that must count. Of one force 2 % at most did in 240 records with up to 10 % of noise; of
# a second force of 0.1 of the first 20 to 90 % did.
LINES = 0.10
# Share of the lines, and second over first eigenvalue at their median, above which identified values are
# nonsense: a second force of 0.3 of the first.
FATAL_LINES, FATAL = 0.4, 0.025
# Noise level of a line is averaged over so many lines.
SMOOTHING = 15
# Second over first eigenvalue at the median line above which one force does not explain the responses at all.
UNEXPLAINED = 0.2


def one_force(seen: Evidence) -> Said:
    """Second eigenvalue against the first, the noise and the leakage."""
    n = len(seen.dofs)
    if seen.eigenvalues is None:
        return [
            NotTested(
                NAME,
                "measured responses and single impacts hold one vector a line, which one force "
                "always explains; a record with several averages is needed",
            )
        ]
    if seen.n_averages < LEAST_AVERAGES:
        return [
            NotTested(
                NAME,
                f"{seen.n_averages:.1f} independent averages; {LEAST_AVERAGES:g} are needed "
                "to tell a second force from noise",
            )
        ]
    if n == 1:
        return [NotTested(NAME, "a single channel has one eigenvalue")]
    if n == 2:
        return [_two_channels(seen)]
    first, second = seen.eigenvalues[:, 0], seen.eigenvalues[:, 1]
    share = second / np.maximum(first, 1e-300)
    limit = OVER_NOISE * noise_level(seen)
    counts = (second > limit) & (second > OVER_LEAKAGE * seen.leakage) & (share > LEAST_SHARE)
    lines = float(counts.mean())
    if lines > LINES:
        middle = float(np.median((second - 0.5 * limit)[counts] / first[counts]))
        text = (
            f"The responses need more than one force: at {100 * lines:.0f} % of the lines the second "
            "eigenvalue of the spectral matrix stands clear of noise and leakage, at "
            f"{rounded(100 * middle)} % of the first (median of these lines)."
        )
        advice = (
            "Stop the other source (a second shaker, machines, wind, people), or record while only the "
            "known force acts."
        )
        severity: Severity = "fatal" if lines > FATAL_LINES and middle > FATAL else "warning"
        return [Finding(NAME, severity, (), lines, LINES, text, advice)]
    middle = float(np.median(share))
    if middle > UNEXPLAINED:
        text = (
            f"One force does not explain the responses: at the median line the second eigenvalue of the "
            f"spectral matrix is {100 * middle:.0f} % of the first, {100 * UNEXPLAINED:.0f} % being the "
            "limit. Noise and many forces at once look alike here."
        )
        advice = "Force harder, use quieter sensors, narrow the band, or stop other sources."
        return [Finding(NAME, "warning", (), middle, UNEXPLAINED, text, advice)]
    return []


def expected(seen: Evidence) -> FloatArray:
    """Second eigenvalue that one force gives with noise and leakage, (n_freq,)."""
    return np.asarray(np.maximum(noise_level(seen), seen.leakage), dtype=np.float64)


def noise_level(seen: Evidence) -> FloatArray:
    """Mean second eigenvalue under one force and noise, by line, from the lower ones; (n_freq,)."""
    assert seen.eigenvalues is not None
    rest = _smoothed(seen.eigenvalues[:, 2:].mean(axis=1))
    return noise_ratio(len(seen.dofs), seen.n_averages) * rest


def noise_ratio(n: int, n_averages: float) -> float:
    """Mean second eigenvalue over the mean of the lower ones, under one force and white noise.

    The n - 1 noise eigenvalues are those of a complex Wishart matrix; its largest one by Johnstone's limit
    (mean of the Tracy-Widom law -1.7711), the others by the trace.
    """
    p, m = n - 1.0, max(n_averages - 1.0, 1.0)
    a, b = np.sqrt(m), np.sqrt(p)
    largest = ((a + b) ** 2 - 1.7711 * (a + b) * (1.0 / a + 1.0 / b) ** (1.0 / 3.0)) / m
    largest = min(max(largest, 1.0), 0.95 * p)
    return float(largest * (p - 1.0) / (p - largest))


def _two_channels(seen: Evidence) -> NotTested:
    assert seen.coherence is not None
    level = float(np.median(seen.coherence))
    return NotTested(
        NAME,
        "two channels cannot tell a second force from noise; their coherence is "
        f"{level:.3g} at the median line, and what lacks to one is either",
    )


def _smoothed(values: FloatArray) -> FloatArray:
    """Running mean, so that the noise of a few channels has enough samples."""
    width = min(SMOOTHING, values.size)
    kernel = np.ones(width)
    return np.asarray(np.convolve(values, kernel, "same") / np.convolve(np.ones(values.size), kernel, "same"))
