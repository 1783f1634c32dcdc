r"""The error to be expected of a reduced model's antiresonances, from its residuals on the full one.

With a and b the columns of the force and of the sensor on the reduced model, at a root x of it,

.. math:: r_a = e_k - (K - x M) V a, \quad r_b = e_i - (K - x M) V b, \quad
          \delta H_{ik} = r_b^T (K - x M)^{-1} r_a

is what H lacks, exactly; over its slope it is how far the root is off. The residuals have no part in the
basis, where the modes of the band are, so that outside of it :math:`(K - x M)^{-1}` is at most
:math:`(\lambda + \sigma) / (\lambda - x)` times :math:`(K + \sigma M)^{-1}`, whose factors are at hand.

Reference: Becker & Rannacher, Acta Numerica 10 (2001) 1-102 (residuals weighted with the dual solution).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .affine import Affine, matrices

if TYPE_CHECKING:
    from ..support.validation import FloatArray
    from .reduced_basis import Basis

__all__ = ["estimated_error", "expected_errors"]


def estimated_error(affine: Affine, basis: Basis, x: FloatArray, paired_hz: FloatArray) -> float:
    """Largest relative error of ``paired_hz``, the roots of the reduced model paired at ``x``."""
    problem = affine.problem
    rows, forces = affine.rows(problem.measured_dofs), affine.rows(problem.measured_excitations)
    there = ~np.isnan(paired_hz)
    asked = np.unique(np.stack([rows[there], forces[there], paired_hz[there]]), axis=1)
    if asked.size == 0:
        return 0.0
    ends = asked[0].astype(int), asked[1].astype(int)
    return float(np.max(expected_errors(matrices(affine.at(x)), basis, ends, asked[2])))


def expected_errors(
    full: tuple[Any, Any], basis: Basis, ends: tuple[Any, Any], roots_hz: FloatArray
) -> FloatArray:
    """Relative error of each root of the reduced model; ``ends`` are rows of response and force."""
    (responses, forces), roots = ends, (2.0 * np.pi * roots_hz) ** 2
    (stiffness, mass), vectors = full, basis.vectors
    of_stiffness, of_mass = vectors.T @ (stiffness @ vectors), vectors.T @ (mass @ vectors)
    dynamic = of_stiffness - roots[:, None, None] * of_mass
    loads = np.stack([vectors[forces], vectors[responses]], axis=2)
    columns = np.linalg.solve(dynamic, loads)
    slope = np.einsum("zi,ij,zj->z", columns[:, :, 1], of_mass, columns[:, :, 0])

    def residual(at: FloatArray, places: Any) -> FloatArray:
        full = vectors @ at.T
        left = -np.asarray(stiffness @ full) + np.asarray(mass @ full) * roots
        left[places, range(roots.size)] += 1.0
        return np.asarray(left)

    right = basis.factors.solve(residual(columns[:, :, 0], forces))
    lacking = np.einsum("iz,iz->z", residual(columns[:, :, 1], responses), right)
    stretch = (basis.limit + basis.sigma) / np.maximum(basis.limit - roots, basis.sigma)
    return np.asarray(np.abs(stretch * lacking / slope) / (2.0 * roots))
