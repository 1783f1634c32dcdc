"""The matrices of a problem as sums: the term that each parameter scales.

``K(x) = K + sum (s_j(x_j) - 1) K_j`` with s_j the factor of a parameter, and so M. It holds for factors and
reductions that do not share a term; sections, angles and positions bend it. The rows are those of the core's
model in which every measured dof is one: what constraints take out is not there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.matrices import as_sparse
from .antiresonance_targets import AntiresonanceTargets
from .model_dofs import Part

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from .._core import Model as CoreModel
    from ..models.parameter import Parameter
    from ..support.validation import FloatArray
    from .problem import UpdatingProblem

__all__ = ["Affine", "bent_by", "matrices"]

#: Quantities in which K and M are linear, and the matrix that each scales.
_SCALES = {"stiffness_factor": "K", "stiffness_reduction": "K", "mass_factor": "M"}


def bent_by(parameters: Iterable[Parameter]) -> str | None:
    """Why K and M are no sums in these parameters; None where they are."""
    taken: set[tuple[str, int]] = set()
    for parameter in parameters:
        scaled = _SCALES.get(parameter.quantity)
        if scaled is None:
            return f"{parameter.quantity!r} does not scale whole terms"
        for term in parameter.terms:
            if (scaled, term) in taken:
                return f"two parameters scale term {term}"
            taken.add((scaled, term))
    return None


def matrices(core: CoreModel) -> tuple[Any, Any]:
    """K and M, sparse."""
    return as_sparse(core.stiffness()), as_sparse(core.mass())


class Affine:
    """The sums of a problem, its parameters as :func:`bent_by` allows.

    ``terms`` are those of each parameter, (K_j, M_j), one of them None, ``places`` the rows where these have
    entries; ``parts`` the targets, response and force by row.
    """

    def __init__(self, problem: UpdatingProblem) -> None:
        assert isinstance(problem._targets, AntiresonanceTargets)
        of = problem._targets.parts
        self.problem = problem
        self.core, rows = problem.model._core_for([dof for part in of for dof in part[:2]])
        ends = zip(rows[::2], rows[1::2], strict=True)
        self.parts: list[Part] = [(*end, *part[2:]) for end, part in zip(ends, of, strict=True)]
        self.sensors = sorted(set(rows[::2]))
        self.forces = sorted(set(rows[1::2]))
        self._row = dict(zip((dof for part in of for dof in part[:2]), rows, strict=True))
        self._parameters = problem.model.description.core_parameters(problem.parameters)
        self.stiffness, self.mass = matrices(self.core)
        self.terms = [self._term(nth) for nth in range(len(problem.parameters))]
        self.places = [_filled(k if k is not None else m) for k, m in self.terms]
        self._cut = [
            (k if k is not None else m).tocsr()[rows][:, rows]
            for (k, m), rows in zip(self.terms, self.places, strict=True)
        ]

    def at(self, x: FloatArray) -> CoreModel:
        """The full model at ``x``."""
        return self.core.at(self._parameters, np.ascontiguousarray(x))

    def times(self, nth: int, vectors: FloatArray) -> FloatArray:
        """The term of a parameter times vectors (n, m), in its places."""
        return np.asarray(self._cut[nth] @ vectors[self.places[nth]])

    def rows(self, dofs: Any) -> FloatArray:
        """Rows of measured dofs."""
        return np.array([self._row[int(dof)] for dof in dofs])

    def _term(self, nth: int) -> tuple[Any, Any]:
        quantity = self.problem.parameters[nth].quantity
        # Half of it taken away or all of it added: no digit is lost that its sum with the others had kept.
        value, factor = (0.5, -0.5) if quantity == "stiffness_reduction" else (2.0, 1.0)
        k, m = matrices(self.core.at([self._parameters[nth]], np.array([value])))
        of_stiffness = _SCALES[quantity] == "K"
        term = (k - self.stiffness if of_stiffness else m - self.mass) / factor
        term.eliminate_zeros()
        return (term, None) if of_stiffness else (None, term)


def _filled(matrix: Any) -> NDArray[np.intp]:
    """Rows with entries."""
    return np.flatnonzero(np.diff(matrix.tocsr().indptr))
