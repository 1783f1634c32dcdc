"""The model's roots at one state, and which root of another state each has become."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray

__all__ = ["SHOWN", "Roots", "Source", "follow", "roots_at"]

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
