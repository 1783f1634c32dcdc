r"""Probability of detection against severity, and what is read from it.

.. math:: \ln \frac{POD}{1 - POD} = \ln 9 + b (\ln a - \ln a_{90})

is fitted to found and missed by the largest likelihood. a90/95 is the largest a90 that the likelihood-ratio
test does not reject at 95 %, one-sided; infinity ("never") where the data do not rule out that 90 % are not
reached at all.

Reference: MIL-HDBK-1823A, Nondestructive evaluation system reliability assessment, 2009, appendix G.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..damage.evidence import HIGHEST
from ..support.validation import FloatArray

__all__ = ["Logit", "crossing", "fit_logit", "reached", "rising"]

#: Logit of 0.9, and half the 90 % quantile of chi-square with one degree of freedom.
_LN9, _DROP = float(np.log(9.0)), 1.3528
#: A grid, and one of so many points between its neighbours.
_SLOPES, _STEPS = np.geomspace(0.3, 60.0, 26), 160
_FINE = 31


class Logit:
    """A fitted curve: a90, its slope b, and a90/95."""

    def __init__(self, a90: float, slope: float, bound: float) -> None:
        self.a90, self.slope, self.bound = a90, slope, bound

    def at(self, severity: FloatArray) -> FloatArray:
        """POD."""
        return np.asarray(1.0 / (1.0 + np.exp(-_LN9 - self.slope * (np.log(severity) - np.log(self.a90)))))

    @property
    def a50(self) -> float:
        """Severity found in half of the tests."""
        return float(self.a90 * np.exp(-_LN9 / self.slope))


def fit_logit(severity: FloatArray, found: NDArray[np.bool_], most: float = HIGHEST) -> Logit:
    """The curve of tests (n,) with these severities, found or not; none is larger than ``most``."""
    log_a, sign = np.log(severity), np.where(found, 1.0, -1.0)
    # Beyond the largest severity a90 is only a way to say that the curve stays below.
    at = np.linspace(log_a.min() - 1.0, np.log(most) + 4.0, _STEPS)
    best, slope, profile = _likeliest(log_a, sign, at, _SLOPES)
    near = np.linspace(-1.0, 1.0, _FINE) * (at[1] - at[0])
    finer = np.geomspace(_SLOPES[0] / _SLOPES[1], _SLOPES[1] / _SLOPES[0], _FINE)
    exact, slope, top = _likeliest(log_a, sign, best + near, slope * finer)
    # The last a90 that is not rejected, between two of both grids.
    order = np.argsort(np.concatenate([at, best + near]), kind="stable")
    at, profile = np.concatenate([at, best + near])[order], np.concatenate([profile, top])[order]
    last = int(np.flatnonzero(profile >= top.max() - _DROP)[-1])
    if last == at.size - 1:
        return Logit(float(np.exp(exact)), slope, np.inf)
    share = (profile[last] - top.max() + _DROP) / (profile[last] - profile[last + 1])
    bound = float(np.exp(at[last] + share * (at[last + 1] - at[last])))
    return Logit(float(np.exp(exact)), slope, reached(bound, most))


def _likeliest(
    log_a: FloatArray, sign: FloatArray, at: FloatArray, slopes: FloatArray
) -> tuple[float, float, FloatArray]:
    """ln a90, slope, and the log likelihood of each a90 with its best slope."""
    margin = sign * (log_a - at[:, None])
    table = np.stack([-np.logaddexp(0.0, -sign * _LN9 - b * margin).sum(axis=1) for b in slopes], axis=1)
    profile = table.max(axis=1)
    # A gap between found and missed leaves a range of equally likely a90: its middle.
    top = np.flatnonzero(profile >= profile.max() - 1e-6)
    best = int(top[top.size // 2])
    return float(at[best]), float(slopes[int(table[best].argmax())]), profile


def reached(a: float, most: float = HIGHEST) -> float:
    """Infinity for what lies beyond every severity."""
    return a if a <= most else np.inf


def rising(share: FloatArray) -> FloatArray:
    """The nearest curve that nowhere falls (least squares): detection does not become less with damage.

    Examples
    --------
    >>> rising(np.array([0.1, 0.4, 0.2, 0.9])).round(2).tolist()
    [0.1, 0.3, 0.3, 0.9]
    """
    blocks: list[tuple[float, int]] = []
    for value in share.tolist():
        blocks.append((value, 1))
        while len(blocks) > 1 and blocks[-2][0] >= blocks[-1][0]:
            (b, n), (a, m) = blocks.pop(), blocks.pop()
            blocks.append(((a * m + b * n) / (m + n), m + n))
    return np.repeat([value for value, _ in blocks], [count for _, count in blocks])


def crossing(severity: FloatArray, share: FloatArray, level: float) -> float:
    """Severity from which on a rising curve is at the level or above; infinity where it ends below."""
    reached_at = np.flatnonzero(share >= level)
    if not reached_at.size:
        return np.inf
    first = int(reached_at[0])
    if first == 0:
        return float(severity[0])
    (low, high), (a, b) = share[first - 1 : first + 1], np.log(severity[first - 1 : first + 1])
    return float(np.exp(a + (b - a) * (level - low) / (high - low)))
