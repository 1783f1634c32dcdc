"""What is known of many tests in order, without the views on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.pickling import FrozenDict, ReadOnly
from ..support.validation import FloatArray, part, reject
from .conditions import checked_conditions, checked_names, checked_times

__all__ = ["NO_SET", "KeptTests", "SomeSets"]

#: Reason of a test that was given as None.
NO_SET = "no set was given"


class KeptTests(ReadOnly):
    """Sets, names, times and conditions of tests in order, see :class:`antires_rs.Series`."""

    sets: Sequence[AntiresonanceSet | None]
    names: tuple[str, ...]
    times: NDArray[np.datetime64] | None
    conditions: Mapping[str, FloatArray]
    failed: Mapping[int, str]
    excitation: Any
    dofs: tuple[Any, ...]
    interrupted: bool

    def __init__(
        self,
        sets: Sequence[AntiresonanceSet | None],
        *,
        names: Any = None,
        conditions: Any = None,
        times: Any = None,
        failed: Mapping[int, str] | None = None,
        excitation: Any = None,
        dofs: tuple[Any, ...] | None = None,
        interrupted: bool = False,
    ) -> None:
        count = len(sets)
        if failed is None or dofs is None:
            failed = _checked_failed(failed, sets)
            excitation, dofs, failed = _read_through(sets, failed)
        self._fill(
            sets=sets,
            names=checked_names(names, count),
            conditions=checked_conditions(conditions, count),
            times=checked_times(times, count),
            failed=FrozenDict(sorted(failed.items())),
            excitation=excitation,
            dofs=dofs,
            interrupted=interrupted,
        )

    def __iter__(self) -> Iterator[AntiresonanceSet | None]:
        return iter(self.sets)

    def __len__(self) -> int:
        return len(self.sets)

    def __eq__(self, other: object) -> bool:
        """Same tests in the same order: names, conditions, times, reasons and sets, bit for bit."""
        if not isinstance(other, KeptTests):
            return NotImplemented
        return (
            self.names == other.names
            and self.failed == other.failed
            and _same(dict(self.conditions), dict(other.conditions))
            and _same({"times": self.times}, {"times": other.times})
            and all(one == two for one, two in zip(self, other, strict=True))
        )

    __hash__ = None  # type: ignore[assignment]


class SomeSets(Sequence[AntiresonanceSet | None]):
    """Some of the sets, which stay where they are until they are asked for."""

    def __init__(self, whole: Sequence[AntiresonanceSet | None], at: tuple[int, ...]) -> None:
        self._whole: Sequence[AntiresonanceSet | None] = whole
        self._at = at
        if isinstance(whole, SomeSets):
            self._whole, self._at = whole._whole, tuple(whole._at[i] for i in at)

    def __getitem__(self, i: Any) -> Any:
        if isinstance(i, slice):
            return SomeSets(self._whole, self._at[i])
        return self._whole[self._at[i]]

    def __len__(self) -> int:
        return len(self._at)


def _checked_failed(given: Any, sets: Sequence[AntiresonanceSet | None]) -> Mapping[int, str]:
    """Reasons by the index of a test that has no set."""
    wanted = "why a test has no set, by its index"
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        reject("failed", type(given).__name__, wanted, "As in failed={2: 'cable cut'}.")
    for i in given:
        if isinstance(i, bool) or not isinstance(i, int | np.integer) or not 0 <= i < len(sets):
            reject("failed", f"a test {i!r}", f"{wanted}, from 0 to {len(sets) - 1}", "Count from 0.")
        if sets[int(i)] is not None:
            reject("failed", f"test {i}, which has a set", wanted, "Give None in place of its set.")
    return {int(i): str(why) for i, why in given.items()}


def _read_through(
    sets: Sequence[AntiresonanceSet | None], failed: Mapping[int, str]
) -> tuple[Any, tuple[Any, ...], dict[int, str]]:
    """Excitation, responses and failed tests of sets that nothing is known of."""
    if not len(sets):
        reject("sets", "none", "one test or more", "Give the sets.")
    excitation: Any = None
    dofs: dict[Any, None] = {}
    told: dict[int, str] = {}
    for i, one in enumerate(sets):
        name = part("sets", i)
        if one is None:
            told[i] = failed.get(i, NO_SET)
            continue
        if not isinstance(one, AntiresonanceSet):
            reject(name, type(one).__name__, "an AntiresonanceSet or None", "Identify the record first.")
        if excitation is not None and one.excitation != excitation:
            got, wanted = f"a set of force at {one.excitation!r}", f"that of the others, {excitation!r}"
            reject(name, got, wanted, "Make a series for each excitation.")
        excitation = one.excitation
        dofs |= dict.fromkeys(one)
    return excitation, tuple(dofs), told


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(
        a is b or (a is not None and b is not None and np.array_equal(a, b, equal_nan=True))
        for a, b in zip(one.values(), other.values(), strict=True)
    )
