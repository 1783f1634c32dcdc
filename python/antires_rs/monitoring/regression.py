"""Straight lines through values with gaps and wild points: least squares with Huber's weights.

Reference: P. J. Huber, Robust Statistics, 1981, chapter 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.validation import FloatArray

__all__ = ["Regression", "fitted"]

#: Residuals beyond so many standard deviations count less, with 95 % efficiency for normal ones.
HUBER = 1.345
ROUNDS = 12
#: The median of the absolute values of a standard normal variable.
_MAD = 0.6745
#: Ridge relative to the mean diagonal: where the rows do not tell a coefficient, it is 0.
_RIDGE = 1e-9


@dataclass(frozen=True)
class Regression:
    """Coefficients (q, m) of the columns of a basis, and (X'X)^-1 of its rows, (q, q)."""

    coefficients: FloatArray
    inverse: FloatArray

    def at(self, x: FloatArray) -> FloatArray:
        """Values (n, m) at rows (n, q)."""
        return np.asarray(x @ self.coefficients)

    def leverage(self, x: FloatArray) -> FloatArray:
        """Variance of the fitted value over that of a single one, (n,)."""
        return np.asarray(np.einsum("ij,jk,ik->i", x, self.inverse, x))


def fitted(y: FloatArray, x: FloatArray) -> Regression:
    """Each column of y (n, m), NaN where there is no value, on the rows of x (n, q)."""
    there = ~np.isnan(y)
    filled = np.where(there, y, 0.0)
    weight = there.astype(np.float64)
    # About its median: logarithms of hertz are of one size, their changes 1e-3 of it.
    middle = _median(y)
    filled = np.where(there, filled - middle, 0.0)
    size = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-300)
    scaled = x / size
    eye = np.eye(x.shape[1])
    products = (scaled[:, :, None] * scaled[:, None, :]).reshape(len(x), -1)
    for _ in range(ROUNDS):
        gram = (weight.T @ products).reshape(-1, *eye.shape)
        gram += _RIDGE * np.maximum(np.trace(gram, axis1=1, axis2=2), 1e-300)[:, None, None] * eye
        right = (weight * filled).T @ scaled
        coefficients = np.linalg.solve(gram, right[..., None])[..., 0].T
        rest = np.where(there, filled - scaled @ coefficients, np.nan)
        if x.shape[0] < 4:
            break
        with np.errstate(invalid="ignore", divide="ignore"):
            scale = _median(np.abs(rest)) / _MAD
            wild = np.abs(rest) / (HUBER * np.maximum(scale, 1e-300))
            weight = np.where(there, 1.0 / np.maximum(wild, 1.0), 0.0)
    coefficients = coefficients / size[:, None]
    coefficients[0] += middle  # the first column of every basis is 1
    inverse = np.linalg.inv(scaled.T @ scaled + _RIDGE * len(x) * eye) / np.outer(size, size)
    return Regression(coefficients, inverse)


def _median(values: FloatArray) -> FloatArray:
    """Of each column, 0 where it is empty; sorting puts NaN last, ten times as fast as nanmedian."""
    ranked = np.sort(values, axis=0)
    count = np.sum(~np.isnan(values), axis=0)
    at = np.arange(values.shape[1])
    low, high = np.maximum((count - 1) // 2, 0), np.minimum(count // 2, len(values) - 1)
    return np.asarray(np.where(count > 0, 0.5 * (ranked[low, at] + ranked[high, at]), 0.0))
