"""What is kept of one test, wherever it is kept."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any
from zlib import compress, decompress

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..signals.one_force import DataCheck, Finding
from ..support.values import frozen

# -- A set of antiresonances as plain data: facts about its tables, and columns with a row an antiresonance
#
# This is what a worker sends back, a database holds, and the rows of a table are made of. Nothing
# is lost but diagrams, curves of the data check and the cross-check; floats keep every bit.


Plain = dict[str, Any]
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


@dataclass(frozen=True, slots=True)
class Row:
    """A test in its place in the series: what is asked of it often, and how to get its set.

    ``failed`` says why there is none; ``kinds`` are names of its scores with the letters of their types;
    ``conditions`` and ``time`` (datetime64 or None) what was measured beside it.
    """

    name: str
    conditions: Mapping[str, float]
    time: Any
    fingerprint: str
    failed: str | None
    count: int
    excitation: Any
    dofs: tuple[Any, ...]
    kinds: tuple[tuple[str, str], ...]
    plain: Callable[[], Plain]

    @classmethod
    def of(
        cls,
        name: str,
        conditions: Mapping[str, float],
        time: Any,
        fingerprint: str,
        failed: str | None,
        facts: Mapping[str, Any] | None,
        plain: Callable[[], Plain],
    ) -> Row:
        """A test that failed, or a set of which the facts are known."""
        tables = facts["tables"] if facts else []
        accepted = [(dof, count) for group, dof, count, _ in tables if group == GROUPS[0]]
        return cls(
            name,
            conditions,
            time,
            fingerprint,
            failed,
            sum(count for _, count in accepted),
            facts["excitation"] if facts else None,
            _one(tuple(dof for dof, _ in accepted)),
            _one(tuple(sorted({item for _, _, _, kinds in tables for item in kinds.items()}))),
            plain,
        )

    @classmethod
    def packed(
        cls, name: str, conditions: Mapping[str, float], time: Any, fingerprint: str, outcome: Plain | str
    ) -> Row:
        """An outcome held in memory, packed: 3 kB where a set of eight responses has 60."""
        if isinstance(outcome, str):
            return cls.of(name, conditions, time, fingerprint, outcome, None, dict)
        data = compress(json.dumps(outcome).encode(), 1)
        return cls.of(name, conditions, time, fingerprint, None, outcome["facts"], partial(_unpacked, data))


def _unpacked(data: bytes) -> Plain:
    found: Plain = json.loads(decompress(data))
    return found


class StoredSets(Sequence[AntiresonanceSet | None]):
    """The sets of some tests, made when they are asked for."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self._rows = tuple(rows)

    @property
    def counts(self) -> list[int]:
        """How many antiresonances each test has that did not fail."""
        return [row.count for row in self._rows if row.failed is None]

    def take(self, at: Iterable[int]) -> StoredSets:
        """Those of some tests."""
        return StoredSets([self._rows[i] for i in at])

    def __getitem__(self, at: Any) -> Any:
        if isinstance(at, slice):
            return StoredSets(self._rows[at])
        row = self._rows[at]
        return None if row.failed is not None else decoded(row.plain())

    def __len__(self) -> int:
        return len(self._rows)

    def __reduce__(self) -> Any:
        return tuple, (list(self),)


def parts_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Arguments of a :class:`~antires_rs.Series` of these tests."""
    columns = dict.fromkeys(name for row in rows for name in row.conditions)
    times = np.array(["NaT" if row.time is None else row.time for row in rows], dtype="datetime64[ms]")
    return {
        "sets": StoredSets(rows),
        "names": [row.name for row in rows],
        "conditions": {name: [row.conditions.get(name, np.nan) for row in rows] for name in columns},
        "times": None if np.isnat(times).all() else times,
        "failed": {i: row.failed for i, row in enumerate(rows) if row.failed is not None},
        "excitation": next((row.excitation for row in rows if row.failed is None), None),
        "dofs": tuple(dict.fromkeys(dof for row in rows for dof in row.dofs)),
    }


#: Tuples that most tests share are held once.
_SHARED: dict[tuple[Any, ...], tuple[Any, ...]] = {}


def _one(item: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(_SHARED) > 1000:
        _SHARED.clear()
    return _SHARED.setdefault((*item, *map(type, item)), item)
