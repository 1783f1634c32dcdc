"""From channels, of a file or of SDyPy, to a signal: roles, rates, names, and units, which become SI."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import part, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar, real_array, shape_of
from ..support.messages import warn
from ._child import matches
from .common import Dofs, Reading, rate_of, refuse_real, simplest_rate, unsuitable

#: Names of a channel that holds the instants of the others.
_TIME = ("time", "t", "time_s", "x_value", "zeit")
_SAME_RATE = 1e-6


@dataclass(frozen=True)
class Channel:
    """A channel with what its file says of it; the unit is '' and the step None where it is silent.

    ``start`` is when the record began, as the file writes it, ``offset_s`` its first sample after that;
    ``role`` is "force" where the file states it.
    """

    name: Any
    values: Any
    unit: str = ""
    step_s: float | None = None
    start: str = ""
    offset_s: float = 0.0
    role: str = ""


def recording_of(path: Path, channels: Sequence[Channel], fs_hz: float, given: Reading) -> Recording:
    """The recording, in SI; a force is what the file calls so by role or unit, or ``given.force`` names."""
    units = {id(c): _unit(path, c) for c in channels}
    forces = [c for c in channels if c.role == "force" or units[id(c)].quantity == "force"]
    if given.force not in ("auto", None) and all(c.name != given.force for c in forces):
        forces += [c for c in channels if c.name == given.force]  # the user knows better than a silent file
    responses = [c for c in channels if not any(c is f for f in forces)]
    if not responses:
        found = f"with {len(forces)} force and no response"
        unsuitable(path, found, "at least one response channel", "Export the response channels too.")
    force = _force(forces, given.force)
    labels = renamed("dofs", [c.name for c in responses], given.dofs)
    rows = kept(labels)  # what is left out need not fit the rest
    used = [responses[i] for i in rows]
    lengths = {c.values.size for c in (*used, *([] if force is None else [force]))}
    if len(lengths) > 1:
        found = f"with channels of {sorted(lengths)} samples"
        remedy = "Leave out those of other lengths by dofs=."
        unsuitable(path, found, "channels of one length", remedy)
    if given.unit is not None:  # which is that of the responses
        units |= {id(c): named_unit("unit", given.unit) for c in used}
    else:
        for unit in sorted({c.unit for c in used}):
            unit_or_warning(path, unit)
    one_quantity(path, [(repr(c.name), units[id(c)].quantity, f"in {c.unit or 'no unit'}") for c in used])
    values = np.stack([in_si(c.values, units[id(c)]) for c in used])
    pushed = None if force is None else in_si(force.values, units[id(force)])
    return Recording(values, fs_hz, [labels[i] for i in rows], pushed)


def response_of(
    path: Path, freq_hz: Any, columns: Sequence[Channel], given: Reading, coherence: Any = None
) -> FrequencyResponse:
    """Complex columns over ``freq_hz`` as a response, in SI; ``coherence`` has a row for each column."""
    labels = renamed("dofs", [c.name for c in columns], given.dofs)
    chosen = kept(labels)
    named = None if given.unit is None else named_unit("unit", given.unit)
    units = [named or unit_or_warning(path, columns[i].unit) for i in chosen]
    values = [in_si(columns[i].values, unit) for i, unit in zip(chosen, units, strict=True)]
    refuse_real(path, [(columns[i].name, row) for i, row in zip(chosen, values, strict=True)])
    kind: Any = "frf" if given.kind is None else given.kind
    beside = None if coherence is None else coherence[chosen]
    dofs = [labels[i] for i in chosen]
    return FrequencyResponse(freq_hz, np.stack(values), dofs, kind, given.reference, beside)


def stated_recording(file: Path, channels: Sequence[Channel], given: Reading) -> Recording:
    """The recording, in SI, of channels that state their own rate, unit and start."""
    instants = [c for c in channels if c.step_s is None and c.name.rpartition("/")[2].lower() in _TIME]
    rest = [c for c in channels if c not in instants]
    forces = [c for c in rest if c.name == given.force or c.name.lower() == "force"]
    chosen = rest if given.responses is None else [*_named(file, rest, given.responses), *forces]
    chosen = list({id(c): c for c in chosen}.values())
    if not chosen:
        found = "without a channel of numbers"
        unsuitable(file, found, "at least one channel of samples", "Export the channels of the record.")
    rate = _rate(file, chosen, instants, given)
    first = chosen[0]
    begun = (first.start, round(first.offset_s, 9))
    other = next((c for c in chosen if (c.start, round(c.offset_s, 9)) != begun), None)
    if other is not None:
        names = (f"{c.name!r} from {c.start or 'the start'} + {c.offset_s:g} s" for c in (first, other))
        found, remedy = f"with {' and '.join(names)}", "Name the responses= of one record."
        unsuitable(file, found, "channels that begin together", remedy)
    if given.unit is None and not any(c.unit for c in chosen):
        said = "does not say in which unit its channels are; the values are as in the file"
        warn("no_unit", f"path: {str(file)!r} {said}. Name it by unit=.")
    made = [replace(c, role="force" if c in forces and given.force is not None else "") for c in chosen]
    return recording_of(file, made, rate, given)


def _named(file: Path, channels: Sequence[Channel], responses: Any) -> list[Channel]:
    found = []
    for pattern in [responses] if shape_of(responses) == () else list(responses):
        hits = [c for c in channels if isinstance(pattern, str) and matches(c.name, pattern)]
        if not hits:
            shown = ", ".join(repr(c.name) for c in channels[:20]) or "none of that name"
            got = repr(pattern)
            reject("responses", got, f"channels of {str(file)!r}: {shown}", "Correct the name or pattern.")
        found += hits
    return found


def _rate(file: Path, channels: Sequence[Channel], instants: Sequence[Channel], given: Reading) -> float:
    rates = {c.name: rate_of_step(c.step_s) for c in channels if c.step_s is not None and c.step_s > 0.0}
    rate = given.rate_hz
    if rate is None and not rates:
        if len(instants) == 1:
            return rate_of(file, instants[0].values)
        found = f"whose channels {', '.join(repr(c.name) for c in channels[:6])} state no sampling interval"
        unsuitable(file, found, "a sampling rate", "Give it by fs_hz=.")
    if rates and max(rates.values()) - min(rates.values()) > _SAME_RATE * max(rates.values()):
        low, high = (f(rates, key=lambda name: rates[name]) for f in (min, max))
        found = f"with {low!r} at {rates[low]:.6g} Hz and {high!r} at {rates[high]:.6g} Hz"
        unsuitable(file, found, "channels of one rate", "Name the responses= of one rate.")
    own = next(iter(rates.values()), rate)
    if rate is not None:
        warn_other_rate(file, "has channels at", own, rate)
    return float(rate if rate is not None else own or 0.0)


def warn_other_rate(file: Path, says: str, own: float | None, rate: float) -> None:
    """A rate that the caller gives and the file denies moves every frequency."""
    if own is not None and abs(own - rate) > 1e-3 * rate:
        said = f"{says} {own:.6g} Hz; read at {rate:.6g} Hz, as fs_hz= says"
        warn("other_rate", f"path: {str(file)!r} {said}. Leave fs_hz= out if the file is right.")


def rate_of_step(step_s: float) -> float:
    """The rate of a sampling interval in double precision."""
    return simplest_rate((1.0 - 1e-12) / step_s, (1.0 + 1e-12) / step_s)


def one_quantity(path: Path, found: Sequence[tuple[str, str, str]]) -> None:
    """Refuse accelerations beside displacements; ``found`` has name, quantity and unit of each channel."""
    if len({quantity for _, quantity, _ in found}) > 1:
        shown = ", ".join(f"{name} {unit}" for name, _, unit in found)
        remedy = "Leave out those of other kinds by dofs=, or name the unit= of all."
        wanted = "accelerations, velocities or displacements alone"
        unsuitable(path, f"with responses of several kinds, {shown}", wanted, remedy)


def renamed(argument: str, names: Sequence[Any], dofs: Dofs) -> list[Any]:
    """The dof of each channel; None for those the user leaves out."""
    if dofs is None:
        return list(names)
    if isinstance(dofs, Mapping):
        lost = [name for name in names if name not in dofs]
        if lost:
            got = f"no dof for {lost}"
            remedy = "Map a channel to None to leave it out."
            reject(argument, got, f"a dof for each of {list(names)}", remedy)
        return [dofs[name] for name in names]
    if callable(dofs):
        return [dofs(name) for name in names]
    labels = list(dofs) if shape_of(dofs) != () else [dofs]
    if len(labels) != len(names):
        remedy = "Name a dof for each channel, in their order, or map channels to dofs."
        reject(argument, f"{len(labels)} dofs", f"{len(names)}, one for each of {list(names)}", remedy)
    return labels


def kept(labels: Sequence[Any]) -> list[int]:
    """Which channels are kept: those with a dof."""
    rows = [i for i, label in enumerate(labels) if label is not None]
    if not rows:
        reject("dofs", "None for every channel", "at least one channel to keep", "Give one of them a dof.")
    return rows


def in_si(values: Any, unit: Unit) -> Any:
    """Values in SI; bit-identical where they are SI already."""
    return values if unit.factor == 1.0 else values * unit.factor


def _unit(path: Path, channel: Channel) -> Unit:
    unit = parse_unit(channel.unit) or Unit()
    if unit.per:
        found, wanted = f"with the unit {channel.unit!r} of channel {channel.name!r}", "a unit of a record"
        unsuitable(path, found, wanted, "Export time records, or read the file as frequency responses.")
    return unit


def unit_or_warning(path: Path, text: str) -> Unit:
    """The unit of that name; one that is not known leaves values as they are, with a warning."""
    unit = parse_unit(text)
    if unit is None:
        said = f"has responses in {text!r}, which is no unit known here; values are as they are in the file"
        warn("unknown_unit", f"path: {str(path)!r} {said}. Name it by unit= if they should be converted.")
    return unit or Unit()


def _force(forces: list[Channel], force: Any) -> Channel | None:
    automatic = isinstance(force, str) and force == "auto"
    if force is None or (automatic and not forces):
        return None
    names = [c.name for c in forces]
    if automatic and len(forces) > 1:
        got = f"'auto' for a file with {len(forces)} force channels, {names}"
        reject("force", got, "the name of one, or None", "The theory is that of one force.")
    if not automatic and force not in names:
        wanted = f"'auto', None or a channel of the file, {names or 'it has no force'}"
        reject("force", repr(force), wanted, "Name a channel of the file, or pass None for no force.")
    return forces[0 if automatic else names.index(force)]


# -- Units of channels and how they become SI: m/s2, m/s, m and N
#
# Names are compared without brackets, spaces, carets and superscripts: ``m/s^2`` and ``(m/s²)`` are one unit.
# An FRF has a quotient, such as ``g/N`` or ``m/s2/N``.

#: m/s2 in one g, by definition (3rd CGPM, 1901).
STANDARD_GRAVITY = 9.80665
INCH, POUND_FORCE = 0.0254, 4.4482216152605

_SI = {
    "acceleration": {
        **dict.fromkeys(("m/s2", "m/s/s", "ms-2"), 1.0),
        **dict.fromkeys(("g", "gn"), STANDARD_GRAVITY),
        **{"mg": 1e-3 * STANDARD_GRAVITY, "mm/s2": 1e-3, "cm/s2": 1e-2, "gal": 1e-2},
        **{"in/s2": INCH, "ft/s2": 12.0 * INCH},
    },
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "in/s": INCH, "ft/s": 12.0 * INCH},
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": INCH, "ft": 12.0 * INCH},
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": POUND_FORCE, "kgf": STANDARD_GRAVITY},
}
#: Units of time and frequency, in small letters.
_ABSCISSA = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "hz", "hertz", "1/s"), 1.0),
    **dict.fromkeys(("ms", "msec", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "microseconds"), 1e-6),
    "ns": 1e-9,
    **dict.fromkeys(("min", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hours"), 3600.0),
    **dict.fromkeys(("samples/s", "samples/sec", "samples/second", "sa/s", "s/s", "sps"), 1.0),
    **dict.fromkeys(("khz", "ksamples/s", "ksa/s", "ks/s", "ksps"), 1e3),
    **dict.fromkeys(("rpm", "cpm", "1/min"), 1.0 / 60.0),
    **dict.fromkeys(("rad/s", "rad/sec"), 0.5 / math.pi),
}
_INVERSE = re.compile(r"^\(?1/(\w+)\)?[*.](.+)$")
_NONE = {"", "1", "-", "none", "unknown", "[]"}
_SPELLED = str.maketrans({"²": "2", "µ": "u", "μ": "u", "^": "", "·": "", " ": ""})


@dataclass(frozen=True)
class Unit:
    """What a channel measures, per what ('' where that is not stated), and the factor into SI."""

    quantity: str = ""
    per: str = ""
    factor: float = 1.0


def parse_unit(text: str) -> Unit | None:
    """The unit of that name; None where it is not known."""
    name = _plain(text)
    if name.lower() in _NONE:
        return Unit()
    if inverse := _INVERSE.match(name):  # (1/N)*(m/s2)
        name = f"{inverse[2].strip('()')}/{inverse[1]}"
    if simple := _simple(name):
        return Unit(simple[0], "", simple[1])
    for cut in (i for i, letter in enumerate(name) if letter == "/"):
        above, below = _simple(_plain(name[:cut])), _simple(_plain(name[cut + 1 :]))
        if above and below:
            return Unit(above[0], below[0], above[1] / below[1])
    return None


def named_unit(name: str, value: Any) -> Unit:
    """The unit a user names; an unknown one is refused."""
    unit = parse_unit(value) if isinstance(value, str) else None
    if unit is None:
        known = ", ".join(repr(u) for units in _SI.values() for u in list(units)[:4])
        wanted = f"a unit such as {known}, or a quotient such as 'g/N'"
        reject(name, repr(value), wanted, "Correct the unit, or convert the values to SI and leave it out.")
    return unit


def si_unit(name: str, value: Any) -> Unit:
    """The unit in which a user writes values, which stay as they are."""
    unit = named_unit(name, value)
    if unit.factor != 1.0:
        wanted = "an SI unit, such as 'm/s2' or 'm/s2/N': signals are in SI"
        reject(name, repr(value), wanted, "Name the SI unit, or leave unit out.")
    return unit


def abscissa_factor(text: str) -> float:
    """Factor of a time or frequency into s or Hz; 1 for names that are not known."""
    return _ABSCISSA.get(_plain(text).lower(), 1.0)


def is_abscissa(text: str) -> bool:
    """Whether the name is that of a unit of time or frequency."""
    return _plain(text).lower() in _ABSCISSA


def is_frequency(text: str) -> bool:
    """Whether the name is that of a unit of frequency."""
    return _plain(text).lower() in ("hz", "hertz", "khz", "rad/s", "rad/sec")


def _plain(text: str) -> str:
    # What is left of a Latin-1 ² where a package read it as UTF-8.
    text = text.replace("/s\ufffd", "/s2").replace("**", "").translate(_SPELLED)
    while len(text) > 1 and (text[0], text[-1]) in (("(", ")"), ("[", "]")):
        text = text[1:-1]
    return text


def _simple(name: str) -> tuple[str, float] | None:
    # Capitals as they are first: mN and MN differ. Then in small letters, as some programs print M/S2.
    for spelled in (name, name.lower()):
        for quantity, units in _SI.items():
            if spelled in units:
                return quantity, units[spelled]
    return None


# -- Time series as the dictionaries of the SDyPy projects, SDyPy Enhancement Proposal 5 (draft of 2023)

_COMPULSORY = ("data", "name", "unit_str")
_KEYS = (*_COMPULSORY, "fs", "time", "unit_tex", "start_timestamp", "start_timestamp_format")
#: How SEP 5 spells a key, by its small letters; those that it prohibits stand for another.
_SPELLED_SO = {key.replace("_", ""): key for key in _KEYS}
_PROHIBITED = {"unit": "unit_str", "timestamp": "start_timestamp", "signal": "data", "samplefrequency": "fs"}


def from_sep005(
    channels: Any, *, dofs: Dofs = None, force: Any = "auto", unit: str | None = None
) -> Recording:
    """A recording of the channels of SEP 5.

    Parameters
    ----------
    channels : dict or sequence of dict
        One for each channel: ``data`` (1-D), ``name``, ``unit_str``, and ``fs`` in Hz or ``time`` in s.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        names.
    force : str or None
        Name of the force; "auto" takes the one channel in N, None leaves it out.
    unit : str, optional
        Unit of the responses, in place of ``unit_str``.

    Returns
    -------
    Recording
        In SI.

    Raises
    ------
    InvalidInputError
        A key that is missing, misspelled or prohibited by the proposal, a name twice, different rates or
        lengths.
    UnsuitableDataError
        Gaps in ``time``, responses of several kinds.

    Notes
    -----
    SEP 5, SDyPy Unified timeseries, W. Weijtjens and J. Slavic, draft of 2023-07-07. ``start_timestamp``
    must be the same in all channels that have it; it is not kept.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> ar.from_sep005([{"name": "tip", "data": np.array([0.0, 1.0, 0.5]), "fs": 100, "unit_str": "g"}])
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    given = [channels] if isinstance(channels, Mapping) else channels
    if not isinstance(given, Iterable) or isinstance(given, str):
        wanted = "a sequence of dicts, one for each channel"
        reject("channels", type(channels).__name__, wanted, "Put a single channel in a list.")
    rows = list(given)
    if not rows:
        found = "none"
        reject("channels", found, "at least one dict", "Pass the dicts that the reader of the file returned.")
    made, rates = [], []
    for i, row in enumerate(rows):
        _check_keys(i, row)
        at = part("channels", i).item("data")
        data = real_array(at, row["data"], ndim=1, wanted="a real array (n_samples,)")
        made.append(Channel(row["name"], data, row["unit_str"] or ""))
        rates.append(_rate_of_row(i, row, data.size))
    names = [c.name for c in made]
    if len(set(names)) != len(names):
        got = f"the name {next(n for n in names if names.count(n) > 1)!r} twice"
        reject("channels", got, "names that differ", "Rename one of the channels.")
    if max(rates) - min(rates) > 1e-9 * max(rates):
        found = f"rates from {min(rates):g} to {max(rates):g} Hz"
        reject("channels", found, "one rate", "Resample them first.")
    starts = {row["start_timestamp"] for row in rows if row.get("start_timestamp")}
    if len(starts) > 1:
        got = f"{len(starts)} different start_timestamp"
        reject("channels", got, "channels recorded together", "Pass the channels of one record only.")
    return recording_of(Path("SEP-005 channels"), made, rates[0], Reading(dofs=dofs, force=force, unit=unit))


def to_sep005(rec: Recording, *, unit: str = "m/s2") -> list[dict[str, Any]]:
    """The channels of a recording as SEP 5 has them, the force last.

    Parameters
    ----------
    rec : Recording
    unit : str
        SI unit of the responses.

    Returns
    -------
    list of dict
        ``data``, ``name`` (the dof as text), ``fs``, ``unit_str``, and ``dof``, the label itself.

    Raises
    ------
    InvalidInputError
        Something that is not a Recording, a unit that is not SI, dofs that are the same as text.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.to_sep005(ar.Recording([[1.0, 2.0, 3.0]], 8.0, dofs=["tip"]))[0]["unit_str"]
    'm/s2'
    """
    if not isinstance(rec, Recording):
        got = type(rec).__name__
        reject("rec", got, "a Recording", "Make one of the arrays first: Recording(responses, fs_hz).")
    si_unit("unit", unit)
    rows: list[dict[str, Any]] = [
        {"name": str(dof), "data": np.array(row), "fs": rec.fs_hz, "unit_str": unit, "dof": dof}
        for dof, row in zip(rec.dofs, rec.responses, strict=True)
    ]
    if rec.force is not None:
        rows.append({"name": "force", "data": np.array(rec.force), "fs": rec.fs_hz, "unit_str": "N"})
    if len({row["name"] for row in rows}) != len(rows):
        wanted = "dofs that differ as text, and from 'force' where there is one"
        reject("rec", f"dofs {rec.dofs}", wanted, "Rename the dofs.")
    return rows


def _check_keys(i: int, row: Any) -> None:
    here = part("channels", i)
    if not isinstance(row, Mapping):
        remedy = "Each channel is a dict with data, name, unit_str and fs or time."
        reject(here, type(row).__name__, "a dict", remedy)
    for key in row:
        plain = str(key).lower().replace("_", "")
        if plain in _PROHIBITED:
            got = f"the key {key!r}, which SEP 5 prohibits"
            reject(here, got, repr(_PROHIBITED[plain]), "Rename the key.")
        if _SPELLED_SO.get(plain, key) != key:
            wanted = f"{_SPELLED_SO[plain]!r}, as SEP 5 spells it"
            reject(here, f"the key {key!r}", wanted, "Rename the key.")
    for key in _COMPULSORY:
        if key not in row:
            wanted = f"the keys {', '.join(map(repr, _COMPULSORY))}, and 'fs' or 'time'"
            reject(here, f"no {key!r}", wanted, "Add the key.")
    if not isinstance(row["name"], str):
        reject(here.item("name"), row["name"], "a text", "Give the channel its name in quotes.")
    if not isinstance(row["unit_str"], str | None):
        remedy = "Name the unit in quotes, such as 'm/s2', or None where it is not known."
        reject(here.item("unit_str"), row["unit_str"], "a text or None", remedy)


def _rate_of_row(i: int, row: Mapping[str, Any], size: int) -> float:
    here, fs = part("channels", i), row.get("fs")
    if fs is not None:
        fs = finite_scalar(here.item("fs"), fs, low=0.0, low_open=True, unit="Hz")
    if row.get("time") is None:
        if fs is None:
            remedy = "Add the sampling rate, fs in Hz, or the instants, time in s."
            reject(here, "neither 'fs' nor 'time'", "one of them", remedy)
        return fs
    at = here.item("time")
    time = real_array(at, row["time"], ndim=1, wanted=f"a real array ({size},) in s")
    if time.size != size:
        remedy = "Give an instant for each sample, or the rate alone."
        reject(at, f"{time.size} instants", f"{size}, as the data", remedy)
    rate = rate_of(Path(f"SEP-005 channels[{i}]"), time)
    if fs is not None and abs(rate / fs - 1.0) > 1e-3:
        got = f"{fs:g} Hz beside a 'time' of {rate:g} Hz"
        reject(here.item("fs"), got, "one rate", "Correct one of them, or leave it out.")
    return rate if fs is None else fs
