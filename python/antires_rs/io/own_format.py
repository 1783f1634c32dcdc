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
from dataclasses import fields
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar
from .channels import Reading, kept, renamed
from .common import Signal, unsuitable
from .units import named_unit

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


# -- Options of a reader for a file of our own, which states itself what they would say


def own_signal(path: Path, signal: Signal, given: Reading) -> Signal:
    """A signal of ours with the channels that are kept, by their new names, and with its force or without.

    Every other option is refused, unless it says what the file says: an option that is passed over in silence
    looks as if it had worked.
    """
    made = signal
    if given.dofs is not None:
        labels = renamed("dofs", signal.dofs, given.dofs)
        made = relabelled(signal, kept(labels), [labels[i] for i in kept(labels)])
    _check_force(path, signal, given.force)
    if isinstance(made, Recording) and given.force is None:
        made = Recording(made.responses, made.fs_hz, made.dofs)
    # Our files hold SI, and any SI unit leaves values as they are.
    in_si = given.unit is not None and named_unit("unit", given.unit).factor == 1.0
    stated: dict[str, Any] = {
        **{each.name: getattr(given, each.name) for each in fields(given)},
        "fs_hz": None if given.fs_hz is None else finite_scalar("fs_hz", given.fs_hz),
        "freq_hz": None if given.freq_hz is None else "an axis",
        **dict.fromkeys(("dofs", "force", *["unit"] * in_si)),
    }
    if isinstance(signal, Recording):
        same: dict[str, tuple[Any, ...]] = {"responses": ("responses", ["responses"]), "first": ("time",)}
        if stated["fs_hz"] is not None and np.isclose(stated["fs_hz"], signal.fs_hz, rtol=1e-9, atol=0.0):
            stated["fs_hz"] = None
        said = f"a recording at {signal.fs_hz:g} Hz"
    else:
        said = f"kind {signal.kind!r}"
        said += "" if signal.reference is None else f", reference {signal.reference!r}"
        same = {
            "responses": ("values", ["values"]),
            "first": ("freq",),
            "freq": ("freq_hz",),
            "kind": (signal.kind,),
            "reference": (signal.reference, getattr(made, "reference", None)),
        }
    for name, value in stated.items():
        if value is not None and not any(
            type(value) is type(own) and value == own for own in same.get(name, ())
        ):
            reject(
                name,
                f"{value!r} for {str(path)!r}, a file of antires_rs ({'in SI' if name == 'unit' else said})",
                "it with files of other programs alone",
                "This file states it itself; leave it out."
                + (" To leave channels out, name them by dofs." if name == "responses" else ""),
            )
    return made


def relabelled(signal: Signal, rows: list[int], dofs: list[Any]) -> Signal:
    """Some channels of a signal under other names."""
    if isinstance(signal, Recording):
        return Recording(signal.responses[rows], signal.fs_hz, dofs, signal.force)
    old = [signal.dofs[i] for i in rows]
    if signal.reference is not None and signal.reference not in old:
        reject("dofs", f"no dof for the reference, {signal.reference!r}", "one for it", "Keep that channel.")
    reference = None if signal.reference is None else dofs[old.index(signal.reference)]
    coherence, std = (None if a is None else a[rows] for a in (signal.coherence, signal.std))
    return FrequencyResponse(
        signal.freq_hz, signal.values[rows], dofs, signal.kind, reference, coherence, signal.n_averages, std
    )


def _check_force(path: Path, signal: Signal, force: Any) -> None:
    there = isinstance(signal, Recording) and signal.force is not None
    if force is not None and not (isinstance(force, str) and force in ("auto", *["force"] * there)):
        reject(
            "force",
            f"{force!r} for {str(path)!r}, a file of antires_rs {'with' if there else 'without'} a force",
            "'auto', 'force' or None" if there else "'auto' or None",
            "The file states itself which channel is its force; leave it out.",
        )
