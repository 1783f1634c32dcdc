"""Carry out a job of many tests: records, series, files."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import MissingDependencyError
from ..figures.canvas import picture
from ..figures.sets import plot_tracks
from ..io.common import Signal
from ..measured.track import Tracks
from ..support.files import write_atomically
from ..watch.identify_series import identify_series
from ..watch.series import Series
from .job import Job
from .keys import FOLDER, FORMATS, IDENTIFICATION, SIGNALS, format_of, shown
from .reading import KEYS, read_signal
from .run import RunFolder, picture_name

#: Tracks that fewer of the tests have are not drawn, and of more tests than this no events.
LEAST_SHARE, EVENTS_OF = 0.3, 50
_OPTIONS = {key.name: ("identification", key.name) for key in IDENTIFICATION.keys}


@dataclass(frozen=True)
class JobReader:
    """Reads one file of the series by the keys of [data]."""

    table: Mapping[str, Any]

    def __call__(self, file: Path) -> Signal:
        """The signal of a file, or of a folder of one FRF a file."""
        kind = FOLDER if file.is_dir() else format_of(file.name, self.table.get("format"))
        return read_signal(file, kind or "", dict(self.table))


@dataclass(frozen=True)
class SeriesOutcome:
    """What a job of many tests came to: the series, its folder, a summary, and what was not drawn."""

    series: Series
    folder: Path
    summary: dict[str, Any]
    notes: tuple[str, ...]


def run_series(job: Job, *, workers: int | None = None, say: Callable[[str], Any] = str) -> SeriesOutcome:
    """Identify all tests of a job; the same job run again goes on, and takes in what has come since."""
    place, table, own = job.data_places[0], job.data[0], job.section("series")
    sources = job.file(table["file"])
    for key in ("excitation", "band_hz"):
        if key not in table:
            job.missing(place, key)
    if "repeats" in table:
        job.reject((*place, "repeats"), "repeats", "tests of one file each", "Remove it.")
    for key in KEYS.keys() & table:
        job.reject((*place, key), f"{key} for many tests", "edits of one test", "Remove it.")
    if "format" in table and table["format"] not in FORMATS.keys() & set(SIGNALS):
        wanted = f"a format out of {', '.join(name for name in FORMATS if name in SIGNALS)}"
        job.reject((*place, "format"), shown(table["format"]), wanted, "Leave it out: the endings tell.")
    options = dict(job.section("identification"))
    conditions = own.get("conditions")
    if conditions is not None:
        conditions = job.existing(("series", "conditions"), conditions)
    folder = RunFolder.of(job).folder
    if not sources.is_dir() and "*" not in sources.name:
        job.existing((*place, "file"), table["file"], 'a folder, or a pattern such as "records/*.npz"')
    folder.mkdir(parents=True, exist_ok=True)
    say("identifying the series")
    elsewhere = {
        "sources": (*place, "file"),
        "conditions": ("series", "conditions"),
        "workers": ("series", "workers"),
        "store": ("output", "folder"),
        **_OPTIONS,
    }
    with job.blame(place, elsewhere):
        series = identify_series(
            sources,
            excitation=_force(table),
            band_hz=table["band_hz"],
            conditions=conditions,
            store=folder / "series.parquet",
            workers=workers if workers is not None else own.get("workers"),
            reading=JobReader(table),
            **options,
        )
    over = own.get("over")
    if over is not None and over not in (*series.conditions, "times", "names"):
        known = ", ".join(map(repr, (*series.conditions, "times", "names")))
        job.reject(("series", "over"), shown(over), f"one of {known}", "Name a column of the conditions.")
    summary = _summary(series)
    write_atomically(folder / "summary.json", (json.dumps(summary, indent=1) + "\n").encode())
    notes = _drawn(series, folder, over, say) if job.section("output").get("pictures", True) else ()
    return SeriesOutcome(series, folder, summary, notes)


def _force(table: Mapping[str, Any]) -> Any:
    """The dof of the force; the name of a channel stands for its dof."""
    force, dofs = table["excitation"], table.get("dofs")
    if isinstance(dofs, dict) and dofs.get(force, False) is not False:
        return dofs[force]
    return force


def _summary(series: Series) -> dict[str, Any]:
    """The series in numbers that JSON knows."""

    def span(column: Any) -> list[float] | None:
        known = column[~np.isnan(column)]
        return [float(known.min()), float(known.max())] if known.size else None

    return {
        "tests": len(series),
        "identified": len(series) - len(series.failed),
        "failed": {series.names[i]: why for i, why in series.failed.items()},
        "excitation": series.excitation,
        "dofs": list(series.dofs),
        "conditions": {name: span(column) for name, column in series.conditions.items()},
        "interrupted": series.interrupted,
    }


def _drawn(series: Series, folder: Path, over: str | None, say: Callable[[str], Any]) -> tuple[str, ...]:
    """A picture of the tracks of each response; what is left out is told."""
    if len(series) - len(series.failed) < 2:
        return ("no tracks are drawn: fewer than two tests were identified",)
    say("drawing the tracks")
    tracks = _lasting(series.tracks(over))
    pictures = folder / "pictures"
    pictures.mkdir(exist_ok=True)
    for dof in dict.fromkeys(tracks.dof.tolist()):
        try:
            drawn = picture(lambda ax, dof=dof: plot_tracks(tracks, dof, ax=ax), (9.0, 5.0))
        except MissingDependencyError as exc:
            return (str(exc),)
        write_atomically(pictures / picture_name(f"tracks_dof_{dof}"), drawn)
    return ()


def _lasting(tracks: Tracks) -> Tracks:
    """The tracks that a picture shows."""
    seen = np.sum(~np.isnan(tracks.freq_hz), axis=0)
    kept = np.flatnonzero(seen >= LEAST_SHARE * len(tracks.conditions))
    rank = {int(track): i for i, track in enumerate(kept)}
    events = tracks.events if len(tracks.conditions) <= EVENTS_OF else ()
    return replace(
        tracks,
        dof=tracks.dof[kept],
        freq_hz=tracks.freq_hz[:, kept],
        std_hz=tracks.std_hz[:, kept],
        events=tuple(replace(one, track=rank[one.track]) for one in events if one.track in rank),
    )
