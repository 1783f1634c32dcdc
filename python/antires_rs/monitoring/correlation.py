r"""Correlations of many values from few tests.

Factors that all values share (eigenvalues above what noise of this size makes, Marchenko and Pastur) are kept
as they are; what is left of the correlations is shrunk towards none by

.. math:: \lambda = \sum_{i \ne j} \mathrm{Var}(r_{ij}) / \sum_{i \ne j} r_{ij}^2.

References: V. A. Marchenko, L. A. Pastur, Math. USSR-Sbornik 1 (1967) 457-483; J. Schaefer, K. Strimmer,
Stat. Appl. Genet. Mol. Biol. 4 (2005) 32.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray

__all__ = ["correlations"]

#: Eigenvalues this much above the edge of noise are factors; at most so many of them.
_ABOVE, _MOST = 1.3, 4
_LEAST = 0.05


def correlations(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Correlation matrix (m, m) of normal scores (n, m) with NaN, and loadings (m, k) of its factors."""
    there = ~np.isnan(z)
    filled = np.where(there, z, 0.0)
    count = there.T.astype(float) @ there.astype(float)
    sums = filled.T @ filled
    size = np.sqrt(np.maximum(np.diag(sums), 1e-300) / np.maximum(np.diag(count), 1.0))
    r = sums / np.maximum(count, 1.0) / np.outer(size, size)
    # Pairs that are hardly ever seen together tell nothing.
    r = np.where(count >= 4, np.clip(r, -0.98, 0.98), 0.0)
    np.fill_diagonal(r, 1.0)
    m, n = len(r), max(4.0, float(np.median(count)))
    loadings = _factors(r, n)
    common = loadings @ loadings.T
    own = np.maximum(1.0 - np.diag(common), _LEAST)
    rest = r - common
    off = rest[~np.eye(m, dtype=bool)]
    noise = ((1.0 - r**2) ** 2 / np.maximum(count - 1.0, 1.0))[~np.eye(m, dtype=bool)]
    share = 1.0 if not off.size else float(np.clip(noise.sum() / max(np.sum(off**2), 1e-300), 0.0, 1.0))
    rest = (1.0 - share) * rest
    np.fill_diagonal(rest, own)
    return _positive(rest) + common, loadings


def _factors(r: FloatArray, n: float) -> FloatArray:
    """Loadings of what stands above noise."""
    m = len(r)
    if m < 4:
        return np.empty((m, 0))
    values, vectors = np.linalg.eigh(r)
    edge = _ABOVE * (1.0 + np.sqrt(m / n)) ** 2
    kept = np.flatnonzero(values > edge)[::-1][: min(_MOST, m // 4)]
    # What noise adds to an eigenvalue is taken off it.
    return np.asarray(vectors[:, kept] * np.sqrt(np.maximum(values[kept] - 1.0 - m / n, 0.0)))


def _positive(a: FloatArray) -> FloatArray:
    """The matrix with no eigenvalue near or below 0."""
    values, vectors = np.linalg.eigh(0.5 * (a + a.T))
    return np.asarray((vectors * np.maximum(values, _LEAST)) @ vectors.T)
