"""Formats that are not read, by the endings of their files: whose they are, and what converts them."""

from __future__ import annotations

from pathlib import PurePath

__all__ = ["conversion"]

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
    """A sentence on the file of that name, with a blank before it; '' where its ending says nothing.

    Examples
    --------
    >>> conversion("run.mf4")
    ' It is MDF. The package asammdf converts it to MAT, HDF5, Parquet or CSV.'
    """
    suffix = PurePath(name).suffix.lower()
    return next((f" {said}." for endings, said in _KNOWN.items() if suffix in endings), "")
