"""HDF5 and MATLAB files, read in a child process, as damaged ones can crash the interpreter."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ..support.files import write_atomically
from ._child import Answer, Unfit, asked
from .channels import Channel, response_of, stated_recording
from .child_process import Found, Limits, in_a_child
from .common import Signal, rate_of, require, unsuitable
from .options import OfArrays, PathLike, Reading, opened, reader, writer
from .own_format import FORMAT, TEXT, own_signal, pack
from .raw_arrays import channels_first, signal_of_arrays, stated_number
from .units import abscissa_factor, is_abscissa, is_frequency

__all__ = ["read_hdf5", "read_mat", "write_hdf5", "write_mat"]


@reader(".h5 .hdf5 .hdf")
def read_hdf5(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[OfArrays]
) -> Signal:
    """Read an HDF5 file: one of ours as it was, any other by the names of its datasets.

    Datasets in groups are named ``group/name``. Where ``responses`` are named, nothing else is read but what
    the other roles need. Attributes of the dataset, its group or the file tell the sampling rate (``fs``,
    ``sampling_rate``, ``dt``, ...) and the ``unit``. Options for a file of ours: as in :func:`read_npz`.

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

    Notes
    -----
    The datasets ``responses`` and ``force``, or ``freq_hz``, ``values``, ``coherence`` and ``std``, at the
    root, channels first, in SI; the attribute ``antires_rs`` of the root is a JSON text with dofs, rate, kind
    and the shape of each dataset.

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


def datasets_of(file: Path, reader: str, limits: Limits, given: Reading) -> Found:
    """The datasets asked for by their paths, and our JSON text or the attributes."""
    require(reader, "h5py", "hdf5")
    return in_a_child(datasets, file, "a whole HDF5 file", limits, given)


# -- In the child process

MOST_ARRAYS, DEEPEST = 10_000, 8  # more parts than this, and the file is no record of a test
MOST_ATTRIBUTES, LONGEST_TEXT = 100, 1_000
COMPLEX = (("real", "imag"), ("r", "i"))  # complex numbers as pairs: MATLAB's, and those of h5py


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
        self.listed: list[Any] = []  # name, shape, and whether nothing is missing of what was asked for
        self.texts: dict[str, str] = {}  # attributes, by path@name, and MATLAB's texts

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
        if item.is_virtual or item.external:
            if asked((name, name.replace("/", ".")), name.rpartition("/")[2], self.request):
                raise Unfit(f"{name!r} lies in another file, which is not opened")
            return
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
        names, role = (name, name.replace("/", ".")), name.rpartition("/")[2]
        wanted = item.ndim <= 2 and asked(names, role, self.request)
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
    values = np.asarray(item[()])
    if values.dtype.names:
        real, imaginary = values.dtype.names
        values = values[real] + 1j * values[imaginary]
    return values.T if "MATLAB_class" in item.attrs else values


# -- MATLAB files as common analysers export them: which variables are channels, their rate, names and units
#
# - Siemens Testlab: structs with ``x_values`` (``start_value``, ``increment``), ``y_values`` (``values``,
#   ``quantity`` with label and factor) and ``function_record`` (``name``). Values are SI, the factor brings
#   them to the label's unit.
# - B&K (PULSE, BK Connect): ``File_Header``, ``Channel_1_Header`` (``SignalName``, ``Unit``),
#   ``Channel_1_Data``.
# - Dewesoft: ``Data1_NAME`` with ``Data1_time_NAME`` or ``Sample_rate``.

Arrays = Mapping[str, NDArray[Any]]
_DATA, _CHANNEL = re.compile(r"^Data\d+_(?!time_)(.+)$"), re.compile(r"^Channel_(\d+)_Data$")


def signal_of_analyser(file: Path, arrays: Arrays, texts: Mapping[str, str], given: Reading) -> Signal | None:
    """The signal of a file whose variables are those of an analyser; None for any other."""
    said = {**texts, **{n: float(a.ravel()[0].real) for n, a in arrays.items() if a.size == 1}}
    testlab = [name[: -len(".y_values.values")] for name in arrays if name.endswith(".y_values.values")]
    testlab = [name for name in testlab if f"{name}.x_values.increment" in arrays]
    if testlab:
        return _of_testlab(file, arrays, said, testlab, given)
    channels = _of_pulse(arrays, said) or _of_dewesoft(file, arrays, said)
    return stated_recording(file, channels, given) if channels else None


def _text(said: Mapping[str, Any], *names: str) -> str:
    """The first text of these names that is not empty."""
    return next((text for name in names if (text := str(said.get(name, "")).strip())), "")


def _positive(said: Mapping[str, Any], *names: str) -> float | None:
    """The first number of these names that is above zero."""
    numbers = (stated_number(said.get(name)) for name in names)
    return next((number for number in numbers if number is not None and number > 0.0), None)


def _of_testlab(
    file: Path, arrays: Arrays, said: Mapping[str, Any], names: Iterable[str], given: Reading
) -> Signal:
    channels: list[Channel] = []
    kinds = set()
    for name in names:
        step = _positive(said, f"{name}.x_values.increment")
        axis = _text(said, f"{name}.x_values.quantity.label")
        if step is None or (axis and not is_abscissa(axis)):
            got = f"whose {name} lies over {axis!r} in steps of {said.get(f'{name}.x_values.increment')}"
            unsuitable(file, got, "functions over time or frequency, in s or Hz, with a positive increment")
        factor = abscissa_factor(axis)
        first = factor * (stated_number(said.get(f"{name}.x_values.start_value")) or 0.0)
        values = channels_first(arrays[f"{name}.y_values.values"])
        if values.shape[0] == said.get(f"{name}.x_values.number_of_values") != values.shape[1]:
            values = values.T  # more channels than values
        kinds.add(is_frequency(axis) or bool(np.iscomplexobj(values)))
        record, quantity = f"{name}.function_record.name", f"{name}.y_values.quantity"
        for i, row in enumerate(values):
            alone, own = len(values) == 1, f"{quantity}[{i}]"
            title = _text(said, f"{record}[{i}]", *[record] * alone) or (name if alone else f"{name}[{i}]")
            scales = (f"{each}.unit_transformation.factor" for each in (own, quantity))
            label = _text(said, f"{own}.label", f"{quantity}.label")
            # In the label's unit, from which it becomes SI as any other.
            scaled = row * (_positive(said, *scales) or 1.0)
            channels.append(Channel(title, scaled, label, factor * step, "", first))
    axes = {(c.values.size, c.step_s, c.offset_s) for c in channels}
    if len(kinds) > 1 or (len(axes) > 1 and True in kinds):
        got = "with records over time and functions over frequency, or different frequencies"
        unsuitable(file, got, "one axis", "Name the responses= of one.")
    if kinds == {False}:
        return stated_recording(file, channels, given)
    size, spacing, start = axes.pop()
    return response_of(file, start + (spacing or 0.0) * np.arange(size), channels, given)


def _of_pulse(arrays: Arrays, said: Mapping[str, Any]) -> list[Channel]:
    rate = _positive(said, "File_Header.SampleFrequency")
    channels = []
    for number, name in sorted((int(match[1]), name) for name in arrays if (match := _CHANNEL.match(name))):
        head = f"Channel_{number}_Header"
        title, unit = _text(said, f"{head}.SignalName") or f"channel {number}", _text(said, f"{head}.Unit")
        values = np.float64(arrays[name]).ravel()
        channels.append(Channel(title, values, unit, None if rate is None else 1.0 / rate))
    return channels


def _of_dewesoft(file: Path, arrays: Arrays, said: Mapping[str, Any]) -> list[Channel]:
    found = [(name, match[1]) for name in arrays if (match := _DATA.match(name)) and arrays[name].size > 1]
    if any(np.iscomplexobj(arrays[name]) for name, _ in found):
        return []  # spectra, no records
    rate = _positive(said, *(name for name in arrays if name.lower().endswith("sample_rate")))
    channels = []
    for name, title in found:
        own = arrays.get(name[: -len(title)] + "time_" + title)
        begun, each = 0.0, rate
        if own is not None and own.size == arrays[name].size:
            each, begun = rate_of(file, np.float64(own).ravel()), float(own.ravel()[0])
        if each is None:
            return []  # neither instants nor a rate: variables that happen to be called so
        channels.append(Channel(title, np.float64(arrays[name]).ravel(), "", 1.0 / each, "", begun))
    return channels


_WANTED = "a whole MAT file, version 5 or 7.3"


@reader(".mat")
def read_mat(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[OfArrays]
) -> Signal:
    """Read a MATLAB file: one of ours as it was, any other by the names of its variables.

    Fields of structs are named ``struct.field``, and ``struct[0].field`` where there are several. Sampling
    rate and units are taken from fields beside the array (``fs``, ``dt``, ``unit``), and the exports of
    Siemens Testlab, B&K and Dewesoft are known. Options for a file of ours: as in :func:`read_npz`.

    Parameters
    ----------
    path : path-like
        Version 5 (7 and 6 of MATLAB's ``save``) or 7.3, which needs h5py.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_mat(folder + "/a.mat", ar.Recording([[1.0, 2.0, 4.0]], 8.0, dofs=["tip"]))
    ...     ar.read_mat(file)
    Recording(1 channels, 0.375 s at 8 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_mat, path, options)
    arrays, texts = _variables(file, Limits(time_limit_s, memory_limit_gb), given)
    if TEXT in texts:
        # MATLAB has no vectors: a row stands for one.
        shapes = {n: a.ravel() if n in ("force", "freq_hz") else a for n, a in arrays.items()}
        return own_signal(file, texts[TEXT], shapes, given)
    roles = (given.responses, given.time, given.freq, given.freq_hz, given.df_hz)
    made = signal_of_analyser(file, arrays, texts, given) if all(each is None for each in roles) else None
    if made is not None:
        return made
    objects = {name[len(OPAQUE) :]: made for name, made in texts.items() if name.startswith(OPAQUE)}
    if objects and not any(array.size > 1 for array in arrays.values()):
        name, kind = next(iter(objects.items()))
        found = f"whose {name or 'variable'} is a {kind or 'object'} of MATLAB"
        saved = "x = T.Variables; t = seconds(T.Properties.RowTimes); save('file.mat', 'x', 't')"
        unsuitable(file, found, "arrays or structs of numbers", f"Of a timetable T save there: {saved}.")
    return signal_of_arrays(file, arrays, given, texts)


@writer
def write_mat(path: PathLike, signal: Signal) -> Path:
    """Write a signal as a MATLAB file (version 5), whole or not at all; floats come back bit for bit.

    Notes
    -----
    Variables: ``responses`` and ``force``, or ``freq_hz``, ``values``, ``coherence`` and ``std``; channels in
    rows. The first, ``antires_rs``, is a JSON text with dofs, rate and the shapes (``jsondecode`` reads it).

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ar.write_mat(folder + "/a.mat", ar.Recording([[1.0, 2.0, 4.0]], 8.0)).name
    'a.mat'
    """
    from scipy.io import savemat

    text, arrays = pack(signal)
    buffer = io.BytesIO()
    savemat(buffer, {TEXT: text, **arrays}, format="5", oned_as="row")
    return write_atomically(path, buffer.getvalue())


def _variables(file: Path, limits: Limits, given: Reading) -> Found:
    """The numeric variables, and our JSON text or the texts of the file."""
    with open(file, "rb") as opened:
        head = opened.read(1024)
    if b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520]):  # Version 7.3 is HDF5 after a block of 512 bytes.
        found = datasets_of(file, "read_mat of a 7.3 file", limits, given)
        arrays = {name.replace("/", "."): array for name, array in found.arrays.items()}
        return Found(arrays, {name.replace("/", "."): text for name, text in found.texts.items()})
    if head[:10] == b"MATLAB 7.3":
        unsuitable(file, "which announces version 7.3 and is cut in its head", _WANTED)
    _check_length(file)
    return in_a_child(variables, file, _WANTED, limits)


def _check_length(file: Path) -> None:
    """The top elements of a version 5 file: each states its length, and the last must end the file."""
    size, position, count = file.stat().st_size, 128, 0
    with open(file, "rb") as stream:
        order: Any = {b"IM": "little", b"MI": "big"}.get(stream.read(128)[126:])
        if order is None:
            return  # version 4, or no MAT file: the child's reader judges
        while position < size:
            stream.seek(position)
            tag = stream.read(8)
            length = 8 + int.from_bytes(tag[4:], order) if len(tag) == 8 else 8
            if position + length > size:
                found = f"{size - position} of at least {length} bytes are there"
                unsuitable(file, f"cut in its variable {count + 1}: {found}", _WANTED)
            position, count = position + length, count + 1
    if not count:
        unsuitable(file, "a MAT file without any variable", _WANTED)


# -- In the child process

OPAQUE = "object "  # before the name of an object among the texts, whose class is the text


def variables(path: str, request: dict[str, Any]) -> Answer:
    """Variables of version 5 or 4, structs and cells taken apart."""
    from scipy.io import loadmat

    arrays: dict[str, Any] = {}
    texts: dict[str, str] = {}
    for name, value in loadmat(path, chars_as_strings=True).items():
        if not name.startswith("__"):
            flatten(name, value, arrays, texts)
    return arrays, texts, [[name, list(each.shape), True] for name, each in arrays.items()]


def flatten(name: str, value: Any, arrays: dict[str, Any], texts: dict[str, str], depth: int = 0) -> None:
    """Numeric arrays and texts of a variable by name: ``struct.field``, ``struct[1].field``, ``cell[2]``."""
    if depth > DEEPEST or len(arrays) >= MOST_ARRAYS or not isinstance(value, np.ndarray):
        return
    if value.dtype.names == ("s0", "s1", "s2", "arr"):  # an object, which only MATLAB reads
        texts[f"{OPAQUE}{name}"] = b"".join(map(bytes, value["s2"].ravel()[:1])).decode("latin-1")
        return
    if value.dtype.names:
        items = list(enumerate(value.ravel(order="F")))
        for i, item in items:
            for field in value.dtype.names:
                each = f"{name}.{field}" if len(items) == 1 else f"{name}[{i}].{field}"
                flatten(each, item[field], arrays, texts, depth + 1)
    elif value.dtype.kind == "O":
        for i, item in enumerate(value.ravel(order="F")):
            flatten(f"{name}[{i}]", item, arrays, texts, depth + 1)
    elif value.dtype.kind == "U":
        texts[name] = "\n".join(map(str, value.ravel()))
    elif value.dtype.kind in "biufc":
        arrays[name] = value
