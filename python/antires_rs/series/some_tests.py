"""Which tests of a series are meant by an index, a slice, indices or a mask."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import reject

__all__ = ["one_or_some"]

_WANTED = "an index, a slice, a list of indices, or a mask with a truth value for each test"


def one_or_some(at: Any, count: int) -> int | NDArray[np.intp]:
    """The index of one test, or those of some.

    Raises
    ------
    IndexError
        No such test.
    InvalidInputError
        Nothing that tests are named by, a mask of another length, or a test more than once.
    """
    if isinstance(at, slice):
        return np.arange(count)[at]
    if isinstance(at, int | np.integer) and not isinstance(at, bool):
        _there(int(at), count)
        return int(at)
    found = np.asarray(at) if np.size(at) else np.empty(0, int)
    if found.ndim != 1 or found.dtype.kind not in "biu":
        reject("series[...]", at, _WANTED, "As in series[3], series[:100] or series[temperature_c < 20].")
    if found.dtype.kind == "b":
        if len(found) != count:
            reject("series[...]", f"a mask of {len(found)}", f"one of {count}", "Make it of all tests.")
        return np.flatnonzero(found)
    for i in found.tolist():
        _there(i, count)
    found = found.astype(np.intp) % max(count, 1)
    if len(np.unique(found)) < len(found):
        reject("series[...]", "a test more than once", "each test once", "Use np.unique.")
    return found


def _there(at: int, count: int) -> None:
    if not -count <= at < count:
        raise IndexError(f"test {at} of a series of {count}, which are counted from 0")
