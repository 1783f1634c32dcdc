"""A set of antiresonances as plain data: facts about its tables, and columns with a row an antiresonance.

This is what a worker sends back, a line of the journal holds, and the rows of a file are made of. Nothing is
lost but diagrams, curves of the data check and the cross-check; floats keep every bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..data_check import DataCheck, Finding
from ..measured.antiresonance_set import AntiresonanceSet
from ..order_sweep.table import ResponseTable
from ..support.pickling import frozen

__all__ = ["COLUMNS", "GROUPS", "decoded", "encoded"]

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
