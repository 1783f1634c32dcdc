"""NumPy archives, without pickle in either direction."""

from __future__ import annotations

import io
from contextlib import suppress
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ..exceptions import AntiresError
from ..support.files import write_atomically
from .common import Signal, brief, unsuitable
from .own_format import TEXT, own_signal, pack
from .raw_arrays import signal_of_arrays
from .reading import OfArrays, PathLike, opened, reader, writer

#: The first bytes of a .npy file; the dtype stands within those of its head.
_NPY, _HEAD_BYTES = b"\x93NUMPY", 512


@reader
def read_npz(path: PathLike, **options: Unpack[OfArrays]) -> Signal:
    """Read a NumPy archive (.npz) or array (.npy): ours as it was, any other by the names of its arrays.

    A file of ours states everything itself: ``dofs=`` renames its channels or leaves some out, ``force=None``
    drops its force, and any other option that does not agree with it is refused.

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file (the archive's directory is its end, and every member has a checksum), objects
        that would need pickle, or arrays whose role is not clear.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savez(folder + "/a.npz", time=np.arange(100) / 50.0, tip=np.sin(np.arange(100.0)))
    ...     ar.read_npz(folder + "/a.npz", unit="g")
    Recording(1 channels, 2 s at 50 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_npz, path, options)
    with file.open("rb") as stream:
        alone = stream.read(len(_NPY)) == _NPY
    arrays = _array(file) if alone else read_archive(file)
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
    file: Path,
    wanted: str = "a whole NumPy archive (.npz) of plain arrays",
    remedy: str = "It was cut, or is another file.",
) -> dict[str, NDArray[Any]]:
    """Every array of an archive; the checksums of zip are compared.

    ``wanted`` and ``remedy`` are said of a file that is no archive.
    """
    import zipfile

    try:
        if not zipfile.is_zipfile(file):
            unsuitable(file, "which is no archive", wanted, remedy)
        # Opened here: of a damaged archive numpy would leave the file open.
        with open(file, "rb") as opened, np.load(opened, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except AntiresError:
        raise
    except Exception as exc:  # of zip, of zlib, of numpy, and of Python's parser, which reads the headers
        if _holds_objects(file):
            found = "which holds objects, which only pickle reads"
            unsuitable(file, found, wanted, "A pickle can run any code. Save arrays of numbers alone.")
        got = f"which cannot be read ({brief(exc)})"
        unsuitable(file, got, wanted, "It was cut or damaged: copy it again.")


def _array(file: Path) -> dict[str, NDArray[Any]]:
    """The array of a .npy file, under the name of the file."""
    try:
        return {file.stem: np.load(file, allow_pickle=False)}
    except Exception as exc:  # numpy parses the header as Python, with the errors of Python's own parser
        remedy = "It was cut, or holds objects, which only pickle reads: save numbers alone."
        unsuitable(file, f"which cannot be read ({brief(exc)})", "a whole array of numbers (.npy)", remedy)


def _holds_objects(file: Path) -> bool:
    """Whether an array of the archive is one of Python objects, by the headers of its members."""
    import zipfile

    with suppress(Exception), zipfile.ZipFile(file) as archive:
        for name in archive.namelist():
            with archive.open(name) as member:
                if b"'|O'" in member.read(_HEAD_BYTES):
                    return True
    return False
