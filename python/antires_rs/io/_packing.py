"""A signal as named arrays and one JSON text: what npz, HDF5 and MAT files of our own hold.

Version 1. The text has ``format``, ``version``, ``kind`` ("recording", "frf" or "transmissibility"),
``dofs`` and ``arrays``, the shape and type of each array, so that one that is missing or cut is noticed; a
recording has ``fs_hz``, a response ``reference`` and ``n_averages``. Arrays: ``responses`` and ``force``, or
``freq_hz``, ``values``, ``coherence`` and ``std``; values in SI, rows in the order of ``dofs``. ``crc32`` has
checksums of the arrays, ``text_crc32`` that of the text without it; files of versions before have neither.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.validation import reject
from ._common import Signal, unsuitable

__all__ = ["FORMAT", "check_dofs", "pack", "unpack"]

FORMAT, VERSION = "antires_rs.signal", 1
_OPTIONAL = {"recording": ("force",), "response": ("coherence", "std")}
WANTED = f"a file written by antires_rs, version {VERSION} or older"


def pack(signal: Signal) -> tuple[str, dict[str, NDArray[Any]]]:
    """The text and the arrays of a signal."""
    text: dict[str, Any] = {"format": FORMAT, "version": VERSION, "dofs": check_dofs(signal)}
    arrays: dict[str, NDArray[Any]]
    if isinstance(signal, Recording):
        text |= {"kind": "recording", "fs_hz": signal.fs_hz}
        arrays, optional = {"responses": signal.responses}, _OPTIONAL["recording"]
    else:
        text |= {"kind": signal.kind, "reference": signal.reference, "n_averages": signal.n_averages}
        arrays, optional = {"freq_hz": signal.freq_hz, "values": signal.values}, _OPTIONAL["response"]
    arrays |= {name: getattr(signal, name) for name in optional if getattr(signal, name) is not None}
    text["arrays"] = {name: [str(array.dtype), *array.shape] for name, array in arrays.items()}
    text["crc32"] = {name: _checksum(array) for name, array in arrays.items()}
    text["text_crc32"] = crc32(json.dumps(text, allow_nan=False).encode())
    return json.dumps(text, allow_nan=False), arrays


def _checksum(array: NDArray[Any]) -> int:
    return crc32(np.ascontiguousarray(array).view(np.uint8).reshape(-1))  # type: ignore[arg-type]


def _check_sums(path: Path, data: dict[str, Any], made: dict[str, NDArray[Any]]) -> None:
    """Compare the checksums, which files of versions before do not have."""
    if "text_crc32" in data:
        text = {key: value for key, value in data.items() if key != "text_crc32"}
        if crc32(json.dumps(text).encode()) != data["text_crc32"]:
            unsuitable(path, "whose text does not have its checksum", WANTED, "It was damaged or edited.")
    for name, stated in data.get("crc32", {}).items():
        if name not in made or _checksum(made[name]) != stated:
            unsuitable(
                path,
                f"whose {name} does not have its checksum",
                WANTED,
                "It was damaged or edited: copy it again.",
            )


def unpack(path: Path, text: str, arrays: Mapping[str, Any]) -> Signal:
    """The signal of text and arrays; what is missing or cut is refused."""
    try:
        data = json.loads(text)
        if data["format"] != FORMAT:
            unsuitable(
                path,
                f"which holds {data['format']!r}",
                f"{FORMAT!r}",
                "Read it by the function for such files.",
            )
        if not isinstance(data["version"], int) or data["version"] > VERSION:
            unsuitable(path, f"of version {data['version']!r}", WANTED, "Update antires_rs.")
        lost = [name for name in data["arrays"] if name not in arrays]
        if lost:
            unsuitable(
                path,
                f"without {', '.join(lost)} of its {len(data['arrays'])} arrays",
                WANTED,
                "It was cut: copy it again.",
            )
        made = {name: np.asarray(arrays[name]) for name in data["arrays"]}
        for name, (dtype, *shape) in data["arrays"].items():
            if made[name].dtype != np.dtype(dtype) or made[name].shape != tuple(shape):
                unsuitable(
                    path,
                    f"whose {name} has shape {made[name].shape} of {made[name].dtype}",
                    f"{tuple(shape)} of {dtype}, as the file itself states",
                    "It was damaged.",
                )
        _check_sums(path, data, made)
        if data["kind"] == "recording":
            return Recording(made["responses"], data["fs_hz"], data["dofs"], made.get("force"))
        return FrequencyResponse(
            made["freq_hz"],
            made["values"],
            data["dofs"],
            data["kind"],
            data["reference"],
            made.get("coherence"),
            data["n_averages"],
            made.get("std"),
        )
    except (KeyError, TypeError, AttributeError, json.JSONDecodeError) as exc:
        unsuitable(
            path,
            f"which is damaged ({type(exc).__name__}: {exc})",
            WANTED,
            "Copy it again, or write it anew.",
        )


def check_dofs(signal: Signal) -> list[Any]:
    """Labels as a file can hold them: whole numbers and text."""
    for dof in signal.dofs:
        if isinstance(dof, bool) or not isinstance(dof, int | str):
            reject(
                "signal",
                f"the dof {dof!r}, a {type(dof).__name__}",
                "dofs that are integers or strings",
                "Rename the dof.",
            )
    return list(signal.dofs)
