"""The roots of a large model at many severities, from reduced models around the model after the baseline.

Points that were settled have a basis of their own, and their roots were compared with the full model's.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measured.modal_set import ModalSet
from ..support.progress import step
from ..support.validation import reject
from ..updating.reduced_error import expected_errors
from .near_point import Local, NearPoint
from .roots import SHOWN, Roots

if TYPE_CHECKING:
    from .. import _core
    from ..models.structural_model import StructuralModel
    from ..support.validation import FloatArray
    from .terms import Terms

__all__ = ["TOLERANCE", "ReducedRoots", "wanted_reduced"]

#: Krylov vectors of a sensor, first and most; relative difference from the full model's roots that is enough.
_DEPTH, _DEEPEST, TOLERANCE = 3, 7, 1e-6
#: Roots so far (ln f) beside the measured band are compared too.
_BESIDE = 0.01
#: More dofs than these are reduced unless told otherwise.
_LARGE = 2000


class ReducedRoots:
    """A :class:`~antires_rs.damage.roots.Source` of a model of many dofs; ``full`` is the core's own."""

    def __init__(self, terms: Terms, full: _core.Objective) -> None:
        self.terms, self._full = terms, full
        self._base: NearPoint | None = None
        self._settled: dict[bytes, NearPoint] = {}
        self._depth = _DEPTH
        #: Bases made, evaluations of the full model, and the dofs of the largest reduced one.
        self.bases, self.full_evaluations, self.largest = 0, 0, 0
        #: Largest relative error to be expected of a measured root at what was settled last.
        self.expected = 0.0

    def roots(self, candidates: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        """The roots at each row of ``candidates`` (m, n); all rows have the same factors."""
        n = self.terms.n
        alike: dict[tuple[int, ...], list[int]] = {}
        found: list[Roots | None] = [None] * len(candidates)
        jobs: list[tuple[list[int], Local]] = []
        for nth, row in enumerate(candidates):
            near = self._settled.get(row.tobytes())
            if near is not None:
                jobs.append(([nth], near.local(())))
            else:
                alike.setdefault(tuple(np.flatnonzero(row[:n]).tolist()), []).append(nth)
        if alike:
            base = self._base_at(candidates[0, n:])
            for elements, rows in alike.items():
                step("reduced models")
                local = base.local(elements)
                for own, one in zip(rows, self._at(local, candidates[rows], slopes, threads), strict=True):
                    found[own] = one
        for (nth,), local in jobs:
            found[nth] = self._at(local, candidates[[nth]], slopes, threads)[0]
        return [one for one in found if one is not None]

    def settle(self, x: FloatArray) -> float:
        """Give a point a basis of its own, deep enough that its roots are the full model's to ``TOLERANCE``.

        Returns the largest relative difference that is left.
        """
        self.full_evaluations += 1
        target, hz, shown, _ = self._full.states(x[None].copy(), False, 1)[0]
        exact = _seen(target, hz, shown)
        while True:
            near = NearPoint(self.terms, x, self._depth)
            self.bases += 1
            ours = self._at(near.local(()), x[None], False, 1)[0]
            apart = _largest_difference(ours, exact, self.terms)
            if apart <= TOLERANCE or self._depth >= _DEEPEST:
                break
            self._depth += 1
        self._settled[x.tobytes()] = near
        low, high = self.terms.measured_hz
        ours = ours.only(ours.between(np.log(low) - 1e-9, np.log(high) + 1e-9))
        rows, forces = np.array(self.terms.ends)[ours.response].T
        full = near.stiffness, near.mass
        told = expected_errors(full, near.basis, (rows, forces), np.exp(ours.log_f))
        self.expected = float(told.max(initial=0.0))
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
            return [_seen(*state[:3]) for state in states]
        with ThreadPoolExecutor(max(1, min(threads, len(rows)))) as pool:
            return list(pool.map(lambda row: self._with_slopes(local, row), rows))

    def _with_slopes(self, local: Local, row: FloatArray) -> Roots:
        target, hz, shown, *vectors = local.null_vectors(row)
        return _seen(target, hz, shown, self.terms.slopes(row, hz, *vectors))


def wanted_reduced(model: StructuralModel, measured: Any, given: Any) -> bool:
    """Whether to seek the roots on reduced models."""
    modes = isinstance(measured, ModalSet)
    if isinstance(given, str) and given == "auto":
        return model.n_dof > _LARGE and not modes
    if not isinstance(given, bool):
        reject(
            "reduction",
            given,
            "'auto', True or False",
            "Leave it out: large models are reduced where that is sound.",
        )
    if given and modes:
        reject("reduction", "a reduced model, but modes were measured", "antiresonances", "Leave it out.")
    return given


def _seen(target: Any, hz: FloatArray, shown: FloatArray, slopes: FloatArray | None = None) -> Roots:
    seen = (shown >= SHOWN) & (hz > 0.0)
    told = np.empty((0, 0)) if slopes is None else slopes[seen]
    return Roots(target[seen].astype(np.intp), np.log(hz[seen]), told)


def _largest_difference(one: Roots, other: Roots, terms: Terms) -> float:
    """Largest relative difference of the roots where values were measured; infinity where there are not as
    many."""
    low, high = np.log(terms.measured_hz) + [-_BESIDE, _BESIDE]
    inside = [roots.only(roots.between(low, high)) for roots in (one, other)]
    if not np.array_equal(inside[0].response, inside[1].response):
        return float("inf")
    return float(np.abs(np.expm1(inside[0].log_f - inside[1].log_f)).max(initial=0.0))
