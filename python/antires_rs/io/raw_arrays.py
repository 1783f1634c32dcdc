"""Foreign files that are a bag of named arrays (MAT, HDF5, npz): which of them is what."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..support.checks import FloatArray, finite_scalar, shape_of
from ..support.messages import Passed, Wording, warn
from .channels import Channel, matches, rate_of_step, recording_of, response_of, warn_other_rate
from .common import Signal, rate_of, unsuitable
from .reading import Reading
from .units import Unit, abscissa_factor, is_abscissa, parse_unit

# -- Which arrays of a file are responses: by name, by pattern, or single rows of a matrix


_ROW = re.compile(r"(.+)\[(\d{1,9})\]")


def chosen_rows(
    path: Path, numeric: Mapping[str, NDArray[Any]], responses: Any, taken: set[str]
) -> list[tuple[str, NDArray[Any], str]]:
    """(name, values, array) of every response, in the order asked for; rows of a matrix are ``name[0]``..."""
    if responses is None:
        names = _longest(path, numeric, taken)
        rows = [row for name in names for row in _rows(name, numeric[name])]
    else:
        asked: Sequence[Any] = [responses] if shape_of(responses) == () else list(responses)
        found = {row[0]: row for pattern in asked for row in _asked(path, pattern, numeric, taken)}
        rows = list(found.values())
    if not rows:
        got = f"with {listed(numeric)}, none of which is a response"
        unsuitable(path, got, "arrays of samples", "Name them: responses=[...].")
    shared = {n.rpartition(".")[0] for n, _, _ in rows}
    cut = len(shared.pop()) + 1 if len(shared) == 1 and "." in rows[0][0] else 0
    return [(name[cut:], row, raw) for name, row, raw in rows]


def array_of(name: str) -> str:
    """The array of a single row, ``acc`` of ``acc[3]``; any other name as it is."""
    match = _ROW.fullmatch(name)
    return name if match is None else match[1]


def _longest(path: Path, numeric: Mapping[str, NDArray[Any]], taken: set[str]) -> list[str]:
    """Arrays with the most samples, but those that have another role."""
    longest = max((v.shape[1] for n, v in numeric.items() if n not in taken), default=0)
    # Tables of settings are short; what is nearly as long is a channel that was cut.
    short = [
        f"{n} ({v.shape[1]})"
        for n, v in numeric.items()
        if n not in taken and longest > v.shape[1] > longest // 2
    ]
    if short:
        warn(
            "short_arrays",
            f"path: {str(path)!r} has arrays shorter than the {longest} samples of the longest, "
            f"{', '.join(short)}, which are left out. Name the responses= to choose.",
        )
    return [n for n, v in numeric.items() if n not in taken and v.shape[1] == longest and longest > 1]


def _asked(
    path: Path, pattern: Any, numeric: Mapping[str, NDArray[Any]], taken: set[str]
) -> list[tuple[str, NDArray[Any], str]]:
    """The rows that a name or pattern means."""
    if isinstance(pattern, str):
        if pattern in numeric:
            return _rows(pattern, numeric[pattern])
        one = [
            row for row in _rows(array_of(pattern), numeric.get(array_of(pattern), ())) if row[0] == pattern
        ]
        if one:
            return one
        hits = [n for n in numeric if matches(n, pattern) and n not in taken]
        if "*" in pattern and hits:
            return [row for name in hits for row in _rows(name, numeric[name])]
    wanted = f"arrays of {str(path)!r}: {listed(numeric)}"
    reject("responses", repr(pattern), wanted, "Correct the pattern; the names of the file are listed.")


def _rows(name: str, values: Any) -> list[tuple[str, NDArray[Any], str]]:
    several = len(values) > 1
    return [(f"{name}[{i}]" if several else name, row, name) for i, row in enumerate(values)]


def listed(arrays: Mapping[str, Any]) -> str:
    """Names and shapes, for a message."""
    shown = [f"{name} {'x'.join(map(str, value.shape))}" for name, value in list(arrays.items())[:20]]
    return ", ".join(shown) + (f" and {len(arrays) - 20} more" if len(arrays) > 20 else "")


# -- The frequencies of responses whose file does not hold them


class GivenAxis:
    """Frequencies that the caller gives: ``size`` of them, or (None) their spacing from 0 Hz on."""

    def __init__(self, freq_hz: Any = None, df_hz: Any = None) -> None:
        self._df_hz = (
            0.0 if df_hz is None else finite_scalar("df_hz", df_hz, low=0.0, low_open=True, unit="Hz")
        )
        self._freq_hz = None if freq_hz is None else _axis(freq_hz)
        self.size = None if self._freq_hz is None else self._freq_hz.size

    @classmethod
    def of(cls, given: Reading) -> GivenAxis | None:
        """The axis by ``freq_hz`` or ``df_hz``; None where neither is given."""
        if given.freq_hz is None and given.df_hz is None:
            return None
        if given.freq_hz is not None and given.df_hz is not None:
            remedy = Wording("Leave out {}, which the frequencies tell.", Passed("df_hz"))
            reject("df_hz", "it beside freq_hz", "one of them", remedy)
        return cls(given.freq_hz, given.df_hz)

    def lines(self, path: Path, count: int) -> FloatArray:
        """The frequencies of ``count`` values."""
        if self._freq_hz is None:
            return self._df_hz * np.arange(count, dtype=np.float64)
        if self._freq_hz.size != count:
            found, remedy = f"with {count} values of each response", "Give the frequencies of this file."
            unsuitable(path, found, f"{self._freq_hz.size}, one for each of freq_hz", remedy)
        return self._freq_hz


def _axis(freq_hz: Any) -> FloatArray:
    try:
        lines = np.asarray(freq_hz, dtype=np.float64)
        got = f"an array of shape {lines.shape}"
    except (TypeError, ValueError):
        lines, got = np.empty((0, 0)), type(freq_hz).__name__
    if lines.ndim != 1 or not np.isfinite(lines).all():
        reject("freq_hz", got, "finite frequencies in Hz, one for each line", "Pass a sequence of numbers.")
    return lines


# -- What a file says of its arrays beside them: attributes of HDF5, texts and numbers in fields of structs
#
# Names are those of arrays, ``run1/acc`` or ``test.acc``; an attribute is ``run1/acc@unit``, of a group
# ``run1@fs``, of the file ``@fs``. What is said of a group or struct holds for all within.


RATES = frozenset(
    {
        *("fs", "fs_hz", "rate", "samplerate", "sampling_rate", "sample_rate", "samplingfrequency"),
        *("sampling_frequency", "samplefrequency", "sample_rate_hz", "sampling_rate_hz", "rate_hz"),
    }
)
STEPS = frozenset({"dt", "dt_s", "delta_t", "deltat", "wf_increment", "sample_interval", "sampling_interval"})
UNITS = frozenset({"unit", "units", "unit_string", "y_unit", "yunit", "y_unit_label", "einheit"})
_PART = re.compile(r"[./@]")
_QUANTITY = re.compile(r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*(.*)\Z")
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(?:,\d{3})+\Z")


class Said:
    """Numbers and texts by name.

    >>> said = Said({"run1@fs": 512.0, "run1/acc@unit": "g"})
    >>> said.rate(Path("a.h5"), ["run1/acc"]), said.unit("run1/acc")
    (512.0, 'g')
    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        self._values = dict(values or {})

    def unit(self, name: str) -> str:
        """Unit of an array; '' where nothing is said."""
        found = next((str(v) for _, v in self._of(name, UNITS) if isinstance(v, str)), "")
        known = [each for each in re.split(r"[,;]", found) if (unit := parse_unit(each)) and unit.quantity]
        return known[0].strip() if len(known) == 1 else found  # "s, m/s2": of time and values

    def factor(self, path: Path, name: str, instead: str = "fs_hz", *, refuse: bool = True) -> float:
        """What makes Hz or s of a rate, step, time or frequency: its attribute ``unit``, or ``NAME_unit``."""
        beside = [f"{name}{mark}{word}" for mark in "@_" for word in ("unit", "units")]
        found = {
            key.lower(): str(value).strip() for key, value in self._values.items() if isinstance(value, str)
        }
        text = next((found[key.lower()] for key in beside if found.get(key.lower())), "")
        words = (text, text.partition(" ")[0])  # "seconds since 1970-01-01"
        known = next((word for word in words if is_abscissa(word)), "")
        if refuse and not known and parse_unit(text) != Unit():
            got = f"whose {name} is in {text!r}"
            wanted = "a unit of time or frequency that is known (s, ms, us, Hz, kHz, rpm, rad/s)"
            unsuitable(path, got, wanted, Wording("Export it in s or Hz, or give {}.", Passed(instead)))
        return abscissa_factor(known)

    def rate(self, path: Path, names: Iterable[str], *, refuse: bool = True) -> float | None:
        """Sampling rate of arrays; None where nothing is said. Several rates are refused."""
        found: dict[str, float] = {}
        for name in names:
            for key, value in self._of(name, RATES | STEPS):
                number = stated_number(value)
                if number is not None and number > 0.0:
                    number *= self.factor(path, key, refuse=refuse)
                    step = _PART.split(key)[-1].lower() in STEPS
                    found[key] = rate_of_step(number) if step else number
                    break
        if found and max(found.values()) > (1.0 + 1e-6) * min(found.values()):
            shown = ", ".join(f"{key} of {rate:g} Hz" for key, rate in found.items())
            unsuitable(
                path, f"with several sampling rates ({shown})", "one", "Name the responses= of one rate."
            )
        return next(iter(found.values()), None)

    def listed(self) -> str:
        """The numbers and texts that are said, for an error; '' without any."""
        shown = [f"{key} = {value!r}" for key, value in self._values.items() if str(value).strip()][:8]
        return "" if not shown else "; it says " + ", ".join(shown)[:300]

    def _of(self, name: str, wanted: frozenset[str]) -> Iterable[tuple[str, Any]]:
        """What is said of an array, the nearest first: of itself, of its struct or group, of the file."""
        here = name.partition("[")[0] if name.endswith("]") and "/" not in name else name
        while True:
            for key, value in self._values.items():
                above, _, last = _split(key)
                if last.lower() in wanted and above == here:
                    yield key, value
            if not here:
                return
            here = _split(here)[0]


def _split(key: str) -> tuple[str, str, str]:
    """The part before the last separator, the separator, and the last part."""
    places = [match.start() for match in _PART.finditer(key)]
    if not places:
        return "", "", key
    return key[: places[-1]], key[places[-1]], key[places[-1] + 1 :]


def stated_number(value: Any) -> float | None:
    """A number in Hz or s, also as text with a decimal comma or a unit behind it, ``51.2 kHz``.

    None where it is no number, in a unit that is not known, or may have a comma between thousands.
    """
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
#: Names that tell a role, whatever is asked for.
ROLES = frozenset(_TIME | RATES | STEPS | _FREQ | _FORCE | _COHERENCE)

Arrays = dict[str, NDArray[Any]]


def signal_of_arrays(
    path: Path, arrays: Mapping[str, NDArray[Any]], given: Reading, texts: Mapping[str, Any] | None = None
) -> Signal:
    """A Recording, or a FrequencyResponse where the arrays lie over a frequency.

    Roles that are not named are taken from the arrays' own names; what remains ambiguous is refused, with the
    list of what the file holds. ``texts`` are attributes and fields beside the arrays.
    """
    numeric = {
        name: _vectors(value)
        for name, value in arrays.items()
        if value.dtype.kind in "iufc" and value.ndim <= 2 and value.size
    }
    cubes = [name for name, value in arrays.items() if value.dtype.kind in "iufc" and value.ndim > 2]
    if cubes and given.responses is None:
        warn(
            "many_axes",
            f"path: {str(path)!r} has arrays of three and more axes, {', '.join(cubes)}, which are not "
            "read. Slice them to (n_channels, n_samples) if they are responses.",
        )
    said = Said(texts)
    if not numeric:
        remedy = "Export the signals as arrays of numbers, one row or column a channel."
        unsuitable(path, f"with no numeric array ({listed(arrays)})", "arrays of numbers", remedy)
    axis = GivenAxis.of(given)
    if axis is not None:
        if given.freq is not None:
            reject("freq", repr(given.freq), "no name beside freq_hz or df_hz", "Leave one of them out.")
        if axis.size is not None:
            numeric = {name: _along(values, axis.size) for name, values in numeric.items()}
        return _response(path, numeric, axis, None, given, said)
    freq = _role(path, "freq", given.freq, numeric, _FREQ)
    time = _role(path, "time", given.time, numeric, _TIME)
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
        return _response(path, numeric, lines, freq, given, said)
    return _recording(path, arrays, numeric, time, given, said)


def _recording(
    path: Path, arrays: Mapping[str, Any], numeric: Arrays, time: str | None, given: Reading, said: Said
) -> Signal:
    """A record over the array ``time``, or at a rate that is stated."""
    taken = {time} if time else set()
    taken |= {name for name in numeric if _last(name) in RATES | STEPS and numeric[name].size == 1}
    pushed = given.force if isinstance(given.force, str) and given.force in numeric else None
    if isinstance(given.force, str) and given.force != "auto" and pushed is None:
        wanted = f"'auto', None or an array of the file: {listed(arrays)}"
        reject("force", repr(given.force), wanted, "Name an array of the file, or pass None for no force.")
    if pushed is None:
        found = [n for n in numeric if _last(n) in _FORCE and len(numeric[n]) == 1]
        pushed = found[0] if len(found) == 1 and given.force == "auto" else None
        taken |= set(found)
    rows = chosen_rows(path, numeric, given.responses, taken | ({pushed} if pushed else set()))
    rate = _rate(path, numeric, time, given, said, [raw for _, _, raw in rows])
    channels = [Channel(name, values, said.unit(raw)) for name, values, raw in rows]
    instants = None if time is None or given.fs_hz is not None else numeric[time].shape[1]
    for c in channels:
        if instants not in (None, c.values.size):
            got = f"with {c.values.size} samples of {c.name!r} over {instants} instants of {time!r}"
            remedy = Wording("Name the {} that belongs to them, or give {}.", Passed("time"), Passed("fs_hz"))
            unsuitable(path, got, "as many", remedy)
    if pushed is not None:
        channels.append(Channel(pushed, numeric[pushed][0], said.unit(pushed) or "N", role="force"))
    return recording_of(path, channels, rate, replace(given, force=None if given.force is None else "auto"))


def _response(
    path: Path, numeric: Arrays, axis: GivenAxis, freq: str | None, given: Reading, said: Said
) -> FrequencyResponse:
    """FRFs or transmissibilities over the array ``freq``, or over a given axis."""
    seen = [n for n in numeric if _last(n) in _COHERENCE]
    axes = {freq} if freq is not None else {n for n in numeric if _last(n) in _FREQ | _TIME}
    complex_ones = {name: values for name, values in numeric.items() if np.iscomplexobj(values)}
    among = complex_ones if given.responses is None and complex_ones else numeric
    rows = chosen_rows(path, among, given.responses, {*axes, *seen})
    real = next((name for name, values, _ in rows if not np.iscomplexobj(values)), None)
    if real is not None:
        remedy = "Magnitudes alone have lost the phase; combine magnitude and phase first."
        unsuitable(path, f"whose {real} is real", "complex FRFs or transmissibilities", remedy)
    count = rows[0][1].size
    lines = axis.lines(path, count if freq is None else axis.size or count)
    for name, values, _ in rows:
        if values.size != lines.size:
            found = f"with {values.size} values of {name!r} over {lines.size} frequencies"
            unsuitable(path, found, "as many", "Export values and frequencies of the same test.")
    coherence = np.vstack([numeric[n] for n in seen]).real if seen else None
    if coherence is not None and coherence.shape != (len(rows), lines.size):
        found, wanted = f"with coherences of shape {coherence.shape}", f"({len(rows)}, {lines.size})"
        unsuitable(path, found, wanted, "Export a coherence for each response, over the same frequencies.")
    columns = [Channel(name, values, said.unit(raw)) for name, values, raw in rows]
    return response_of(path, lines, columns, given, coherence)


def _rate(
    path: Path, numeric: Arrays, time: str | None, given: Reading, said: Said, names: list[str]
) -> float:
    refuse = given.fs_hz is None
    stated = said.rate(path, names, refuse=refuse)
    single = {
        n: float(values[0, 0].real) * said.factor(path, n, refuse=refuse)
        for n, values in numeric.items()
        if values.size == 1 and _last(n) in RATES | STEPS
    }
    rates = [n for n in single if _last(n) in RATES]
    if given.rate_hz is not None:
        if stated is None and len(rates) == 1:
            stated = single[rates[0]]
        warn_other_rate(path, "states", stated, given.rate_hz)
        return given.rate_hz
    if time is not None:
        rate = rate_of(path, said.factor(path, time) * numeric[time][0].real)
        stated = single[rates[0]] if len(rates) == 1 else rate
        if abs(stated - rate) > 1e-3 * rate:
            found = f"with {rates[0]} of {stated:g} Hz and a {time!r} of {rate:g} Hz, if it is in s"
            unsuitable(path, found, "one rate", Wording("Give the true one by {}.", Passed("fs_hz")))
        return rate
    if not rates:
        if stated is not None:
            return stated
        steps = [x for n, x in single.items() if _last(n) in STEPS]
        if len(steps) == 1 and 0.0 < steps[0] < float("inf"):
            return rate_of_step(steps[0])
    if len(rates) != 1:
        unsuitable(
            path,
            f"without a sampling rate or a time ({listed(numeric)}{said.listed()})",
            "one of them",
            Wording(
                "Name {} or give {}; for responses over frequency name {}, or give {} or {}.",
                *map(Passed, ("time", "fs_hz", "freq", "freq_hz", "df_hz")),
            ),
        )
    return finite_scalar(rates[0], single[rates[0]], low=0.0, low_open=True, unit="Hz")


def _role(path: Path, argument: str, given: str | None, numeric: Arrays, names: set[str]) -> str | None:
    """The array the user names for a role, or the only one whose name says it."""
    if given is not None:
        if given not in numeric:
            wanted = f"a numeric array of {str(path)!r}: {listed(numeric)}"
            reject(argument, repr(given), wanted, "Correct the name; those of the file are listed.")
        return given
    found = [n for n in numeric if _last(n) in names and len(numeric[n]) == 1 and numeric[n].size > 1]
    if len(found) > 1:
        got = f"with several candidates for {argument}=, {found}"
        unsuitable(path, got, f"one {argument}", f"Name it: {argument}={found[0]!r}.")
    return found[0] if found else None


def _vectors(value: NDArray[Any]) -> NDArray[Any]:
    """Channels first: the longer axis is time or frequency."""
    rows = np.atleast_2d(value.astype(np.complex128 if value.dtype.kind == "c" else np.float64))
    return rows.T if rows.shape[0] > rows.shape[1] else rows


def _along(rows: NDArray[Any], size: int) -> NDArray[Any]:
    """Rows of ``size`` values, where the shorter axis has that many."""
    return rows.T if rows.shape[1] != size and rows.shape[0] == size else rows


def _last(name: str) -> str:
    return name.rpartition(".")[2].rpartition("/")[2].lower()
