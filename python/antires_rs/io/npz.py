"""NumPy archives, without pickle in either direction."""

from __future__ import annotations

import io
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import AntiresError
from ..support.files import write_atomically
from .channels import Dofs, Reading
from .common import Signal, brief, existing_file, signal_given, unsuitable
from .own_format import own_signal, pack, unpack
from .raw_arrays import signal_of_arrays

#: The member that holds the JSON text, as bytes.
TEXT = "antires_rs"


def read_npz(
    path: str | os.PathLike[str],
    *,
    responses: Any = None,
    time: str | None = None,
    freq: str | None = None,
    force: Any = "auto",
    fs_hz: float | None = None,
    dofs: Dofs = None,
    unit: str | None = None,
    kind: str | None = None,
    reference: Any = None,
    freq_hz: Any = None,
    df_hz: float | None = None,
) -> Signal:
    """Read a NumPy archive (.npz) or array (.npy): ours as it was, any other by the names of its arrays.

    A file of ours states everything itself: ``dofs=`` renames its channels or leaves some out, ``force=None``
    drops its force, and any other option that does not agree with it is refused.

    Parameters
    ----------
    path : path-like
    responses : str or sequence of str, optional
        Names of the response arrays, ``*`` for any text; those that no other role takes by default. A matrix
        gives one channel for each row, the longer axis being time or frequency.
    time, freq : str, optional
        Name of the time or the frequency; by default the array called so.
    force : str or None
        Name of the force; "auto" takes the array called so, None leaves it out.
    fs_hz : float, optional
        Sampling rate, where the file has neither time nor rate.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        arrays' names.
    unit : str, optional
        Unit of the responses, which are converted to SI: ``'m/s2'``, ``'g'``, ``'g/N'`` and the like. SI by
        default.
    kind, reference
        Of responses over frequency: as in :class:`FrequencyResponse`; "frf" by default.
    freq_hz : (n_freq,), optional
        Frequencies of the responses, where the file does not hold them. Of a matrix the axis of that length
        is frequency.
    df_hz : float, optional
        Their spacing from 0 Hz on, in place of ``freq_hz``.

    Returns
    -------
    Recording or FrequencyResponse

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file (the archive's directory is its end, and every member has a checksum), objects
        that would need pickle, or arrays whose role is not clear.
    InvalidInputError
        Options that do not fit the file.
    FileNotFoundError
        There is none.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savez(folder + "/a.npz", time=np.arange(100) / 50.0, tip=np.sin(np.arange(100.0)))
    ...     ar.read_npz(folder + "/a.npz", unit="g")
    Recording(1 channels, 2 s at 50 Hz, dofs=('tip',), no force)
    """
    file, given = existing_file(path), Reading.of(locals())
    with file.open("rb") as opened:
        alone = opened.read(len(_NPY)) == _NPY
    arrays = _array(file) if alone else read_archive(file)
    if TEXT in arrays:
        return own_signal(file, unpack(file, bytes(arrays[TEXT]).decode("utf-8", "replace"), arrays), given)
    return signal_of_arrays(file, arrays, given)


def write_npz(path: str | os.PathLike[str], signal: Signal) -> Path:
    """Write a signal as a NumPy archive, whole or not at all; every float comes back bit for bit.

    Parameters
    ----------
    path : path-like
        Replaced if it exists.
    signal : Recording or FrequencyResponse

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InvalidInputError
        The folder does not exist, or dofs that are neither integers nor strings.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_npz(folder + "/a.npz", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_npz(file).responses
    array([[1., 2., 4.]])
    """
    text, arrays = pack(signal_given(signal))
    return write_archive(path, text, arrays)


def write_archive(path: str | os.PathLike[str], text: str, arrays: dict[str, NDArray[Any]]) -> Path:
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
            unsuitable(
                file,
                "which holds objects, which only pickle reads",
                wanted,
                "A pickle can run any code. Save arrays of numbers alone.",
            )
        unsuitable(
            file, f"which cannot be read ({brief(exc)})", wanted, "It was cut or damaged: copy it again."
        )


def _array(file: Path) -> dict[str, NDArray[Any]]:
    """The array of a .npy file, under the name of the file."""
    try:
        return {file.stem: np.load(file, allow_pickle=False)}
    except Exception as exc:  # numpy parses the header as Python, with the errors of Python's own parser
        unsuitable(
            file,
            f"which cannot be read ({brief(exc)})",
            "a whole array of numbers (.npy)",
            "It was cut, or holds objects, which only pickle reads: save numbers alone.",
        )


def _holds_objects(file: Path) -> bool:
    """Whether an array of the archive is one of Python objects, by the headers of its members."""
    import zipfile

    with suppress(Exception), zipfile.ZipFile(file) as archive:
        for name in archive.namelist():
            with archive.open(name) as member:
                if b"'|O'" in member.read(_HEADER_BYTES):
                    return True
    return False


#: The first bytes of a .npy file.
_NPY = b"\x93NUMPY"
#: The dtype stands at the beginning of a .npy file.
_HEADER_BYTES = 512
