"""FRFs, transmissibilities and spectra of a universal file as a FrequencyResponse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import FloatArray
from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import refuse_real, simplest_rate, unsuitable
from .uff_names import Point, as_point, label_of
from .uff_sets import Function
from .units import Unit, named_unit, parse_unit

__all__ = ["half_digit", "response_of"]

Named = Callable[[Point], tuple[Any, float]]


def response_of(
    file: Path, functions: list[Function], kind: str, named: Named, reference: Any, unit: str | None
) -> FrequencyResponse:
    """The response of all points to one reference; its kind, coherence and averages."""
    names = ("auto spectrum", "cross spectrum") if kind == "spectra" else (kind,)
    wanted = [f for f in functions if f.what in names]
    if kind == "spectra" and all(f.what == "auto spectrum" for f in wanted):
        unsuitable(
            file,
            f"with {len(wanted)} auto spectra (power spectral densities), the first of "
            f"{label_of(wanted[0].response)}, and no cross spectrum",
            "time records, FRFs, or cross spectra with the auto spectrum of their reference",
            "Power spectra have lost the phase between channels, from which antiresonances are found: export "
            "one of these instead.",
        )
    point = _reference(file, [f for f in wanted if kind != "spectra" or f.response != f.reference], reference)
    if kind == "spectra":
        wanted, is_force = _over_auto(file, wanted, point, unit)
        kind = "frf" if is_force else "transmissibility"
    else:
        wanted = [f for f in wanted if f.reference == point]
    beside = _beside(file, functions, point, {f.response for f in wanted})
    lines = frequencies(wanted[0])
    for f in (*wanted, *beside):
        if f.x.size != lines.size or np.abs(frequencies(f) - lines).max() > 1e-6 * lines[-1]:
            unsuitable(
                file,
                f"with other frequencies at {label_of(f.response)} than at {label_of(wanted[0].response)}",
                "one frequency axis for all",
                "Export all functions over the same lines.",
            )
    for f in wanted:
        if not np.iscomplexobj(f.values):
            unsuitable(
                file,
                f"whose {f.what} of {label_of(f.response)} is real",
                "complex functions",
                "Magnitudes alone have lost the phase; export real and imaginary part.",
            )
    if unit is None:
        _check_kinds(file, [f for f in wanted if named(f.response)[0] is not None])
    rows = {f.response: _values(file, f, unit) for f in wanted}
    refuse_real(file, list(rows.values()))
    coherence = _coherence(file, rows, beside)
    if kind == "transmissibility" and point not in rows:
        rows[point] = np.ones(lines.size, dtype=np.complex128)
        if coherence is not None:
            coherence = {**coherence, point: np.ones(lines.size)}
    return _response(
        rows,
        lines,
        kind,
        point,
        coherence,
        named,
        next((f.own["n_averages"] for f in wanted if "n_averages" in f.own), None),
    )


def _response(
    rows: dict[Point, NDArray[Any]],
    lines: FloatArray,
    kind: str,
    point: Point,
    coherence: dict[Point, FloatArray] | None,
    named: Named,
    averages: float | None,
) -> FrequencyResponse:
    labelled = [(p, *named(p)) for p in rows]
    kept = [(p, dof, sign) for p, dof, sign in labelled if dof is not None]
    turn = 1.0
    if kind == "transmissibility":  # the reference itself may point the other way
        turn = next((sign for p, _, sign in kept if p == point), 1.0)
    made: Literal["frf", "transmissibility"] = "frf" if kind == "frf" else "transmissibility"
    return FrequencyResponse(
        lines,
        np.stack([rows[p] * (sign * turn) for p, _, sign in kept]),
        [dof for _, dof, _ in kept],
        made,
        named(point)[0] if kind == "transmissibility" else None,
        None if coherence is None else np.stack([coherence[p] for p, _, _ in kept]),
        averages,
    )


def frequencies(f: Function) -> FloatArray:
    """Frequencies without the rounding of first line and step to six digits, as far as it can be undone."""
    if not f.even or "start" in f.own or f.x.size < 2:
        return f.x
    half = half_digit(f.step, f.x_unit)
    step = 1.0 / simplest_rate(1.0 / (f.step + half), 1.0 / (f.step - half))  # 0.333333 is 1/3
    first = step * round(float(f.x[0]) / step)
    start = first if abs(first - f.x[0]) <= half_digit(float(f.x[0]), f.x_unit) else float(f.x[0])
    return np.asarray(start + step * np.arange(f.x.size), dtype=np.float64)


def half_digit(value: float, unit: float = 1.0) -> float:
    """Half a unit in the sixth digit, the rounding of the format's E13.5, and a little more.

    ``unit`` is that in which the file has the value.
    """
    if value == 0.0:
        return 0.0
    digit: float = 10.0 ** (float(np.floor(np.log10(abs(value / unit)))) - 5.0)
    return unit * 0.50001 * digit


def _reference(file: Path, functions: list[Function], given: Any) -> Point:
    points = list(dict.fromkeys(f.reference for f in functions))
    shown = ", ".join(map(label_of, points)) or "none"
    if given is not None:
        point = as_point("reference", given)
        if point not in points:
            unsuitable(
                file,
                f"with the references {shown}",
                Wording("{}", Passed("reference", label_of(point))),
                "Pass one of them.",
            )
        return point
    if len(points) != 1:
        unsuitable(file, f"with the references {shown}", "one", _remedy(functions))
    return points[0]


def _remedy(functions: list[Function]) -> str | Wording:
    """What to do about several references, or none."""
    if not functions:
        return "Export the functions with their references."
    responses = {f.response for f in functions}
    if len(responses) > 1:
        return Wording("Choose it by {}.", Passed("reference"))
    stayed = Passed("roving", label_of(responses.pop()))
    return Wording(
        "If the hammer roved and this sensor stayed, pass {}; else choose one by {}.",
        stayed,
        Passed("reference"),
    )


def _values(file: Path, f: Function, unit: str | None) -> NDArray[Any]:
    """Values in SI."""
    if unit is not None:
        factor = named_unit("unit", unit).factor
    else:
        above, below = parse_unit(f.unit), parse_unit(f.reference_unit)
        if above is None or below is None:
            odd = f.unit if above is None else f.reference_unit
            warn(
                "unknown_unit",
                f"path: {str(file)!r} has {label_of(f.response)} in {odd!r}, which is no unit known here; "
                "its values are as in the file. Name unit= to convert them.",
            )
        above, below = above or Unit(), below or Unit()
        # Some programs write the whole quotient into the numerator's label.
        factor = f.scale * above.factor / (1.0 if above.per else below.factor)
    values = f.values.astype(np.complex128)
    return values if factor == 1.0 else values * factor


def _check_kinds(file: Path, wanted: list[Function]) -> None:
    """Refuse receptances beside accelerances: their quotients are no transmissibilities."""
    kinds = {f.response: (parse_unit(f.unit) or Unit()).quantity for f in wanted}
    if len(set(kinds.values())) > 1:
        unsuitable(
            file,
            "with responses of several kinds, "
            + ", ".join(f"{label_of(point)} {kind or 'in no known unit'}" for point, kind in kinds.items()),
            "accelerations, velocities or displacements alone",
            Wording(
                "Leave out those of other kinds by {}, or name the {} of all.", Passed("dofs"), Passed("unit")
            ),
        )


def _beside(file: Path, functions: list[Function], point: Point, responses: set[Point]) -> list[Function]:
    """Coherences with the reference; a warning names those that may have been meant to be."""
    coherences = [f for f in functions if f.what == "coherence"]
    own = {f.reference for f in functions if f.what in ("frf", "transmissibility", "cross spectrum")}
    near = {(0, 0), (point[0], -point[1])} - own  # those with a reference of other functions belong to them
    turned = {(node, -way) for node, way in responses} - responses
    odd = [
        f
        for f in coherences
        if f.response in responses | turned
        and f.reference in near
        or f.response in turned
        and f.reference == point
    ]
    if odd:
        warn(
            "coherence_left_out",
            f"path: {str(file)!r} has coherences of other points than its functions, "
            f"{', '.join(f'{label_of(f.response)} / {label_of(f.reference)}' for f in odd)}; they are left "
            f"out. Wanted are the directions of the functions and the reference {label_of(point)}.",
        )
    return [f for f in coherences if f.reference == point]


def _coherence(file: Path, rows: dict[Point, Any], beside: list[Function]) -> dict[Point, FloatArray] | None:
    found = {f.response: f.values.real for f in beside if f.response in rows}
    lost = [p for p in rows if p not in found]
    if found and lost:
        warn(
            "coherence_left_out",
            f"path: {str(file)!r} has coherences of {len(found)} of {len(rows)} responses, not of "
            f"{', '.join(map(label_of, lost))}; they are left out.",
        )
    return found if found and not lost else None


def _over_auto(
    file: Path, spectra: list[Function], point: Point, unit: str | None
) -> tuple[list[Function], bool]:
    """Cross spectra over the auto spectrum of their reference."""
    autos = [
        f
        for f in spectra
        if f.response == point and f.reference in (point, (0, 0)) and f.what == "auto spectrum"
    ]
    crosses = [
        f for f in spectra if f.reference == point and f.response != point and f.what == "cross spectrum"
    ]
    if len(autos) != 1 or not crosses:
        unsuitable(
            file,
            f"with {len(crosses)} cross spectra and {len(autos)} auto spectra of the reference "
            f"{label_of(point)}",
            "cross spectra, and one auto spectrum of their reference",
            "Export the auto spectrum of the reference with its cross spectra.",
        )
    power = autos[0].values.real
    if power.min() <= 0.0:
        unsuitable(
            file,
            f"with an auto spectrum of {label_of(point)} that is not positive everywhere",
            "a positive one",
            "Check the reference channel: it was dead at some lines.",
        )
    single = autos[0].unit or crosses[0].reference_unit
    is_force = autos[0].role == "force" or (parse_unit(single) or Unit()).quantity == "force"
    if is_force and unit is None and any(f.scale != 1.0 for f in (*autos, *crosses)):
        unsuitable(
            file,
            "with spectra without units where dataset 164 names others than SI",
            "the unit of their quotient",
            "Pass unit=, such as 'mm/s2/N'.",
        )
    made = []
    for f in crosses:
        if f.values.shape != power.shape:
            unsuitable(
                file,
                f"with {f.values.size} lines at {label_of(f.response)} and {power.size} of the reference",
                "one frequency axis",
                "Export all spectra over the same lines.",
            )
        made.append(replace(f, values=f.values / power, reference_unit=single, scale=1.0))
    return made, is_force
