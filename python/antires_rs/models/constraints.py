r"""Linear constraints between dofs, taken out of the matrices.

.. math:: C u = 0 \;\Rightarrow\; u = T q, \qquad K_q = T^T K T, \quad M_q = T^T M T

q are the dofs that remain, unchanged, so that a sensor on one of them is still a row of the model. A rigid
link, a slab that is stiff in its plane, a multi-point constraint or a Lagrange row of an export is such an
equation.

Reference: R. D. Cook et al., Concepts and Applications of Finite Element Analysis, 4th ed., 2002,
section 13.2.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.validation import part, reject
from .equations import Equation, dofs_to_keep, equations_of, square

__all__ = ["Constrained", "eliminate_constraints", "lagrange_rows", "solved"]

#: Coefficients so much below the largest of their equation are rounding.
_ROUNDING = 1e-12
#: What an equation has beside those before it, at least: less is the rounding of one that repeats them.
_OWN = 1e-5
#: A dof whose coefficient is at least this share of the largest may be the one that is taken out.
_PIVOT = 0.1


class Constrained(NamedTuple):
    """Matrices without the dofs that equations make dependent, as :func:`eliminate_constraints` gives them.

    Attributes
    ----------
    stiffness, mass : scipy.sparse array, (m, m)
        Of the dofs that remain.
    stiffness_terms, mass_terms : list of scipy.sparse array, (m, m)
    dofs : ndarray of int, (m,)
        Rows of the matrices given that remain, ascending.
    transformation : scipy.sparse array, (n, m)
        All dofs from those that remain.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> made = ar.eliminate_constraints(np.eye(3), np.eye(3), [{2: 1.0, 1: -0.5}])
    >>> made.transformation.toarray()
    array([[1. , 0. ],
           [0. , 1. ],
           [0. , 0.5]])
    """

    stiffness: Any
    mass: Any
    stiffness_terms: list[Any]
    mass_terms: list[Any]
    dofs: NDArray[np.intp]
    transformation: Any


def eliminate_constraints(
    stiffness: Any,
    mass: Any,
    constraints: Any,
    *,
    keep: Sequence[int] = (),
    stiffness_terms: Iterable[Any] = (),
    mass_terms: Iterable[Any] = (),
) -> Constrained:
    """Matrices without the dofs that linear equations make dependent.

    Parameters
    ----------
    stiffness, mass : array_like or scipy.sparse, (n, n)
        Symmetric, of all dofs.
    constraints : sequence of dict, array_like or scipy.sparse, (c, n)
        Each a homogeneous equation between dofs: ``{12: 1.0, 3: -1.0, 5: 0.4}`` is u12 - u3 + 0.4 u5 = 0;
        or a row of an array.
    keep : sequence of int
        Dofs that must remain: those of sensors and of the force.
    stiffness_terms, mass_terms : sequence of the same as the matrices
        Terms that parameters scale.

    Returns
    -------
    Constrained
        For ``ar.MatrixModel(made.stiffness, made.mass, stiffness_terms=made.stiffness_terms)``; row r of the
        model is dof ``made.dofs[r]``.

    Raises
    ------
    InvalidInputError
        A dof outside the matrices; coefficients that are not finite or not real; matrices that are not
        square; equations that tie the dofs of ``keep`` to each other or fix one of them; one that repeats
        others but for the last digits.

    Notes
    -----
    Of each equation the dof that occurs in the fewest equations is taken out, the first of equals, among
    those with a coefficient of at least a tenth of the largest. Equations that follow from others are passed
    over.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> stiffness = 500.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> made = ar.eliminate_constraints(stiffness, np.eye(3), [{2: 1.0, 1: -1.0}])  # a rigid bar
    >>> made.dofs
    array([0, 1])
    >>> ar.MatrixModel(made.stiffness, made.mass).antiresonances(0, 0).round(3)
    array([2.516])
    """
    from scipy.sparse import coo_array, csc_array

    n = int(square("stiffness", stiffness).shape[0])
    gone = solved(equations_of(constraints, n), dofs_to_keep(keep, n))
    dofs = np.array([dof for dof in range(n) if dof not in gone], dtype=np.intp)
    row_of = {int(dof): row for row, dof in enumerate(dofs)}
    entries = [(int(dof), row, 1.0) for row, dof in enumerate(dofs)]
    entries += [(dof, row_of[q], value) for dof, by in gone.items() for q, value in by.items()]
    rows, columns, values = zip(*entries, strict=True)
    t = csc_array(coo_array((values, (rows, columns)), shape=(n, dofs.size)))

    def reduced(name: str, matrix: Any) -> Any:
        product = csc_array(t.T @ square(name, matrix, n) @ t)
        return 0.5 * (product + product.T)  # the products round differently above and below

    return Constrained(
        reduced("stiffness", stiffness),
        reduced("mass", mass),
        [reduced(part("stiffness_terms", i), term) for i, term in enumerate(stiffness_terms)],
        [reduced(part("mass_terms", i), term) for i, term in enumerate(mass_terms)],
        dofs,
        t,
    )


def lagrange_rows(stiffness: Any, mass: Any) -> tuple[NDArray[np.intp], Any]:
    """Rows of an export that are equations, not dofs, and these equations.

    Parameters
    ----------
    stiffness, mass : array_like or scipy.sparse, (n, n)
        Matrices with Lagrange multipliers: rows without mass and with nothing on the diagonal of the
        stiffness, nor between each other.

    Returns
    -------
    dofs : ndarray of int, (m,)
        The other rows.
    constraints : scipy.sparse array, (c, m)
        For :func:`eliminate_constraints` with the matrices of ``dofs``.

    Raises
    ------
    InvalidInputError
        Matrices that are not square, or not of one size.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> stiffness = np.array([[500.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, -1.0, 0.0]])  # u0 - u1 = 0
    >>> dofs, equations = ar.lagrange_rows(stiffness, np.diag([1.0, 2.0, 0.0]))
    >>> dofs, equations.toarray()
    (array([0, 1]), array([[ 1., -1.]]))
    """
    k = square("stiffness", stiffness)
    m = square("mass", mass, k.shape[0])
    without_mass = np.asarray(abs(m).sum(axis=1)).ravel() == 0.0
    alone = np.flatnonzero(
        without_mass & (k.diagonal() == 0.0) & (np.asarray(abs(k).sum(axis=1)).ravel() > 0.0)
    )
    # A multiplier has nothing with other multipliers; of two massless dofs that are joined neither is one.
    joined = np.asarray(abs(k[alone][:, alone]).sum(axis=1)).ravel() > 0.0
    rows = alone[~joined]
    dofs = np.setdiff1d(np.arange(k.shape[0]), rows)
    return dofs, k[rows][:, dofs]


def solved(equations: list[Equation], kept: set[int]) -> dict[int, Equation]:
    """Each dependent dof by those that remain."""
    occurs = Counter(dof for each in equations for dof in each)
    gone: dict[int, Equation] = {}
    used_by: defaultdict[int, set[int]] = defaultdict(set)
    for i, each in enumerate(equations):
        largest = max(map(abs, each.values()), default=0.0)
        now: defaultdict[int, float] = defaultdict(float)
        for dof, value in each.items():
            for q, share in gone.get(dof, {dof: 1.0}).items():
                now[q] += value * share
        own = {q: value for q, value in now.items() if abs(value) > _ROUNDING * largest}
        if not own:
            continue
        new = max(map(abs, own.values())) / largest
        if new < _OWN:
            reject(
                part("constraints", i),
                f"an equation that repeats those before it but for {new:.1g} of its "
                f"coefficients, at {_named(own)}",
                f"equations that are clearly apart (by {_OWN:g}), or the same in all digits",
                "Leave it out: as it stands it would tie or hold these dofs.",
            )
        free = {q: value for q, value in own.items() if q not in kept}
        if not free:
            reject(
                part("constraints", i),
                "an equation between dofs to keep: " + _named(own),
                "equations that leave these dofs independent",
                "Leave one of them out of keep: its motion follows from the others.",
            )
        bar = _PIVOT * max(map(abs, free.values()))
        # Of equals the first, as in the multi-point constraints of most programs.
        pivot = min((q for q, v in free.items() if abs(v) >= bar), key=lambda q: occurs[q])
        by = {q: -value / own[pivot] for q, value in own.items() if q != pivot}
        for dof in used_by.pop(pivot, set()):
            share = gone[dof].pop(pivot)
            for q, value in by.items():
                gone[dof][q] = gone[dof].get(q, 0.0) + share * value
                used_by[q].add(dof)
        gone[pivot] = by
        for q in by:
            used_by[q].add(pivot)
    return gone


def _named(own: Equation) -> str:
    return ", ".join(map(str, sorted(own)))
