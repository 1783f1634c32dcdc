"""A change that no element explains: of every value by any amount, or of all values alike.

The evidence that :meth:`antires_rs.damage.likelihood.Likelihood.something_else` has, from one eigenvalue
problem for each way to associate values and roots: an error of every value is added to the eigenvalues, one
of all alike is of rank one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..damage.likelihood import ALIKE, ALIKE_SHARE, ANY_CHANGE
from ..damage.measured_states import Values
from ..damage.view import Band, Foreseen, associated

__all__ = ["something_else"]

#: Errors of the roots and multiples of all errors with which values and roots are associated.
_PATTERNS = ((0.0, 1.0), (0.01, 1.0), (0.06, 3.0))


def something_else(now: Values, start: Foreseen, band: Band) -> tuple[float, float]:
    """Log evidence, and the relative change of all values where it is mostly that; else 0."""
    by_itself = np.full(ANY_CHANGE.size, -np.inf)
    alike = np.full(len(ALIKE), -np.inf)
    shift, likeliest = 0.0, -np.inf
    known: list[NDArray[np.intp]] = []
    for extra, wider in _PATTERNS:
        sigma = np.sqrt(np.maximum(np.diag(start.spread), 0.0) + extra**2)
        partner, place, price = associated(now, start, band, sigma, wider)
        if any(np.array_equal(partner, each) for each in known):
            continue
        known.append(partner)
        has = np.flatnonzero(partner >= 0)
        root = partner[has]
        residual = place[has] - start.place[root]
        if not has.size:
            continue
        covariance = start.spread[np.ix_(root, root)]
        covariance[np.diag_indices(root.size)] += now.std[has] ** 2
        size, vectors = np.linalg.eigh(covariance)
        size = np.maximum(size, 1e-16)
        y, ones = residual @ vectors, vectors.sum(axis=0)
        usual = -0.5 * has.size * np.log(2.0 * np.pi) - price
        more = size + (ANY_CHANGE**2)[:, None]
        by_itself = np.maximum(by_itself, usual - 0.5 * np.sum(np.log(more) + y**2 / more, axis=1))
        plain = usual - 0.5 * np.sum(np.log(size) + y**2 / size)
        s, q, c2 = np.sum(ones**2 / size), np.sum(ones * y / size), np.array(ALIKE) ** 2
        own = plain - 0.5 * np.log1p(c2 * s) + 0.5 * c2 * q**2 / (1.0 + c2 * s)
        if own.max() > likeliest:
            shift, likeliest = float(np.expm1(np.median(residual))), float(own.max())
        alike = np.maximum(alike, own)
    of_each = np.log1p(-ALIKE_SHARE) + np.logaddexp.reduce(by_itself) - np.log(by_itself.size)
    of_all = np.log(ALIKE_SHARE) + np.logaddexp.reduce(alike) - np.log(alike.size)
    return float(np.logaddexp(of_each, of_all)), shift if of_all > of_each else 0.0
