"""Signals as datasets 58 of a universal file, in text or binary form."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.spectra import std_of_coherence
from ..support.files import write_atomically
from ..support.messages import warn
from .channels import si_unit
from .common import PathLike, Signal, writer
from .own_format import check_dofs
from .uff import VERSION, Point, as_point, checksum_line, label_of, points_of

#: Function types of record 6, and the titles in ID line 1.
_TIME, _FRF, _TRANSMISSIBILITY, _COHERENCE = 1, 4, 5, 6
_TITLES = {_TIME: "Time Response", _FRF: "Frequency Response Function"}
_TITLES |= {_TRANSMISSIBILITY: "Transmissibility", _COHERENCE: "Coherence"}
#: Specific data types of records 8 to 10.
_DATA = {"": 0, "displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}
_OF_TIME, _OF_FREQUENCY = 17, 18


@dataclass
class _Set:
    """One dataset 58 to be written; ``even`` has the first abscissa and the step, unless ``x`` is uneven."""

    kind: int
    dof: Any
    response: Point
    values: NDArray[Any]
    types: tuple[int, int]
    units: tuple[str, str, str]
    abscissa: int
    even: tuple[float, float] | None
    line4: dict[str, Any]
    reference: Point = (0, 0)
    x: Any = None


@writer
def write_uff(
    path: PathLike,
    signal: Signal,
    *,
    binary: bool = True,
    unit: str | None = None,
    dofs: Mapping[Any, Any] | Callable[[Any], Any] | None = None,
    excitation: Any = None,
) -> Path:
    """Write dataset 58 for every channel, whole or not at all.

    Parameters
    ----------
    binary : bool
        Double precision in binary form (58b), bit for bit; otherwise text of 12 digits.
    unit : str, optional
        SI unit of the values: ``'m/s2'`` by default, for FRFs ``'m/s2/N'``.
    dofs : mapping or callable, optional
        ``{dof: (node, direction)}``, such as ``(12, '+Z')``. Default: read from labels such as ``'12+Z'``;
        other dofs become scalars of nodes of their own. The dofs themselves are kept in the ID lines.
    excitation : int or str or (int, str), optional
        Point of the force: one of the dofs, or a node and direction. Not known by default.

    Raises
    ------
    InvalidInputError
        The folder does not exist, a unit that is not SI, two dofs at one point, labels that do not fit.

    Warns
    -----
    AntiresWarning
        Standard deviations that do not follow from coherence and averages, which the format cannot keep.

    Notes
    -----
    Numbers of the header have six digits; rate and frequencies are therefore repeated in full in ID line 4,
    the dof in ID line 5 and the place among all sets in ID line 2, which :func:`read_uff` uses; ID line 3
    has checksums, by which it notices damaged numbers as long as nobody has edited the header.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> record = ar.Recording([[1.0, 2.0, 4.0]], 512.0, dofs=["12+Z"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_uff(folder + "/a.uff", record, binary=False)
    ...     print(file.read_text().splitlines()[-2].split())
    ['1.00000000000e+00', '2.00000000000e+00', '4.00000000000e+00']
    """
    check_dofs(signal)
    points = points_of(signal.dofs, dofs)
    force = None
    if excitation is not None:
        known = isinstance(excitation, int | str) and excitation in points
        force = points[excitation] if known else as_point("excitation", excitation)
    make = _recorded if isinstance(signal, Recording) else _responses
    sets = make(signal, points, force, unit)  # type: ignore[arg-type]
    blocks = [_block(each, f"{i} of {len(sets)}", binary) for i, each in enumerate(sets, start=1)]
    return write_atomically(path, b"".join(blocks))


def _recorded(rec: Recording, points: dict[Any, Point], force: Point | None, unit: str | None) -> list[_Set]:
    unit = "m/s2" if unit is None else unit
    types = (_DATA[si_unit("unit", unit).quantity], 0)
    even = (0.0, 1.0 / rec.fs_hz)
    line4 = {"start": 0.0, "step": 1.0 / rec.fs_hz, "rate_hz": rec.fs_hz}
    rows, of_time = zip(rec.dofs, rec.responses, strict=True), (_OF_TIME, even, line4)
    sets = [_Set(_TIME, dof, points[dof], row, types, ("s", unit, ""), *of_time) for dof, row in rows]
    if rec.force is not None:
        at = force or (max(node for node, _ in points.values()) + 1, 0)
        types = (_DATA["force"], 0)
        sets.append(_Set(_TIME, None, at, rec.force, types, ("s", "N", ""), _OF_TIME, even, line4))
    return sets


def _responses(
    resp: FrequencyResponse, points: dict[Any, Point], force: Point | None, unit: str | None
) -> list[_Set]:
    is_frf = resp.kind == "frf"
    unit = ("m/s2/N" if is_frf else "1") if unit is None else unit
    parsed = si_unit("unit", unit)
    above, _, below = unit.rpartition("/") if parsed.per else (unit, "", "")
    reference = (force or (0, 0)) if is_frf else points[resp.reference]
    start, step = float(resp.freq_hz[0]), float((resp.freq_hz[-1] - resp.freq_hz[0]) / (resp.n_freq - 1))
    gap = np.abs(start + step * np.arange(resp.n_freq) - resp.freq_hz).max()
    even = (start, step) if gap <= 1e-12 * resp.freq_hz[-1] else None
    derived = None  # what a reader makes of coherence and averages
    if resp.coherence is not None and resp.n_averages is not None and resp.n_averages > 1.0:
        derived = std_of_coherence(resp.values, resp.coherence, resp.n_averages)
    if resp.std is not None and (derived is None or not np.array_equal(resp.std, derived)):
        said = "its standard deviations are not those of coherence and averages"
        why = "and a universal file has no place for them; they are left out"
        warn("errors_not_written", f"signal: {said}, {why}.")
    line4: dict[str, Any] = {} if resp.n_averages is None else {"n_averages": resp.n_averages}
    line4 |= {} if even is None else {"start": start, "step": step}
    axis = (_OF_FREQUENCY, even, line4, reference, resp.freq_hz)
    types = (_DATA[parsed.quantity], _DATA[parsed.per])
    units = ("Hz", above if unit != "1" else "", below)
    kind = _FRF if is_frf else _TRANSMISSIBILITY
    rows = zip(resp.dofs, resp.values, strict=True)
    sets = [_Set(kind, dof, points[dof], row, types, units, *axis) for dof, row in rows]
    if resp.coherence is not None:
        rows = zip(resp.dofs, resp.coherence, strict=True)
        sets += [_Set(_COHERENCE, dof, points[dof], row, (0, 0), ("Hz", "", ""), *axis) for dof, row in rows]
    return sets


def _block(given: _Set, place: str, binary: bool) -> bytes:
    """One dataset, from marker to marker."""
    values, uneven = given.values, given.even is None
    is_complex = np.iscomplexobj(values)
    numbers = values.astype(np.complex128).view(np.float64) if is_complex else values.astype(np.float64)
    if uneven:  # abscissa before each value
        numbers = np.column_stack([given.x, numbers.reshape(values.size, -1)]).ravel()
    identity = f"{58:6d}"
    if binary:  # little endian, IEEE 754, 11 lines of header
        body = numbers.astype("<f8").tobytes()
        identity += f"b{1:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
        body += b"\n"  # the marker is on a line of its own
    else:
        body = _text(numbers, uneven, is_complex)
    lines = [f"{-1:6d}", identity, *_header(given, is_complex, place)]
    lines[4] = checksum_line(lines, body)
    head = "".join(f"{line:<80}\n" for line in lines)
    return head.encode("ascii") + body + f"{-1:6d}\n".encode()


def _header(given: _Set, is_complex: bool, place: str) -> list[str]:
    response, reference = given.response, given.reference
    start, step = given.even or (0.0, 0.0)
    over = f" / {label_of(reference)}" if reference != (0, 0) else ""
    line5 = json.dumps({} if given.dof is None else {"dof": given.dof})
    if len(line5) > 80:
        wanted = "labels of at most 70 letters in a universal file"
        reject("dofs", repr(given.dof), wanted, "Shorten the label.")
    points = [f" {'NONE':<10}{node:10d}{direction:4d}" for node, direction in (response, reference)]
    axes = zip((given.abscissa, *given.types, 0), (*given.units, ""), strict=True)
    return [
        f"{_TITLES[given.kind]} {label_of(response)}{over}",
        f"antires_rs uff {VERSION} set {place}",
        "NONE",
        json.dumps(given.line4),
        line5,
        f"{given.kind:5d}{0:10d}{0:5d}{0:10d}{points[0]}{points[1]}",
        f"{6 if is_complex else 4:10d}{given.values.size:10d}{int(given.even is not None):10d}"
        f"{start:13.5e}{step:13.5e}{0.0:13.5e}",
        *(f"{data:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit or 'NONE':<20}" for data, unit in axes),
    ]


def _text(numbers: NDArray[Any], uneven: bool, is_complex: bool) -> bytes:
    """4E20.12, or with abscissae 2(E13.5,E20.12) and E13.5,2E20.12."""
    if not uneven:
        forms = ["%20.11e"] * 4
    else:
        forms = ["%13.5e", "%20.11e", "%20.11e"] if is_complex else ["%13.5e", "%20.11e"] * 2
    rows = [numbers[i : i + len(forms)].tolist() for i in range(0, numbers.size, len(forms))]
    lines = ("".join(form % v for form, v in zip(forms, row, strict=False)) for row in rows)
    return "".join(f"{line}\n" for line in lines).encode()
