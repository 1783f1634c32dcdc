"""Formats of measurements by the endings of their files."""

from __future__ import annotations

from pathlib import PurePath

from ..io.readers import ENDINGS

__all__ = ["ARRAYS", "COLUMNS", "FOLDER", "FORMATS", "RECORDS", "RESPONSES", "SIGNALS", "format_of"]

#: Endings of files by format.
FORMATS = {**ENDINGS, "antiresonances": (".json",)}
#: What has no ending: a folder of files of one response each.
FOLDER = "folder"

ARRAYS, SIGNALS = ("mat", "hdf5", "npz"), (*ENDINGS, FOLDER)
#: Tables of columns; records of channels that state themselves; what may hold responses over frequency.
COLUMNS, RECORDS = ("csv", "excel", "parquet"), ("tdms", "lvm", "wav", "miniseed")
RESPONSES = tuple(kind for kind in SIGNALS if kind not in RECORDS)


def format_of(name: str, given: str | None = None) -> str | None:
    """The format named, or that of the file's ending; None where neither is known."""
    if given is not None:
        return given if given in FORMATS else None
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in FORMATS.items() if suffix in endings), None)
