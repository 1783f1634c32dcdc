"""Tables of conditions in files: CSV as any program writes it, and Parquet."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from ..support.validation import reject
from .pyarrow_package import pyarrow_parquet

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
    text = path.read_text(encoding="utf-8-sig")
    head = text.partition("\n")[0]
    delimiter = max(("\t", ";", ","), key=head.count)
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if any(map(str.strip, row))]
    if len(rows) < 2:
        reject("conditions", f"{str(path)!r} without rows", "a line of names and a line a test", "Fill it.")
    names = [name.strip() for name in rows[0]]
    for i, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            got, wanted = f"{len(row)} cells in row {i} of {str(path)!r}", f"{len(names)} as in its first row"
            reject("conditions", got, wanted, "Correct that row.")
    cells = zip(*rows[1:], strict=True)
    return {
        name: _column([cell.strip() for cell in column]) for name, column in zip(names, cells, strict=True)
    }


def _column(cells: list[str]) -> list[Any]:
    """Numbers where all are, with a decimal comma too; else texts."""
    try:
        return [float(cell.replace(",", ".")) if cell else None for cell in cells]
    except ValueError:
        return list(cells)
