"""HDF5: a layout of our own, and any other by the names of its datasets."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.files import write_atomically
from ._common import Signal, existing_file, missing_package, signal_given, unsuitable
from ._packing import FORMAT, pack, unpack
from .arrays import signal_of_arrays
from .channels import Dofs
from .own import own_signal

__all__ = ["datasets_of", "read_hdf5", "write_hdf5"]

#: Cells in cells deeper than this are no record of a test.
DEEPEST = 8
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
) -> Signal:
    """Read an HDF5 file: one of ours as it was, any other by the names of its datasets.

    Parameters
    ----------
    path : path-like
    responses, time, freq, force, fs_hz, dofs, unit, kind, reference, freq_hz, df_hz
        As in :func:`read_npz`; datasets in groups are named ``group/name``.

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
    text, arrays = datasets_of(file, "read_hdf5")
    if text is not None:
        return own_signal(
            file,
            unpack(file, text, arrays),
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


def datasets_of(file: Path, reader: str) -> tuple[str | None, dict[str, NDArray[Any]]]:
    """Our JSON text, where there is one, and every dataset by its path."""
    try:
        import h5py
    except ImportError as exc:
        raise missing_package(reader, "h5py", "hdf5", exc) from exc
    arrays: dict[str, NDArray[Any]] = {}

    def keep(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            _keep(arrays, name, item)

    try:
        with h5py.File(file, "r") as opened:
            text = opened.attrs.get(TEXT)
            opened.visititems(keep)
    except (OSError, RuntimeError, ValueError, KeyError, TypeError, MemoryError) as exc:
        unsuitable(
            file,
            f"which cannot be read ({str(exc).splitlines()[0]})",
            "a whole HDF5 file",
            "It was cut or damaged: copy it again.",
        )
    return (None if text is None else str(text)), arrays


def _keep(arrays: dict[str, NDArray[Any]], name: str, item: Any, above: tuple[Any, ...] = ()) -> None:
    """A dataset by its name; what MATLAB's cells and struct arrays refer to, by names as in version 5."""
    made = _matlab_class(item)
    if "MATLAB_empty" in item.attrs or made == "char":
        return  # MATLAB stores texts as numbers, and the shape of what is empty
    struct = made != "cell" and item.dtype.kind == "O" and _matlab_class(item.parent) == "struct"
    if made != "cell" and not struct:
        arrays[name] = _values(item)
        return
    parent, _, field = name.rpartition("/")
    for i, reference in enumerate(item[()].ravel()):
        target = item.file[reference] if reference else item
        if target in (item, *above) or len(above) >= DEEPEST:
            continue  # nothing, or a damaged file that refers to itself
        each = f"{parent}[{i}]/{field}" if struct else f"{name}[{i}]"
        found = {each: target}
        if not hasattr(target, "dtype"):  # a group: a struct, in which others may lie
            found = {}
            target.visititems(lambda n, part, at=each, into=found: into.update({f"{at}/{n}": part}))
        for label, part in found.items():
            if hasattr(part, "dtype"):
                _keep(arrays, label, part, (*above, item))


def _matlab_class(item: Any) -> str:
    made = item.attrs.get("MATLAB_class", b"")
    return made.decode() if isinstance(made, bytes) else str(made)


def _values(item: Any) -> NDArray[Any]:
    """Values of a dataset; MATLAB's are stored transposed, and its complex numbers as pairs."""
    values = np.asarray(item[()])
    if values.dtype.names == ("real", "imag"):
        values = values["real"] + 1j * values["imag"]
    return values.T if "MATLAB_class" in item.attrs else values
