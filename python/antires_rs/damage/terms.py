"""K and M of a model as sums of terms that severities and factors scale, and how roots move with each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._core import Model as CoreModel
    from ..models.parameter import Parameter
    from ..models.structural_model import StructuralModel
    from ..support.validation import FloatArray
    from .measured_states import Part

__all__ = ["Term", "Terms"]

#: The model is asked for roots up to this multiple of the highest measured one, as the core does; slopes are
#: told of those within so much (ln f) of what was measured.
_BAND, _NEAR = 1.5, 0.31
#: Terms of more dofs stay sparse.
_DENSE = 256


class Term(NamedTuple):
    """The dofs that a term joins, and its matrix (d, d) there."""

    dofs: NDArray[np.intp]
    matrix: Any

    @classmethod
    def of(cls, entries: Any) -> Term:
        """Of rows, columns and values."""
        from scipy.sparse import coo_array

        rows, columns, values = entries
        dofs = np.unique(np.concatenate([rows, columns])).astype(np.intp)
        at = np.searchsorted(dofs, rows), np.searchsorted(dofs, columns)
        matrix = coo_array((values, at), shape=(dofs.size, dofs.size))
        return cls(dofs, matrix.toarray() if dofs.size <= _DENSE else matrix.tocsr())

    def joined(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """leftᵀ term right for each column."""
        here = self.matrix @ right[self.dofs]
        return np.asarray(np.einsum("dz,dz->z", left[self.dofs], here))


class Terms:
    """A model whose parameters are the severities of ``elements``, then ``factors`` of single terms.

    ``rows`` are those of all measured dofs, ``sensors`` and ``forces`` among them; ``reduced_parts`` the
    responses where these rows are the first dofs, ``ends`` their rows in the full model; values were measured
    from ``measured_hz`` on, slopes are told between ``slopes_hz``.
    """

    def __init__(
        self,
        model: StructuralModel,
        parts: Sequence[Part],
        parameters: Any,
        elements: Sequence[int],
        factors: Sequence[Parameter],
    ) -> None:
        self._core, ends = model._core_for([dof for part in parts for dof in part[:2]])
        self._parameters, self.n = parameters, len(elements)
        self.sensors, self.forces = sorted(set(ends[::2])), sorted(set(ends[1::2]))
        self.ends = list(zip(ends[::2], ends[1::2], strict=True))
        self.rows = sorted({*ends})
        place = {row: nth for nth, row in enumerate(self.rows)}
        self.reduced_parts = [
            (place[i], place[k], *part[2:]) for (i, k), part in zip(self.ends, parts, strict=True)
        ]
        hz = np.concatenate([part[2] for part in parts])
        self.limit_hz = _BAND * float(hz.max())
        self.measured_hz = float(hz.min()), float(hz.max())
        self.slopes_hz = float(hz.min() * np.exp(-_NEAR)), float(hz.max() * np.exp(_NEAR))
        self._elements = list(elements)
        self._stiffness = [Term.of(each) for each in self._core.stiffness_terms()]
        self._factors = [(one.quantity, one.terms[0]) for one in factors]
        masses = {term for quantity, term in self._factors if quantity == "mass_factor"}
        self._mass = {t: Term.of(each) for t, each in enumerate(self._core.mass_terms()) if t in masses}

    @property
    def n_dof(self) -> int:
        """Dofs of the full model."""
        return self._core.n_dof

    def at(self, x: FloatArray) -> CoreModel:
        """The full model."""
        return self._core.at(self._parameters, np.ascontiguousarray(x))

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
        found[term.dofs] = self.left(element, x) * (term.matrix @ vectors[term.dofs])
        return found

    def slopes(
        self, x: FloatArray, hz: FloatArray, left: FloatArray, right: FloatArray, slope: FloatArray
    ) -> FloatArray:
        """d ln f / dp of roots (roots, parameters) by their null vectors (dofs, roots) on the full model.

        0 where a root has no derivative, or was not asked for.
        """
        known = np.flatnonzero(np.isfinite(slope) & (slope != 0.0))
        squares = (2.0 * np.pi * hz[known]) ** 2
        scale = 1.0 / (slope[known] * 2.0 * squares)
        if known.size < hz.size:
            left, right = left[:, known], right[:, known]
        found = np.zeros((hz.size, self.n + len(self._factors)))
        factor = self._factor_of(x)
        joined = {}
        for nth, term in enumerate(self._elements):
            joined[term] = self._stiffness[term].joined(left, right) * scale
            found[known, nth] = -factor.get(term, 1.0) * joined[term]
        lost = dict(zip(self._elements, x, strict=False))
        for nth, (quantity, term) in enumerate(self._factors, start=self.n):
            if quantity == "mass_factor":
                found[known, nth] = -squares * self._mass[term].joined(left, right) * scale
            else:
                found[known, nth] = (1.0 - lost.get(term, 0.0)) * joined[term]
        return np.where(np.isfinite(found), found, 0.0)

    def _factor_of(self, x: FloatArray) -> dict[int, float]:
        """Factor of each stiffness term that has one."""
        pairs = zip(self._factors, x[self.n :], strict=True)
        return {term: float(value) for (quantity, term), value in pairs if quantity != "mass_factor"}
