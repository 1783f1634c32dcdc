"""HDF5: a layout of our own, and any other by the names of its datasets."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

from ..support.checks import finite_scalar
from ..support.files import write_atomically
from .channels import Dofs
from .child_process import Asked, Found, in_a_child
from .common import Signal, existing_file, missing_package, signal_given
from .own_format import FORMAT, own_signal, pack, unpack
from .raw_arrays import Said, signal_of_arrays

#: Attribute of the root that holds the JSON text.
TEXT = "antires_rs"


def read_hdf5(
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
    """Read an HDF5 file: one of ours as it was, any other by the names of its datasets.

    Parameters
    ----------
    path : path-like
    responses, time, freq, force, fs_hz, dofs, unit, kind, reference, freq_hz, df_hz
        As in :func:`read_npz`; datasets in groups are named ``group/name``. Where ``responses`` are named,
        nothing else is read but what the other roles need. Attributes of the dataset, its group or the file
        tell the sampling rate (``fs``, ``sampling_rate``, ``dt``, ...) and the ``unit``.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording or FrequencyResponse

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file (the format states its own length, and our datasets have checksums), or datasets
        whose role is not clear.
    MissingDependencyError
        h5py is not installed.
    FileNotFoundError
        There is none.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_hdf5(folder + "/a.h5", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_hdf5(file)
    Recording(1 channels, 0.375 s at 8 Hz, dofs=('tip',), no force)
    """
    file = existing_file(path)
    found = datasets_of(
        file,
        "read_hdf5",
        Asked.of(responses=responses, time=time, freq=freq, force=force),
        time_limit_s=finite_scalar("time_limit_s", time_limit_s, low=0.0, low_open=True, unit="s"),
        memory_limit_gb=finite_scalar("memory_limit_gb", memory_limit_gb, low=0.0, low_open=True, unit="GB"),
    )
    arrays = found.arrays
    if TEXT in found.texts:
        return own_signal(
            file,
            unpack(file, found.texts[TEXT], arrays),
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


def write_hdf5(path: str | os.PathLike[str], signal: Signal) -> Path:
    """Write a signal as HDF5, whole or not at all; every float comes back bit for bit.

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
    MissingDependencyError
        h5py is not installed.

    Notes
    -----
    Layout, version 1: the datasets ``responses`` and ``force``, or ``freq_hz``, ``values``, ``coherence`` and
    ``std``, at the root, channels first, in SI, with Fletcher checksums; the attribute ``antires_rs`` of the
    root is a JSON text with dofs, rate, kind and the shape of each dataset.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ar.write_hdf5(folder + "/a.h5", ar.Recording([[1.0, 2.0, 4.0]], 8.0)).name
    'a.h5'
    """
    try:
        import h5py
    except ImportError as exc:
        raise missing_package("write_hdf5", "h5py", "hdf5", exc) from exc
    text, arrays = pack(signal_given(signal))
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs[TEXT] = text
        file.attrs["format"] = FORMAT
        for name, array in arrays.items():
            file.create_dataset(name, data=array, chunks=True, fletcher32=True)
    return write_atomically(path, buffer.getvalue())


def datasets_of(
    file: Path, reader: str, asked: Asked, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0
) -> Found:
    """The datasets asked for by their paths, and our JSON text or the attributes."""
    from importlib.util import find_spec

    if find_spec("h5py") is None:
        raise missing_package(reader, "h5py", "hdf5", ImportError("h5py"))
    return in_a_child(
        "hdf5", file, asked, "a whole HDF5 file", time_limit_s=time_limit_s, memory_limit_gb=memory_limit_gb
    )
