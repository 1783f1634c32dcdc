"""MATLAB files, read in a child process, as damaged ones can crash the interpreter; 7.3 is HDF5."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import NDArray

from ..support.files import write_atomically
from ..support.validation import finite_scalar
from ._common import Signal, existing_file, signal_given, unsuitable
from ._packing import pack, unpack
from .analysers import signal_of_analyser
from .arrays import signal_of_arrays
from .channels import Dofs
from .child import OPAQUE, Asked, Found, in_a_child
from .hdf5 import datasets_of
from .own import own_signal
from .said import Said

__all__ = ["mat_arrays", "read_mat", "write_mat"]

#: The variable that holds our JSON text.
TEXT = "antires_rs"
T = TypeVar("T")
WANTED = "a whole MAT file, version 5 or 7.3"


def read_mat(
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
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
) -> Signal:
    """Read a MATLAB file: one of ours as it was, any other by the names of its variables.

    Parameters
    ----------
    path : path-like
        Version 5 (7 and 6 of MATLAB's ``save``) or 7.3, which needs h5py.
    responses, time, freq, force, fs_hz, dofs, unit, kind, reference, freq_hz, df_hz
        As in :func:`read_npz`; fields of structs are named ``struct.field``, and
        ``struct[0].field`` where there are several. Sampling rate and units are taken from fields beside the
        array (``fs``, ``dt``, ``unit``), and the exports of Siemens Testlab, B&K and Dewesoft are
        known. See :func:`antires_rs.io.mat_arrays` for what a file holds.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording or FrequencyResponse

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file, a limit that was reached, or variables whose role is not clear.
    MissingDependencyError
        A 7.3 file without h5py.
    FileNotFoundError
        There is none.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_mat(folder + "/a.mat", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_mat(file)
    Recording(1 channels, 0.375 s at 8 Hz, dofs=('tip',), no force)
    """
    file = existing_file(path)
    asked = Asked.of(responses=responses, time=time, freq=freq, force=force)
    found = _variables(file, time_limit_s, memory_limit_gb, asked)
    arrays, text = found.arrays, found.texts.get(TEXT)
    if text is not None:
        # MATLAB has no vectors: a row stands for one.
        shapes = {n: a.ravel() if n in ("force", "freq_hz") else a for n, a in arrays.items()}
        return own_signal(
            file,
            unpack(file, text, shapes),
            responses=responses,
            time=time,
            freq=freq,
            force=force,
            fs_hz=fs_hz,
            dofs=dofs,
            unit=unit,
            kind=kind,
            reference=reference,
            freq_hz=None if freq_hz is None else "an axis",
            df_hz=df_hz,
        )
    axis = (responses, time, freq, freq_hz, df_hz)
    if all(given is None for given in axis):
        made = signal_of_analyser(
            file,
            arrays,
            found.texts,
            fs_hz=fs_hz,
            dofs=dofs,
            force=force,
            unit=unit,
            kind=kind,
            reference=reference,
        )
        if made is not None:
            return made
    _no_objects(file, found)
    return signal_of_arrays(
        file,
        arrays,
        responses=responses,
        time=time,
        freq=freq,
        force=force,
        fs_hz=fs_hz,
        dofs=dofs,
        unit=unit,
        kind="frf" if kind is None else kind,
        reference=reference,
        freq_hz=freq_hz,
        df_hz=df_hz,
        said=Said(found.texts),
    )


def mat_arrays(
    path: str | os.PathLike[str], *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0
) -> dict[str, NDArray[Any]]:
    """Every numeric array of a MATLAB file by its name, structs and cells taken apart.

    Parameters
    ----------
    path : path-like
    time_limit_s, memory_limit_gb : float
        As in :func:`~antires_rs.read_mat`.

    Returns
    -------
    dict of str to ndarray
        Two-dimensional, as in MATLAB.

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file, or a limit that was reached.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_mat(folder + "/a.mat", ar.Recording([[1.0, 2.0, 4.0]], 8.0))
    ...     ar.io.mat_arrays(file)
    {'responses': array([[1., 2., 4.]])}
    """
    return _variables(existing_file(path), time_limit_s, memory_limit_gb, Asked(every=True)).arrays


def write_mat(path: str | os.PathLike[str], signal: Signal) -> Path:
    """Write a signal as a MATLAB file (version 5), whole or not at all; floats come back bit for bit.

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

    Notes
    -----
    Variables: ``responses`` and ``force``, or ``freq_hz``, ``values``, ``coherence`` and ``std``; channels
    in rows.
    The first, ``antires_rs``, is a JSON text with dofs, rate and the shapes (``jsondecode`` reads it).

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ar.write_mat(folder + "/a.mat", ar.Recording([[1.0, 2.0, 4.0]], 8.0)).name
    'a.mat'
    """
    from scipy.io import savemat

    text, arrays = pack(signal_given(signal))
    buffer = io.BytesIO()
    savemat(buffer, {TEXT: text, **arrays}, format="5", oned_as="row")
    return write_atomically(path, buffer.getvalue())


def _no_objects(file: Path, found: Found) -> None:
    """Refuse a file of objects and no numbers."""
    objects = {name[len(OPAQUE) :]: made for name, made in found.texts.items() if name.startswith(OPAQUE)}
    if objects and not any(array.size > 1 for array in found.arrays.values()):
        name, made = next(iter(objects.items()))
        unsuitable(
            file,
            f"whose {name or 'variable'} is a {made or 'object'} of MATLAB",
            "arrays or structs of numbers",
            "Only MATLAB reads its objects. Of a timetable T save there: x = T.Variables; t = seconds("
            "T.Properties.RowTimes); save('file.mat', 'x', 't').",
        )


def _variables(file: Path, time_limit_s: float, memory_limit_gb: float, asked: Asked) -> Found:
    """The numeric variables, and our JSON text or the texts of the file."""
    with open(file, "rb") as opened:
        head = opened.read(1024)
    time_limit_s = finite_scalar("time_limit_s", time_limit_s, low=0.0, low_open=True, unit="s")
    memory_limit_gb = finite_scalar("memory_limit_gb", memory_limit_gb, low=0.0, low_open=True, unit="GB")
    # Version 7.3 is HDF5 after a block of 512 bytes.
    if b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520]):
        found = datasets_of(
            file, "read_mat of a 7.3 file", asked, time_limit_s=time_limit_s, memory_limit_gb=memory_limit_gb
        )
        return Found(_dotted(found.arrays), _dotted(found.texts))
    if head[:10] == b"MATLAB 7.3":
        unsuitable(file, "which announces version 7.3 and is cut in its head", WANTED, "Copy it again.")
    _check_length(file)
    return in_a_child(
        "mat5", file, Asked(every=True), WANTED, time_limit_s=time_limit_s, memory_limit_gb=memory_limit_gb
    )


def _dotted(named: dict[str, T]) -> dict[str, T]:
    return {name.replace("/", "."): value for name, value in named.items()}


def _check_length(file: Path) -> None:
    """Walk the top elements of a version 5 file: each states its length, and the last must end the file."""
    size, position, count = file.stat().st_size, 128, 0
    with open(file, "rb") as opened:
        head = opened.read(128)
        order = {b"IM": "little", b"MI": "big"}.get(head[126:128])
        if order is None:
            return  # version 4, or no MAT file: the child's reader judges
        while position < size:
            opened.seek(position)
            tag = opened.read(8)
            length = int.from_bytes(tag[4:8], order)  # type: ignore[arg-type]
            if len(tag) < 8 or position + 8 + length > size:
                unsuitable(
                    file,
                    f"cut in its variable {count + 1}: {size - position} of at least "
                    f"{8 + length if len(tag) == 8 else 8} bytes are there",
                    WANTED,
                    "Copy it again.",
                )
            position += 8 + length
            count += 1
    if not count:
        unsuitable(file, "a MAT file without any variable", WANTED, "It may be cut after its head.")
