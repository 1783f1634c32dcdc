r"""A large model on few dofs around one point, whichever of a few severities change from there.

The basis at the point (:mod:`~antires_rs.updating.reduced_basis`: modes, Krylov vectors of force and
sensors) carries the model there. Damage of element e adds :math:`\delta\, K_e`; what answers it are
:math:`A^{-1} K_e v` for all v of the basis and :math:`A^{-1} K_e w`, :math:`A^{-1} M w` for all w found so
far, with A = K + sigma M: a group of elements moves in few ways, so that these end soon. They are made for
the elements asked for only.

Slopes by all parameters come from the null vectors of each root: those of the reduced model are those of the
full one, and the terms of the full one are sparse.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .. import _core
from ..models.entries import Entries
from ..updating.affine import matrices
from ..updating.reduced_basis import Basis, beside, point_basis, solved
from ..updating.reduced_model import coordinates

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..support.validation import FloatArray
    from .terms import Terms

__all__ = ["Local", "NearPoint"]

#: Vectors that an element's damage makes: generations, and the least size of one.
_GENERATIONS, _LEAST = 4, 1e-4
#: A direction of several elements together that is smaller is one of them twice.
_INERTIA = 0.5
_SAME = 1e-5
#: Memory of what is kept of sets of elements (bytes), at about so many vectors a set; least number of sets.
_ROOM, _USUAL, _LEAST_KEPT = 6e8, 120, 16

_Key = TypeVar("_Key")
_Made = TypeVar("_Made")


class NearPoint:
    """Reduced models around one point x (n,) of the terms, for the responses of ``parts`` by row."""

    def __init__(self, terms: Terms, x: FloatArray, depth: int) -> None:
        self.terms, self.x = terms, x.copy()
        core = terms.at(x)
        self.stiffness, self.mass = matrices(core)
        basis, self.moving = point_basis(core, terms.sensors, terms.forces, terms.limit_hz, depth)
        self.basis: Basis = basis
        self._shifted = (self.stiffness + basis.sigma * self.mass).tocsc()
        own = basis.vectors
        self._own = own, self.stiffness @ own, self.mass @ own
        self._square = tuple(own.T @ each for each in self._own[1:])
        self._local: dict[tuple[int, ...], Local] = {}
        self._most = max(_LEAST_KEPT, int(_ROOM / (8 * _USUAL * terms.n_dof)))
        self._alone: dict[int, tuple[FloatArray, FloatArray]] = {}

    def local(self, elements: tuple[int, ...]) -> Local:
        """The reduced model in which the severities of ``elements`` are free."""
        return _kept(self._local, elements, lambda key: Local(self, key, self._answering(key)), self._most)

    def _answering(self, elements: tuple[int, ...]) -> FloatArray:
        """What answers damage of the elements, beside the basis, (n, k)."""
        if not elements:
            return np.empty((self.terms.n_dof, 0))
        alone = [_kept(self._alone, e, self._of_one, self._most // 2) for e in elements]
        if len(alone) == 1:
            return alone[0][0]
        own = self.basis.vectors
        joined = beside(self._shifted, own, np.hstack([v for v, _ in alone]), _SAME)
        others = [
            (e, natural) for e in elements for f, (_, natural) in zip(elements, alone, strict=True) if f != e
        ]
        moved = self._moved(others)
        core = np.hstack([own, joined])
        return np.hstack([joined, beside(self._shifted, core, moved, _LEAST)])

    def _of_one(self, element: int) -> tuple[FloatArray, FloatArray]:
        """What answers damage of one element, and the same in the size in which it does, with signs."""
        core, last = self.basis.vectors, self.moving
        found: list[FloatArray] = []
        sized: list[FloatArray] = []
        for nth in range(_GENERATIONS):
            moved = self._moved([(element, last)])
            if nth:
                inertia = self.basis.limit * _INERTIA * (self.mass @ last)
                moved = np.hstack([moved, solved(self.basis.factors, inertia)])
            new = beside(self._shifted, core, moved, _LEAST)
            if not new.shape[1]:
                break
            turn, sizes, _ = np.linalg.svd(new.T @ (self._shifted @ moved), full_matrices=False)
            last = new @ (turn * sizes)
            found.append(new)
            sized.append(last)
            core = np.hstack([core, new])
        none = [np.empty((self.terms.n_dof, 0))]
        return np.hstack(found or none), np.hstack(sized or none)

    def _moved(self, pairs: list[tuple[int, FloatArray]]) -> FloatArray:
        """A^-1 K_e v for elements e and vectors v."""
        loads = [self.terms.loads(e, self.x, vectors) for e, vectors in pairs]
        return solved(self.basis.factors, np.hstack(loads))

    def projected(self, more: FloatArray) -> tuple[FloatArray, FloatArray]:
        """K and M on the basis and ``more`` vectors."""
        found = []
        for matrix, mine, square in zip(
            (self.stiffness, self.mass), self._own[1:], self._square, strict=True
        ):
            across = mine.T @ more
            found.append(np.block([[square, across], [across.T, more.T @ (matrix @ more)]]))
        return found[0], found[1]


def _kept(cache: dict[_Key, _Made], key: _Key, make: Callable[[_Key], _Made], most: int) -> _Made:
    """What there is, else what is made; those used last stay."""
    found = cache.pop(key, None)
    cache[key] = make(key) if found is None else found
    while len(cache) > most:
        cache.pop(next(iter(cache)))
    return cache[key]


class Local:
    """A reduced model whose free parameters are severities, beside a :class:`NearPoint`."""

    def __init__(self, near: NearPoint, elements: tuple[int, ...], vectors: FloatArray) -> None:
        self._near, self._elements, self.vectors = near, elements, vectors
        terms, own = near.terms, near.basis.vectors
        self._change = coordinates(np.hstack([own[terms.rows], vectors[terms.rows]]))
        self.size = self._change.shape[1]
        # An objective has a parameter at least.
        scaled = elements or (0,)
        each = [self._entries(self._of_term(e)) for e in scaled]
        both = [self._entries(matrix) for matrix in near.projected(vectors)]
        model = _core.Model.from_matrices(self.size, both[0], both[1], each, [])
        free = [("stiffness_reduction", [nth], False, None) for nth in range(len(scaled))]
        self.core = _core.Objective.antiresonance(
            model, free, terms.reduced_parts, "squared", None, 0.0, None
        )

    def severities(self, rows: FloatArray) -> FloatArray:
        """The free parameters at rows (m, n) of all: what is lost of what the point has left."""
        if not self._elements:
            return np.zeros((len(rows), 1))
        at = list(self._elements)
        return np.ascontiguousarray(1.0 - (1.0 - rows[:, at]) / (1.0 - self._near.x[at]))

    def null_vectors(self, row: FloatArray) -> tuple[Any, ...]:
        """Target, frequency (Hz) and visibility of the roots at a row; left and right null vectors on the
        full model (dofs, roots); leftᵀ M right."""
        low, high = self._near.terms.slopes_hz
        target, hz, shown, left, right, slope = self.core.null_vectors(
            self.severities(row[None])[0], low, high
        )
        own, count = self._near.basis.vectors, self._near.basis.vectors.shape[1]

        def full(coefficients: FloatArray) -> FloatArray:
            turned = self._change @ coefficients.T
            return np.asarray(own @ turned[:count] + self.vectors @ turned[count:])

        return target, hz, shown, full(left), full(right), slope

    def _of_term(self, element: int) -> FloatArray:
        """The term that is lost with severity one of what the point has left, on the vectors."""
        terms, near = self._near.terms, self._near
        term = terms.of_element(element)
        here = np.hstack([near.basis.vectors[term.dofs], self.vectors[term.dofs]])
        return np.asarray(terms.left(element, near.x) * (here.T @ (term.matrix @ here)))

    def _entries(self, matrix: FloatArray) -> Entries:
        small = self._change.T @ matrix @ self._change
        return Entries.of(0.5 * (small + small.T))
