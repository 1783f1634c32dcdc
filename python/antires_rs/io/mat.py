"""MATLAB files, read in a child process, as damaged ones can crash the interpreter; 7.3 is HDF5."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ..support.files import write_atomically
from ._child import Answer
from .channels import Channel, response_of, stated_recording
from .child_process import Found, Limits, in_a_child
from .common import Signal, existing_file, rate_of, unsuitable
from .hdf5 import datasets_of
from .own_format import TEXT, own_signal, pack
from .raw_arrays import signal_of_arrays, stated_number
from .reading import OfArrays, PathLike, Reading, opened, reader, writer
from .units import abscissa_factor, is_abscissa, is_frequency

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
    testlab = [name[: -len(".y_values.values")] for name in arrays if name.endswith(".y_values.values")]
    testlab = [name for name in testlab if f"{name}.x_values.increment" in arrays]
    if testlab:
        return _of_testlab(file, arrays, texts, testlab, given)
    channels = _of_pulse(arrays, texts) or _of_dewesoft(file, arrays)
    return stated_recording(file, channels, given) if channels else None


def _of_testlab(
    file: Path, arrays: Arrays, texts: Mapping[str, str], names: Iterable[str], given: Reading
) -> Signal:
    channels: list[Channel] = []
    kinds = set()
    for name in names:
        step = _scalar(arrays, f"{name}.x_values.increment")
        if step is None or not step > 0.0:
            remedy = "Export it again; steps that are not even cannot be exported so."
            unsuitable(file, f"whose {name}.x_values.increment is {step}", "a positive increment", remedy)
        axis = texts.get(f"{name}.x_values.quantity.label", "").strip()
        if axis and not is_abscissa(axis):
            got, wanted = f"whose {name} lies over {axis!r}", "functions over time or frequency, in s or Hz"
            unsuitable(file, got, wanted, "Export the time records or the FRFs.")
        factor = abscissa_factor(axis)
        first = factor * (_scalar(arrays, f"{name}.x_values.start_value") or 0.0)
        count = _scalar(arrays, f"{name}.x_values.number_of_values")
        values = _columns(arrays[f"{name}.y_values.values"], count)
        kinds.add(is_frequency(axis) or bool(np.iscomplexobj(values)))
        record, quantity = f"{name}.function_record.name", f"{name}.y_values.quantity"
        for i, row in enumerate(values):
            alone = len(values) == 1
            title = texts.get(f"{record}[{i}]") or (texts.get(record, "") if alone else "")
            title = title.strip() or (name if alone else f"{name}[{i}]")
            label = (texts.get(f"{quantity}[{i}].label") or texts.get(f"{quantity}.label", "")).strip()
            scales = (
                _scalar(arrays, f"{q}.unit_transformation.factor") for q in (f"{quantity}[{i}]", quantity)
            )
            scale = next((each for each in scales if each is not None and each > 0.0), 1.0)
            # In the label's unit, from which it becomes SI as any other.
            channels.append(Channel(title, row * scale, label, factor * step, "", first))
    if len(kinds) > 1:
        got = "with records over time and functions over frequency"
        unsuitable(file, got, "one of them", "Export them into files of their own, or name the responses=.")
    if kinds == {False}:
        return stated_recording(file, channels, given)
    axes = {(c.values.size, c.step_s, c.offset_s) for c in channels}
    if len(axes) > 1:
        found = f"with {len(axes)} different frequency axes"
        unsuitable(file, found, "one for all", "Export functions over the same lines.")
    size, spacing, start = axes.pop()
    return response_of(file, start + (spacing or 0.0) * np.arange(size), channels, given)


def _of_pulse(arrays: Arrays, texts: Mapping[str, str]) -> list[Channel]:
    found = sorted((int(match[1]), name) for name in arrays if (match := _CHANNEL.match(name)))
    rate = stated_number(texts.get("File_Header.SampleFrequency", ""))
    step = 1.0 / rate if rate is not None and rate > 0.0 else None
    if step is None and (fs := _scalar(arrays, "File_Header.SampleFrequency")):
        step = 1.0 / fs
    channels = []
    for number, name in found:
        head = f"Channel_{number}_Header"
        title = texts.get(f"{head}.SignalName", "").strip() or f"channel {number}"
        unit = texts.get(f"{head}.Unit", "").strip()
        channels.append(Channel(title, np.float64(arrays[name]).ravel(), unit, step))
    return channels


def _of_dewesoft(file: Path, arrays: Arrays) -> list[Channel]:
    found = [(name, match[1]) for name in arrays if (match := _DATA.match(name)) and arrays[name].size > 1]
    rates = [name for name in arrays if name.lower().endswith("sample_rate") and arrays[name].size == 1]
    step = 1.0 / float(arrays[rates[0]].ravel()[0].real) if rates else None
    channels = []
    if any(np.iscomplexobj(arrays[name]) for name, _ in found):
        return []  # spectra, no records
    for name, title in found:
        begun = 0.0
        own = arrays.get(name[: -len(title)] + "time_" + title)
        each = step
        if own is not None and own.size == arrays[name].size:
            each, begun = 1.0 / rate_of(file, np.float64(own).ravel()), float(own.ravel()[0])
        elif step is None:
            return []  # neither instants nor a rate: variables that happen to be called so
        channels.append(Channel(title, np.float64(arrays[name]).ravel(), "", each, "", begun))
    return channels


def _columns(values: NDArray[Any], count: float | None) -> NDArray[Any]:
    """Channels first; columns are channels, as far as the count of values does not say otherwise."""
    rows = np.atleast_2d(values.astype(np.complex128 if values.dtype.kind == "c" else np.float64))
    if count is not None and rows.shape[1] == int(count) != rows.shape[0]:
        return rows
    return rows.T if rows.shape[0] > rows.shape[1] else rows


def _scalar(arrays: Arrays, name: str) -> float | None:
    value = arrays.get(name)
    return None if value is None or value.size != 1 else float(value.ravel()[0].real)


_WANTED = "a whole MAT file, version 5 or 7.3"


@reader
def read_mat(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[OfArrays]
) -> Signal:
    """Read a MATLAB file: one of ours as it was, any other by the names of its variables.

    Fields of structs are named ``struct.field``, and ``struct[0].field`` where there are several. Sampling
    rate and units are taken from fields beside the array (``fs``, ``dt``, ``unit``), and the exports of
    Siemens Testlab, B&K and Dewesoft are known. See :func:`antires_rs.io.mat_arrays` for what a file holds.
    Options for a file of ours: as in :func:`read_npz`.

    Parameters
    ----------
    path : path-like
        Version 5 (7 and 6 of MATLAB's ``save``) or 7.3, which needs h5py.

    Raises
    ------
    UnsuitableDataError
        A damaged or cut file, a limit that was reached, or variables whose role is not clear.
    MissingDependencyError
        A 7.3 file without h5py.

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
    _no_objects(file, arrays, texts)
    return signal_of_arrays(file, arrays, given, texts)


def mat_arrays(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0
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
    limits = Limits(time_limit_s, memory_limit_gb)
    return _variables(existing_file(path), limits, every=True).arrays


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


def _no_objects(file: Path, arrays: Arrays, texts: Mapping[str, str]) -> None:
    """Refuse a file of objects and no numbers."""
    objects = {name[len(OPAQUE) :]: made for name, made in texts.items() if name.startswith(OPAQUE)}
    if objects and not any(array.size > 1 for array in arrays.values()):
        name, made = next(iter(objects.items()))
        unsuitable(
            file,
            f"whose {name or 'variable'} is a {made or 'object'} of MATLAB",
            "arrays or structs of numbers",
            "Only MATLAB reads its objects. Of a timetable T save there: x = T.Variables; t = seconds("
            "T.Properties.RowTimes); save('file.mat', 'x', 't').",
        )


def _variables(file: Path, limits: Limits, given: Reading | None = None, **more: Any) -> Found:
    """The numeric variables, and our JSON text or the texts of the file."""
    with open(file, "rb") as opened:
        head = opened.read(1024)
    # Version 7.3 is HDF5 after a block of 512 bytes.
    if b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520]):
        found = datasets_of(file, "read_mat of a 7.3 file", limits, given, **more)
        arrays = {name.replace("/", "."): array for name, array in found.arrays.items()}
        return Found(arrays, {name.replace("/", "."): text for name, text in found.texts.items()})
    if head[:10] == b"MATLAB 7.3":
        unsuitable(file, "which announces version 7.3 and is cut in its head", _WANTED, "Copy it again.")
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
                unsuitable(file, f"cut in its variable {count + 1}: {found}", _WANTED, "Copy it again.")
            position, count = position + length, count + 1
    if not count:
        unsuitable(file, "a MAT file without any variable", _WANTED, "It may be cut after its head.")


# -- In the child process


#: More parts than this, and the file is no record of a test.
MOST_ARRAYS, DEEPEST = 10_000, 8
#: Before the name of an object among the texts, whose class is the text.
OPAQUE = "object "


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
