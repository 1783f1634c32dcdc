"""MATLAB files as common analysers export them: which variables are channels, their rate, names and units.

- Siemens Testlab: structs with ``x_values`` (``start_value``, ``increment``), ``y_values`` (``values``,
  ``quantity`` with label and factor) and ``function_record`` (``name``). Values are SI, the factor brings
  them to the label's unit.
- B&K (PULSE, BK Connect): ``File_Header``, ``Channel_1_Header`` (``SignalName``, ``Unit``),
  ``Channel_1_Data``.
- Dewesoft: ``Data1_NAME`` with ``Data1_time_NAME`` or ``Sample_rate``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import choice
from ._common import Signal, rate_of, refuse_real, unsuitable
from .channels import Dofs, in_si, kept, renamed, unit_or_warning
from .said import stated_number
from .stated import Stated, stated_recording
from .units import abscissa_factor, is_abscissa, is_frequency, named_unit

__all__ = ["signal_of_analyser"]

Arrays = Mapping[str, NDArray[Any]]
_DATA, _CHANNEL = re.compile(r"^Data\d+_(?!time_)(.+)$"), re.compile(r"^Channel_(\d+)_Data$")


def signal_of_analyser(
    file: Path,
    arrays: Arrays,
    texts: Mapping[str, str],
    *,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    kind: str | None = None,
    reference: Any = None,
) -> Signal | None:
    """The signal of a file whose variables are those of an analyser; None for any other."""
    testlab = [name[: -len(".y_values.values")] for name in arrays if name.endswith(".y_values.values")]
    testlab = [name for name in testlab if f"{name}.x_values.increment" in arrays]
    if testlab:
        return _of_testlab(file, arrays, texts, testlab, fs_hz, dofs, force, unit, kind, reference)
    channels = _of_pulse(arrays, texts) or _of_dewesoft(file, arrays)
    if not channels:
        return None
    return stated_recording(file, channels, fs_hz=fs_hz, dofs=dofs, force=force, unit=unit)


def _of_testlab(
    file: Path,
    arrays: Arrays,
    texts: Mapping[str, str],
    names: Iterable[str],
    fs_hz: float | None,
    dofs: Dofs,
    force: Any,
    unit: str | None,
    kind: str | None,
    reference: Any,
) -> Signal:
    channels: list[tuple[bool, Stated]] = []
    for name in names:
        step = _scalar(arrays, f"{name}.x_values.increment")
        first = _scalar(arrays, f"{name}.x_values.start_value") or 0.0
        values = _columns(
            arrays[f"{name}.y_values.values"], _scalar(arrays, f"{name}.x_values.number_of_values")
        )
        if step is None or not step > 0.0:
            unsuitable(
                file,
                f"whose {name}.x_values.increment is {step}",
                "a positive increment",
                "Export it again; steps that are not even cannot be exported so.",
            )
        axis = texts.get(f"{name}.x_values.quantity.label", "").strip()
        if axis and not is_abscissa(axis):
            unsuitable(
                file,
                f"whose {name} lies over {axis!r}",
                "functions over time or frequency, in s or Hz",
                "Export the time records or the FRFs.",
            )
        step, first = abscissa_factor(axis) * step, abscissa_factor(axis) * first
        over_freq = is_frequency(axis) or bool(np.iscomplexobj(values))
        for i, row in enumerate(values):
            label = _text(texts, f"{name}.y_values.quantity", "label", i)
            factor = _factor(arrays, f"{name}.y_values.quantity", i)
            title = texts.get(f"{name}.function_record.name[{i}]") or (
                texts.get(f"{name}.function_record.name", "") if len(values) == 1 else ""
            )
            title = title.strip() or (name if len(values) == 1 else f"{name}[{i}]")
            # In the label's unit, from which it becomes SI as any other.
            channels.append((over_freq, Stated(title, row * factor, label, step, "", first)))
    kinds = {over for over, _ in channels}
    if len(kinds) > 1:
        unsuitable(
            file,
            "with records over time and functions over frequency",
            "one of them",
            "Export them into files of their own, or name the responses=.",
        )
    stated = [channel for _, channel in channels]
    if kinds == {False}:
        return stated_recording(file, stated, fs_hz=fs_hz, dofs=dofs, force=force, unit=unit)
    return _response(file, stated, dofs, unit, kind or "frf", reference)


def _response(
    file: Path, channels: list[Stated], dofs: Dofs, unit: str | None, kind: str, reference: Any
) -> FrequencyResponse:
    choice("kind", kind, ("frf", "transmissibility"))
    axes = {(c.values.size, c.step_s, c.offset_s) for c in channels}
    if len(axes) > 1:
        unsuitable(
            file,
            f"with {len(axes)} different frequency axes",
            "one for all",
            "Export functions over the same lines.",
        )
    count, step, first = axes.pop()
    labels = renamed("dofs", [c.name for c in channels], dofs)
    rows = kept(labels)
    values = []
    for i in rows:
        own = channels[i]
        values.append(
            in_si(own.values, named_unit("unit", unit) if unit else unit_or_warning(file, own.unit))
        )
    refuse_real(file, values)
    return FrequencyResponse(
        first + (step or 0.0) * np.arange(count),
        np.stack(values),
        [labels[i] for i in rows],
        "frf" if kind == "frf" else "transmissibility",
        reference,
    )


def _of_pulse(arrays: Arrays, texts: Mapping[str, str]) -> list[Stated]:
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
        channels.append(Stated(title, np.float64(arrays[name]).ravel(), unit, step))
    return channels


def _of_dewesoft(file: Path, arrays: Arrays) -> list[Stated]:
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
        channels.append(Stated(title, np.float64(arrays[name]).ravel(), "", each, "", begun))
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


def _text(texts: Mapping[str, str], above: str, last: str, i: int) -> str:
    return (texts.get(f"{above}[{i}].{last}") or texts.get(f"{above}.{last}", "")).strip()


def _factor(arrays: Arrays, above: str, i: int) -> float:
    for place in (f"{above}[{i}]", above):
        if (factor := _scalar(arrays, f"{place}.unit_transformation.factor")) is not None and factor > 0.0:
            return factor
    return 1.0
