"""What is kept of one test, wherever it is kept."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol
from zlib import compress, decompress

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from .encoded import GROUPS, decoded, encoded

__all__ = ["InMemory", "Kept", "KeptSets", "Packed", "Place", "Row", "parts_of"]

Plain = dict[str, Any]


class Place(Protocol):
    """Where sets are kept as plain data."""

    def plain(self, key: int) -> Plain:
        """One of them, see :mod:`~antires_rs.series.encoded`."""

    def set(self, key: int) -> AntiresonanceSet:
        """The set itself."""


@dataclass(frozen=True, slots=True)
class Kept:
    """One test: what is asked of it often, and where its set is.

    Attributes
    ----------
    fingerprint : str
    failed : str or None
        Why there is no set.
    count : int
        Antiresonances.
    excitation : int, str or None
    dofs : tuple
    kinds : tuple of (str, str)
        Names of its scores, and the letters of their types.
    place, key
    """

    fingerprint: str
    failed: str | None
    count: int
    excitation: Any
    dofs: tuple[Any, ...]
    kinds: tuple[tuple[str, str], ...]
    place: Place
    key: int

    @classmethod
    def of(cls, fingerprint: str, outcome: Plain | str, place: Place, key: int) -> Kept:
        """What is kept of an outcome, once it is in its place."""
        if isinstance(outcome, str):
            return cls(fingerprint, outcome, 0, None, (), (), place, key)
        return cls.of_facts(fingerprint, outcome["facts"], place, key)

    @classmethod
    def of_facts(cls, fingerprint: str, facts: Mapping[str, Any], place: Place, key: int) -> Kept:
        """The same of a set, of which the facts are enough."""
        accepted = [(dof, count) for group, dof, count, _ in facts["tables"] if group == GROUPS[0]]
        kinds = sorted({item for _, _, _, kinds in facts["tables"] for item in kinds.items()})
        return cls(
            fingerprint,
            None,
            sum(count for _, count in accepted),
            facts["excitation"],
            _one(tuple(dof for dof, _ in accepted)),
            _one(tuple(kinds)),
            place,
            key,
        )

    def plain(self) -> Plain:
        """The set as plain data."""
        return self.place.plain(self.key)

    def set(self) -> AntiresonanceSet | None:
        """The set itself."""
        return None if self.failed is not None else self.place.set(self.key)


@dataclass(frozen=True, slots=True)
class Row:
    """A test in its place in the series, with what was measured beside it; ``time`` is datetime64 or None."""

    name: str
    conditions: Mapping[str, float]
    time: Any
    kept: Kept


class InMemory:
    """Sets that are there, as a place."""

    def __init__(self, sets: Sequence[AntiresonanceSet | None]) -> None:
        self._sets = sets

    def plain(self, key: int) -> Plain:
        """One of them as plain data."""
        return encoded(self.set(key))

    def set(self, key: int) -> AntiresonanceSet:
        """One of them."""
        found = self._sets[key]
        assert found is not None  # it did not fail
        return found


class Packed:
    """Sets in memory as text that is packed: 3 kB where a set of eight responses has 60."""

    def __init__(self) -> None:
        self._packed: list[bytes] = []

    def add(self, outcome: Plain | str) -> int:
        """Keep one; returns its key."""
        self._packed.append(b"" if isinstance(outcome, str) else compress(json.dumps(outcome).encode(), 1))
        return len(self._packed) - 1

    def plain(self, key: int) -> Plain:
        """One of them as plain data."""
        found: Plain = json.loads(decompress(self._packed[key]))
        return found

    def set(self, key: int) -> AntiresonanceSet:
        """One of them."""
        return decoded(self.plain(key))


class KeptSets(Sequence[AntiresonanceSet | None]):
    """The sets of some tests, made when they are asked for."""

    def __init__(self, kept: Sequence[Kept]) -> None:
        self._kept = tuple(kept)

    @property
    def counts(self) -> list[int]:
        """How many antiresonances each test has that did not fail."""
        return [one.count for one in self._kept if one.failed is None]

    def __getitem__(self, at: Any) -> Any:
        return KeptSets(self._kept[at]) if isinstance(at, slice) else self._kept[at].set()

    def __len__(self) -> int:
        return len(self._kept)

    def __reduce__(self) -> Any:
        return tuple, (list(self),)


def parts_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Arguments of a :class:`~antires_rs.series.kept_tests.KeptTests` of these tests."""
    kept = [row.kept for row in rows]
    columns = dict.fromkeys(name for row in rows for name in row.conditions)
    times = np.array(["NaT" if row.time is None else row.time for row in rows], dtype="datetime64[ms]")
    return {
        "sets": KeptSets(kept),
        "names": [row.name for row in rows],
        "conditions": {name: [row.conditions.get(name, np.nan) for row in rows] for name in columns},
        "times": None if np.isnat(times).all() else times,
        "failed": {i: one.failed for i, one in enumerate(kept) if one.failed is not None},
        "excitation": next((one.excitation for one in kept if one.failed is None), None),
        "dofs": tuple(dict.fromkeys(dof for one in kept for dof in one.dofs)),
    }


#: Tuples that most tests share are held once.
_SHARED: dict[tuple[Any, ...], tuple[Any, ...]] = {}


def _one(item: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(_SHARED) > 1000:
        _SHARED.clear()
    return _SHARED.setdefault((*item, *map(type, item)), item)
