r"""Vectors that carry a model and its parameters' effect near one point, for antiresonances up to a limit.

With :math:`A = K + \sigma M` and :math:`\sigma > 0`:

- the modes up to the limit;
- for every force and sensor the first vectors of its Krylov space, :math:`A^{-1} e`,
  :math:`A^{-1} M A^{-1} e`, ...: they stand for all higher modes, and the first for dofs without mass;
- what a parameter makes of these to first order, :math:`A^{-1} K_j v`, of which the largest combinations
  are kept.

All are orthonormal in A. Projected on them (Galerkin) a root errs by the product of the errors of both
columns, that of the force and that of the sensor.

References: Ericsson & Ruhe, Math. Comp. 35 (1980) 1251-1268; Balmes, Mech. Syst. Signal Process. 10 (1996)
381-394 (bases of a parametric family); Benner, Gugercin & Willcox, SIAM Review 57 (2015) 483-531.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .affine import Affine, matrices

if TYPE_CHECKING:
    from .._core import Model as CoreModel
    from ..support.validation import FloatArray

__all__ = ["Basis", "basis_at"]

#: Shift, as a share of the limit in omega squared: small keeps digits of the lowest modes.
_SHIFT = 0.1
#: So many vectors more for a force than for a sensor: its error is a factor in that of all roots.
_MORE_OF_FORCE = 4
#: A direction this small beside the others is rounding.
_ROUNDING = 1e-7
#: So many right-hand sides are solved for at once.
_AT_ONCE = 256


@dataclass(frozen=True)
class Basis:
    """Vectors (n, r), factors of K + sigma M at the point, sigma, and the limit in omega squared."""

    vectors: FloatArray
    factors: Any
    sigma: float
    limit: float


def basis_at(
    affine: Affine,
    x: FloatArray,
    half_widths: FloatArray,
    f_max_hz: float,
    depth: int,
    largest: tuple[int, float],
) -> Basis:
    """The basis at one point.

    ``half_widths`` are the half of what each parameter may change by, ``depth`` the Krylov vectors of a
    sensor, ``largest`` the most vectors and the least size of one that parameters make.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    size, least = largest
    core = affine.at(x)
    stiffness, mass = matrices(core)
    limit = (2.0 * np.pi * f_max_hz) ** 2
    sigma = _SHIFT * limit
    shifted = sparse.csc_matrix(stiffness + sigma * mass)
    factors = splu(
        shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    blocks, first = [_modes(core, f_max_hz)], []
    for rows, count in ((affine.sensors, depth), (affine.forces, depth + _MORE_OF_FORCE)):
        loads = np.zeros((mass.shape[0], len(rows)))
        loads[rows, range(len(rows))] = 1.0
        for _ in range(count):
            blocks.append(factors.solve(loads))
            loads = np.asarray(mass @ blocks[-1])
        first.append(blocks[-count])
    own = _orthonormal(shifted, np.hstack(blocks))[:, :size]
    moving = _units(shifted, np.hstack([blocks[0], *first]))
    moved = _moved(factors, affine, half_widths, sigma, moving)
    beside = _beside(shifted, own, moved, size - own.shape[1], least)
    return Basis(np.hstack([own, beside]), factors, sigma, limit)


def _modes(core: CoreModel, f_max_hz: float) -> FloatArray:
    """Shapes up to the limit, (n, m)."""
    freq_hz, shapes = core.modes(f_max_hz, None)
    return np.asarray(shapes[:, freq_hz <= f_max_hz])


def _moved(
    factors: Any, affine: Affine, half_widths: FloatArray, sigma: float, vectors: FloatArray
) -> list[FloatArray]:
    """A^-1 (dK + sigma dM) v for every parameter, over half of its range."""
    blocks = []
    for (k, m), half in zip(affine.terms, half_widths, strict=True):
        if half <= 0.0:
            continue
        loads = half * np.asarray((k if k is not None else m) @ vectors) * (1.0 if k is not None else sigma)
        blocks += [factors.solve(loads[:, at : at + _AT_ONCE]) for at in range(0, loads.shape[1], _AT_ONCE)]
    return blocks


def _units(shifted: Any, vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.sqrt(np.einsum("ij,ij->j", vectors, shifted @ vectors)))


def _orthonormal(shifted: Any, vectors: FloatArray) -> FloatArray:
    """A-orthonormal combinations of vectors, brought to unit size, without those that rounding makes."""
    vectors = _units(shifted, vectors)
    for floor in (_ROUNDING, 0.5):  # twice, for the digits
        gram = vectors.T @ (shifted @ vectors)
        sizes, rotation = _principal(gram)
        kept = sizes > floor
        vectors = np.asarray(vectors @ (rotation[:, kept] / sizes[kept]))
    return vectors


def _principal(gram: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sizes of the principal directions, descending, and the directions."""
    squares, rotation = np.linalg.eigh(0.5 * (gram + gram.T))
    return np.sqrt(np.maximum(squares[::-1], 0.0)), rotation[:, ::-1]


def _without(shifted: Any, vectors: FloatArray, core: FloatArray) -> FloatArray:
    for _ in range(2):
        vectors = vectors - core @ (core.T @ (shifted @ vectors))
    return vectors


def _beside(shifted: Any, core: FloatArray, moved: list[FloatArray], room: int, least: float) -> FloatArray:
    """The largest directions of what moves out of the core."""
    none = np.empty((core.shape[0], 0))
    if not moved or room <= 0:
        return none
    vectors = np.hstack(moved)
    weighted = shifted @ vectors
    inside = core.T @ weighted
    # What is kept is far above the digits that the difference loses.
    sizes, rotation = _principal(vectors.T @ weighted - inside.T @ inside)
    kept = int(np.count_nonzero(sizes[:room] > least))
    if kept == 0:
        return none
    turn = rotation[:, :kept] / sizes[:kept]
    found = _without(shifted, vectors @ turn - core @ (inside @ turn), core)
    return _orthonormal(shifted, found)
