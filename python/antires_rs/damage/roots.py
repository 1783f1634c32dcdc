"""The model's roots at one state, and which root of another state each has become."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.checks import FloatArray

#: A root that is shown by less than this share is not seen by the test.
SHOWN = 0.5
#: Price of a root that appears or vanishes, in ln f: large damage moves roots by a fifth and more.
_BORN = 0.15


@dataclass(frozen=True)
class Roots:
    """Roots that a test shows: response, ln f (n,) and, where asked for, d ln f / dp (n, parameters)."""

    response: NDArray[np.intp]
    log_f: FloatArray
    slopes: FloatArray

    @property
    def size(self) -> int:
        """How many."""
        return int(self.log_f.size)

    @property
    def kind(self) -> NDArray[np.intp]:
        """0: all are frequencies."""
        return np.zeros(self.size, dtype=np.intp)

    def between(self, low: float, high: float) -> NDArray[np.bool_]:
        """Which lie between two ln f."""
        return (self.log_f > low) & (self.log_f < high)

    def only(self, kept: NDArray[np.bool_]) -> Roots:
        """Some of them."""
        return Roots(
            self.response[kept], self.log_f[kept], self.slopes[kept] if len(self.slopes) else self.slopes
        )

    def since(self, before: Roots) -> tuple[Roots, NDArray[np.intp]]:
        """These, and which root of ``before`` each has been."""
        return self, follow(before, self)


class Source(Protocol):
    """What has roots of its own kind."""

    def roots(self, candidates: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        """The roots at each row of ``candidates`` (m, n)."""


def roots_at(
    core: _core.Objective | Source,
    candidates: FloatArray,
    *,
    slopes: bool,
    threads: int,
    band_hz: tuple[float, float] = (0.0, np.inf),
) -> list[Roots]:
    """The roots at each row of ``candidates`` (m, n); slopes of those in the band, 0 for others."""
    if not isinstance(core, _core.Objective):
        return core.roots(candidates, slopes, threads)
    found = []
    states = core.states(np.ascontiguousarray(candidates), slopes, threads, *band_hz)
    for target, hz, shown, slope in states:
        seen = (shown >= SHOWN) & (hz > 0.0)
        found.append(Roots(target[seen].astype(np.intp), np.log(hz[seen]), slope[seen] if slopes else slope))
    return found


def follow(before: Roots, after: Roots) -> NDArray[np.intp]:
    """Number of the root of ``before`` that each root of ``after`` has been; -1 for a new one.

    Where a response has as many roots as before they keep their order; otherwise those that moved least are
    the same.
    """
    return _core.follow(before.response, before.log_f, after.response, after.log_f, _BORN)


# -- Which value belongs to which root: one to one within a response, in ascending order, with gaps
#
# Along a change of the model the roots of one response keep their order, but for pairs that merge, vanish or
# appear; and so do the values that were measured of them. So the assignment that explains a whole response
# best is an alignment of two ascending lists: a pair costs its distance, what stays alone costs a price.
#
# The prices are those of the likelihood: a root in the band is found with the probability ``FOUND`` (if the
# other state showed it; else with ``FOUND_ONCE``), and a value is a false one with ``FALSE``, anywhere in the
# band.


#: Index of what has no partner.
ALONE = -1
FOUND, FOUND_ONCE, FALSE = 0.97, 0.5, 0.01


def align(cost: FloatArray, alone_row: FloatArray, alone_column: FloatArray) -> NDArray[np.intp]:
    """Column of each row, ``ALONE`` without one: the order-preserving assignment of least cost.

    ``cost`` is (rows, columns); ``alone_row`` and ``alone_column`` are the prices of staying without partner.
    """
    return _core.align(cost, alone_row, alone_column)


def associate(
    value: tuple[NDArray[np.intp], FloatArray, FloatArray],
    root: tuple[NDArray[np.intp], FloatArray, FloatArray],
    alone: float,
    alone_root: FloatArray,
) -> NDArray[np.intp]:
    """Root of each value, ``ALONE`` without one: that of the greatest likelihood.

    ``value`` and ``root`` are group, place and standard deviation of each; both ascend within a group.
    ``alone`` is the price of a value, ``alone_root`` that of each root.
    """
    return _core.associate(*value, *root, alone, alone_root)
