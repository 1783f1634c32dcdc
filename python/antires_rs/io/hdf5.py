"""HDF5: a layout of our own, and any other by the names of its datasets."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Unpack

from ..support.files import write_atomically
from ._child import Answer, asked
from .child_process import Found, Limits, in_a_child
from .common import Signal, require
from .own_format import FORMAT, TEXT, own_signal, pack
from .raw_arrays import signal_of_arrays
from .reading import OfArrays, PathLike, Reading, opened, reader, writer


@reader
def read_hdf5(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[OfArrays]
) -> Signal:
    """Read an HDF5 file: one of ours as it was, any other by the names of its datasets.

    Datasets in groups are named ``group/name``. Where ``responses`` are named, nothing else is read but what
    the other roles need. Attributes of the dataset, its group or the file tell the sampling rate (``fs``,
    ``sampling_rate``, ``dt``, ...) and the ``unit``. Options for a file of ours: as in :func:`read_npz`.

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file (the format states its own length, and our datasets have checksums), or datasets
        whose role is not clear.
    MissingDependencyError
        h5py is not installed.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_hdf5(folder + "/a.h5", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_hdf5(file)
    Recording(1 channels, 0.375 s at 8 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_hdf5, path, options)
    arrays, texts = datasets_of(file, "read_hdf5", Limits(time_limit_s, memory_limit_gb), given)
    if TEXT in texts:
        return own_signal(file, texts[TEXT], arrays, given)
    return signal_of_arrays(file, arrays, given, texts)


@writer
def write_hdf5(path: PathLike, signal: Signal) -> Path:
    """Write a signal as HDF5, whole or not at all; every float comes back bit for bit.

    Raises
    ------
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
    require("write_hdf5", "h5py", "hdf5")
    import h5py

    text, arrays = pack(signal)
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs[TEXT] = text
        file.attrs["format"] = FORMAT
        for name, array in arrays.items():
            file.create_dataset(name, data=array, chunks=True, fletcher32=True)
    return write_atomically(path, buffer.getvalue())


def datasets_of(file: Path, reader: str, limits: Limits, given: Reading | None = None, **more: Any) -> Found:
    """The datasets asked for by their paths, and our JSON text or the attributes."""
    require(reader, "h5py", "hdf5")
    return in_a_child(datasets, file, "a whole HDF5 file", limits, given, **more)


# -- In the child process


#: More parts than this, and the file is no record of a test.
MOST_ARRAYS, DEEPEST = 10_000, 8
MOST_ATTRIBUTES, LONGEST_TEXT = 100, 1_000
#: Complex numbers as pairs: MATLAB's, and those of h5py.
COMPLEX = (("real", "imag"), ("r", "i"))


def datasets(path: str, request: dict[str, Any]) -> Answer:
    """Datasets by path; of those that are not asked for, or are too large, the shape alone."""
    import h5py

    with h5py.File(path, "r") as opened:
        text = opened.attrs.get("antires_rs")
        found = Datasets(request if text is None else {**request, "only": None})  # ours are read whole
        opened.visititems(found.visit)
        found.attributes("", opened)
    return found.arrays, found.texts if text is None else {"antires_rs": str(text)}, found.listed


class Datasets:
    """Those of an HDF5 file: arrays that are asked for, and the shapes of all."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.request, self.left = request, request["most_bytes"]
        self.arrays: dict[str, Any] = {}
        #: Name, shape, and whether nothing is missing of what was asked for.
        self.listed: list[Any] = []
        #: Attributes, by path@name, and MATLAB's texts.
        self.texts: dict[str, str] = {}

    def visit(self, name: str, item: Any) -> None:
        """Keep a data set; MATLAB's own places are reached by references."""
        self.attributes(name, item)
        if hasattr(item, "dtype") and not name.startswith("#"):
            self.keep(name, item)

    def attributes(self, name: str, item: Any) -> None:
        """Keep the attributes that are a number or a short text."""
        for key in list(item.attrs)[:MOST_ATTRIBUTES]:
            if key.startswith("MATLAB_") or len(self.texts) >= MOST_ARRAYS:
                continue
            try:
                value = item.attrs[key]
            except (OSError, TypeError, ValueError):  # of a type that h5py does not know
                continue
            if getattr(value, "size", 0) == 1:
                value = value.ravel()[0]
            if isinstance(value, bytes):
                value = value.decode("utf-8", "replace")
            if isinstance(value, str):
                self.texts[f"{name}@{key}"] = value[:LONGEST_TEXT]
            elif getattr(value, "size", 0) == 1 and value.dtype.kind in "iuf":
                self.texts[f"{name}@{key}"] = repr(float(value))

    def keep(self, name: str, item: Any, above: tuple[Any, ...] = ()) -> None:
        """Keep a data set, or what it refers to."""
        made = matlab_class(item)
        if "MATLAB_empty" in item.attrs or len(self.listed) >= MOST_ARRAYS:
            return  # the shape of what is empty is stored as numbers
        if made == "char":  # as are texts
            if item.dtype.kind == "u" and 0 < item.size <= LONGEST_TEXT and len(self.texts) < MOST_ARRAYS:
                self.texts[name] = "".join(map(chr, item[()].ravel(order="F").tolist()))
            return
        struct = made != "cell" and item.dtype.kind == "O" and matlab_class(item.parent) == "struct"
        if made == "cell" or struct:
            self.refer(name, item, above, struct)
        elif item.shape is not None and (item.dtype.kind in "biufc" or item.dtype.names in COMPLEX):
            self.take(name, item)

    def take(self, name: str, item: Any) -> None:
        """Read an array of numbers, if it is asked for and there is room for it."""
        size = 2 * item.size * item.dtype.itemsize
        wanted = self.request.get("every") or (
            item.ndim <= 2 and asked((name, name.replace("/", ".")), name.rpartition("/")[2], self.request)
        )
        read = wanted and size <= self.left
        shape = item.shape[::-1] if "MATLAB_class" in item.attrs else item.shape
        self.listed.append([name, list(shape), read or not wanted])
        if read:
            self.left -= size
            self.arrays[name] = values_of(item)

    def refer(self, name: str, item: Any, above: tuple[Any, ...], struct: bool) -> None:
        """What the cells of an array refer to, by names as in version 5."""
        parent, _, field = name.rpartition("/")
        for i, reference in enumerate(item[()].ravel() if item.size <= MOST_ARRAYS else ()):
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
                    self.keep(label, part, (*above, item))


def matlab_class(item: Any) -> str:
    """What MATLAB says that it is; '' for others."""
    made = item.attrs.get("MATLAB_class", b"")
    return made.decode() if isinstance(made, bytes) else str(made)


def values_of(item: Any) -> Any:
    """Values of a dataset; MATLAB's are stored transposed, and its complex numbers as pairs."""
    import numpy as np

    values = np.asarray(item[()])
    if values.dtype.names:
        real, imaginary = values.dtype.names
        values = values[real] + 1j * values[imaginary]
    return values.T if "MATLAB_class" in item.attrs else values
