"""The package that reads and writes Parquet, imported where a file is asked for."""

from __future__ import annotations

from typing import Any

from ..io._common import missing_package

__all__ = ["pyarrow", "pyarrow_parquet"]


def pyarrow(what: str) -> Any:
    """The package, or the error that names the extra."""
    try:
        import pyarrow
    except ImportError as exc:
        raise missing_package(what, "pyarrow", "series", exc) from exc
    return pyarrow


def pyarrow_parquet(what: str) -> Any:
    """Its module for Parquet."""
    from importlib import import_module

    return import_module(f"{pyarrow(what).__name__}.parquet")
