"""Time series as the dictionaries of the SDyPy projects, SDyPy Enhancement Proposal 5 (draft of 2023)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import part, reject
from ..signals.recording import Recording
from ..support.checks import finite_scalar, real_array
from .channels import Channel, recording_of
from .common import rate_of
from .reading import Dofs, Reading
from .units import named_unit

_COMPULSORY = ("data", "name", "unit_str")
_SPELLED = ("data", "name", "unit_str", "fs", "time", "unit_tex", "start_timestamp", "start_timestamp_format")
_PROHIBITED = ("unit", "timestamp", "signal", "sample_frequency")


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
        data = real_array(
            part("channels", i).item("data"), row["data"], ndim=1, wanted="a real array (n_samples,)"
        )
        made.append(Channel(row["name"], data, row["unit_str"] or ""))
        rates.append(_rate(i, row, data.size))
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
    if named_unit("unit", unit).factor != 1.0:
        reject("unit", repr(unit), "an SI unit: recordings are in SI", "Name the SI unit, or leave unit out.")
    names = [str(dof) for dof in rec.dofs]
    taken = [*names, "force"] if rec.force is not None else names
    if len(set(taken)) != len(taken):
        wanted = "dofs that differ as text, and from 'force' where there is one"
        reject("rec", f"dofs {rec.dofs}", wanted, "Rename the dofs.")
    out = [
        {"name": name, "data": np.array(row), "fs": rec.fs_hz, "unit_str": unit, "dof": dof}
        for name, row, dof in zip(names, rec.responses, rec.dofs, strict=True)
    ]
    if rec.force is not None:
        out.append({"name": "force", "data": np.array(rec.force), "fs": rec.fs_hz, "unit_str": "N"})
    return out


def _check_keys(i: int, row: Any) -> None:
    here = part("channels", i)
    if not isinstance(row, Mapping):
        remedy = "Each channel is a dict with data, name, unit_str and fs or time."
        reject(here, type(row).__name__, "a dict", remedy)
    for key in row:
        plain = str(key).lower().replace("_", "")
        near = [k for k in _SPELLED if k.replace("_", "") == plain and k != key]
        if near:
            reject(here, f"the key {key!r}", f"{near[0]!r}, as SEP 5 spells it", "Rename the key.")
        if plain in (k.replace("_", "") for k in _PROHIBITED):
            wanted = "'unit_str', 'start_timestamp', 'data' or 'fs'"
            reject(here, f"the key {key!r}, which SEP 5 prohibits", wanted, "Rename the key.")
    for key in _COMPULSORY:
        if key not in row:
            wanted = f"the keys {', '.join(map(repr, _COMPULSORY))}, and 'fs' or 'time'"
            reject(here, f"no {key!r}", wanted, "Add the key.")
    if not isinstance(row["name"], str):
        reject(here.item("name"), row["name"], "a text", "Give the channel its name in quotes.")
    if not isinstance(row["unit_str"], str | None):
        remedy = "Name the unit in quotes, such as 'm/s2', or None where it is not known."
        reject(here.item("unit_str"), row["unit_str"], "a text or None", remedy)


def _rate(i: int, row: Mapping[str, Any], size: int) -> float:
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
