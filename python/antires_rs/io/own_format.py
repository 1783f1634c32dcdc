"""A signal as named arrays and one JSON text: what npz, HDF5 and MAT files of our own hold; NumPy archives.

Version 1. The text has ``format``, ``version``, ``kind`` ("recording", "frf" or "transmissibility"),
``dofs`` and ``arrays``, the shape and type of each array, so that one that is missing or cut is noticed; a
recording has ``fs_hz``, a response ``reference`` and ``n_averages``. Arrays: ``responses`` and ``force``, or
``freq_hz``, ``values``, ``coherence`` and ``std``; values in SI, rows in the order of ``dofs``. ``crc32`` has
checksums of the arrays, ``text_crc32`` that of the text without it; files of versions before have neither.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from ..exceptions import AntiresError, OutOfMemoryError, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar
from ..support.files import write_atomically
from .channels import kept, renamed
from .common import Signal, bounded, brief, parts_of, unsuitable
from .options import OfArrays, PathLike, Reading, opened, reader, writer
from .raw_arrays import signal_of_arrays
from .units import Unit

__all__ = ["read_npz", "write_npz"]

FORMAT, VERSION = "antires_rs.signal", 1
TEXT = "antires_rs"  # the name of the JSON text in a file
_RECORDING = ("responses",), ("force",), ("fs_hz",)  # arrays, those that may be missing, and other parts
_RESPONSE = ("freq_hz", "values"), ("coherence", "std"), ("kind", "reference", "n_averages")
_WANTED = f"a file written by antires_rs, version {VERSION} or older"


def pack(signal: Any) -> tuple[str, dict[str, NDArray[Any]]]:
    """The text and the arrays of a signal."""
    text: dict[str, Any] = {"format": FORMAT, "version": VERSION, "dofs": check_dofs(signal)}
    needed, optional, values = _RECORDING if isinstance(signal, Recording) else _RESPONSE
    text |= {"kind": "recording"} if isinstance(signal, Recording) else {}
    text |= {name: getattr(signal, name) for name in values}
    arrays = {name: getattr(signal, name) for name in (*needed, *optional)}
    arrays = {name: array for name, array in arrays.items() if array is not None}
    text["arrays"] = {name: [str(array.dtype), *array.shape] for name, array in arrays.items()}
    text["crc32"] = {name: _checksum(array) for name, array in arrays.items()}
    text["text_crc32"] = crc32(json.dumps(text, allow_nan=False).encode())
    return json.dumps(text, allow_nan=False), arrays


def _checksum(array: NDArray[Any]) -> int:
    return crc32(np.ascontiguousarray(array).view(np.uint8).reshape(-1))  # type: ignore[arg-type]


def own_signal(path: Path, text: str, arrays: Mapping[str, Any], given: Reading) -> Signal:
    """The signal of text and arrays, as the options say; what is missing or cut is refused."""
    with parts_of(path, _WANTED):
        data = json.loads(text)
        if data["format"] != FORMAT:
            found = f"which holds {data['format']!r}"
            unsuitable(path, found, f"{FORMAT!r}", "Read it by the function for such files.")
        if not isinstance(data["version"], int) or data["version"] > VERSION:
            unsuitable(path, f"of version {data['version']!r}", _WANTED, "Update antires_rs.")
        lost = [name for name in data["arrays"] if name not in arrays]
        if lost:
            found = f"without {', '.join(lost)} of its {len(data['arrays'])} arrays"
            unsuitable(path, found, _WANTED)
        made = {name: np.asarray(arrays[name]) for name in data["arrays"]}
        for name, (dtype, *shape) in data["arrays"].items():
            if made[name].dtype != np.dtype(dtype) or made[name].shape != tuple(shape):
                got = f"whose {name} has shape {made[name].shape} of {made[name].dtype}"
                unsuitable(path, got, f"{tuple(shape)} of {dtype}, as the file itself states")
        # Checksums, which files of versions before do not have.
        text = json.dumps({key: value for key, value in data.items() if key != "text_crc32"})
        stated = {"text": data.get("text_crc32"), **data.get("crc32", {})}
        sums = {"text": crc32(text.encode())} | {name: _checksum(array) for name, array in made.items()}
        wrong = next((name for name, crc in stated.items() if crc not in (None, sums.get(name))), None)
        if wrong is not None:
            unsuitable(path, f"whose {wrong} does not have its checksum", _WANTED)
        kind: type[Signal] = Recording if data["kind"] == "recording" else FrequencyResponse
        needed, optional, values = _RECORDING if kind is Recording else _RESPONSE
        held: dict[str, Any] = {name: made[name] for name in needed}
        held |= {name: made.get(name) for name in optional}
        signal = kind(**held, **{name: data[name] for name in ("dofs", *values)})
    return as_asked(path, signal, given)


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


def as_asked(path: Path, signal: Signal, given: Reading) -> Signal:
    """A signal of ours as the options say; those that the file contradicts are refused, not passed over."""
    made = signal if given.dofs is None else relabelled(signal, renamed("dofs", signal.dofs, given.dofs))
    if isinstance(made, Recording) and given.force is None:
        made = Recording(made.responses, made.fs_hz, made.dofs)

    def agrees(name: str, value: Any) -> bool:
        if name == "unit":  # our files hold SI, and any SI unit leaves values as they are
            return Unit.named(value).factor == 1.0
        if name == "force":
            there = isinstance(signal, Recording) and signal.force is not None
            return isinstance(value, str) and value in ("auto", *["force"] * there)
        if name == "fs_hz":
            rate = finite_scalar("fs_hz", value)
            return isinstance(signal, Recording) and abs(rate / signal.fs_hz - 1.0) <= 1e-9
        own = [getattr(each, name, None) for each in (signal, made)] if name in ("kind", "reference") else []
        if name == "align":
            return True
        return any(type(value) is type(each) and value == each for each in own)

    asked = {name: value for name, value in vars(given).items() if name != "dofs" and value is not None}
    odd = next((name for name, value in asked.items() if not agrees(name, value)), None)
    if odd is not None:
        what = f"at {signal.fs_hz:g} Hz" if isinstance(signal, Recording) else f"of kind {signal.kind!r}"
        got = f"{str(asked[odd])[:40]!r} for {str(path)!r}, a file of antires_rs (in SI, {what})"
        remedy = "This file states it itself; leave it out. Channels are left out by dofs."
        reject(odd, got, "it with files of other programs alone", remedy)
    return made


def relabelled(signal: Signal, labels: Sequence[Any]) -> Signal:
    """The channels of a signal under other names; those without one are left out."""
    rows = kept(labels)
    dofs = [labels[i] for i in rows]
    if isinstance(signal, Recording):
        return Recording(signal.responses[rows], signal.fs_hz, dofs, signal.force, signal.time_s)
    old = [signal.dofs[i] for i in rows]
    if signal.reference is not None and signal.reference not in old:
        reject("dofs", f"no dof for the reference, {signal.reference!r}", "one for it", "Keep that channel.")
    reference = None if signal.reference is None else dofs[old.index(signal.reference)]
    coherence, std = (None if a is None else a[rows] for a in (signal.coherence, signal.std))
    return FrequencyResponse(
        signal.freq_hz, signal.values[rows], dofs, signal.kind, reference, coherence, signal.n_averages, std
    )


# -- NumPy archives, without pickle in either direction

_NPY = b"\x93NUMPY"  # the first bytes of a .npy file


@reader(".npz .npy")
def read_npz(path: PathLike, **options: Unpack[OfArrays]) -> Signal:
    """Read a NumPy archive (.npz) or array (.npy): ours as it was, any other by the names of its arrays.

    A file of ours states everything itself: ``dofs=`` renames its channels or leaves some out, ``force=None``
    drops its force, and any other option that does not agree with it is refused. So are objects, which need
    pickle, and what unpacks to more than 1 GB (the environment variable ``ANTIRES_MAX_BYTES`` allows more).

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savez(folder + "/a.npz", time=np.arange(100) / 50.0, tip=np.sin(np.arange(100.0)))
    ...     ar.read_npz(folder + "/a.npz", unit="g")
    Recording(1 channels, 2 s at 50 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_npz, path, options)
    arrays = read_archive(file)
    if TEXT in arrays:
        return own_signal(file, bytes(arrays[TEXT]).decode("utf-8", "replace"), arrays, given)
    return signal_of_arrays(file, arrays, given)


@writer
def write_npz(path: PathLike, signal: Signal) -> Path:
    """Write a signal as a NumPy archive, whole or not at all; every float comes back bit for bit.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_npz(folder + "/a.npz", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_npz(file).responses
    array([[1., 2., 4.]])
    """
    return write_archive(path, *pack(signal))


def write_archive(path: PathLike, text: str, arrays: dict[str, NDArray[Any]]) -> Path:
    """Arrays and a text in one archive."""
    buffer = io.BytesIO()
    members: dict[str, Any] = {TEXT: np.frombuffer(text.encode(), dtype=np.uint8), **arrays}
    np.savez_compressed(buffer, **members)  # plain arrays only: nothing is pickled
    return write_atomically(path, buffer.getvalue())


def read_archive(
    file: Path, wanted: str = "a whole NumPy archive (.npz) or array (.npy) of numbers"
) -> dict[str, NDArray[Any]]:
    """Every array of an archive, the checksums of zip compared."""
    import zipfile

    size = file.stat().st_size
    try:
        with open(file, "rb") as opened:  # Opened here: of a damaged archive numpy would leave the file open.
            alone = opened.read(len(_NPY)) == _NPY
            if not alone and not zipfile.is_zipfile(opened):
                unsuitable(file, "which is no archive", wanted)
            if not alone:
                members = zipfile.ZipFile(opened).infolist()
                size = sum(each.file_size for each in members)
                bounded(file, size, "a packed archive")
            opened.seek(0)
            held = np.load(opened, allow_pickle=False)
            arrays = {file.stem: held} if alone else {name: held[name] for name in held.files}
            odd = next((name for name, each in arrays.items() if not isinstance(each, np.ndarray)), None)
            if odd is not None:
                unsuitable(file, f"whose member {odd!r} is no array", wanted)
            return arrays
    except AntiresError:
        raise
    except MemoryError:
        less = "Free some; if the file is small, it is damaged."
        raise OutOfMemoryError(f"reading {str(file)!r}", size, less) from None
    except Exception as exc:  # of zip, of zlib, of numpy, and of Python's parser, which reads the headers
        unsuitable(file, f"which cannot be read ({brief(exc)})", wanted)
