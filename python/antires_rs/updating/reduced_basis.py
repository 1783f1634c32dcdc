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

from ..exceptions import NumericalError
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
#: Directions of one parameter are left out below this part of the least size.
_PART = 0.2
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

    Raises
    ------
    NumericalError
        Fewer vectors than modes, forces and sensors need.
    """
    size, least = largest
    carried = _carried(affine.at(x), (affine.sensors, affine.forces), f_max_hz, depth)
    needed = carried.blocks[0].shape[1] + len(affine.sensors) + len(affine.forces)
    if size < needed:
        raise NumericalError(
            f"a reduced model of {size} vectors",
            f"the modes to {f_max_hz:.4g} Hz, the forces and the sensors alone take {needed}. Give "
            f"reduction=Reduction(size={2 * needed}) or more, or reduction=False.",
        )
    shifted, factors = carried.shifted, carried.factors
    own = _orthonormal(shifted, np.hstack(carried.blocks))[:, :size]
    moved = _moved(factors, affine, half_widths, carried.sigma, carried.moving, own, _PART * least)
    more = _beside(shifted, own, moved, size - own.shape[1], least)
    return Basis(np.hstack([own, more]), factors, carried.sigma, carried.limit)


def point_basis(
    core: CoreModel, sensors: list[int], forces: list[int], f_max_hz: float, depth: int
) -> tuple[Basis, FloatArray]:
    """The basis of one model without parameters, and the vectors that these move most, of unit size."""
    carried = _carried(core, (sensors, forces), f_max_hz, depth)
    own = _orthonormal(carried.shifted, np.hstack(carried.blocks))
    return Basis(own, carried.factors, carried.sigma, carried.limit), carried.moving


def beside(shifted: Any, core: FloatArray, vectors: FloatArray, least: float) -> FloatArray:
    """The directions of ``vectors`` (n, m) of more than the least size beside an orthonormal core."""
    loads = np.asarray(shifted @ vectors)
    return _beside(shifted, core, _Moved(vectors, loads, core.T @ loads), vectors.shape[1], least)


def solved(factors: Any, loads: FloatArray) -> FloatArray:
    """A^-1 times many loads (n, m)."""
    parts = [factors.solve(loads[:, at : at + _AT_ONCE]) for at in range(0, loads.shape[1], _AT_ONCE)]
    return np.hstack(parts) if parts else loads


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
    """``ends`` are sensors and forces."""
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


@dataclass(frozen=True)
class _Moved:
    """What parameters make of vectors: v = A^-1 l, l, and the part of v in the core, by columns."""

    vectors: FloatArray
    loads: FloatArray
    inside: FloatArray

    @classmethod
    def by(
        cls, nth: int, affine: Affine, change: float, factors: Any, of: FloatArray, core: FloatArray
    ) -> _Moved:
        """By one parameter: l = (dK + sigma dM) v."""
        places = affine.places[nth]
        held = change * affine.times(nth, of)
        n, m = of.shape
        loads = np.zeros((n, m))
        loads[places] = held
        return cls(solved(factors, loads), loads, core[places].T @ held)

    def principal(self, places: Any, least: float, most: int) -> tuple[_Moved, FloatArray]:
        """The largest combinations in what is outside of the core, and their sizes."""
        # What is kept is far above the digits that the difference loses.
        gram = self.vectors[places].T @ self.loads[places] - self.inside.T @ self.inside
        sizes, rotation = _principal(gram)
        kept = int(np.count_nonzero(sizes[:most] > least))
        turn = rotation[:, :kept]
        return _Moved(self.vectors @ turn, self.loads @ turn, self.inside @ turn), sizes[:kept]


def _moved(
    factors: Any,
    affine: Affine,
    half_widths: FloatArray,
    sigma: float,
    of: FloatArray,
    core: FloatArray,
    least: float,
) -> _Moved | None:
    """By all parameters, over half of their ranges."""
    found = []
    for nth, half in enumerate(half_widths):
        if half > 0.0:
            change = half * (1.0 if affine.terms[nth][0] is not None else sigma)
            moved = _Moved.by(nth, affine, change, factors, of, core)
            found.append(moved.principal(affine.places[nth], least, of.shape[1])[0])
    if not found:
        return None
    return _Moved(
        np.hstack([each.vectors for each in found]),
        np.hstack([each.loads for each in found]),
        np.hstack([each.inside for each in found]),
    )


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


def _beside(shifted: Any, core: FloatArray, moved: _Moved | None, room: int, least: float) -> FloatArray:
    """The largest directions of what moves out of the core."""
    none = np.empty((core.shape[0], 0))
    if moved is None or room <= 0 or moved.vectors.shape[1] == 0:
        return none
    largest, sizes = moved.principal(slice(None), least, room)
    if sizes.size == 0:
        return none
    found = _without(shifted, (largest.vectors - core @ largest.inside) / sizes, core)
    return _orthonormal(shifted, found)
