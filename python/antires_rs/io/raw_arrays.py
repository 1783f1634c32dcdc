"""Foreign files that are a bag of named arrays (MAT, HDF5, npz): which of them is what."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..support.checks import FloatArray, finite_scalar, shape_of
from ..support.messages import some, warn
from ._child import matches
from .channels import Channel, rate_of_step, recording_of, response_of, warn_other_rate
from .common import TO_ALIGN, Signal, rate_of, refuse_real, unsuitable, usual_rate
from .options import Reading
from .units import Unit, abscissa_factor, is_abscissa

# -- The frequencies of responses whose file does not hold them


def given_lines(path: Path, given: Reading, count: int) -> FloatArray:
    """The frequencies of ``count`` values by ``freq_hz``, or by ``df_hz`` from 0 Hz on."""
    if given.freq_hz is None:
        spacing = finite_scalar("df_hz", given.df_hz, low=0.0, low_open=True, unit="Hz")
        return spacing * np.arange(count, dtype=np.float64)
    if given.df_hz is not None:
        reject("df_hz", "it beside freq_hz", "one of them", "Leave out df_hz=, which the frequencies tell.")
    try:
        lines = np.asarray(given.freq_hz, dtype=np.float64)
        got = f"an array of shape {lines.shape}"
    except (TypeError, ValueError):
        lines, got = np.empty((0, 0)), type(given.freq_hz).__name__
    if lines.ndim != 1 or not np.isfinite(lines).all():
        reject("freq_hz", got, "finite frequencies in Hz, one for each line", "Pass a sequence of numbers.")
    if lines.size != count:
        found, wanted = f"with {count} values of each response", f"{lines.size}, one for each of freq_hz"
        unsuitable(path, found, wanted, "Give the frequencies of this file.")
    return lines


def lines_of_axis(values: Any) -> FloatArray | None:
    """A column as frequencies if it can be nothing else: real, not negative, ascending in even steps."""
    if values.size < 8 or np.any(np.imag(values)):
        return None
    lines = np.real(values).astype(np.float64)
    steps = np.diff(lines)
    even = steps.min() > 0.0 and float(np.ptp(steps)) <= 1e-3 * float(steps.mean())
    return lines if even and lines[0] >= 0.0 else None


# -- What a file says of its arrays beside them: attributes of HDF5, texts and numbers in fields of structs
#
# Names are those of arrays, ``run1/acc`` or ``test.acc``; an attribute is ``run1/acc@unit``, of a group
# ``run1@fs``, of the file ``@fs``. What is said of a group or struct holds for all within.

RATES = {"fs", "fs_hz", "rate", "samplerate", "sampling_rate", "sample_rate", "samplingfrequency"}
RATES |= {"sampling_frequency", "samplefrequency", "sample_rate_hz", "sampling_rate_hz", "rate_hz"}
STEPS = {"dt", "dt_s", "delta_t", "deltat", "wf_increment", "sample_interval", "sampling_interval"}
UNITS = {"unit", "units", "unit_string", "y_unit", "yunit", "y_unit_label", "einheit"}
_QUANTITY = re.compile(r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*(.*)\Z")
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(?:,\d{3})+\Z")


class Notes:
    """Numbers and texts by name, ``{"run1@fs": 512.0, "run1/acc@unit": "g"}``."""

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        self._values = dict(values or {})

    def unit(self, name: str) -> str:
        """Unit of an array; '' where nothing is said."""
        found = next((str(v) for _, v in self._of(name, UNITS) if isinstance(v, str)), "")
        known = [each for each in re.split(r"[,;]", found) if Unit.of(each).quantity]
        return known[0].strip() if len(known) == 1 else found  # "s, m/s2": of time and values

    def factor(self, path: Path, name: str, instead: str = "fs_hz", *, refuse: bool = True) -> float:
        """What makes Hz or s of a rate, step, time or frequency: its attribute ``unit``, or ``NAME_unit``."""
        beside = [f"{name}{mark}{word}" for mark in "@_" for word in ("unit", "units")]
        texts = {key.lower(): value.strip() for key, value in self._values.items() if isinstance(value, str)}
        text = next((texts[key.lower()] for key in beside if texts.get(key.lower())), "")
        words = (text, text.partition(" ")[0])  # "seconds since 1970-01-01"
        known = next((word for word in words if is_abscissa(word)), "")
        if refuse and not known and Unit.of(text) != Unit():
            got = f"whose {name} is in {text!r}"
            wanted = "a unit of time or frequency that is known (s, ms, us, Hz, kHz, rpm, rad/s)"
            unsuitable(path, got, wanted, f"Export it in s or Hz, or give {instead}=.")
        return abscissa_factor(known)

    def rate(self, path: Path, names: Iterable[str], *, refuse: bool) -> float | None:
        """Sampling rate of arrays, or the only one that is said; None without any. Several are refused."""
        found: dict[str, float] = {}
        for name in names:
            found |= dict(list(self._rates(path, self._of(name, RATES | STEPS), refuse))[:1])
        for wanted in (RATES, STEPS):  # of another struct, if there is but one
            said = ((key, value) for key, value in self._values.items() if _last(key) in wanted)
            if not found and len(alone := dict(self._rates(path, said, refuse))) == 1:
                found = alone
        if found and max(found.values()) > (1.0 + 1e-6) * min(found.values()):
            shown = ", ".join(f"{key} of {rate:g} Hz" for key, rate in found.items())
            remedy = "Name the responses= of one rate."
            unsuitable(path, f"with several sampling rates ({shown})", "one", remedy)
        return next(iter(found.values()), None)

    def _rates(
        self, path: Path, said: Iterable[tuple[str, Any]], refuse: bool
    ) -> Iterator[tuple[str, float]]:
        for key, value in said:
            number = stated_number(value)
            if number is not None and number > 0.0:
                number *= self.factor(path, key, refuse=refuse)
                yield key, rate_of_step(number) if _last(key) in STEPS else number

    def listed(self) -> str:
        """The numbers and texts that are said, for an error; '' without any."""
        shown = [f"{key} = {value!r}" for key, value in self._values.items() if str(value).strip()][:8]
        return "" if not shown else "; it says " + ", ".join(shown)[:300]

    def _of(self, name: str, wanted: set[str]) -> Iterable[tuple[str, Any]]:
        """What is said of an array, the nearest first: of itself, of its struct or group, of the file."""
        here = name.partition("[")[0] if name.endswith("]") and "/" not in name else name
        while True:
            for key, value in self._values.items():
                if _last(key) in wanted and _above(key) == here:
                    yield key, value
            if not here:
                return
            here = _above(here)


def _above(key: str) -> str:
    """What stands before the last separator."""
    return key[: max(0, *(key.rfind(sign) for sign in "./@"))]


def _last(key: str) -> str:
    """What stands behind it, in small letters."""
    return re.split(r"[./@]", key)[-1].lower()


def stated_number(value: Any) -> float | None:
    """A number in Hz or s, also as text, ``51.2 kHz``; None for others, and commas between thousands."""
    factor = 1.0
    if isinstance(value, str):
        match = _QUANTITY.match(value.strip())
        if match is None or _THOUSANDS.match(match[1]) or not (match[2] == "" or is_abscissa(match[2])):
            return None
        value, factor = match[1].replace(",", "."), abscissa_factor(match[2])
    try:
        number = factor * float(value)
    except (ValueError, TypeError):
        return None
    return number if math.isfinite(number) else None


#: Last parts of names, in small letters, that say what an array is when the user does not.
_TIME = {"time", "t", "time_s", "tijd", "zeit"}
_FREQ = {"f", "freq", "freq_hz", "frequency", "frequencies", "freqs"}
_FORCE = {"force", "hammer", "excitation", "input"}
_COHERENCE = {"coherence", "coh", "gamma2"}
ROLES = _TIME | RATES | STEPS | _FREQ | _FORCE | _COHERENCE  # names that tell a role, whatever is asked for
_ROW = re.compile(r"(.+)\[(\d{1,9})\]")


def array_of(name: str) -> str:
    """The array of a single row, ``acc`` of ``acc[3]``; any other name as it is."""
    match = _ROW.fullmatch(name)
    return name if match is None else match[1]


def signal_of_arrays(
    path: Path, arrays: Mapping[str, NDArray[Any]], given: Reading, texts: Mapping[str, Any] | None = None
) -> Signal:
    """A Recording, or a FrequencyResponse where arrays lie over a frequency; ``texts`` stand beside them."""
    return _Bag(path, arrays, given, texts).signal()


class _Bag:
    """The arrays of a file, channels first, with what its caller and its texts say of them."""

    def __init__(
        self, path: Path, arrays: Mapping[str, NDArray[Any]], given: Reading, texts: Mapping[str, Any] | None
    ) -> None:
        self.path, self.given, self.listed = path, given, _listed(arrays)
        numbers = {name: value for name, value in arrays.items() if value.dtype.kind in "iufc"}
        # A rate or a step in an array of its own is said as in an attribute.
        rates = {n: v.item().real for n, v in numbers.items() if v.size == 1 and _last(n) in RATES | STEPS}
        self.notes = Notes({**rates, **(texts or {})})
        flat = {n: v for n, v in numbers.items() if v.ndim <= 2 and v.size and n not in rates}
        self.numeric = {name: channels_first(value) for name, value in flat.items()}
        cubes = [name for name, value in numbers.items() if value.ndim > 2]
        if cubes and given.responses is None:
            said = f"has arrays of three and more axes, {', '.join(cubes)}, which are not read"
            warn("many_axes", f"path: {str(path)!r} {said}.")
        if not self.numeric:
            found = "without an array of numbers" + f" ({self.listed})" * bool(self.listed)
            unsuitable(path, found, "arrays of numbers")

    def signal(self) -> Signal:
        """What the arrays are."""
        given = self.given
        own = self._axis_within()
        if own is not None and given.responses is None and given.freq is None:
            return self._over_own_axis(*own)
        if given.freq_hz is not None or given.df_hz is not None:
            if given.freq is not None:
                reject("freq", repr(given.freq), "no name beside freq_hz or df_hz", "Leave one of them out.")
            for name, rows in self.numeric.items():
                if given.freq_hz is not None and rows.shape[1] != np.size(given.freq_hz) == rows.shape[0]:
                    self.numeric[name] = rows.T
            return self._response(None)
        freq = self._role("freq", given.freq, _FREQ)
        time = self._role("time", given.time, _TIME)
        if freq is not None and time is not None:
            remedy = "Name the responses=, and the time= or freq= that belongs to them."
            unsuitable(self.path, f"with both {time!r} and {freq!r} ({self.listed})", "one of them", remedy)
        if freq is None:
            return self._recording(time)
        return self._response(freq)

    def _axis_within(self) -> tuple[str, FloatArray] | None:
        """The only complex matrix, if its first row is a frequency; and that row."""
        found = [n for n, rows in self.numeric.items() if len(rows) > 1 and np.iscomplexobj(rows)]
        lines = lines_of_axis(self.numeric[found[0]][0]) if len(found) == 1 else None
        return None if lines is None else (found[0], lines)

    def _over_own_axis(self, name: str, lines: FloatArray) -> FrequencyResponse:
        """The other rows of a matrix over its first one."""
        given, rows = self.given, self.numeric[name][1:]
        if given.freq_hz is not None or given.df_hz is not None:
            stated = given_lines(self.path, given, lines.size)
            option = "df_hz" if given.freq_hz is None else "freq_hz"
            if not np.allclose(stated, lines, rtol=1e-6, atol=1e-6 * lines[-1]):
                got = f"it for {name!r}, whose first column holds frequencies, {lines[0]:g} to {lines[-1]:g}"
                reject(option, got, "the frequencies of the file", "Leave it out: the column is used.")
        unit = self.notes.unit(name)
        channels = [Channel(each, row, unit) for each, row, _ in _rows(name, rows)]
        return response_of(self.path, lines, channels, given)

    def _role(self, argument: str, given: str | None, names: set[str]) -> str | None:
        """The array the user names for a role, or the only one whose name says it."""
        if given is not None:
            if given not in self.numeric:
                wanted = f"a numeric array of {str(self.path)!r}: {_listed(self.numeric)}"
                reject(argument, repr(given), wanted, "Correct the name; those of the file are listed.")
            return given
        found = [n for n, rows in self.numeric.items() if _last(n) in names and len(rows) == 1 < rows.size]
        if len(found) > 1:
            got = f"with several candidates for {argument}=, {found}"
            unsuitable(self.path, got, f"one {argument}", f"Name it: {argument}={found[0]!r}.")
        return found[0] if found else None

    def _recording(self, time: str | None) -> Signal:
        """A record over the array ``time``, or at a rate that is stated."""
        numeric, force = self.numeric, self.given.force
        pushed = force if isinstance(force, str) and force in numeric else None
        if isinstance(force, str) and force != "auto" and pushed is None:
            wanted = f"'auto', None or an array of the file: {self.listed}"
            reject("force", repr(force), wanted, "Name an array of the file, or pass None for no force.")
        found = [] if pushed else [n for n in numeric if _last(n) in _FORCE and len(numeric[n]) == 1]
        pushed = found[0] if len(found) == 1 and force == "auto" else pushed
        channels, raw = self._responses(numeric, {*found, *filter(None, (time, pushed))})
        rate, size = self._rate(time, raw), channels[0].values.size
        if time is not None and self.given.fs_hz is None and size != numeric[time].shape[1]:
            n_instants = numeric[time].shape[1]
            got = f"with {size} samples of {channels[0].name!r} over {n_instants} instants of {time!r}"
            unsuitable(self.path, got, "as many", "Name the time= that belongs to them, or give fs_hz=.")
        if pushed is not None:
            unit = self.notes.unit(pushed) or "N"
            channels.append(Channel(pushed, numeric[pushed][0], unit, role="force"))
        given = replace(self.given, force=None if force is None else "auto")
        clock = None
        if time is not None and size == numeric[time].shape[1]:
            clock = self.notes.factor(self.path, time) * numeric[time][0].real
            clock = clock if np.all(np.diff(clock) > 0.0) else None
        return recording_of(self.path, channels, rate, given, clock)

    def _response(self, freq: str | None) -> FrequencyResponse:
        """FRFs or transmissibilities over the array ``freq``, or over a given axis."""
        path, numeric = self.path, self.numeric
        seen = [n for n in numeric if _last(n) in _COHERENCE]
        axes = {freq} if freq is not None else {n for n in numeric if _last(n) in _FREQ | _TIME}
        complex_ones = {name: values for name, values in numeric.items() if np.iscomplexobj(values)}
        among = complex_ones if self.given.responses is None and complex_ones else numeric
        channels, _ = self._responses(among, {*axes, *seen})
        refuse_real(path, [(c.name, c.values) for c in channels])
        if freq is None:
            lines = given_lines(path, self.given, channels[0].values.size)
        else:
            lines = self.notes.factor(path, freq, "freq_hz") * numeric[freq][0].real
        for c in channels:
            if c.values.size != lines.size:
                found = f"with {c.values.size} values of {c.name!r} over {lines.size} frequencies"
                unsuitable(path, found, "as many")
        coherence = np.vstack([numeric[n] for n in seen]).real if seen else None
        if coherence is not None and coherence.shape != (len(channels), lines.size):
            found, wanted = f"with coherences of shape {coherence.shape}", f"({len(channels)}, {lines.size})"
            unsuitable(path, found, wanted)
        return response_of(path, lines, channels, self.given, coherence)

    def _rate(self, time: str | None, names: list[str]) -> float:
        """The sampling rate of arrays of these names."""
        path, notes, given = self.path, self.notes, self.given.rate_hz
        stated = notes.rate(path, names, refuse=given is None)
        if given is not None:
            warn_other_rate(path, "states", stated, given)
            return given
        if time is not None:
            instants = notes.factor(path, time) * self.numeric[time][0].real
            rate = (
                usual_rate(path, instants) if self.given.align else rate_of(path, instants, remedy=TO_ALIGN)
            )
            if stated is not None and abs(stated - rate) > 1e-3 * rate:
                found = f"with a stated rate of {stated:g} Hz and a {time!r} of {rate:g} Hz, if it is in s"
                unsuitable(path, found, "one rate", "Give the true one by fs_hz=.")
            return rate
        if stated is None:
            over = "for responses over frequency name freq=, or give freq_hz= or df_hz="
            found = f"without a sampling rate or a time ({self.listed}{notes.listed()})"
            unsuitable(path, found, "one of them", f"Name time= or give fs_hz=; {over}.")
        return stated

    def _responses(
        self, among: Mapping[str, NDArray[Any]], taken: set[str]
    ) -> tuple[list[Channel], list[str]]:
        """Every response in the order asked for, rows of a matrix being ``name[0]``..., and its array."""
        responses = self.given.responses
        if responses is None:
            names = self._longest(among, taken)
            rows = [row for name in names for row in _rows(name, among[name])]
        else:
            asked: Sequence[Any] = [responses] if shape_of(responses) == () else list(responses)
            found = {row[0]: row for pattern in asked for row in self._asked(pattern, among, taken)}
            rows = list(found.values())
        if not rows:
            got = f"with {_listed(among)}, none of which is a response"
            unsuitable(self.path, got, "arrays of samples", "Name them: responses=[...].")
        shared = {name.rpartition(".")[0] for name, _, _ in rows}
        cut = len(shared.pop()) + 1 if len(shared) == 1 and "." in rows[0][0] else 0
        channels = [Channel(name[cut:], row, self.notes.unit(array)) for name, row, array in rows]
        return channels, [array for _, _, array in rows]

    def _longest(self, among: Mapping[str, NDArray[Any]], taken: set[str]) -> list[str]:
        """Arrays with the most samples, but those that have another role."""
        sizes = {name: rows.shape[1] for name, rows in among.items() if name not in taken}
        longest = max(sizes.values(), default=0)
        # Tables of settings are short; what is nearly as long is a channel that was cut.
        short = [f"{name} ({size})" for name, size in sizes.items() if longest > size > longest // 2]
        if short:
            said = f"has arrays shorter than the {longest} samples of the longest, {', '.join(short)}"
            warn("short_arrays", f"path: {str(self.path)!r} {said}, which are left out.")
        return [name for name, size in sizes.items() if size == longest > 1]

    def _asked(self, pattern: Any, among: Mapping[str, NDArray[Any]], taken: set[str]) -> list[_Row]:
        """The rows that a name or pattern means."""
        if isinstance(pattern, str):
            if pattern in among:
                return _rows(pattern, among[pattern])
            array = array_of(pattern)
            one = [row for row in _rows(array, among.get(array, ())) if row[0] == pattern]
            if one:
                return one
            hits = [n for n in among if matches(n, pattern) and n not in taken]
            if "*" in pattern and hits:
                return [row for name in hits for row in _rows(name, among[name])]
        wanted = f"arrays of {str(self.path)!r}: {_listed(among)}"
        reject("responses", repr(pattern), wanted, "Correct the pattern; the names of the file are listed.")


_Row = tuple[str, NDArray[Any], str]  # name, values, and the name of the array


def _rows(name: str, values: Any) -> list[_Row]:
    return [(f"{name}[{i}]" if len(values) > 1 else name, row, name) for i, row in enumerate(values)]


def _listed(arrays: Mapping[str, Any]) -> str:
    """Names and shapes, for a message."""
    return some((f"{name} {'x'.join(map(str, value.shape))}".rstrip() for name, value in arrays.items()), 20)


def channels_first(value: NDArray[Any]) -> NDArray[Any]:
    """The longer axis is time or frequency."""
    rows = np.atleast_2d(value.astype(np.complex128 if value.dtype.kind == "c" else np.float64))
    return rows.T if rows.shape[0] > rows.shape[1] else rows
