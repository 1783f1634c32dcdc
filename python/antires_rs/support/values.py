"""Values that hold arrays: read-only, compared by contents, the same after ``pickle`` and ``deepcopy``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Generic, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

# What is left out of a pickle is made again from the rest, bit-identical; arrays that were read-only are so
# again. A pickle is for the same version of this package; files are written by ``save``.

Core = TypeVar("Core")
Key = TypeVar("Key")
Held = TypeVar("Held")
Array = TypeVar("Array", bound="NDArray[Any] | None")


class ReadOnly:
    """What nobody may change, neither attributes nor arrays in it; constructors fill it by :meth:`_fill`."""

    def _fill(self, **attributes: Any) -> None:
        """Set the attributes, in the constructor."""
        self.__dict__.update(attributes)

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        self._refuse(name)

    def __delattr__(self, name: str) -> NoReturn:
        self._refuse(name)

    def _refuse(self, name: str) -> NoReturn:
        kind = type(self).__name__
        raise AttributeError(f"{kind}.{name} is read-only: make another {kind} instead.", name=name, obj=self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._fill(**state)
        _freeze(state)


class AroundCore(ReadOnly, Generic[Core]):
    """An object around one of the Rust core, ``_core``, which is made again from what else it holds."""

    _core: Core

    def _made_core(self) -> Core:
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_core"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self._fill(_core=self._made_core())


class FrozenDict(dict[Key, Held]):
    """A dict that nobody may change; unlike a ``MappingProxyType`` it can be pickled and copied."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("this dict is read-only; dict(...) makes one that can be changed")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> Any:
        return _frozen_dict, (dict(self),)


def _frozen_dict(items: Mapping[Key, Held]) -> FrozenDict[Key, Held]:
    _freeze(items)
    return FrozenDict(items)


def _freeze(value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, dict | tuple):
        for item in value.values() if isinstance(value, dict) else value:
            _freeze(item)


def frozen(array: Array, given: Any = None) -> Array:
    """Read-only copy of an array, None of None; what is read-only itself, or was made anew of what was
    ``given``, is not copied."""
    if array is None:
        return array
    if given is not None and not (isinstance(given, np.ndarray) and np.may_share_memory(array, given)):
        array.setflags(write=False)
    if array.base is None and array.flags.c_contiguous and not array.flags.writeable:
        return array
    copy: Any = np.array(array, order="C")
    copy.setflags(write=False)
    return copy  # type: ignore[no-any-return]


class Value(ReadOnly):
    """Base of frozen dataclasses that hold arrays: read-only copies of them, compared by their contents."""

    def __post_init__(self) -> None:
        self.__setstate__({field.name: _kept(getattr(self, field.name)) for field in fields(self)})  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and _same(self.__dict__, other.__dict__)

    __hash__ = None  # type: ignore[assignment]


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
