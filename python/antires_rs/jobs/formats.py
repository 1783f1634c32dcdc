"""Formats of measurements by the endings of their files."""

from __future__ import annotations

from pathlib import PurePath

__all__ = ["ARRAYS", "FORMATS", "SIGNALS", "format_of"]

#: Endings of files by format.
FORMATS = {
    "uff": (".uff", ".unv", ".uf", ".u58"),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "csv": (".csv", ".tsv", ".txt"),
    "npz": (".npz",),
    "antiresonances": (".json",),
}

ARRAYS, SIGNALS = ("mat", "hdf5", "npz"), ("uff", "mat", "hdf5", "csv", "npz")


def format_of(name: str, given: str | None = None) -> str | None:
    """The format named, or that of the file's ending; None where neither is known."""
    if given is not None:
        return given if given in FORMATS else None
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in FORMATS.items() if suffix in endings), None)
