r"""Stiffness with stiff dofs taken out: what cancels is summed with many digits, the rest as doubles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from decimal import Decimal
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .dependent import congruent
from .entries import Entries
from .stiff_cluster import Row

__all__ = ["Exact", "transformed_terms", "with_added"]


class Exact(NamedTuple):
    """Each dof taken out by rows that remain and its own, and which of them are rigid."""

    gone: dict[int, Row]
    rigid: set[int]

    def transformation(self, n: int) -> Entries:
        """T (n, n) in double precision."""
        own = np.setdiff1d(np.arange(n), list(self.gone))
        parts = [(dof, q, float(value)) for dof, by in self.gone.items() for q, value in by.items()]
        rows, columns, values = (np.array(each) for each in zip(*parts, strict=True))
        return Entries.joined(
            np.concatenate([own, rows]),
            np.concatenate([own, columns]),
            np.concatenate([np.ones(own.size), values]),
        )


def with_added(
    n: int, stiffness: Entries, gone: Iterable[int], added: Mapping[tuple[int, int], Decimal]
) -> Entries:
    """The stiffness without the dofs taken out, with what the others gain."""
    out = _mask(n, gone)
    rest = stiffness.those(~(out[stiffness.rows] | out[stiffness.columns]))
    touched = _mask(n, (i for pair in added for i in pair))
    inside = touched[rest.rows] & touched[rest.columns]
    whole = dict(added)
    for i, j, value in zip(*(each.tolist() for each in rest.those(inside)), strict=True):
        whole[i, j] = whole.get((i, j), Decimal(0)) + Decimal(value)
    return _joined(rest.those(~inside), whole)


def transformed_terms(n: int, terms: Iterable[Entries], exact: Exact, bar: float) -> list[Entries]:
    """T' A T of terms; entries from ``bar`` (N/m) on are those of a penalty, and cancel."""
    out, t = _mask(n, exact.gone), exact.transformation(n).sparse(n)
    reached = _mask(n, (q for by in exact.gone.values() for q in by)) | out
    found = []
    for term in terms:
        if not np.any(out[term.rows] | out[term.columns]):
            found.append(term)
            continue
        cancels = (np.abs(term.values) >= bar) & reached[term.rows] & reached[term.columns]
        whole = congruent(n, term.those(~cancels), t)
        if cancels.any():
            whole = _sum(n, whole, _exactly(term.those(cancels), exact.gone))
        found.append(whole)
    return found


def _exactly(term: Entries, gone: Mapping[int, Row]) -> Entries:
    """T' A T with many digits."""
    whole: defaultdict[tuple[int, int], Decimal] = defaultdict(Decimal)
    for i, j, value in zip(*(each.tolist() for each in term), strict=True):
        given = Decimal(value)
        for p, left in gone.get(i, {i: Decimal(1)}).items():
            for q, right in gone.get(j, {j: Decimal(1)}).items():
                whole[p, q] += left * given * right
    nothing = term.those(np.zeros(term.values.size, dtype=bool))
    return _joined(nothing, {(p, q): (v + whole.get((q, p), v)) / 2 for (p, q), v in whole.items()})


def _sum(n: int, one: Entries, other: Entries) -> Entries:
    return Entries.of_sparse(one.sparse(n) + other.sparse(n))


def _mask(n: int, dofs: Iterable[int]) -> NDArray[np.bool_]:
    which = np.zeros(n, dtype=bool)
    which[list(dofs)] = True
    return which


def _joined(rest: Entries, exact: Mapping[tuple[int, int], Decimal]) -> Entries:
    """Entries with those of many digits, in double precision again."""
    found = [(i, j, float(value)) for (i, j), value in exact.items() if float(value) != 0.0]
    i, j, values = zip(*found, strict=True) if found else ((), (), ())
    return Entries.joined(
        np.concatenate([rest.rows, np.array(i, dtype=np.uint32)]),
        np.concatenate([rest.columns, np.array(j, dtype=np.uint32)]),
        np.concatenate([rest.values, np.array(values, dtype=np.float64)]),
    )
