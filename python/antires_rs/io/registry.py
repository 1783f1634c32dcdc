"""Readers of signals by format, and the endings of their files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath

from .common import Signal
from .hdf5_mat import read_hdf5, read_mat
from .npz import read_npz
from .recorders import read_lvm, read_miniseed, read_tdms, read_wav
from .table_files import read_csv, read_excel, read_parquet
from .uff import read_uff

#: Each format with its reader, the endings of its files, and the group of formats to which it belongs.
_FORMATS: dict[str, tuple[Callable[..., Signal], str, str]] = {
    "uff": (read_uff, ".uff .unv .uf .u58", ""),
    "mat": (read_mat, ".mat", "arrays"),
    "hdf5": (read_hdf5, ".h5 .hdf5 .hdf", "arrays"),
    "csv": (read_csv, ".csv .tsv .txt", "columns"),
    "npz": (read_npz, ".npz .npy", "arrays"),
    "tdms": (read_tdms, ".tdms", "records"),
    "lvm": (read_lvm, ".lvm", "records"),
    "wav": (read_wav, ".wav", "records"),
    "excel": (read_excel, ".xlsx .xlsm", "columns"),
    "parquet": (read_parquet, ".parquet .pq", "columns"),
    "miniseed": (read_miniseed, ".mseed .miniseed", "records"),
}
READERS = {name: reader for name, (reader, _, _) in _FORMATS.items()}
ENDINGS = {name: tuple(endings.split()) for name, (_, endings, _) in _FORMATS.items()}


def formats_of(group: str) -> tuple[str, ...]:
    """Names of the formats of a group: arrays with names, tables of columns, or records alone."""
    return tuple(name for name, (_, _, own) in _FORMATS.items() if own == group)


def format_by_ending(name: str) -> str | None:
    """The format that the ending of a file says; None for any other."""
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in ENDINGS.items() if suffix in endings), None)


# -- Formats that are not read, by the endings of their files: whose they are, and what converts them

_EXPORT = "Export it there as a universal file (58), MAT, HDF5 or CSV"
_SEVERAL = f"Several programs write that ending. {_EXPORT}, or name the format if it is one that is read"
_KNOWN: dict[tuple[str, ...], str] = {
    (".dxd", ".dxz", ".d7d", ".d7z"): f"It is one of Dewesoft. {_EXPORT}",
    (".ldsf", ".lms", ".tlab"): f"It is one of Siemens Simcenter Testlab. {_EXPORT}",
    (".pti", ".bkc", ".rec"): f"It is one of B&K. {_EXPORT} (PULSE Reflex, BK Connect)",
    (".svd", ".pvd"): f"It is one of Polytec. {_EXPORT}",
    (".blk", ".vtprj", ".str", ".vpr"): f"It is one of MEscope. {_EXPORT}",
    (".vna", ".dp", ".scproj"): f"It is one of Data Physics SignalCalc. {_EXPORT}",
    (".mf4", ".mdf"): "It is MDF. The package asammdf converts it to MAT, HDF5, Parquet or CSV",
    (".sie",): "It is one of HBK SoMat (catman, nCode). Export it there as MAT, universal file or CSV",
    (".tim", ".rsp", ".drv", ".rpc"): "It is RPC of MTS. Export it there, or with nCode, as MAT or CSV",
    (".tdm", ".tdx"): "It is TDM of NI. DIAdem or LabVIEW save it as TDMS",
    (".edf", ".bdf"): "It is EDF. The packages pyedflib and mne read it; save the arrays as npz",
    (".sac", ".gse", ".gse2", ".sgy", ".segy", ".sg2"): "The package obspy converts it to miniSEED",
    (".hdr", ".atfx", ".atf", ".ods5"): f"It is one of ASAM ODS. {_EXPORT}",
    (".nsrf", ".imc", ".raw", ".dat", ".bin", ".sdt", ".dta", ".asc", ".log"): _SEVERAL,
    (".xls", ".ods", ".xlsb"): "Save it as .xlsx or CSV",
    (".feather", ".arrow", ".pkl", ".pickle"): "Save it as Parquet: DataFrame.to_parquet",
    (
        ".flac",
        ".mp3",
        ".ogg",
        ".m4a",
        ".aiff",
        ".aif",
    ): "Convert it to WAV; MP3, OGG and M4A have lost a part",
    (".tdms_index",): "It is the index of the .tdms beside it: name that",
    (".slx", ".m"): "It is no data: save the arrays as MAT",
}


def conversion(name: str) -> str:
    """A sentence on the file of that name, with a blank before it; '' where its ending says nothing."""
    suffix = PurePath(name).suffix.lower()
    return next((f" {text}." for endings, text in _KNOWN.items() if suffix in endings), "")
