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

__all__ = ["Basis", "basis_at", "beside", "point_basis", "solved"]

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
    size, least = largest
    carried = _carried(affine.at(x), (affine.sensors, affine.forces), f_max_hz, depth)
    shifted, factors, sigma = carried.shifted, carried.factors, carried.sigma
    own = _orthonormal(shifted, np.hstack(carried.blocks))[:, :size]
    moved = _moved(factors, affine, half_widths, sigma, carried.moving)
    more = _beside(shifted, own, moved, size - own.shape[1], least)
    return Basis(np.hstack([own, more]), factors, sigma, carried.limit)


def point_basis(
    core: CoreModel, sensors: list[int], forces: list[int], f_max_hz: float, depth: int
) -> tuple[Basis, FloatArray]:
    """The basis of one model without parameters, and the vectors that these move most, of unit size."""
    carried = _carried(core, (sensors, forces), f_max_hz, depth)
    own = _orthonormal(carried.shifted, np.hstack(carried.blocks))
    return Basis(own, carried.factors, carried.sigma, carried.limit), carried.moving


@dataclass(frozen=True)
class _Carried:
    """Vectors that carry a model, block by block, with K + sigma M and its factors."""

    shifted: Any
    factors: Any
    sigma: float
    limit: float
    blocks: list[FloatArray]
    moving: FloatArray


def _carried(core: CoreModel, ends: tuple[list[int], list[int]], f_max_hz: float, depth: int) -> _Carried:
    from scipy import sparse
    from scipy.sparse.linalg import splu

    stiffness, mass = matrices(core)
    limit = (2.0 * np.pi * f_max_hz) ** 2
    sigma = _SHIFT * limit
    shifted = sparse.csc_matrix(stiffness + sigma * mass)
    factors = splu(
        shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    blocks, first = [_modes(core, f_max_hz)], []
    for rows, count in zip(ends, (depth, depth + _MORE_OF_FORCE), strict=True):
        loads = np.zeros((mass.shape[0], len(rows)))
        loads[rows, range(len(rows))] = 1.0
        for _ in range(count):
            blocks.append(factors.solve(loads))
            loads = np.asarray(mass @ blocks[-1])
        first.append(blocks[-count])
    moving = _units(shifted, np.hstack([blocks[0], *first]))
    return _Carried(shifted, factors, sigma, limit, blocks, moving)


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
        blocks.append(solved(factors, loads))
    return blocks


def solved(factors: Any, loads: FloatArray) -> FloatArray:
    """A^-1 times many loads (n, m)."""
    parts = [factors.solve(loads[:, at : at + _AT_ONCE]) for at in range(0, loads.shape[1], _AT_ONCE)]
    return np.hstack(parts) if parts else loads


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
    if not moved or room <= 0:
        return np.empty((core.shape[0], 0))
    return beside(shifted, core, np.hstack(moved), room, least)[0]


def beside(
    shifted: Any, core: FloatArray, vectors: FloatArray, room: int, least: float
) -> tuple[FloatArray, FloatArray]:
    """The largest directions of ``vectors`` (n, m) beside an orthonormal core, and their sizes."""
    weighted = shifted @ vectors
    inside = core.T @ weighted
    # What is kept is far above the digits that the difference loses.
    sizes, rotation = _principal(vectors.T @ weighted - inside.T @ inside)
    kept = int(np.count_nonzero(sizes[:room] > least))
    if kept == 0:
        return np.empty((core.shape[0], 0)), np.empty(0)
    turn = rotation[:, :kept] / sizes[:kept]
    found = _without(shifted, vectors @ turn - core @ (inside @ turn), core)
    return _orthonormal(shifted, found), sizes[:kept]
