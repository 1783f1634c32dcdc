"""Sets that hold the very same data: one record given twice tells no more than once.

Two tests at the same force are independent, and their scatter counts; no two of them come out with the same
numbers at every response. Values and standard deviations that are equal bit by bit at all responses that two
sets share are of one record, which would make every error look smaller than it is.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import numpy as np

from ..support.validation import FloatArray

__all__ = ["note_of_same_data", "same_data"]

#: Of one set by response: values and their standard deviations (NaN: none).
Columns = Mapping[Hashable, tuple[FloatArray, FloatArray]]


def same_data(sets: Sequence[Columns]) -> dict[int, int]:
    """Which sets repeat an earlier one at every response with values that both have: later to earlier."""
    found: dict[int, int] = {}
    for later, own in enumerate(sets):
        for earlier in range(later):
            other = sets[earlier]
            shared = [key for key in own if key in other and own[key][0].size and other[key][0].size]
            if shared and all(_equal(own[key], other[key]) for key in shared):
                found[later] = earlier
                break
    return found


def _equal(one: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray]) -> bool:
    return np.array_equal(one[0], other[0]) and np.array_equal(one[1], other[1], equal_nan=True)


def note_of_same_data(name: str, found: Mapping[int, int]) -> list[str]:
    """What was counted once, in words."""
    return [
        f"{name}[{later}] repeats the values of {name}[{earlier}] number for number, as no second test does: "
        "they are counted once."
        for later, earlier in found.items()
    ]
