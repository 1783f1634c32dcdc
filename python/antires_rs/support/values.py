"""Frozen dataclasses that hold arrays."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from .pickling import ReadOnly, frozen

__all__ = ["Value", "frozen_or_none"]


class Value(ReadOnly):
    """Base of frozen dataclasses that hold arrays: read-only copies of them, compared by their contents."""

    def __post_init__(self) -> None:
        self.__setstate__({field.name: _kept(getattr(self, field.name)) for field in fields(self)})  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and _same(self.__dict__, other.__dict__)

    __hash__ = None  # type: ignore[assignment]


def frozen_or_none(array: Any) -> Any:
    """Read-only copy of an array, None where there is none."""
    return None if array is None else frozen(array)


def _kept(value: Any) -> Any:
    """A copy of every array, so that the caller's stay his own."""
    if isinstance(value, np.ndarray):
        return np.array(value, order="C")
    return tuple(map(_kept, value)) if type(value) is tuple else value


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(item, other[key]) for key, item in one.items())
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other or (one != one and other != other))  # NaN is itself here
