"""Signals, antiresonances and what is computed from them for pandas, xarray and SDyPy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..damage.hypotheses import Hypotheses
from ..exceptions import part, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.compare import Comparison
from ..measured.edits import BY_HAND
from ..measured.track import Tracks
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar, real_array
from ..updating.posterior import ParameterIntervals
from .channels import Channel, named_unit, recording_of
from .common import Dofs, Reading, missing_package, rate_of


def _package(method: str, name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as exc:
        raise missing_package(method, name, "tables", exc) from exc


_pandas, _xarray = partial(_package, "to_dataframe", "pandas"), partial(_package, "to_xarray", "xarray")


def to_dataframe(source: Recording | FrequencyResponse | AntiresonanceSet) -> Any:
    """A pandas.DataFrame: a column a channel over time or frequency, or a row an antiresonance."""
    if isinstance(source, AntiresonanceSet):
        names, rows = rows_of(source)
        return frame_of(rows, names)
    pd = _pandas()
    columns = pd.Index(list(source.dofs), dtype=object)
    if isinstance(source, FrequencyResponse):
        return pd.DataFrame(source.values.T, pd.Index(source.freq_hz, name="freq_hz"), columns)
    frame = pd.DataFrame(source.responses.T, pd.Index(_instants(source), name="time_s"), columns)
    if source.force is not None:
        frame["force"] = source.force
    return frame


def frame_of(rows: list[dict[str, Any]], names: list[str]) -> Any:
    """A pandas.DataFrame of rows with some of these columns."""
    return _pandas().DataFrame(rows, columns=names)


def rows_of(found: AntiresonanceSet) -> tuple[list[str], list[dict[str, Any]]]:
    """Column names and one row an antiresonance."""
    scores = list(dict.fromkeys(name for table in found.tables.values() for name in table.scores))
    checked = found.cross_check
    rows = []
    for dof, table in found.tables.items():
        for i, freq in enumerate(table.freq_hz.tolist()):
            row = {"dof": dof, "freq_hz": freq, "damping_ratio": float(table.damping_ratio[i])}
            row |= {"std_hz": float(table.std_hz[i])}
            row |= {"source": BY_HAND if table.by_hand[i] else "identified"}
            row |= {name: table.scores[name][i].item() if name in table.scores else None for name in scores}
            if checked is not None:
                row["confirmed"] = checked.is_confirmed(dof, freq)
            rows.append(row)
    known = ["dof", "freq_hz", "damping_ratio", "std_hz", "source"]
    return [*known, *scores, *([] if checked is None else ["confirmed"])], rows


def to_xarray(source: Recording | FrequencyResponse | AntiresonanceSet) -> Any:
    """An xarray.Dataset with dofs and time, frequency or rank as coordinates."""
    xr = _xarray()
    dofs = list(source if isinstance(source, AntiresonanceSet) else source.dofs)
    labels = np.empty(len(dofs), dtype=object)  # whole numbers and text, which numpy would make text
    labels[:] = dofs
    if isinstance(source, Recording):
        data: dict[str, Any] = {"responses": (("dof", "time_s"), np.array(source.responses))}
        if source.force is not None:
            data["force"] = (("time_s",), np.array(source.force))
        return xr.Dataset(data, {"dof": labels, "time_s": _instants(source)}, {"fs_hz": source.fs_hz})
    if isinstance(source, FrequencyResponse):
        held = {name: getattr(source, name) for name in ("values", "coherence", "std")}
        data = {name: (("dof", "freq_hz"), np.array(v)) for name, v in held.items() if v is not None}
        # Attributes that netCDF can hold: what is not known is left out.
        stated = {name: getattr(source, name) for name in ("kind", "reference", "n_averages")}
        known = {name: value for name, value in stated.items() if value is not None}
        return xr.Dataset(data, {"dof": labels, "freq_hz": np.array(source.freq_hz)}, known)
    longest = max(freq.size for freq in source.values())
    names = ("freq_hz", "damping_ratio", "std_hz")
    padded = {name: np.full((len(source), longest), np.nan) for name in names}
    for i, dof in enumerate(source):
        for name, column in source.columns(dof).items():
            padded[name][i, : column.size] = column
    data = {name: (("dof", "rank"), rows) for name, rows in padded.items()}
    return xr.Dataset(data, {"dof": labels, "rank": np.arange(longest)}, {"excitation": source.excitation})


def _instants(rec: Recording) -> Any:
    return np.arange(rec.n_samples) / rec.fs_hz


#: Columns of a comparison, in the order in which they are read, and what it says of all pairs.
_PAIRS: tuple[str, ...] = ("dof", "a_hz", "b_hz", "difference_hz", "difference_percent")
_PAIRS += ("std_hz", "std_percent", "z", "p", "changed")
_ALL_PAIRS = ("excitation", "chi_square", "freedom", "p_all", "alpha")


def comparison_frame(compared: Comparison) -> Any:
    """A pandas.DataFrame, one row a pair."""
    return _pandas().DataFrame({name: np.array(getattr(compared, name)) for name in _PAIRS})


def comparison_dataset(compared: Comparison) -> Any:
    """An xarray.Dataset over the pairs."""
    columns = {name: (("pair",), np.array(getattr(compared, name))) for name in _PAIRS}
    over = {"dof": columns.pop("dof")}
    return _xarray().Dataset(columns, over, {name: getattr(compared, name) for name in _ALL_PAIRS})


def intervals_frame(found: ParameterIntervals) -> Any:
    """A pandas.DataFrame, one row a parameter."""
    columns = {name: np.array(getattr(found, name)) for name in ("low", "high", "center", "std", "words")}
    return _pandas().DataFrame(columns, index=_pandas().Index(found.names, name="parameter"))


def tracks_frame(tracks: Tracks) -> Any:
    """A pandas.DataFrame, one row a test and track."""
    events = {(event.test, event.track): event.kind for event in tracks.events}
    change, rows = tracks.change_percent, []
    for test, condition in enumerate(tracks.conditions):
        for i in range(len(tracks)):
            row = {"test": test, "condition": condition, "dof": tracks.dof[i], "track": i}
            row |= {"freq_hz": tracks.freq_hz[test, i], "std_hz": tracks.std_hz[test, i]}
            rows.append(row | {"change_percent": change[test, i], "event": events.get((test, i), "")})
    return _pandas().DataFrame(rows)


def tracks_dataset(tracks: Tracks) -> Any:
    """An xarray.Dataset over test and track."""
    names = ("freq_hz", "std_hz", "change_percent")
    data = {name: (("test", "track"), np.array(getattr(tracks, name))) for name in names}
    over: dict[str, Any] = {
        "test": np.arange(len(tracks.conditions)),
        "dof": (("track",), np.array(tracks.dof)),
    }
    over["condition"] = (("test",), np.array(tracks.conditions))
    return _xarray().Dataset(data, over, {"excitation": tracks.excitation})


def hypotheses_frame(hypotheses: Hypotheses) -> Any:
    """A pandas.DataFrame, one row a hypothesis."""
    columns = ("elements", "probability", "severities", "low", "high", "candidate")
    return _pandas().DataFrame({name: [getattr(one, name) for one in hypotheses] for name in columns})


# -- Time series as the dictionaries of the SDyPy projects, SDyPy Enhancement Proposal 5 (draft of 2023)

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
        at = part("channels", i).item("data")
        data = real_array(at, row["data"], ndim=1, wanted="a real array (n_samples,)")
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
    out = []
    for name, row, dof in zip(names, rec.responses, rec.dofs, strict=True):
        out.append({"name": name, "data": np.array(row), "fs": rec.fs_hz, "unit_str": unit, "dof": dof})
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
