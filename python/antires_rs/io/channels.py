"""From channels, of a file or of SDyPy, to a signal: roles, rates, names, and units, which become SI."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import Argument, part, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar, real_array, shape_of
from ..support.messages import some, warn
from ._child import matches
from .common import rate_of, refuse_real, simplest_rate, unsuitable
from .options import Dofs, Reading
from .units import Unit

__all__ = ["from_sep005", "to_sep005"]

_TIME = ("time", "t", "time_s", "x_value", "zeit")  # names of a channel that holds the instants of the others
_SAME_RATE = 1e-6


@dataclass(frozen=True)
class Channel:
    """A channel with what its file says of it; the unit is '' and the step None where it is silent."""

    name: Any
    values: Any
    unit: str = ""
    step_s: float | None = None
    start: str = ""  # when the record began, as the file writes it
    offset_s: float = 0.0  # of the first sample after that
    role: str = ""  # "force" where the file states it


def recording_of(
    path: Path, channels: Sequence[Channel], fs_hz: float, given: Reading, time_s: Any = None
) -> Recording:
    """The recording, in SI; a force is what the file calls so by role or unit, or ``given.force`` names."""
    units = {id(c): _unit(path, c) for c in channels}
    forces = [c for c in channels if c.role == "force" or units[id(c)].quantity == "force"]
    if given.force not in ("auto", None) and all(c.name != given.force for c in forces):
        forces += [c for c in channels if c.name == given.force]  # the user knows better than a silent file
    responses = [c for c in channels if not any(c is f for f in forces)]
    if not responses:
        unsuitable(path, f"with {len(forces)} force and no response", "at least one response channel")
    force = _force(forces, given.force)
    if force is not None and units[id(force)].quantity not in ("", "force"):
        said = f"{force.name!r} is in {force.unit}, no force: its antiresonances would be missing"
        warn("other_unit", f"force: {said}. Name the channel of the hammer, or leave force out.")
    labels = renamed("dofs", [c.name for c in responses], given.dofs)
    rows = kept(labels)  # what is left out need not fit the rest
    used = [responses[i] for i in rows]
    lengths = {c.values.size for c in (*used, *([] if force is None else [force]))}
    if len(lengths) > 1:
        remedy = "Leave out those of other lengths by dofs=."
        unsuitable(path, f"with channels of {sorted(lengths)} samples", "channels of one length", remedy)
    if given.unit is not None:  # which is that of the responses
        named = Unit.named(given.unit)
        other = {c.unit for c in used if units[id(c)].quantity and units[id(c)] != named}
        if other:
            said = f"{str(path)!r} says {' and '.join(sorted(other))}, which was not used"
            warn("other_unit", f"unit: {given.unit!r}; {said}. Leave unit out if the file is right.")
        units |= {id(c): named for c in used}
    kinds = [(repr(c.name), units[id(c)].quantity, f"in {c.unit or 'no unit'}") for c in used]
    remedy = "Leave out those of other kinds by responses= or dofs=, name the hammer by force=, or the unit= "
    remedy += "of all."
    one_quantity(path, kinds, remedy)
    for unit in sorted({c.unit for c in used}) if given.unit is None else ():
        unit_or_warning(path, unit)
    values = np.stack([units[id(c)].in_si(c.values) for c in used])
    pushed = None if force is None else units[id(force)].in_si(force.values)
    return Recording(values, fs_hz, [labels[i] for i in rows], pushed, time_s)


def response_of(
    path: Path, freq_hz: Any, columns: Sequence[Channel], given: Reading, coherence: Any = None
) -> FrequencyResponse:
    """Complex columns over ``freq_hz`` as a response, in SI; ``coherence`` has a row for each column."""
    labels = renamed("dofs", [c.name for c in columns], given.dofs)
    chosen = kept(labels)
    named = None if given.unit is None else Unit.named(given.unit)
    units = [named or unit_or_warning(path, columns[i].unit) for i in chosen]
    values = [unit.in_si(columns[i].values) for i, unit in zip(chosen, units, strict=True)]
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
    used = rest if given.responses is None else [*chosen(file, rest, given), *forces]
    used = list({id(c): c for c in used}.values())
    if not used:
        unsuitable(file, "without a channel of numbers", "at least one channel of samples")
    rate = _rate(file, used, instants, given)
    first = used[0]
    begun = (first.start, round(first.offset_s, 9))
    other = next((c for c in used if (c.start, round(c.offset_s, 9)) != begun), None)
    if other is not None:
        ends = (f"{c.name!r} from {c.start or 'the start'} + {c.offset_s:g} s" for c in (first, other))
        remedy = "Name the responses= of one record."
        unsuitable(file, f"with {' and '.join(ends)}", "channels that begin together", remedy)
    if given.unit is None and not any(c.unit for c in used):
        said = "does not say in which unit its channels are; the values are as in the file"
        warn("no_unit", f"path: {str(file)!r} {said}. Name it by unit=.")
    made = [replace(c, role="force" if c in forces and given.force is not None else "") for c in used]
    return recording_of(file, made, rate, given)


def chosen(file: Path, channels: Sequence[Channel], given: Reading) -> list[Channel]:
    """The channels that ``given.responses`` means, in that order, and a force; all without it."""
    responses, found = given.responses, list(channels)
    if responses is None:
        return found
    found = [c for c in channels if c.role == "force" or c.name == given.force]
    for pattern in [responses] if shape_of(responses) == () else list(responses):
        hits = [c for c in channels if isinstance(pattern, str) and matches(str(c.name), pattern)]
        if not hits:
            wanted = f"channels of {str(file)!r}: {some((repr(c.name) for c in channels), 20)}"
            reject("responses", repr(pattern), wanted, "Correct the name or pattern.")
        found += hits
    return found


def _rate(file: Path, channels: Sequence[Channel], instants: Sequence[Channel], given: Reading) -> float:
    rates = {c.name: rate_of_step(c.step_s) for c in channels if c.step_s is not None and c.step_s > 0.0}
    rate = given.rate_hz
    if rate is None and not rates:
        if len(instants) == 1:
            return rate_of(file, instants[0].values)
        found = f"whose channels {some((repr(c.name) for c in channels), 6)} state no sampling interval"
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


def one_quantity(
    path: Path,
    found: Sequence[tuple[str, str, str]],
    remedy: str = "Leave out those of other kinds by dofs=, or name the unit= of all.",
) -> None:
    """Refuse accelerations beside displacements; ``found`` has name, quantity and unit of each channel."""
    if len({quantity for _, quantity, _ in found}) > 1:
        got = "with responses of several kinds, " + ", ".join(f"{name} {unit}" for name, _, unit in found)
        unsuitable(path, got, "accelerations, velocities or displacements alone", remedy)


def renamed(argument: str, names: Sequence[Any], dofs: Dofs) -> list[Any]:
    """The dof of each channel; None for those the user leaves out."""
    if dofs is None:
        return list(names)
    if isinstance(dofs, Mapping):
        lost = [name for name in names if name not in dofs]
        if lost:
            remedy = "Map a channel to None to leave it out."
            reject(argument, f"no dof for {lost}", f"a dof for each of {list(names)}", remedy)
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


def _unit(path: Path, channel: Channel) -> Unit:
    unit = Unit.of(channel.unit)
    if unit.per:
        found = f"with the unit {channel.unit!r} of channel {channel.name!r}"
        unsuitable(path, found, "a unit of a record", "Read responses over frequency as such.")
    return unit


def unit_or_warning(path: Path, text: str) -> Unit:
    """The unit of that name; one that is not known leaves values as they are, with a warning."""
    unit = Unit.of(text)
    if not unit.known:
        said = f"has responses in {text!r}, which is no unit known here; values are as they are in the file"
        warn("unknown_unit", f"path: {str(path)!r} {said}. Name it by unit= if they should be converted.")
    return unit


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


# -- Time series as the dictionaries of the SDyPy projects, SDyPy Enhancement Proposal 5 (draft of 2023)

_SEP_5 = "dicts with 'data', 'name', 'unit_str', and 'fs' or 'time'"


def from_sep005(
    channels: Any, *, dofs: Dofs = None, force: Any = "auto", unit: str | None = None
) -> Recording:
    """A recording of the channels of SEP 5.

    Parameters
    ----------
    channels : dict or sequence of dict
        One for each channel: ``data`` (1-D), ``name``, ``unit_str``, and ``fs`` in Hz or ``time`` in s.
    dofs, force, unit : optional
        As in :func:`~antires_rs.read_tdms`.

    Returns
    -------
    Recording
        In SI.

    Raises
    ------
    InvalidInputError, UnsuitableDataError
        A key that is missing, a name twice, different rates, lengths or starts (which are not kept); gaps in
        ``time``, responses of several kinds.

    Notes
    -----
    SEP 5, SDyPy Unified timeseries, W. Weijtjens and J. Slavic, draft of 2023-07-07.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> ar.from_sep005([{"name": "tip", "data": np.array([0.0, 1.0, 0.5]), "fs": 100, "unit_str": "g"}])
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    rows = [channels] if isinstance(channels, Mapping) else channels
    if not isinstance(rows, list | tuple) or not rows:
        got = "none" if rows == [] else type(channels).__name__
        reject("channels", got, f"a list of {_SEP_5}", "Pass what the reader of the file returned.")
    made = [_channel_of(part("channels", i), row) for i, row in enumerate(rows)]
    rates = [1.0 / (c.step_s or 1.0) for c in made]
    if max(len({round(rate, 9) for rate in rates}), len({c.start for c in made} - {""})) > 1:
        got = "several rates or starts"
        reject("channels", got, "channels recorded together", "Pass the channels of one record only.")
    twice = next((name for name, n in Counter(c.name for c in made).items() if n > 1), None)
    if twice is not None:
        reject("channels", f"the name {twice!r} twice", "names that differ", "Rename one of the channels.")
    fs_hz = rows[0].get("fs") or rates[0]
    return recording_of(_SOURCE, made, float(fs_hz), Reading(dofs=dofs, force=force, unit=unit))


def to_sep005(rec: Recording, *, unit: str = "m/s2") -> list[dict[str, Any]]:
    """The channels of a recording as SEP 5 has them, the force last.

    Parameters
    ----------
    rec : Recording
        Its dofs have to differ as text.
    unit : str
        SI unit of the responses.

    Returns
    -------
    list of dict
        ``data``, ``name`` (the dof as text), ``fs``, ``unit_str``, and ``dof``, the label itself.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.to_sep005(ar.Recording([[1.0, 2.0, 3.0]], 8.0, dofs=["tip"]))[0]["unit_str"]
    'm/s2'
    """
    if not isinstance(rec, Recording):
        reject("rec", type(rec).__name__, "a Recording", "Make one first: Recording(responses, fs_hz).")
    Unit.written(unit)
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


_SOURCE = Path("SEP-005 channels")  # what stands in messages in place of a file


def _channel_of(here: Argument, row: Any) -> Channel:
    given = row.items() if isinstance(row, Mapping) else ()
    keys = {key: None for key, value in given if value is not None or key == "unit_str"}.keys()
    if not ({"data", "name", "unit_str"} <= keys and {"fs", "time"} & keys):
        reject(here, f"the keys {some(keys, 9) or 'none'}", _SEP_5, "Add those that are missing.")
    data = real_array(here.item("data"), row["data"], ndim=1, wanted="a real array (n_samples,)")
    fs, time, rate = row.get("fs"), row.get("time"), 0.0
    if fs is not None:
        fs = finite_scalar(here.item("fs"), fs, low=0.0, low_open=True, unit="Hz")
    if time is not None:
        rate = rate_of(_SOURCE, real_array(here.item("time"), time, ndim=1, wanted="a real array in s"))
        if np.size(time) != data.size or (fs is not None and abs(rate / fs - 1.0) > 1e-3):
            got = f"{np.size(time)} instants at {rate:g} Hz"
            reject(here.item("time"), got, f"{data.size}, at the rate fs", "Leave out what is wrong.")
    start = str(row.get("start_timestamp") or "")
    return Channel(str(row["name"]), data, str(row["unit_str"] or ""), 1.0 / (fs or rate), start)
