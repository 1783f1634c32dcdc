"""Tables of conditions in files: CSV as any program writes it, and Parquet."""

from __future__ import annotations

import csv
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from pathlib import Path
from typing import Any

from ..support.validation import reject
from .condition_numbers import number
from .pyarrow_package import pyarrow_parquet
from .row_names import NAMES, is_one_of

__all__ = ["read_table"]

_ENDINGS = "a file that ends in .csv, .tsv, .txt or .parquet"


def read_table(path: Path) -> dict[str, Any]:
    """Columns by name.

    Raises
    ------
    FileNotFoundError
        There is none.
    InvalidInputError
        A file of another kind, or rows of different lengths.
    """
    suffix = path.suffix.lower()
    if suffix == ".parquet":
        table = pyarrow_parquet("conditions from Parquet").read_table(path)
        return {name: table.column(name).to_pylist() for name in table.column_names}
    if suffix not in (".csv", ".tsv", ".txt"):
        reject("conditions", repr(str(path)), _ENDINGS, "Export the table as CSV.")
    text = _text(path)
    head = text.partition("\n")[0]
    delimiter = max(("\t", ";", ","), key=head.count)
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if row]
    while rows and not any(map(str.strip, rows[-1])):  # within, nothing is known of a test
        rows.pop()
    if len(rows) < 2:
        reject("conditions", f"{str(path)!r} without rows", "a line of names and a line a test", "Fill it.")
    names = [name.strip() for name in rows[0]]
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if twice is not None:
        got = f"two columns {twice!r} in {str(path)!r}"
        reject("conditions", got, "columns of different names", "Rename or remove one.")
    for i, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            got, wanted = f"{len(row)} cells in row {i} of {str(path)!r}", f"{len(names)} as in its first row"
            reject("conditions", got, wanted, "Correct that row.")
    cells = zip(*rows[1:], strict=True)
    return {
        name: _column(name, [cell.strip() for cell in column])
        for name, column in zip(names, cells, strict=True)
    }


def _text(path: Path) -> str:
    """What the file says: in UTF-8, in UTF-16 where it is marked so, or as older spreadsheets write it."""
    data = path.read_bytes()
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _column(name: str, cells: list[str]) -> list[Any]:
    """Numbers where there are some, with a decimal comma too; texts stay, as do the names of tests."""
    return list(cells) if is_one_of(name, NAMES) else [_cell(cell) for cell in cells]


def _cell(cell: str) -> Any:
    try:
        value = number(cell.replace(",", "."))
    except ValueError:
        return cell
    return None if value != value else value
