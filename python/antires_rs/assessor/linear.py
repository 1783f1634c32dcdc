"""Evidence of many sets of one or two elements at once, as one view has them.

The same integrals as :func:`antires_rs.damage.evidence.fitted`, without its Python loop.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..damage.box import log_between
from ..damage.evidence import FURTHEST, HIGHEST
from ..damage.view import View
from ..support.validation import FloatArray

__all__ = ["further_gains", "pair_evidence", "single_evidence"]

#: As in the evidence: precision of u where nothing sees it, change of u up to which roots are linear.
_BLIND, _LINEAR = 1e-2, 0.12
#: Pairs so far below the likeliest get no evidence.
_HOPELESS = 6.0
#: Least severity (u) of either element for a pair that the slopes do not reach.
_IDLE = 0.01


def single_evidence(view: View) -> FloatArray:
    """Log evidence of each element alone, (n,); the view is one without damage. Where the most probable
    severity is out of reach of the slopes it is what they say nevertheless."""
    gain, precision = view.gain - 1.0, np.diag(view.curvature) + _BLIND
    mean, std = gain / precision, 1.0 / np.sqrt(precision)
    inside = log_between(-mean / std, (FURTHEST - mean) / std)
    volume = np.log(np.sqrt(2.0 * np.pi) * std / HIGHEST)
    return np.asarray(view.log_likelihood + 0.5 * gain * mean + volume + inside)


def further_gains(view: View, elements: tuple[int, ...]) -> FloatArray:
    """Rise of the log-likelihood by each element (n,) beside those of a view from their own severities."""
    own = list(elements)
    known = view.curvature[np.ix_(own, own)] + _BLIND * np.eye(len(own))
    share = np.linalg.solve(known, np.column_stack([view.gain[own], view.curvature[own]]))
    gain = view.gain - view.curvature[:, own] @ share[:, 0]
    precision = np.diag(view.curvature) - np.sum(view.curvature[own] * share[:, 1:], axis=0)
    found = 0.5 * np.clip(gain, 0.0, None) ** 2 / np.maximum(precision, _BLIND)
    found[own] = 0.0
    return np.asarray(found)


def pair_evidence(view: View, pairs: NDArray[np.intp]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log evidence of pairs (k, 2), -inf where it is hopeless or out of reach; most probable u (k, 2); and
    the log evidence (k,) of those that are out of reach, as far as slopes tell it."""
    room = 1.0 - view.beta[pairs]
    start = -np.log(room)
    i, j = pairs.T
    a = view.curvature[i, i] * room[:, 0] ** 2 + _BLIND
    c = view.curvature[j, j] * room[:, 1] ** 2 + _BLIND
    b = view.curvature[i, j] * room[:, 0] * room[:, 1]
    determinant = a * c - b**2
    gain = view.gain[pairs] * room - 1.0
    step = np.stack([c * gain[:, 0] - b * gain[:, 1], a * gain[:, 1] - b * gain[:, 0]], axis=1)
    step /= determinant[:, None]
    mean = start + step
    best = _peaks(mean, a, b, c)
    evidence = view.log_likelihood + 0.5 * np.sum(gain * step, axis=1) - start.sum(axis=1)
    evidence += np.log(2.0 * np.pi) - 0.5 * np.log(determinant) - 2.0 * np.log(HIGHEST)
    within = np.all(np.abs(best - start) <= _LINEAR, axis=1)
    # What lies outside of the box costs at least what its peak does.
    apart = best - mean
    cost = 0.5 * (a * apart[:, 0] ** 2 + 2.0 * b * apart[:, 0] * apart[:, 1] + c * apart[:, 1] ** 2)
    both = np.all(best > _IDLE, axis=1)
    likely = np.where(both & ~within, evidence - cost, -np.inf)
    bound = np.where(within, evidence - cost, -np.inf)
    worth = np.flatnonzero(bound > bound.max(initial=-np.inf) - _HOPELESS)
    found = np.full(len(pairs), -np.inf)
    found[worth] = evidence[worth] + _log_inside(mean[worth], a[worth], b[worth], c[worth])
    return found, best, likely


def _peaks(mean: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Most probable points in [0, FURTHEST]^2, of precisions [[a, b], [b, c]]."""
    first = np.clip(mean[:, 0], 0.0, FURTHEST)
    second = np.clip(mean[:, 1], 0.0, FURTHEST)
    # With one on its bound, the other follows; the better of both ways.
    other = np.clip(mean[:, 1] - b / c * (first - mean[:, 0]), 0.0, FURTHEST)
    one = np.clip(mean[:, 0] - b / a * (second - mean[:, 1]), 0.0, FURTHEST)
    ways = np.stack([np.stack([first, other], axis=1), np.stack([one, second], axis=1)])
    apart = ways - mean
    cost = a * apart[..., 0] ** 2 + 2.0 * b * apart[..., 0] * apart[..., 1] + c * apart[..., 1] ** 2
    return np.asarray(np.where((cost[0] <= cost[1])[:, None], ways[0], ways[1]))


#: Rule of quadrature along the first coordinate.
_X, _W = np.polynomial.legendre.leggauss(12)


def _log_inside(mean: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """ln of the probability of [0, FURTHEST]^2, of precisions [[a, b], [b, c]]."""
    determinant = a * c - b**2
    std = np.sqrt(c / determinant)
    # The first coordinate over where it has any probability in the box, the second given it in closed form.
    top = np.clip(mean[:, 0], 0.0, FURTHEST)
    decay = std**2 / np.maximum(np.abs(mean[:, 0] - top), std)
    low = np.maximum(0.0, top - 7.0 * decay)
    high = np.minimum(FURTHEST, top + 7.0 * decay)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    x = middle[:, None] + half[:, None] * _X
    given = mean[:, 1, None] - (b / c)[:, None] * (x - mean[:, 0, None])
    own = 1.0 / np.sqrt(c)[:, None]
    logs = -0.5 * ((x - mean[:, 0, None]) / std[:, None]) ** 2 - np.log(np.sqrt(2.0 * np.pi) * std)[:, None]
    logs += log_between(-given / own, (FURTHEST - given) / own) + np.log(_W * half[:, None])
    return np.asarray(np.logaddexp.reduce(logs, axis=1))
