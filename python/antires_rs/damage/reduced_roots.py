"""The roots of a large model at many severities, from reduced models around the model after the baseline."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..models.parameters import stiffness_reduction
from ..support.progress import step
from ..updating.reduced_model import (
    Large,
    Term,
    beside,
    coordinates,
    matrices,
    point_basis,
    projected,
    solved,
)
from .measured_states import Roots, shown_roots

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..models.parameters import Parameter
    from ..models.structural_model import StructuralModel
    from ..support.checks import FloatArray
    from ..updating.targets import Part


# -- A large model on few dofs around one point, whichever of a few severities change from there
#
# The basis at the point (:mod:`~antires_rs.updating.reduced_model`) carries the model there. Damage of
# element e adds :math:`\delta\, K_e`; what answers it are :math:`A^{-1} K_e v` for all v of the basis and
# :math:`A^{-1} K_e w`, :math:`A^{-1} M w` for all w found so far: a group of elements moves in few ways, so
# that these end soon. Slopes by all parameters come from the null vectors of each root and the full model's
# terms.

#: Vectors that an element's damage makes: generations, and the least size of one.
_GENERATIONS, _LEAST = 4, 1e-4
_INERTIA = 0.5  # a direction of several elements together that is smaller is one of them twice
_SAME = 1e-5
#: Memory of what is kept of sets of elements (bytes), at about so many vectors a set; least number of sets.
_ROOM, _USUAL, _LEAST_KEPT = 6e8, 120, 16


class NearPoint:
    """Reduced models around one point x (n,) of the terms, for the responses of ``parts`` by row."""

    def __init__(self, terms: Terms, x: FloatArray, depth: int) -> None:
        self.terms, self.x = terms, x.copy()
        self.stiffness, self.mass = matrices(terms.at(x))
        self.basis, self.moving = point_basis(terms, x, depth)
        self._shifted = self.basis.shifted
        own = self.basis.vectors
        self._own = own, self.stiffness @ own, self.mass @ own
        self._square = tuple(own.T @ each for each in self._own[1:])
        most = max(_LEAST_KEPT, int(_ROOM / (8 * _USUAL * terms.core.n_dof)))
        #: The reduced model in which the severities of some elements are free.
        self.local = lru_cache(most)(lambda elements: Local(self, elements, self._answering(elements)))
        self._alone = lru_cache(most // 2)(self._of_one)

    def _answering(self, elements: tuple[int, ...]) -> FloatArray:
        """What answers damage of the elements, beside the basis, (n, k)."""
        if not elements:
            return np.empty((self.terms.core.n_dof, 0))
        alone = [self._alone(e) for e in elements]
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
        none = [np.empty((self.terms.core.n_dof, 0))]
        return np.hstack(found or none), np.hstack(sized or none)

    def _moved(self, pairs: list[tuple[int, FloatArray]]) -> FloatArray:
        """A^-1 K_e v for elements e and vectors v."""
        loads = [self.terms.loads(e, self.x, vectors) for e, vectors in pairs]
        return solved(self.basis.factors, np.hstack(loads))

    def on_basis(self, more: FloatArray) -> tuple[FloatArray, FloatArray]:
        """K and M on the basis and ``more`` vectors."""
        (_, *across), (k, m) = (each.T @ more for each in self._own), self._square
        own = [more.T @ (matrix @ more) for matrix in (self.stiffness, self.mass)]
        return (
            np.block([[k, across[0]], [across[0].T, own[0]]]),
            np.block([[m, across[1]], [across[1].T, own[1]]]),
        )


class Local:
    """A reduced model whose free parameters are severities, beside a :class:`NearPoint`."""

    def __init__(self, near: NearPoint, elements: tuple[int, ...], vectors: FloatArray) -> None:
        self._near, self._elements, self.vectors = near, elements, vectors
        terms, own = near.terms, near.basis.vectors
        self._change = coordinates(np.hstack([own[terms.rows], vectors[terms.rows]]))
        self.size = self._change.shape[1]
        scaled = elements or (0,)  # An objective has a parameter at least.
        # What is lost with severity one of what the point has left.
        lost = [terms.left(e, near.x) * terms.of_element(e).on(own, vectors) for e in scaled]
        model = projected(self._change, *near.on_basis(vectors), lost, [])
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


#: Krylov vectors of a sensor, first and most; relative difference from the full model's roots that is enough.
_DEPTH, _DEEPEST, TOLERANCE = 3, 7, 1e-6
_BESIDE = 0.01  # roots so far (ln f) beside the measured band are compared too


class ReducedRoots:
    """The ``Source`` of ``measured_states`` for a model of many dofs; ``full`` is the core's own."""

    def __init__(self, terms: Terms, full: _core.Objective) -> None:
        self.terms, self._full = terms, full
        self._base: NearPoint | None = None
        self._settled: dict[bytes, NearPoint] = {}
        self._depth = _DEPTH
        #: Bases made, evaluations of the full model, and the dofs of the largest reduced one.
        self.bases, self.full_evaluations, self.largest = 0, 0, 0

    def roots(self, candidates: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        """The roots at each row of ``candidates`` (m, n); all rows have the same factors."""
        n = self.terms.n
        found: dict[int, Roots] = {}
        alike: dict[tuple[NearPoint, tuple[int, ...]], list[int]] = {}
        for nth, row in enumerate(candidates):
            near = self._settled.get(row.tobytes())
            elements = () if near else tuple(np.flatnonzero(row[:n]).tolist())
            alike.setdefault((near or self._base_at(row[n:]), elements), []).append(nth)
        for (near, elements), rows in alike.items():
            step("reduced models")
            own = self._at(near.local(elements), candidates[rows], slopes, threads)
            found |= dict(zip(rows, own, strict=True))
        return [found[nth] for nth in range(len(candidates))]

    def settle(self, x: FloatArray) -> float:
        """Give a point a basis with the full model's roots to ``TOLERANCE``; the largest difference left."""
        self.full_evaluations += 1
        exact = shown_roots(*self._full.states(x[None].copy(), False, 1)[0][:3])
        while True:
            near = NearPoint(self.terms, x, self._depth)
            self.bases += 1
            ours = self._at(near.local(()), x[None], False, 1)[0]
            apart = self._apart(ours, exact)
            if apart <= TOLERANCE or self._depth >= _DEEPEST:
                break
            self._depth += 1
        self._settled[x.tobytes()] = near
        return apart

    def _base_at(self, factors: FloatArray) -> NearPoint:
        x = np.concatenate([np.zeros(self.terms.n), factors])
        if self._base is None or not np.array_equal(self._base.x, x):
            self._base = self._settled.get(x.tobytes()) or NearPoint(self.terms, x, self._depth)
            self.bases += 1
        return self._base

    def _at(self, local: Local, rows: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        self.largest = max(self.largest, local.size)
        if not slopes:
            states = local.core.states(local.severities(rows), False, threads)
            return [shown_roots(*state[:3]) for state in states]

        def with_slopes(row: FloatArray) -> Roots:
            target, hz, shown, *vectors = local.null_vectors(row)
            return shown_roots(target, hz, shown, self.terms.slopes(row, hz, *vectors))

        with ThreadPoolExecutor(max(1, min(threads, len(rows)))) as pool:
            return list(pool.map(with_slopes, rows))

    def _apart(self, one: Roots, other: Roots) -> float:
        """Largest relative difference where values were measured; infinity if there are not as many."""
        low, high = np.log(self.terms.measured_hz) + [-_BESIDE, _BESIDE]
        one, other = (roots.only(roots.between(low, high)) for roots in (one, other))
        if not np.array_equal(one.response, other.response):
            return float("inf")
        return float(np.abs(np.expm1(one.log_f - other.log_f)).max(initial=0.0))


# -- K and M of a model as sums of terms that severities and factors scale, and how roots move with each

_NEAR = 0.31  # slopes are told of roots within so much (ln f) of what was measured


class Terms(Large):
    """A large model whose parameters are the severities of ``elements``, then ``factors`` of single terms."""

    def __init__(
        self,
        model: StructuralModel,
        parts: Sequence[Part],
        elements: Sequence[int],
        factors: Sequence[Parameter],
    ) -> None:
        super().__init__(model, parts, (*stiffness_reduction(elements), *factors))
        self.n, (low, high) = len(elements), self.measured_hz
        self.slopes_hz = low * np.exp(-_NEAR), high * np.exp(_NEAR)
        self._elements = list(elements)
        self._stiffness = [Term.of(each) for each in self.core.stiffness_terms()]
        self._factors = [(one.quantity, one.terms[0]) for one in factors]
        masses = {term for quantity, term in self._factors if quantity == "mass_factor"}
        self._mass = {t: Term.of(each) for t, each in enumerate(self.core.mass_terms()) if t in masses}

    def of_element(self, element: int) -> Term:
        """The term whose severity is number ``element``, whole."""
        return self._stiffness[self._elements[element]]

    def left(self, element: int, x: FloatArray) -> float:
        """Share of this term that there is at ``x``."""
        return float((1.0 - x[element]) * self._factor_of(x).get(self._elements[element], 1.0))

    def loads(self, element: int, x: FloatArray, vectors: FloatArray) -> FloatArray:
        """What is left of the term at ``x``, times vectors (dofs, m)."""
        term = self.of_element(element)
        found = np.zeros_like(vectors)
        found[term.dofs] = self.left(element, x) * term.times(vectors)
        return found

    def slopes(
        self, x: FloatArray, hz: FloatArray, left: FloatArray, right: FloatArray, slope: FloatArray
    ) -> FloatArray:
        """d ln f / dp of roots (roots, parameters) by their null vectors (dofs, roots); 0 where none."""
        known = np.flatnonzero(np.isfinite(slope) & (slope != 0.0))
        squares = (2.0 * np.pi * hz[known]) ** 2
        scale = 1.0 / (slope[known] * 2.0 * squares)
        if known.size < hz.size:
            left, right = left[:, known], right[:, known]
        found = np.zeros((hz.size, self.n + len(self._factors)))
        factor = self._factor_of(x)
        joined = {}
        for nth, term in enumerate(self._elements):
            joined[term] = _between(self._stiffness[term], left, right) * scale
            found[known, nth] = -factor.get(term, 1.0) * joined[term]
        lost = dict(zip(self._elements, x, strict=False))
        for nth, (quantity, term) in enumerate(self._factors, start=self.n):
            if quantity == "mass_factor":
                found[known, nth] = -squares * _between(self._mass[term], left, right) * scale
            else:
                found[known, nth] = (1.0 - lost.get(term, 0.0)) * joined[term]
        return np.where(np.isfinite(found), found, 0.0)

    def _factor_of(self, x: FloatArray) -> dict[int, float]:
        """Factor of each stiffness term that has one."""
        pairs = zip(self._factors, x[self.n :], strict=True)
        return {term: float(value) for (quantity, term), value in pairs if quantity != "mass_factor"}


def _between(term: Term, left: FloatArray, right: FloatArray) -> FloatArray:
    """leftᵀ term right for each column."""
    return np.asarray(np.einsum("dz,dz->z", left[term.dofs], term.times(right)))
