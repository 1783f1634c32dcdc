"""Signals and antiresonances for pandas and xarray."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.edits import BY_HAND
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ._common import missing_package

__all__ = ["frame_of", "rows_of", "to_dataframe", "to_xarray"]


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
