"""Comparisons, tracks, hypotheses of damage and intervals for pandas and xarray."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..damage.hypotheses import Hypotheses
from ..measured.compare import Comparison
from ..measured.tracks import Tracks
from ..updating.parameter_intervals import ParameterIntervals
from ._common import missing_package

__all__ = [
    "comparison_dataset",
    "comparison_frame",
    "hypotheses_frame",
    "intervals_frame",
    "tracks_dataset",
    "tracks_frame",
]

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
    return _pandas().DataFrame({name: np.array(getattr(compared, name)) for name in COLUMNS})


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
    index = _pandas().Index(found.names, name="parameter")
    return _pandas().DataFrame({name: np.array(getattr(found, name)) for name in columns}, index=index)


def tracks_frame(tracks: Tracks) -> Any:
    """A pandas.DataFrame, one row a test and track."""
    told = {(event.test, event.track): event.kind for event in tracks.events}
    change = tracks.change_percent
    return _pandas().DataFrame(
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


def _pandas() -> Any:
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
    return _pandas().DataFrame({name: [getattr(one, name) for one in hypotheses] for name in columns})
