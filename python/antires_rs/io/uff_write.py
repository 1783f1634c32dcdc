"""Signals as datasets 58 of a universal file, in text or binary form."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
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
from .common import Signal
from .own_format import check_dofs
from .uff import VERSION, Point, as_point, checksum_line, label_of, points_of
from .units import named_unit

_TIME, _FRF, _TRANSMISSIBILITY, _COHERENCE = 1, 4, 5, 6
#: Specific data types of records 8 to 10.
_DATA = {"": 0, "displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}
_OF_TIME, _OF_FREQUENCY = 17, 18


def write_uff(
    path: str | os.PathLike[str],
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
    path : path-like
        Replaced if it exists.
    signal : Recording or FrequencyResponse
    binary : bool
        Double precision in binary form (58b), bit for bit; otherwise text of 12 digits.
    unit : str, optional
        SI unit of the values: ``'m/s2'`` by default, for FRFs ``'m/s2/N'``.
    dofs : mapping or callable, optional
        ``{dof: (node, direction)}``, such as ``(12, '+Z')``. Default: read from labels such as ``'12+Z'``;
        other dofs become scalars of nodes of their own. The dofs themselves are kept in the ID lines.
    excitation : int or str or (int, str), optional
        Point of the force: one of the dofs, or a node and direction. Not known by default.

    Returns
    -------
    pathlib.Path

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
    force = _excitation(excitation, points)
    sets = (
        _recorded(signal, points, force, unit)
        if isinstance(signal, Recording)
        else _responses(signal, points, force, unit)
    )
    blocks = [
        _block(fields, values, number + 1, len(sets), binary) for number, (fields, values) in enumerate(sets)
    ]
    return write_atomically(path, b"".join(blocks))


def _recorded(
    rec: Recording, points: dict[Any, Point], force: Point | None, unit: str | None
) -> list[tuple[dict[str, Any], NDArray[Any]]]:
    unit = "m/s2" if unit is None else unit
    quantity = _quantity(unit)
    axis = {
        "abscissa": _OF_TIME,
        "units": ("s", unit, ""),
        "even": (0.0, 1.0 / rec.fs_hz),
        "line4": {"start": 0.0, "step": 1.0 / rec.fs_hz, "rate_hz": rec.fs_hz},
    }
    sets: list[tuple[dict[str, Any], NDArray[Any]]] = [
        (
            {
                "kind": _TIME,
                "response": points[dof],
                "types": (_DATA[quantity], 0),
                "line5": {"dof": dof},
                **axis,
            },
            row,
        )
        for dof, row in zip(rec.dofs, rec.responses, strict=True)
    ]
    if rec.force is not None:
        at = force or (max(node for node, _ in points.values()) + 1, 0)
        sets.append(
            (
                {
                    "kind": _TIME,
                    "response": at,
                    "types": (_DATA["force"], 0),
                    "line5": {},
                    **axis,
                    "units": ("s", "N", ""),
                },
                rec.force,
            )
        )
    return sets


def _responses(
    resp: FrequencyResponse, points: dict[Any, Point], force: Point | None, unit: str | None
) -> list[tuple[dict[str, Any], NDArray[Any]]]:
    is_frf = resp.kind == "frf"
    unit = ("m/s2/N" if is_frf else "1") if unit is None else unit
    above, below = (_quantity(unit), named_unit("unit", unit).per)
    reference = (force or (0, 0)) if is_frf else points[resp.reference]
    step = (resp.freq_hz[-1] - resp.freq_hz[0]) / (resp.n_freq - 1)
    ideal = resp.freq_hz[0] + step * np.arange(resp.n_freq)
    if resp.std is not None and not _follows(resp):
        warn(
            "errors_not_written",
            "signal: its standard deviations are not those of coherence and averages, and a universal file "
            "has no place for them; they are left out.",
        )
    even = bool(np.abs(ideal - resp.freq_hz).max() <= 1e-12 * resp.freq_hz[-1])
    line4: dict[str, Any] = {} if resp.n_averages is None else {"n_averages": resp.n_averages}
    if even:
        line4 |= {"start": float(resp.freq_hz[0]), "step": float(step)}
    axis = {
        "abscissa": _OF_FREQUENCY,
        "reference": reference,
        "line4": line4,
        "even": (float(resp.freq_hz[0]), float(step)) if even else None,
        "x": resp.freq_hz,
    }
    numerator, _, denominator = unit.rpartition("/") if below else (unit, "", "")
    types = (_DATA[above], _DATA[below] if below else 0)
    sets: list[tuple[dict[str, Any], NDArray[Any]]] = [
        (
            {
                "kind": _FRF if is_frf else _TRANSMISSIBILITY,
                "response": points[dof],
                "types": types,
                "units": ("Hz", numerator if unit != "1" else "", denominator),
                "line5": {"dof": dof},
                **axis,
            },
            row,
        )
        for dof, row in zip(resp.dofs, resp.values, strict=True)
    ]
    for dof, row in zip(resp.dofs, () if resp.coherence is None else resp.coherence, strict=False):
        sets.append(
            (
                {
                    "kind": _COHERENCE,
                    "response": points[dof],
                    "types": (0, 0),
                    "units": ("Hz", "", ""),
                    "line5": {"dof": dof},
                    **axis,
                },
                row,
            )
        )
    return sets


def _follows(resp: FrequencyResponse) -> bool:
    """Whether the deviations are those that a reader derives."""
    if resp.coherence is None or resp.n_averages is None or resp.n_averages <= 1.0 or resp.std is None:
        return False
    return bool(np.array_equal(resp.std, std_of_coherence(resp.values, resp.coherence, resp.n_averages)))


def _quantity(unit: str) -> str:
    parsed = named_unit("unit", unit)
    if parsed.factor != 1.0:
        wanted = "an SI unit, such as 'm/s2' or 'm/s2/N': signals are in SI"
        reject("unit", repr(unit), wanted, "Convert the values to SI first, or leave unit out.")
    return parsed.quantity


def _excitation(excitation: Any, points: dict[Any, Point]) -> Point | None:
    if excitation is None:
        return None
    if isinstance(excitation, int | str) and excitation in points:
        return points[excitation]
    return as_point("excitation", excitation)


def _block(fields: dict[str, Any], values: NDArray[Any], number: int, total: int, binary: bool) -> bytes:
    """One dataset, from marker to marker."""
    is_complex = np.iscomplexobj(values)
    numbers = values.astype(np.complex128).view(np.float64) if is_complex else values.astype(np.float64)
    if fields["even"] is None:  # abscissa before each value
        numbers = np.column_stack([fields["x"], numbers.reshape(values.size, -1)]).ravel()
    body = numbers.astype("<f8").tobytes() if binary else _text(numbers, fields["even"] is None, is_complex)
    identity = f"{58:6d}"
    if binary:  # little endian, IEEE 754, 11 lines of header
        identity += f"b{1:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    lines = [f"{-1:6d}", identity, *_header(fields, values.size, is_complex, number, total)]
    body += b"\n" if binary else b""  # the marker is on a line of its own: text ends with one already
    lines[4] = checksum_line(lines, body)
    head = "".join(f"{line:<80}\n" for line in lines)
    return head.encode("ascii") + body + f"{-1:6d}\n".encode()


def _header(fields: dict[str, Any], points: int, is_complex: bool, number: int, total: int) -> list[str]:
    response, reference = fields["response"], fields.get("reference", (0, 0))
    start, step = fields["even"] or (0.0, 0.0)
    title = {
        _TIME: "Time Response",
        _FRF: "Frequency Response Function",
        _TRANSMISSIBILITY: "Transmissibility",
        _COHERENCE: "Coherence",
    }[fields["kind"]]
    over = f" / {label_of(reference)}" if reference != (0, 0) else ""
    line5 = json.dumps(fields["line5"])
    if len(line5) > 80:
        got = repr(fields["line5"]["dof"])
        reject("dofs", got, "labels of at most 70 letters in a universal file", "Shorten the label.")
    units = [text or "NONE" for text in fields["units"]]
    types = fields["types"]
    return [
        f"{title} {label_of(response)}{over}",
        f"antires_rs uff {VERSION} set {number} of {total}",
        "NONE",
        json.dumps(fields["line4"]),
        line5,
        f"{fields['kind']:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{response[0]:10d}{response[1]:4d}"
        f" {'NONE':<10}{reference[0]:10d}{reference[1]:4d}",
        f"{6 if is_complex else 4:10d}{points:10d}{int(fields['even'] is not None):10d}"
        f"{start:13.5e}{step:13.5e}{0.0:13.5e}",
        _axis(fields["abscissa"], units[0]),
        _axis(types[0], units[1]),
        _axis(types[1], units[2]),
        _axis(0, "NONE"),
    ]


def _axis(data_type: int, unit: str) -> str:
    return f"{data_type:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit:<20}"


def _text(numbers: NDArray[Any], uneven: bool, is_complex: bool) -> bytes:
    """4E20.12, or with abscissae 2(E13.5,E20.12) and E13.5,2E20.12."""
    if not uneven:
        forms = ["%20.11e"] * 4
    else:
        forms = ["%13.5e", "%20.11e", "%20.11e"] if is_complex else ["%13.5e", "%20.11e"] * 2
    rows = [numbers[i : i + len(forms)].tolist() for i in range(0, numbers.size, len(forms))]
    lines = ("".join(form % v for form, v in zip(forms, row, strict=False)) for row in rows)
    return "".join(f"{line}\n" for line in lines).encode()
