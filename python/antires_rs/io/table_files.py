"""Tables of other programs, Excel and Parquet, read as the columns of a CSV file are."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..support.checks import choice
from .channels import Dofs
from .common import Signal, existing_file, unsuitable
from .raw_arrays import given_axis
from .stated_channels import channels_of_child
from .text_table import Table, named, response_without_axis, signal_of_columns


def read_excel(
    path: str | os.PathLike[str],
    *,
    sheet: str | None = None,
    first: str | None = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    kind: str | None = None,
    reference: Any = None,
    pairs: str | None = None,
    freq_hz: Any = None,
    df_hz: float | None = None,
    time_limit_s: float = 120.0,
    memory_limit_gb: float = 8.0,
) -> Signal:
    """Read a sheet of an Excel workbook (.xlsx), one row a sample or a frequency.

    Parameters
    ----------
    path : path-like
        Lines of text above the numbers: the last names the columns, ``tip [g]``; a line of units may follow.
    sheet : str, optional
        By default the first.
    first, fs_hz, dofs, force, unit, kind, reference, pairs, freq_hz, df_hz
        As in :func:`read_csv`. Days and times, or those of a clock, in the first column are the time.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording or FrequencyResponse
        In SI.

    Raises
    ------
    UnsuitableDataError
        A damaged file, empty cells or texts between numbers, gaps in time.
    InvalidInputError
        Options that do not fit the file.
    MissingDependencyError
        openpyxl is not installed.
    FileNotFoundError
        There is none.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> from openpyxl import Workbook
    >>> book = Workbook()
    >>> for row in (["time [ms]", "tip [g]"], [0, 1.0], [10, -0.5], [20, 0.25]):
    ...     book.active.append(row)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     book.save(folder + "/a.xlsx")
    ...     ar.read_excel(folder + "/a.xlsx")
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    file = existing_file(path)
    entries, texts = channels_of_child(
        "excel",
        file,
        ("openpyxl", "excel"),
        "read_excel",
        "an Excel workbook (.xlsx) with rows of numbers",
        time_limit_s=time_limit_s,
        memory_limit_gb=memory_limit_gb,
        sheet=sheet,
    )
    head = [row for row in json.loads(texts["head"]) if len(row) == len(entries)]
    return _signal(
        file,
        _table(file, entries, head),
        first,
        fs_hz,
        dofs,
        force,
        unit,
        kind,
        reference,
        pairs,
        freq_hz,
        df_hz,
    )


def read_parquet(
    path: str | os.PathLike[str],
    *,
    first: str | None = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    kind: str | None = None,
    reference: Any = None,
    pairs: str | None = None,
    freq_hz: Any = None,
    df_hz: float | None = None,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
) -> Signal:
    """Read a Parquet table, as pandas writes it, one row a sample or a frequency.

    Parameters
    ----------
    path : path-like
        Columns are named ``tip [g]``, or have their unit in the field's metadata, ``unit``.
    first, fs_hz, dofs, force, unit, kind, reference, pairs, freq_hz, df_hz
        As in :func:`read_csv`. The index of pandas comes first; a column of timestamps is the time.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording or FrequencyResponse
        In SI.

    Raises
    ------
    UnsuitableDataError
        A damaged file, empty cells, columns that are no numbers, gaps in time.
    InvalidInputError
        Options that do not fit the file.
    MissingDependencyError
        pyarrow is not installed.
    FileNotFoundError
        There is none.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> import pyarrow as pa, pyarrow.parquet as pq
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     table = pa.table({"time": [0.0, 0.5, 1.0], "tip [g]": [1.0, -0.5, 0.25]})
    ...     pq.write_table(table, folder + "/a.parquet")
    ...     ar.read_parquet(folder + "/a.parquet")
    Recording(1 channels, 1.5 s at 2 Hz, dofs=('tip',), no force)
    """
    file = existing_file(path)
    entries, _ = channels_of_child(
        "parquet",
        file,
        ("pyarrow", "series"),
        "read_parquet",
        "a whole Parquet file with columns of numbers",
        time_limit_s=time_limit_s,
        memory_limit_gb=memory_limit_gb,
    )
    # pandas puts an index of instants last, under a name of its own.
    entries.sort(key=lambda entry: not (entry["name"].startswith("__index_level_") or "instants" in entry))
    for entry in entries:
        if entry["name"].startswith("__index_level_"):
            entry["name"] = "time" if "instants" in entry else ""
    table = _table(file, entries, [[entry["name"] for entry in entries]])
    return _signal(file, table, first, fs_hz, dofs, force, unit, kind, reference, pairs, freq_hz, df_hz)


def _table(file: Path, entries: list[dict[str, Any]], head: list[list[str]]) -> Table:
    """The columns as those of a text."""
    if not entries or entries[0]["values"].size < 2:
        unsuitable(
            file,
            f"with {len(entries)} columns of {entries[0]['values'].size if entries else 0} rows",
            "columns of two rows or more",
            "Export more of the record; a single row is no signal.",
        )
    table = Table(values=np.column_stack([entry["values"] for entry in entries]))
    if not np.isfinite(table.values).all():
        unsuitable(
            file,
            "with values that are not finite",
            "finite numbers",
            "Fill or cut out the cells without one.",
        )
    named(table, head)
    units = table.units or [""] * len(entries)
    table.units = [entry["unit"] or unit for entry, unit in zip(entries, units, strict=True)]
    if "instants" in entries[0] and table.names:
        table.names[0] = "time"
    return table


def _signal(
    file: Path,
    table: Table,
    first: str | None,
    fs_hz: float | None,
    dofs: Dofs,
    force: Any,
    unit: str | None,
    kind: str | None,
    reference: Any,
    pairs: str | None,
    freq_hz: Any,
    df_hz: float | None,
) -> Signal:
    if first is not None:
        choice("first", first, ("time", "freq", "channel"))
    axis = given_axis(freq_hz, df_hz)
    kind = "frf" if kind is None else kind
    if axis is not None:
        return response_without_axis(file, table, axis, first, pairs, dofs, unit, kind, reference)
    return signal_of_columns(file, table, first, pairs, fs_hz, dofs, force, unit, kind, reference)
