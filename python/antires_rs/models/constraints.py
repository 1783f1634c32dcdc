r"""Linear constraints between dofs, taken out of the matrices.

.. math:: C u = 0 \;\Rightarrow\; u = T q, \qquad K_q = T^T K T, \quad M_q = T^T M T

q are the dofs that remain, unchanged, so that a sensor on one of them is still a row of the model. Rigid
links, multi-point constraints and Lagrange rows of an export are such equations (R. D. Cook et al., Concepts
and Applications of Finite Element Analysis, 4th ed., 2002, section 13.2).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import part, reject
from ..support.checks import finite_scalar, integer, real_array
from ..support.directions import DofNames
from .matrices import Entries, as_square

# -- Linear equations between dofs as users give them: dicts, rows, arrays dense or sparse

Equation = dict[int, float]
Number = Callable[[str, Any], int]


def equations_of(constraints: Any, n: int, number: Number | None = None) -> list[Equation]:
    """Each equation by its dofs; ``number`` finds those that are called by a name."""
    wanted = f"a list of equations, each a dict such as {{2: 1.0, 1: -1.0}}, or an array (c, {n})"
    if isinstance(constraints, Mapping):
        reject("constraints", "one dict", wanted, "Put it in a list: [{2: 1.0, 1: -1.0}].")
    if hasattr(constraints, "tocsr"):
        return _of_sparse(constraints, n, wanted)
    if not _listed(constraints):
        reject("constraints", repr(constraints), wanted, "Put the equations in a list, also where it is one.")
    find = number or _numbers(n)
    return [_equation(part("constraints", i), each, n, find) for i, each in enumerate(constraints)]


def dofs_to_keep(keep: Any, n: int, number: Number | None = None) -> set[int]:
    """Numbers of the dofs that must remain."""
    if not _listed(keep):
        reject("keep", repr(keep), "a sequence of dofs", "Put it in a list, also where it is one.")
    find = number or _numbers(n)
    return {find(part("keep", i), dof) for i, dof in enumerate(keep)}


def _listed(given: Any) -> bool:
    """Whether it has items that are no letters: an array of no axis has none."""
    has_axis: bool = getattr(given, "ndim", 1) != 0
    return isinstance(given, Iterable) and not isinstance(given, str | bytes) and has_axis


def _numbers(n: int) -> Number:
    return lambda name, dof: integer(name, dof, low=0, high=n - 1)


def _of_sparse(constraints: Any, n: int, wanted: str) -> list[Equation]:
    shape = constraints.shape
    if len(shape) != 2 or shape[1] != n:
        reject("constraints", f"a sparse array of shape {shape}", wanted, "One column a dof, a row each.")
    table = constraints.tocsr(copy=True)
    table.sum_duplicates()
    # An array of no entry is in order, and not for real_array.
    values = real_array("constraints", table.data, ndim=1, wanted=wanted) if table.nnz else table.data
    at = table.indptr[1:-1]
    rows = zip(np.split(table.indices, at), np.split(values, at), strict=True)
    return [dict(zip(dofs.tolist(), own.tolist(), strict=True)) for dofs, own in rows]


def _equation(name: str, given: Any, n: int, find: Number) -> Equation:
    if not isinstance(given, Mapping):
        wanted = f"a row ({n},) of finite numbers, or a dict of dofs"
        row = real_array(name, given, ndim=None, wanted=wanted)
        if row.shape != (n,):
            reject(name, f"a row of shape {row.shape}", wanted, "One number a dof.")
        return {int(dof): float(row[dof]) for dof in np.flatnonzero(row)}
    return {find(name, dof): finite_scalar(name, value) for dof, value in given.items()}


_ROUNDING = 1e-12  # coefficients so much below the largest of their equation are rounding
#: What an equation has beside those before it, at least: less is the rounding of one that repeats them.
_OWN = 1e-5
_PIVOT = 0.1  # a dof may be taken out whose coefficient is at least this share of the largest


class Constrained(NamedTuple):
    """What :func:`eliminate_constraints` gives: matrices of the m dofs that remain.

    Matrices and terms are scipy.sparse arrays (m, m), ``dofs`` (m,) the rows that remain, ascending, and
    ``transformation`` (n, m) gives all dofs from these.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.eliminate_constraints([[1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]], [{0: 1.0, 1: -0.5}]).dofs
    array([1])
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
    """Matrices without the dofs that linear equations make dependent; :class:`MatrixModel` does it by itself.

    Parameters
    ----------
    stiffness, mass : array_like or scipy.sparse, (n, n)
        Symmetric, of all dofs.
    constraints : sequence of dict, array_like or scipy.sparse, (c, n)
        Each a homogeneous equation between dofs: ``{12: 1.0, 3: -1.0, 5: 0.4}`` is u12 - u3 + 0.4 u5 = 0; or
        a row of an array.
    keep : sequence of int
        Dofs that must remain: those of sensors and of the force.
    stiffness_terms, mass_terms : sequence of the same as the matrices
        Terms that parameters scale.

    Returns
    -------
    Constrained

    Raises
    ------
    InvalidInputError
        Malformed matrices or equations; equations that tie the dofs of ``keep`` to each other or fix one of
        them; one that repeats others but for the last digits.

    Notes
    -----
    Of each equation the dof that occurs in the fewest is taken out, the first of equals, among those with a
    coefficient of at least a tenth of the largest. Equations that follow from others are passed over.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> stiffness = 500.0 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> made = ar.eliminate_constraints(stiffness, np.eye(3), [{2: 1.0, 1: -1.0}])  # a rigid bar
    >>> made.dofs, made.transformation.toarray().tolist()
    (array([0, 1]), [[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    """
    n = as_square("stiffness", stiffness)[0]
    dependent = Dependent.of(solved(equations_of(constraints, n), dofs_to_keep(keep, n)))
    dofs = np.setdiff1d(np.arange(n), dependent.dofs)
    t = dependent.transformation(n)[:, dofs].tocsc()

    def reduced(name: str, matrix: Any) -> Any:
        return congruent(as_square(name, matrix, n)[1].sparse(n).tocsc(), t)

    k, m = reduced("stiffness", stiffness), reduced("mass", mass)
    of_k = [reduced(part("stiffness_terms", i), term) for i, term in enumerate(stiffness_terms)]
    of_m = [reduced(part("mass_terms", i), term) for i, term in enumerate(mass_terms)]
    return Constrained(k, m, of_k, of_m, dofs, t)


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

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> stiffness = np.array([[500.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, -1.0, 0.0]])  # u0 - u1 = 0
    >>> dofs, equations = ar.lagrange_rows(stiffness, np.diag([1.0, 2.0, 0.0]))
    >>> dofs, equations.toarray()
    (array([0, 1]), array([[ 1., -1.]]))
    """
    n, k = as_square("stiffness", stiffness)
    taken = multipliers(n, k, as_square("mass", mass, n)[1])
    dofs = np.flatnonzero(~taken)
    return dofs, k.sparse(n)[taken][:, dofs]


def multipliers(n: int, stiffness: Entries, mass: Entries) -> NDArray[np.bool_]:
    """Which rows are Lagrange multipliers: no mass, nothing on the diagonal, nor with others alike."""
    alone = np.bincount(stiffness.rows, minlength=n) > 0
    alone[stiffness.rows[stiffness.rows == stiffness.columns]] = False
    alone[mass.rows] = False
    found = alone.copy()
    # Of two massless dofs that are joined neither is one.
    found[stiffness.rows[alone[stiffness.rows] & alone[stiffness.columns]]] = False
    return found


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
        argument, named = part("constraints", i), ", ".join(map(str, sorted(own)))
        if new < _OWN:
            got = f"an equation that repeats those before it but for {new:.1g} of it, at {named}"
            wanted = f"equations that are clearly apart (by {_OWN:g}), or the same in all digits"
            reject(argument, got, wanted, "Leave it out: as it stands it would tie or hold these dofs.")
        free = {q: value for q, value in own.items() if q not in kept}
        if not free:
            got = f"an equation between dofs to keep: {named}"
            wanted = "equations that leave these independent"
            reject(argument, got, wanted, "Leave one of them out of keep: it follows from the others.")
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


def equations_by_number(
    names: tuple[str, ...], n: int, constraints: Any, keep: Sequence[int | str]
) -> tuple[Entries | None, tuple[int, ...]]:
    """Equations, a row each, and dofs to keep; ``names`` are those of ``n`` dofs, if they have any."""
    known = DofNames(names)

    def number(name: str, dof: Any) -> int:
        if isinstance(dof, str):
            if names:
                return known.find(name, dof)
            wanted = f"a zero-based number, 0 to {n - 1}: the dofs have no names"
            reject(name, repr(dof), wanted, "Give the names of all rows: dofs=.")
        return integer(name, dof, low=0, high=n - 1)

    kept = tuple(sorted(dofs_to_keep(keep, n, number)))
    equations = [] if constraints is None else equations_of(constraints, n, number)
    entries = [(row, dof, value) for row, each in enumerate(equations) for dof, value in each.items()]
    return (Entries.joined(*map(np.array, zip(*entries, strict=True))) if entries else None), kept


_SHARE = 1e-8  # of what a dof is made, shares below this are rounding


class Dependent(NamedTuple):
    """Dofs that are taken out, ascending; which are multipliers; how the others move by rows that remain."""

    dofs: NDArray[np.uint32]
    multipliers: frozenset[int]
    by: Entries

    @classmethod
    def of(cls, gone: Mapping[int, Equation], multipliers: Iterable[int] = ()) -> Dependent:
        """Each dependent dof by those that remain, and multipliers."""
        others = frozenset(multipliers)
        parts = [(dof, q, value) for dof, by in gone.items() for q, value in by.items()]
        by = zip(*parts, strict=True) if parts else ((), (), ())
        dofs = np.array(sorted(others | gone.keys()), dtype=np.uint32)
        return cls(dofs, others, Entries.joined(*map(np.array, by)))

    def transformation(self, n: int) -> Any:
        """T (n, n), ``scipy.sparse``: columns of dofs taken out are empty."""
        own = np.setdiff1d(np.arange(n), self.dofs)
        rows, columns = np.concatenate([own, self.by.rows]), np.concatenate([own, self.by.columns])
        return Entries(rows, columns, np.concatenate([np.ones(own.size), self.by.values])).sparse(n)

    def rows(self, n: int) -> NDArray[np.intp]:
        """Row of each of ``n`` dofs in matrices without those taken out; -1 for these."""
        there = ~np.isin(np.arange(n), self.dofs)
        return np.where(there, np.cumsum(there) - 1, -1)

    def has(self, dof: int) -> bool:
        """Whether a dof is taken out."""
        return bool((self.dofs == dof).any())

    def moving_as(self, dof: int) -> int:
        """The dof that moves as ``dof`` does: the one that it follows, or itself."""
        mine = self.by.rows == dof
        masters, shares = self.by.columns[mine], self.by.values[mine]
        if not shares.size:
            return dof
        first = int(np.argmax(np.abs(shares)))
        others = np.abs(np.delete(shares, first)).sum()
        return int(masters[first]) if abs(shares[first] - 1.0) + others <= _SHARE else dof

    def masters(self, dof: int) -> set[int]:
        """The dofs by which ``dof`` moves, if it is taken out."""
        return {*self.by.columns[self.by.rows == dof].tolist()}


def without(entries: Entries, rows: NDArray[np.intp]) -> Entries:
    """Entries at their rows among those that are left."""
    at = rows.astype(np.uint32)
    return Entries(at[entries.rows], at[entries.columns], entries.values)


def congruent(matrix: Any, t: Any) -> Any:
    """T' A T of sparse matrices."""
    product = t.T @ matrix @ t
    return 0.5 * (product + product.T)  # the products round differently above and below
