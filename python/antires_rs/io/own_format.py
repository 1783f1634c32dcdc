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

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar
from .channels import kept, renamed
from .common import Signal, parts_of, unsuitable
from .reading import Reading
from .units import named_unit

FORMAT, VERSION = "antires_rs.signal", 1
#: The name of the JSON text in a file.
TEXT = "antires_rs"
#: Arrays, those that may be missing, and other parts.
_RECORDING = ("responses",), ("force",), ("fs_hz",)
_RESPONSE = ("freq_hz", "values"), ("coherence", "std"), ("kind", "reference", "n_averages")
_WANTED = f"a file written by antires_rs, version {VERSION} or older"


def pack(signal: Any) -> tuple[str, dict[str, NDArray[Any]]]:
    """The text and the arrays of a signal."""
    text: dict[str, Any] = {"format": FORMAT, "version": VERSION, "dofs": check_dofs(signal)}
    needed, optional, values = _RECORDING if isinstance(signal, Recording) else _RESPONSE
    if isinstance(signal, Recording):
        text["kind"] = "recording"
    text |= {name: getattr(signal, name) for name in values}
    arrays = {name: getattr(signal, name) for name in (*needed, *optional)}
    arrays = {name: array for name, array in arrays.items() if array is not None}
    text["arrays"] = {name: [str(array.dtype), *array.shape] for name, array in arrays.items()}
    text["crc32"] = {name: _checksum(array) for name, array in arrays.items()}
    text["text_crc32"] = crc32(json.dumps(text, allow_nan=False).encode())
    return json.dumps(text, allow_nan=False), arrays


def _checksum(array: NDArray[Any]) -> int:
    return crc32(np.ascontiguousarray(array).view(np.uint8).reshape(-1))  # type: ignore[arg-type]


def unpack(path: Path, text: str, arrays: Mapping[str, Any]) -> Signal:
    """The signal of text and arrays; what is missing or cut is refused."""
    with parts_of(path, _WANTED, "Copy it again, or write it anew."):
        data = json.loads(text)
        if data["format"] != FORMAT:
            found = f"which holds {data['format']!r}"
            unsuitable(path, found, f"{FORMAT!r}", "Read it by the function for such files.")
        if not isinstance(data["version"], int) or data["version"] > VERSION:
            unsuitable(path, f"of version {data['version']!r}", _WANTED, "Update antires_rs.")
        lost = [name for name in data["arrays"] if name not in arrays]
        if lost:
            found = f"without {', '.join(lost)} of its {len(data['arrays'])} arrays"
            unsuitable(path, found, _WANTED, "It was cut: copy it again.")
        made = {name: np.asarray(arrays[name]) for name in data["arrays"]}
        for name, (dtype, *shape) in data["arrays"].items():
            if made[name].dtype != np.dtype(dtype) or made[name].shape != tuple(shape):
                got = f"whose {name} has shape {made[name].shape} of {made[name].dtype}"
                wanted = f"{tuple(shape)} of {dtype}, as the file itself states"
                unsuitable(path, got, wanted, "It was damaged.")
        _check_sums(path, data, made)
        is_recording = data["kind"] == "recording"
        needed, optional, values = _RECORDING if is_recording else _RESPONSE
        held: dict[str, Any] = {name: made[name] for name in needed} | {
            name: made.get(name) for name in optional
        }
        held |= {name: data[name] for name in ("dofs", *values)}
        return Recording(**held) if is_recording else FrequencyResponse(**held)


def _check_sums(path: Path, data: dict[str, Any], made: dict[str, NDArray[Any]]) -> None:
    """Compare the checksums, which files of versions before do not have."""
    if "text_crc32" in data:
        text = {key: value for key, value in data.items() if key != "text_crc32"}
        if crc32(json.dumps(text).encode()) != data["text_crc32"]:
            unsuitable(path, "whose text does not have its checksum", _WANTED, "It was damaged or edited.")
    for name, stated in data.get("crc32", {}).items():
        if name not in made or _checksum(made[name]) != stated:
            found = f"whose {name} does not have its checksum"
            unsuitable(path, found, _WANTED, "It was damaged or edited: copy it again.")


def check_dofs(signal: Any) -> list[Any]:
    """Labels of a signal as a file can hold them: whole numbers and text."""
    if not isinstance(signal, Signal):
        remedy = "Make one of the arrays first: Recording(responses, fs_hz)."
        reject("signal", type(signal).__name__, "a Recording or a FrequencyResponse", remedy)
    for dof in signal.dofs:
        if isinstance(dof, bool) or not isinstance(dof, int | str):
            got = f"the dof {dof!r}, a {type(dof).__name__}"
            reject("signal", got, "dofs that are integers or strings", "Rename the dof.")
    return list(signal.dofs)


# -- Options of a reader for a file of our own, which states itself what they would say


def own_signal(path: Path, text: str, arrays: Mapping[str, Any], given: Reading) -> Signal:
    """The signal of text and arrays, as the options say."""
    return as_asked(path, unpack(path, text, arrays), given)


def as_asked(path: Path, signal: Signal, given: Reading) -> Signal:
    """A signal of ours with the channels that are kept, by their new names, and with its force or without.

    Every other option is refused, unless it says what the file says: an option that is passed over in silence
    looks as if it had worked.
    """
    made = signal
    if given.dofs is not None:
        labels = renamed("dofs", signal.dofs, given.dofs)
        made = relabelled(signal, kept(labels), [labels[i] for i in kept(labels)])
    has_force = isinstance(signal, Recording) and signal.force is not None
    allowed = ("auto", *["force"] * has_force)
    if given.force is not None and not (isinstance(given.force, str) and given.force in allowed):
        there = "with" if has_force else "without"
        got = f"{given.force!r} for {str(path)!r}, a file of antires_rs {there} a force"
        wanted = "'auto', 'force' or None" if has_force else "'auto' or None"
        reject("force", got, wanted, "The file states itself which channel is its force; leave it out.")
    if isinstance(made, Recording) and given.force is None:
        made = Recording(made.responses, made.fs_hz, made.dofs)
    stated: dict[str, Any] = {
        name: value for name, value in vars(given).items() if name not in ("dofs", "force")
    }
    if given.freq_hz is not None:
        stated["freq_hz"] = "an axis"
    if given.fs_hz is not None:
        stated["fs_hz"] = finite_scalar("fs_hz", given.fs_hz)
    # Our files hold SI, and any SI unit leaves values as they are.
    if given.unit is not None and named_unit("unit", given.unit).factor == 1.0:
        del stated["unit"]
    same: dict[str, tuple[Any, ...]]
    if isinstance(signal, Recording):
        same = {"responses": ("responses", ["responses"]), "first": ("time",)}
        if given.fs_hz is not None and np.isclose(stated["fs_hz"], signal.fs_hz, rtol=1e-9, atol=0.0):
            del stated["fs_hz"]
        content = f"a recording at {signal.fs_hz:g} Hz"
    else:
        content = f"kind {signal.kind!r}"
        content += "" if signal.reference is None else f", reference {signal.reference!r}"
        same = {
            "responses": ("values", ["values"]),
            "first": ("freq",),
            "freq": ("freq_hz",),
            "kind": (signal.kind,),
            "reference": (signal.reference, getattr(made, "reference", None)),
        }
    for name, value in stated.items():
        if value is None or any(type(value) is type(own) and value == own for own in same.get(name, ())):
            continue
        reject(
            name,
            f"{value!r} for {str(path)!r}, a file of antires_rs ({'in SI' if name == 'unit' else content})",
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
