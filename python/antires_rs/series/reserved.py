"""Names of the columns of a series as a table, which no condition may have."""

from __future__ import annotations

from .encoded import COLUMNS

__all__ = ["TEST_COLUMNS", "is_reserved"]

#: Beside the columns of antiresonances; see :mod:`~antires_rs.series.parquet_file`.
TEST_COLUMNS = ("row", "test", "name", "time", "dof", "failed", "count", "fingerprint", "facts")


def is_reserved(name: str) -> bool:
    """Whether a column of the table has this name."""
    return name in TEST_COLUMNS or name in COLUMNS or name == "source" or name.startswith("score_")
