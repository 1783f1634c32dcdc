"""Foreign files that are a bag of named arrays (MAT, HDF5, npz): which of them is what."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import choice, finite_scalar, reject
from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import Signal, rate_of, refuse_real, simplest_rate, unsuitable
from .array_rows import chosen_rows, listed
from .axis import GivenAxis, given_axis
from .channels import Channel, Dofs, in_si, kept, recording_of, renamed, unit_or_warning
from .said import RATES, STEPS, Said
from .units import named_unit

__all__ = ["ROLES", "signal_of_arrays"]

#: Last parts of names, in small letters, that say what an array is when the user does not.
_TIME = {"time", "t", "time_s", "tijd", "zeit"}
_RATE, _STEP = set(RATES), set(STEPS)
_FREQ = {"f", "freq", "freq_hz", "frequency", "frequencies", "freqs"}
_FORCE = {"force", "hammer", "excitation", "input"}
_COHERENCE = {"coherence", "coh", "gamma2"}
#: Names that tell a role, whatever is asked for.
ROLES = frozenset(_TIME | _RATE | _STEP | _FREQ | _FORCE | _COHERENCE)

Kind = Literal["frf", "transmissibility"]


def signal_of_arrays(
    path: Path,
    arrays: Mapping[str, NDArray[Any]],
    *,
    responses: Any = None,
    time: str | None = None,
    freq: str | None = None,
    force: Any = "auto",
    fs_hz: float | None = None,
    dofs: Dofs = None,
    unit: str | None = None,
    kind: str = "frf",
    reference: Any = None,
    freq_hz: Any = None,
    df_hz: float | None = None,
    said: Said | None = None,
) -> Signal:
    """A Recording, or a FrequencyResponse where the arrays lie over a frequency.

    Roles that are not named are taken from the arrays' own names; what remains ambiguous is refused, with the
    list of what the file holds.
    """
    numeric = {name: _vectors(value) for name, value in arrays.items() if _usable(value)}
    cubes = [name for name, value in arrays.items() if value.dtype.kind in "iufc" and value.ndim > 2]
    if cubes and responses is None:
        warn(
            "many_axes",
            f"path: {str(path)!r} has arrays of three and more axes, {', '.join(cubes)}, which are not "
            "read. Slice them to (n_channels, n_samples) if they are responses.",
        )
    said = said or Said()
    if not numeric:
        unsuitable(
            path,
            f"with no numeric array ({listed(arrays)})",
            "arrays of numbers",
            "Export the signals as arrays of numbers, one row or column a channel.",
        )
    axis = given_axis(freq_hz, df_hz)
    if axis is not None:
        if freq is not None:
            reject("freq", repr(freq), "no name beside freq_hz or df_hz", "Leave one of them out.")
        if axis.size is not None:
            numeric = {name: _along(values, axis.size) for name, values in numeric.items()}
        return _response(path, numeric, axis, None, responses, dofs, unit, kind, reference, said)
    freq = _role(path, "freq", freq, numeric, _FREQ)
    time = _role(path, "time", time, numeric, _TIME)
    taken = {name for name in (freq, time) if name}
    if freq is not None and time is not None:
        unsuitable(
            path,
            f"with both {time!r} and {freq!r} ({listed(arrays)})",
            "one of them",
            Wording(
                "Name the {}, and the {} or {} that belongs to them.",
                Passed("responses"),
                Passed("time"),
                Passed("freq"),
            ),
        )
    if freq is not None:
        lines = GivenAxis(said.factor(path, freq, "freq_hz") * numeric[freq][0].real)
        return _response(path, numeric, lines, freq, responses, dofs, unit, kind, reference, said)
    taken |= {name for name in numeric if _last(name) in _RATE | _STEP and numeric[name].size == 1}
    pushed = force if isinstance(force, str) and force in numeric else None
    if isinstance(force, str) and force != "auto" and pushed is None:
        reject(
            "force",
            repr(force),
            f"'auto', None or an array of the file: {listed(arrays)}",
            "Name an array of the file, or pass None for no force.",
        )
    if pushed is None:
        found = [n for n in numeric if _last(n) in _FORCE and len(numeric[n]) == 1]
        pushed = found[0] if len(found) == 1 and force == "auto" else None
        taken |= set(found)
    rows = chosen_rows(path, numeric, responses, taken | ({pushed} if pushed else set()))
    rate = _rate(path, numeric, time, fs_hz, said, [raw for _, _, raw in rows])
    channels = [Channel(name, values, said.unit(raw)) for name, values, raw in rows]
    instants = None if time is None or fs_hz is not None else numeric[time].shape[1]
    for c in channels:
        if instants not in (None, c.values.size):
            unsuitable(
                path,
                f"with {c.values.size} samples of {c.name!r} over {instants} instants of {time!r}",
                "as many",
                Wording("Name the {} that belongs to them, or give {}.", Passed("time"), Passed("fs_hz")),
            )
    if pushed is not None:
        channels.append(Channel(pushed, numeric[pushed][0], said.unit(pushed) or "N", "force"))
    return recording_of(path, channels, rate, dofs=dofs, unit=unit, force=None if force is None else "auto")


def _response(
    path: Path,
    numeric: dict[str, NDArray[Any]],
    axis: GivenAxis,
    freq: str | None,
    responses: Any,
    dofs: Dofs,
    unit: str | None,
    kind: str,
    reference: Any,
    said: Said,
) -> FrequencyResponse:
    """FRFs or transmissibilities over the array ``freq``, or over a given axis."""
    choice("kind", kind, ("frf", "transmissibility"))
    seen = [n for n in numeric if _last(n) in _COHERENCE]
    axes = {freq} if freq is not None else {n for n in numeric if _last(n) in _FREQ | _TIME}
    complex_ones = {name: values for name, values in numeric.items() if np.iscomplexobj(values)}
    rows = chosen_rows(
        path, complex_ones if responses is None and complex_ones else numeric, responses, {*axes, *seen}
    )
    real = next((name for name, values, _ in rows if not np.iscomplexobj(values)), None)
    if real is not None:
        unsuitable(
            path,
            f"whose {real} is real",
            "complex FRFs or transmissibilities",
            "Magnitudes alone have lost the phase; combine magnitude and phase first.",
        )
    count = rows[0][1].size
    lines = axis.lines(path, count) if freq is None else axis.lines(path, axis.size or count)
    for name, values, _ in rows:
        if values.size != lines.size:
            unsuitable(
                path,
                f"with {values.size} values of {name!r} over {lines.size} frequencies",
                "as many",
                "Export values and frequencies of the same test.",
            )
    labels = renamed("dofs", [name for name, _, _ in rows], dofs)
    chosen = kept(labels)
    own = [named_unit("unit", unit) if unit else unit_or_warning(path, said.unit(rows[i][2])) for i in chosen]
    values = np.stack([in_si(rows[i][1], each) for i, each in zip(chosen, own, strict=True)])
    refuse_real(path, values)
    coherence = np.vstack([numeric[n] for n in seen]).real if seen else None
    if coherence is not None and coherence.shape == (len(rows), lines.size):
        coherence = coherence[chosen]
    elif coherence is not None:
        unsuitable(
            path,
            f"with coherences of shape {coherence.shape}",
            f"({len(rows)}, {lines.size})",
            "Export a coherence for each response, over the same frequencies.",
        )
    return FrequencyResponse(
        lines, values, [labels[i] for i in chosen], cast(Kind, kind), reference, coherence
    )


def _rate(
    path: Path,
    numeric: dict[str, NDArray[Any]],
    time: str | None,
    fs_hz: float | None,
    said: Said,
    names: list[str],
) -> float:
    stated = said.rate(path, names, refuse=fs_hz is None)
    single = {n: float(values[0, 0].real) for n, values in numeric.items() if values.size == 1}
    single = {
        n: x * said.factor(path, n, refuse=fs_hz is None)
        for n, x in single.items()
        if _last(n) in _RATE | _STEP
    }
    if fs_hz is not None:
        own = [x for n, x in single.items() if _last(n) in _RATE]
        stated = own[0] if stated is None and len(own) == 1 else stated
        rate = finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
        if stated is not None and abs(stated - rate) > 1e-3 * rate:
            warn(
                "other_rate",
                f"path: {str(path)!r} states {stated:.6g} Hz; read at {rate:.6g} Hz, as fs_hz= says. "
                "Leave fs_hz= out if the file is right.",
            )
        return rate
    rates = [n for n in single if _last(n) in _RATE]
    if time is None and not rates and stated is None:
        steps = [x for n, x in single.items() if _last(n) in _STEP]
        if len(steps) == 1 and 0.0 < steps[0] < float("inf"):
            return simplest_rate((1.0 - 1e-12) / steps[0], (1.0 + 1e-12) / steps[0])
    if time is None and not rates and stated is not None:
        return stated
    if time is not None:
        rate = rate_of(path, said.factor(path, time) * numeric[time][0].real)
        stated = single[rates[0]] if len(rates) == 1 else rate
        if abs(stated - rate) > 1e-3 * rate:
            unsuitable(
                path,
                f"with {rates[0]} of {stated:g} Hz and a {time!r} of {rate:g} Hz, if it is in s",
                "one rate",
                Wording("Give the true one by {}.", Passed("fs_hz")),
            )
        return rate
    if len(rates) != 1:
        unsuitable(
            path,
            f"without a sampling rate or a time ({listed(numeric)}{said.listed()})",
            "one of them",
            Wording(
                "Name {} or give {}; for responses over frequency name {}, or give {} or {}.",
                Passed("time"),
                Passed("fs_hz"),
                Passed("freq"),
                Passed("freq_hz"),
                Passed("df_hz"),
            ),
        )
    return finite_scalar(rates[0], single[rates[0]], low=0.0, low_open=True, unit="Hz")


def _role(
    path: Path, argument: str, given: str | None, numeric: dict[str, NDArray[Any]], names: set[str]
) -> str | None:
    """The array the user names for a role, or the only one whose name says it."""
    if given is not None:
        if given not in numeric:
            reject(
                argument,
                repr(given),
                f"a numeric array of {str(path)!r}: {listed(numeric)}",
                "Correct the name; those of the file are listed.",
            )
        return given
    found = [n for n in numeric if _last(n) in names and len(numeric[n]) == 1 and numeric[n].size > 1]
    if len(found) > 1:
        unsuitable(
            path,
            f"with several candidates for {argument}=, {found}",
            f"one {argument}",
            f"Name it: {argument}={found[0]!r}.",
        )
    return found[0] if found else None


def _usable(value: Any) -> bool:
    return bool(value.dtype.kind in "iufc" and value.ndim <= 2 and value.size)


def _vectors(value: NDArray[Any]) -> NDArray[Any]:
    """Channels first: the longer axis is time or frequency."""
    rows = np.atleast_2d(value.astype(np.complex128 if value.dtype.kind == "c" else np.float64))
    return rows.T if rows.shape[0] > rows.shape[1] else rows


def _along(rows: NDArray[Any], size: int) -> NDArray[Any]:
    """Rows of ``size`` values, where the shorter axis has that many."""
    return rows.T if rows.shape[1] != size and rows.shape[0] == size else rows


def _last(name: str) -> str:
    return name.rpartition(".")[2].rpartition("/")[2].lower()
