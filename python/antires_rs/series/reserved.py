"""Names of the columns of a series as a table, which no condition may have."""

from __future__ import annotations

from ..support.validation import reject
from .encoded import COLUMNS

__all__ = ["TEST_COLUMNS", "refuse_reserved"]

#: Beside the columns of antiresonances; see :mod:`~antires_rs.series.parquet_file`.
TEST_COLUMNS = ("row", "test", "name", "time", "dof", "failed", "count", "fingerprint", "facts")


def refuse_reserved(argument: str, name: str) -> None:
    """Refuse a condition that has the name of a column of the table."""
    if name in TEST_COLUMNS or name in COLUMNS or name == "source" or name.startswith("score_"):
        reject(argument, name, "a name that no column of a series has", "Rename it, as in 'outside_c'.")
