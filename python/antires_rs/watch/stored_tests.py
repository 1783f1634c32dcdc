"""What is kept of one test, wherever it is kept."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol
from zlib import compress, decompress

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..signals.one_force import DataCheck, Finding
from ..support.values import frozen

# -- A set of antiresonances as plain data: facts about its tables, and columns with a row an antiresonance
#
# This is what a worker sends back, a line of the journal holds, and the rows of a file are made of. Nothing
# is lost but diagrams, curves of the data check and the cross-check; floats keep every bit.


#: What a row of a set is: accepted, seen and not accepted, a peak that nothing explains.
GROUPS = ("antiresonance", "left_out", "unexplained")
#: Columns of every row; scores stand beside them by their names.
COLUMNS = ("freq_hz", "damping_ratio", "std_hz", "by_hand")
_CASTS = {"f": np.float64, "i": np.int64, "b": np.bool_, "U": np.str_}


def encoded(found: AntiresonanceSet) -> dict[str, Any]:
    """``facts`` and ``columns``, both fit for JSON but for NaN in the data check."""
    tables: list[list[Any]] = []
    columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    scores: dict[str, list[Any]] = {}
    for group, dof, table in _tables(found):
        kinds = {name: _kind(values) for name, values in table.scores.items()}
        tables.append([group, dof, len(table), kinds])
        before = len(columns["freq_hz"])
        for name in COLUMNS:
            columns[name] += _plain(getattr(table, name))
        for name, values in table.scores.items():
            known = scores.setdefault(name, [])
            known += [None] * (before - len(known)) + _plain(values)
    total = len(columns["freq_hz"])
    for known in scores.values():
        known += [None] * (total - len(known))
    facts = {
        "excitation": found.excitation,
        "sees": found.sees,
        "channels": list(found.channels),
        "tables": tables,
        "check": _check_facts(found.data_check),
        "options": dict(found.options),
    }
    if found.edits:
        facts["edited"] = found.to_json()
    return {"facts": facts, "columns": columns, "scores": scores}


def decoded(plain: Mapping[str, Any]) -> AntiresonanceSet:
    """The set of :func:`encoded`."""
    facts, columns, scores = plain["facts"], plain["columns"], plain["scores"]
    if "edited" in facts:
        return AntiresonanceSet.from_json(facts["edited"])
    by_group: dict[str, dict[Any, ResponseTable]] = {group: {} for group in GROUPS}
    first = 0
    for group, dof, count, kinds in facts["tables"]:
        rows = slice(first, first + count)
        first += count
        by_group[group][dof] = ResponseTable(
            _floats(columns["freq_hz"][rows]),
            _floats(columns["damping_ratio"][rows]),
            _floats(columns["std_hz"][rows]),
            {name: _column(scores[name][rows] if count else [], kind) for name, kind in kinds.items()},
            np.array([value is True for value in columns["by_hand"][rows]], dtype=bool),
        )
    tables, left_out, unexplained = (by_group[group] for group in GROUPS)
    return AntiresonanceSet.from_tables(
        facts["excitation"],
        tables,
        left_out=left_out,
        unexplained_hz={dof: frozen(table.freq_hz) for dof, table in unexplained.items()},
        sees=facts["sees"],
        channels=facts["channels"],
        data_check=_check_of(facts["check"]),
        options=facts.get("options"),
    )


def _tables(found: AntiresonanceSet) -> Iterator[tuple[str, Any, ResponseTable]]:
    for dof, table in found.tables.items():
        yield GROUPS[0], dof, table
    for dof, table in found.left_out.items():
        yield GROUPS[1], dof, table
    for dof, peaks in found.unexplained_hz.items():
        yield GROUPS[2], dof, ResponseTable(peaks)


def _kind(values: Any) -> str:
    """Letter of the type that a score comes back as."""
    return {"u": "i"}.get(values.dtype.kind, values.dtype.kind if values.dtype.kind in _CASTS else "U")


def _plain(values: Any) -> list[Any]:
    """NaN becomes None."""
    return [None if value != value else value for value in values.tolist()]


def _floats(values: Any) -> Any:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


def _column(values: Any, kind: str) -> Any:
    return _floats(values) if kind == "f" else np.array(list(values), dtype=_CASTS[kind])


def _check_facts(checked: Any) -> dict[str, Any] | None:
    if not isinstance(checked, DataCheck):
        return None
    return {
        "findings": [asdict(finding) | {"where": list(finding.where)} for finding in checked.findings],
        "not_tested": dict(checked.not_tested),
        "dofs": list(checked.dofs),
        "excitation": checked.excitation,
        "band_hz": list(checked.band_hz),
        "n_averages": checked.n_averages,
        "nperseg": checked.nperseg,
    }


def _check_of(facts: Mapping[str, Any] | None) -> DataCheck | None:
    if facts is None:
        return None
    low, high = facts["band_hz"]
    return DataCheck(
        tuple(Finding(**row | {"where": tuple(row["where"])}) for row in facts["findings"]),
        facts["not_tested"],
        tuple(facts["dofs"]),
        facts["excitation"],
        (low, high),
        n_averages=facts["n_averages"],
        nperseg=facts["nperseg"],
    )


Plain = dict[str, Any]


class Place(Protocol):
    """Where sets are kept as plain data."""

    def plain(self, key: int) -> Plain:
        """One of them, see :mod:`~antires_rs.watch.stored_tests`."""

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
    """Arguments of a :class:`~antires_rs.watch.series.KeptTests` of these tests."""
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
