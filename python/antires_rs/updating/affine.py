"""Stiffness and mass as sums: the term that each parameter scales.

``K(x) = K + sum (s_j(x_j) - 1) K_j`` with s_j the factor of a parameter, and so M. It holds for factors and
reductions that do not share a term; sections, angles and positions bend it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..models.parameter import Parameter
    from ..models.structural_model import StructuralModel
    from ..support.validation import FloatArray

__all__ = ["AffineParts", "affine_parts", "bent_by", "projected"]

#: Quantities in which K and M are linear, and the matrix that each scales.
_SCALES = {"stiffness_factor": "K", "stiffness_reduction": "K", "mass_factor": "M"}


@dataclass(frozen=True)
class AffineParts:
    """Matrices at the nominal values, and the term of each parameter: (K_j, M_j), one of them None."""

    stiffness: Any
    mass: Any
    terms: list[tuple[Any, Any]]


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


def affine_parts(model: StructuralModel, parameters: tuple[Parameter, ...]) -> AffineParts:
    """The sums of a model, sparse; its parameters as :func:`bent_by` allows."""
    from scipy import sparse

    def matrices(of: Any) -> tuple[Any, Any]:
        return sparse.csc_array(of.stiffness()), sparse.csc_array(of.mass())

    stiffness, mass = matrices(model)
    terms: list[tuple[Any, Any]] = []
    for parameter in parameters:
        # Half of it taken away or all of it added: no digit is lost that its sum with the others had kept.
        value, factor = (0.5, -0.5) if parameter.quantity == "stiffness_reduction" else (2.0, 1.0)
        k, m = matrices(model.with_parameters(parameter, value))
        of_stiffness = _SCALES[parameter.quantity] == "K"
        term = (k - stiffness if of_stiffness else m - mass) / factor
        term.eliminate_zeros()
        terms.append((term, None) if of_stiffness else (None, term))
    return AffineParts(stiffness, mass, terms)


def projected(matrix: Any, basis: FloatArray) -> FloatArray:
    """``V'AV``, exactly symmetric."""
    small = basis.T @ (matrix @ basis)
    return np.ascontiguousarray(0.5 * (small + small.T))
