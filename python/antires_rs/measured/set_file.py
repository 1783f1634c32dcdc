"""An AntiresonanceSet as JSON.

Version 1 holds excitation and, by dof, freq_hz, damping_ratio and std_hz. Version 2 adds the scores, the
edits made by hand, and the values as they were before the first of them. "sees" (what it was identified from)
and "channels" (all dofs measured together) may follow, and by dof "left_out" and "unexplained_hz" (what was
seen and not accepted); older versions of the package read such files too. What is not known is null.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..exceptions import InvalidInputError
from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray, reject
from .edits import Edit
from .sight import Sees

FORMAT = "antires_rs.AntiresonanceSet"
VERSION = 2
COLUMNS = ("freq_hz", "damping_ratio", "std_hz")
ACTIONS = ("drop", "add")
_ANOTHER = "It was cut, or is another file: save the set again, or name the file that holds it."


def to_json(
    excitation: Any,
    tables: Mapping[Any, ResponseTable],
    edits: tuple[Edit, ...],
    before: Mapping[Any, ResponseTable] | None,
    sight: tuple[Sees, tuple[Any, ...]],
    beside: tuple[Mapping[Any, ResponseTable], Mapping[Any, FloatArray]],
) -> str:
    """The file's text.

    ``before`` holds the tables before the first edit, ``sight`` sees and channels, ``beside`` what was left
    out and unexplained, by dof.
    """
    data: dict[str, Any] = {"format": FORMAT, "version": VERSION, "excitation": excitation}
    sees, channels = sight
    if sees is not None:
        data["sees"] = sees
    if channels != tuple(tables):
        data["channels"] = list(channels)
    data["dofs"] = _rows(tables)
    left_out, unexplained_hz = beside
    for row in data["dofs"]:
        if row["dof"] in left_out:
            row["left_out"] = _row(left_out[row["dof"]])
        if row["dof"] in unexplained_hz:
            row["unexplained_hz"] = unexplained_hz[row["dof"]].tolist()
    if edits and before is not None:
        data["edits"] = [asdict(edit) for edit in edits]
        data["before_edits"] = _rows(before)
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def from_json(text: str, path: str) -> dict[str, Any]:
    """What :func:`to_json` took, as plain data by its names; ``before`` is None without edits."""
    wanted = f"a file written by AntiresonanceSet.save, version {VERSION} or older"
    try:
        data = json.loads(text)
    except ValueError as exc:
        raise InvalidInputError("path", f"{path!r}, which is not JSON ({exc})", wanted, _ANOTHER) from exc
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        reject("path", f"{path!r} without the mark {FORMAT!r}", wanted, _ANOTHER)
    if not isinstance(data.get("version"), int) or data["version"] > VERSION:
        reject("path", f"{path!r} of version {data.get('version')!r}", wanted, "Update antires_rs.")
    try:
        edits = tuple(edit_of(row) for row in data.get("edits", ()))
        return {
            "excitation": data["excitation"],
            "sees": data.get("sees"),
            "channels": data.get("channels"),
            "now": _read(data["dofs"]),
            "left_out": _read(
                [{**row["left_out"], "dof": row["dof"]} for row in data["dofs"] if "left_out" in row]
            ),
            "unexplained_hz": {
                row["dof"]: row["unexplained_hz"] for row in data["dofs"] if "unexplained_hz" in row
            },
            "edits": edits,
            "before": _read(data["before_edits"]) if edits else None,
        }
    except (KeyError, TypeError, ValueError, AttributeError) as exc:
        raise damaged(path, exc) from exc


def damaged(path: str, exc: Exception) -> InvalidInputError:
    """The error of a file whose contents cannot be."""
    return InvalidInputError(
        "path",
        f"{path!r}, which is damaged ({exc})",
        f"a file written by AntiresonanceSet.save, version {VERSION} or older",
        _ANOTHER,
    )


def _rows(tables: Mapping[Any, ResponseTable]) -> list[dict[str, Any]]:
    return [{"dof": dof, **_row(table)} for dof, table in tables.items()]


def _row(table: ResponseTable) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for name in COLUMNS:
        values = getattr(table, name)
        # A column of which nothing is known is left out.
        if not values.size or not np.isnan(values).all():
            row[name] = _plain(values)
    if table.scores:
        row["scores"] = {name: _plain(values) for name, values in table.scores.items()}
    return row


def _read(rows: Any) -> dict[str, dict[Any, Any]]:
    """Keyword arguments of AntiresonanceSet."""
    out: dict[str, dict[Any, Any]] = {name: {} for name in (*COLUMNS, "scores")}
    for row in rows:
        dof = row["dof"]
        if dof in out["freq_hz"]:
            raise ValueError(f"dof {dof!r} more than once")
        out["freq_hz"][dof] = row["freq_hz"]
        for name in COLUMNS[1:]:
            if name in row:
                out[name][dof] = [np.nan if v is None else v for v in row[name]]
        if "scores" in row:
            out["scores"][dof] = {name: _column(values) for name, values in row["scores"].items()}
    return out


def edit_of(row: dict[str, Any]) -> Edit:
    """An edit as a file has it; ValueError or TypeError for what is none."""
    edit = Edit(**row)
    known = isinstance(row.get("scores", {}), dict) and isinstance(edit.reason, str)
    if edit.action not in ACTIONS or not known:
        raise ValueError(f"edit {row!r}")
    if not isinstance(edit.freq_hz, int | float) or not edit.freq_hz > 0.0:
        raise ValueError(f"edit of {edit.freq_hz!r} Hz")
    return edit


def _column(values: list[Any]) -> Any:
    """Text, truth, whole numbers or floats; null is NaN."""
    if values and all(isinstance(v, str) for v in values):
        return np.array(values)
    if values and all(isinstance(v, bool) for v in values):
        return np.array(values)
    if values and all(isinstance(v, int) for v in values):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


def _plain(values: Any) -> list[Any]:
    """NaN becomes null."""
    return [None if value != value else value for value in values.tolist()]
