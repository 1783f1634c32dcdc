"""Signals, antiresonances and what is computed from them for pandas and xarray."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from ..damage.hypotheses import Hypotheses, Hypothesis
from ..measured.antiresonance_set import NOT_SEEN, AntiresonanceSet
from ..measured.compare import Comparison
from ..measured.edits import BY_HAND
from ..measured.response_table import label_array
from ..measured.track import Tracks
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import Dofs
from ..updating.posterior import ParameterIntervals
from .common import require


def _package(method: str, name: str) -> Any:
    require(method, name, "tables")
    return import_module(name)


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


def frame_of(table: list[dict[str, Any]] | dict[str, Any], names: list[str]) -> Any:
    """A pandas.DataFrame of rows with some of these columns, or of the columns."""
    return _pandas().DataFrame(table, columns=names)


def rows_of(found: AntiresonanceSet) -> tuple[list[str], list[dict[str, Any]]]:
    """Column names and one row an antiresonance."""
    scores = list(dict.fromkeys(name for table in found.tables.values() for name in table.scores))
    followed = found.followed
    rows: list[dict[str, Any]] = []
    for dof, table in found.tables.items():
        for i, freq in enumerate(table.freq_hz.tolist()):
            row = {"dof": Dofs.cell(dof), "freq_hz": freq, "damping_ratio": float(table.damping_ratio[i])}
            row |= {"std_hz": float(table.std_hz[i])}
            row |= {"source": BY_HAND if table.by_hand[i] else "identified"}
            row |= {name: table.scores[name][i].item() if name in table.scores else None for name in scores}
            if followed:
                row["followed"] = int(followed[dof][i]) if dof in followed else -1
                row["status"] = "new" if row["followed"] == -1 else "followed"
            rows.append(row)
        gone = found.left_out.get(dof, table)
        for i in np.flatnonzero(np.isin(gone.scores.get("why", []), NOT_SEEN)).tolist():
            of_which = {"followed": gone.scores["followed"][i].item(), "status": "not seen"}
            rows.append({"dof": Dofs.cell(dof), "freq_hz": np.nan, "source": "identified", **of_which})
    known = ["dof", "freq_hz", "damping_ratio", "std_hz", "source", *(["status"] if followed else [])]
    return [*known, *scores], rows


def to_xarray(source: Recording | FrequencyResponse | AntiresonanceSet) -> Any:
    """An xarray.Dataset with dofs and time, frequency or rank as coordinates."""
    xr = _xarray()
    dofs = list(source if isinstance(source, AntiresonanceSet) else source.dofs)
    labels = _cells(dofs)
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
    return xr.Dataset(
        data, {"dof": labels, "rank": np.arange(longest)}, {"excitation": Dofs.cell(source.excitation)}
    )


def _cells(labels: Iterable[Any]) -> Any:
    """Whole numbers and text side by side, which numpy would make text; several dofs are text."""
    return np.array(label_array([Dofs.cell(dof) for dof in labels]))


def _instants(rec: Recording) -> Any:
    return np.arange(rec.n_samples) / rec.fs_hz


#: Columns of a table with one row a pair, parameter or hypothesis.
_PAIRS: tuple[str, ...] = ("dof", "a_hz", "b_hz", "difference_hz", "difference_percent")
_PAIRS += ("std_hz", "std_percent", "z", "p", "changed")
_INTERVALS = ("low", "high", "center", "std", "words")
_HYPOTHESES = tuple(each.name for each in fields(Hypothesis))
_ALL_PAIRS = ("excitation", "chi_square", "freedom", "p_all", "alpha")  # what a comparison says of all pairs


def comparison_frame(compared: Comparison) -> Any:
    """A pandas.DataFrame, one row a pair."""
    columns = {name: np.array(getattr(compared, name)) for name in _PAIRS}
    return _pandas().DataFrame(columns | {"dof": _cells(compared.dof)})


def comparison_dataset(compared: Comparison) -> Any:
    """An xarray.Dataset over the pairs."""
    columns = {name: (("pair",), np.array(getattr(compared, name))) for name in _PAIRS if name != "dof"}
    over = {"dof": (("pair",), _cells(compared.dof))}
    return _xarray().Dataset(columns, over, {n: Dofs.cell(getattr(compared, n)) for n in _ALL_PAIRS})


def intervals_frame(found: ParameterIntervals) -> Any:
    """A pandas.DataFrame, one row a parameter."""
    columns = {name: np.array(getattr(found, name)) for name in _INTERVALS}
    return _pandas().DataFrame(columns, index=_pandas().Index(found.names, name="parameter"))


def hypotheses_frame(hypotheses: Hypotheses) -> Any:
    """A pandas.DataFrame, one row a hypothesis."""
    return _pandas().DataFrame({name: [getattr(one, name) for one in hypotheses] for name in _HYPOTHESES})


def tracks_frame(tracks: Tracks) -> Any:
    """A pandas.DataFrame, one row a test and track."""
    events = {(event.test, event.track): event.kind for event in tracks.events}
    change, rows = tracks.change_percent, []
    for test, condition in enumerate(tracks.conditions):
        for i in range(len(tracks)):
            row = {"test": test, "condition": condition, "dof": Dofs.cell(tracks.dof[i]), "track": i}
            row |= {"freq_hz": tracks.freq_hz[test, i], "std_hz": tracks.std_hz[test, i]}
            rows.append(row | {"change_percent": change[test, i], "event": events.get((test, i), "")})
    return _pandas().DataFrame(rows)


def tracks_dataset(tracks: Tracks) -> Any:
    """An xarray.Dataset over test and track."""
    names = ("freq_hz", "std_hz", "change_percent")
    data = {name: (("test", "track"), np.array(getattr(tracks, name))) for name in names}
    over: dict[str, Any] = {"test": np.arange(len(tracks.conditions))}
    over["dof"] = (("track",), _cells(tracks.dof))
    over["condition"] = (("test",), np.array(tracks.conditions))
    return _xarray().Dataset(data, over, {"excitation": Dofs.cell(tracks.excitation)})
