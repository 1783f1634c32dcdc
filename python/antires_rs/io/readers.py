"""Readers of signals by format, and the endings of their files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath

from ._common import Signal
from .delimited import read_csv
from .hdf5 import read_hdf5
from .lvm import read_lvm
from .mat import read_mat
from .miniseed import read_miniseed
from .npz import read_npz
from .table_files import read_excel, read_parquet
from .tdms import read_tdms
from .uff import read_uff
from .wav import read_wav

__all__ = ["ENDINGS", "READERS", "format_by_ending"]

READERS: dict[str, Callable[..., Signal]] = {
    "uff": read_uff,
    "mat": read_mat,
    "hdf5": read_hdf5,
    "csv": read_csv,
    "npz": read_npz,
    "tdms": read_tdms,
    "lvm": read_lvm,
    "wav": read_wav,
    "excel": read_excel,
    "parquet": read_parquet,
    "miniseed": read_miniseed,
}
ENDINGS = {
    "uff": (".uff", ".unv", ".uf", ".u58"),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "csv": (".csv", ".tsv", ".txt"),
    "npz": (".npz", ".npy"),
    "tdms": (".tdms",),
    "lvm": (".lvm",),
    "wav": (".wav",),
    "excel": (".xlsx", ".xlsm"),
    "parquet": (".parquet", ".pq"),
    "miniseed": (".mseed", ".miniseed"),
}


def format_by_ending(name: str) -> str | None:
    """The format that the ending of a file says; None for any other."""
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in ENDINGS.items() if suffix in endings), None)
