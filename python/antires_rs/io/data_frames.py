"""Signals and antiresonances for pandas and xarray."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..damage.hypotheses import Hypotheses
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.compare import Comparison
from ..measured.edits import BY_HAND
from ..measured.track import Tracks
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..updating.posterior import ParameterIntervals
from .common import missing_package


def to_dataframe(source: Recording | FrequencyResponse | AntiresonanceSet) -> Any:
    """A pandas.DataFrame: a column a channel over time or frequency, or a row an antiresonance."""
    pd = _pandas()
    if isinstance(source, Recording):
        index = pd.Index(_instants(source), name="time_s")
        frame = pd.DataFrame(
            source.responses.T, index=index, columns=pd.Index(list(source.dofs), dtype=object)
        )
        if source.force is not None:
            frame["force"] = source.force
        return frame
    if isinstance(source, FrequencyResponse):
        return pd.DataFrame(
            source.values.T,
            index=pd.Index(source.freq_hz, name="freq_hz"),
            columns=pd.Index(list(source.dofs), dtype=object),
        )
    names, rows = rows_of(source)
    return frame_of(rows, names)


def frame_of(rows: list[dict[str, Any]], names: list[str]) -> Any:
    """A pandas.DataFrame of rows with some of these columns."""
    return _pandas().DataFrame(rows, columns=names)


def _pandas() -> Any:
    try:
        import pandas as pd
    except ImportError as exc:
        raise missing_package("to_dataframe", "pandas", "tables", exc) from exc
    return pd


def rows_of(found: AntiresonanceSet) -> tuple[list[str], list[dict[str, Any]]]:
    """Column names and one row an antiresonance."""
    scores = list(dict.fromkeys(name for table in found.tables.values() for name in table.scores))
    checked = found.cross_check
    rows = []
    for dof, table in found.tables.items():
        for i, freq in enumerate(table.freq_hz.tolist()):
            row = {
                "dof": dof,
                "freq_hz": freq,
                "damping_ratio": float(table.damping_ratio[i]),
                "std_hz": float(table.std_hz[i]),
                "source": BY_HAND if table.by_hand[i] else "identified",
            }
            row |= {name: table.scores[name][i].item() if name in table.scores else None for name in scores}
            if checked is not None:
                row["confirmed"] = checked.is_confirmed(dof, freq)
            rows.append(row)
    known = ["dof", "freq_hz", "damping_ratio", "std_hz", "source"]
    return [*known, *scores, *([] if checked is None else ["confirmed"])], rows


def to_xarray(source: Recording | FrequencyResponse | AntiresonanceSet) -> Any:
    """An xarray.Dataset with dofs and time, frequency or rank as coordinates."""
    try:
        import xarray as xr
    except ImportError as exc:
        raise missing_package("to_xarray", "xarray", "tables", exc) from exc
    if isinstance(source, Recording):
        labels = _labels(source.dofs)
        data: dict[str, Any] = {"responses": (("dof", "time_s"), np.array(source.responses))}
        if source.force is not None:
            data["force"] = (("time_s",), np.array(source.force))
        return xr.Dataset(data, {"dof": labels, "time_s": _instants(source)}, {"fs_hz": source.fs_hz})
    if isinstance(source, FrequencyResponse):
        labels = _labels(source.dofs)
        data = {
            name: (("dof", "freq_hz"), np.array(getattr(source, name)))
            for name in ("values", "coherence", "std")
            if getattr(source, name) is not None
        }
        # Attributes that netCDF can hold: what is not known is left out.
        known = {"kind": source.kind, "reference": source.reference, "n_averages": source.n_averages}
        return xr.Dataset(
            data,
            {"dof": labels, "freq_hz": np.array(source.freq_hz)},
            {name: value for name, value in known.items() if value is not None},
        )
    labels = _labels(source)
    longest = max(freq.size for freq in source.values())
    padded = {
        name: np.full((len(source), longest), np.nan) for name in ("freq_hz", "damping_ratio", "std_hz")
    }
    for i, dof in enumerate(source):
        for name, column in source.columns(dof).items():
            padded[name][i, : column.size] = column
    return xr.Dataset(
        {name: (("dof", "rank"), rows) for name, rows in padded.items()},
        {"dof": labels, "rank": np.arange(longest)},
        {"excitation": source.excitation},
    )


def _labels(dofs: Any) -> Any:
    """Whole numbers and text side by side, which numpy would make text."""
    labels = np.empty(len(dofs), dtype=object)
    labels[:] = list(dofs)
    return labels


def _instants(rec: Recording) -> Any:
    return np.arange(rec.n_samples) / rec.fs_hz


# -- Comparisons, tracks, hypotheses of damage and intervals for pandas and xarray


#: Columns of a comparison, in the order in which they are read.
COLUMNS = (
    "dof",
    "a_hz",
    "b_hz",
    "difference_hz",
    "difference_percent",
    "std_hz",
    "std_percent",
    "z",
    "p",
    "changed",
)


def comparison_frame(compared: Comparison) -> Any:
    """A pandas.DataFrame, one row a pair."""
    return _pandas_compared().DataFrame({name: np.array(getattr(compared, name)) for name in COLUMNS})


def comparison_dataset(compared: Comparison) -> Any:
    """An xarray.Dataset over the pairs."""
    return _xarray().Dataset(
        {name: (("pair",), np.array(getattr(compared, name))) for name in COLUMNS[1:]},
        {"dof": (("pair",), np.array(compared.dof))},
        {
            "excitation": compared.excitation,
            "chi_square": compared.chi_square,
            "freedom": compared.freedom,
            "p_all": compared.p_all,
            "alpha": compared.alpha,
        },
    )


def intervals_frame(found: ParameterIntervals) -> Any:
    """A pandas.DataFrame, one row a parameter."""
    columns = ("low", "high", "center", "std", "words")
    index = _pandas_compared().Index(found.names, name="parameter")
    return _pandas_compared().DataFrame(
        {name: np.array(getattr(found, name)) for name in columns}, index=index
    )


def tracks_frame(tracks: Tracks) -> Any:
    """A pandas.DataFrame, one row a test and track."""
    told = {(event.test, event.track): event.kind for event in tracks.events}
    change = tracks.change_percent
    return _pandas_compared().DataFrame(
        [
            {
                "test": test,
                "condition": condition,
                "dof": tracks.dof[i],
                "track": i,
                "freq_hz": tracks.freq_hz[test, i],
                "std_hz": tracks.std_hz[test, i],
                "change_percent": change[test, i],
                "event": told.get((test, i), ""),
            }
            for test, condition in enumerate(tracks.conditions)
            for i in range(len(tracks))
        ]
    )


def tracks_dataset(tracks: Tracks) -> Any:
    """An xarray.Dataset over test and track."""
    over = ("test", "track")
    return _xarray().Dataset(
        {name: (over, np.array(getattr(tracks, name))) for name in ("freq_hz", "std_hz", "change_percent")},
        {
            "test": np.arange(len(tracks.conditions)),
            "condition": (("test",), np.array(tracks.conditions)),
            "dof": (("track",), np.array(tracks.dof)),
        },
        {"excitation": tracks.excitation},
    )


def _pandas_compared() -> Any:
    try:
        import pandas as pd
    except ImportError as exc:
        raise missing_package("to_dataframe", "pandas", "tables", exc) from exc
    return pd


def _xarray() -> Any:
    try:
        import xarray as xr
    except ImportError as exc:
        raise missing_package("to_xarray", "xarray", "tables", exc) from exc
    return xr


def hypotheses_frame(hypotheses: Hypotheses) -> Any:
    """A pandas.DataFrame, one row a hypothesis."""
    columns = ("elements", "probability", "severities", "low", "high", "candidate")
    return _pandas_compared().DataFrame(
        {name: [getattr(one, name) for one in hypotheses] for name in columns}
    )
