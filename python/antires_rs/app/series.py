"""``antires series``: carry out a job of many tests: records, series, files."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import MissingDependencyError, reject
from ..figures.canvas import picture
from ..figures.sets import plot_tracks
from ..io.common import Signal
from ..measured.track import Tracks
from ..support.files import write_atomically
from ..watch.identify_series import identify_series
from ..watch.series import Series
from .command import hint, print_json, say
from .job import Job, read_job
from .keys import FOLDER, FORMATS, IDENTIFICATION, SIGNALS, format_of, shown
from .reading import EDITS, read_signal
from .run import RunFolder, picture_name, write_json

#: Tracks that fewer of the tests have are not drawn, and of more tests than this no events.
LEAST_SHARE, EVENTS_OF = 0.3, 50


@dataclass(frozen=True)
class JobReader:
    """Reads one file of the series, or a folder of one FRF a file, by the keys of [data]."""

    table: Mapping[str, Any]

    def __call__(self, file: Path) -> Signal:
        """The signal of a file."""
        kind = FOLDER if file.is_dir() else format_of(file.name, self.table.get("format"))
        return read_signal(file, kind or "", self.table)


def series(args: argparse.Namespace) -> int:
    """Identify all tests of a job; run again it goes on, and takes in what has come since."""
    job = read_job(args.job)
    if job.task != "series":
        got = f"{str(args.job)!r}, a job for 'antires {job.task}'"
        reject("JOB", got, "a job with [series]", "'antires init --task series' writes one.")
    folder = RunFolder.of(job)
    made = _identified(job, folder.folder, args.workers)
    over = job.sections["series"].get("over")
    columns = (*made.conditions, "times", "names")
    if over is not None and over not in columns:
        wanted = f"one of {', '.join(map(repr, columns))}"
        job.reject(("series", "over"), shown(over), wanted, "Name a column of the conditions.")
    summary = _summary(made)
    write_json(folder.summary, summary)
    note = _draw(made, folder.pictures, over) if job.sections["output"].get("pictures", True) else None
    if args.json:
        print_json(summary)
    else:
        print(made)
        written = sorted(path.name for path in folder.folder.iterdir())
        print(f"\nIn {folder.folder}: {', '.join(written)}")
    if note is not None:
        hint(f"warning: {note}")
    if made.interrupted:
        hint(f"interrupted; go on with: antires series {args.job}")
        return 130
    if made.failed and len(made.failed) == len(made):
        hint(f"no test could be identified; of the first: {next(iter(made.failed.values()))}")
        return 1
    return 0


def _identified(job: Job, folder: Path, workers: int | None) -> Series:
    """The series, kept in the folder of the job."""
    place, table, own = job.data_places[0], job.data[0], job.sections["series"]
    sources = job.file(table["file"])
    job.check_data(place, table)
    if "repeats" in table:
        job.reject((*place, "repeats"), "repeats", "tests of one file each", "Remove it.")
    for key in EDITS.keys() & table:
        job.reject((*place, key), f"{key} for many tests", "edits of one test", "Remove it.")
    formats = [name for name in FORMATS if name in SIGNALS]
    if table.get("format", formats[0]) not in formats:
        wanted = f"a format out of {', '.join(formats)}"
        job.reject((*place, "format"), shown(table["format"]), wanted, "Leave it out: the endings tell.")
    conditions = own.get("conditions")
    if conditions is not None:
        conditions = job.existing(("series", "conditions"), conditions)
    if not sources.is_dir() and "*" not in sources.name:
        job.existing((*place, "file"), table["file"], 'a folder, or a pattern such as "records/*.npz"')
    folder.mkdir(parents=True, exist_ok=True)
    force, dofs = table["excitation"], table.get("dofs")
    if isinstance(dofs, dict) and dofs.get(force, False) is not False:
        force = dofs[force]  # the name of a channel stands for its dof
    say("identifying the series")
    elsewhere = {
        "sources": (*place, "file"),
        "conditions": ("series", "conditions"),
        "workers": ("series", "workers"),
        "store": ("output", "folder"),
        **{key.name: ("identification", key.name) for key in IDENTIFICATION.keys},
    }
    with job.blame(place, elsewhere):
        return identify_series(
            sources,
            excitation=force,
            band_hz=table["band_hz"],
            conditions=conditions,
            store=folder / "series.parquet",
            workers=workers if workers is not None else own.get("workers"),
            reading=JobReader(table),
            **job.sections["identification"],
        )


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


def _draw(series: Series, folder: Path, over: str | None) -> str | None:
    """A picture of the tracks of each response; what is left out is told."""
    if len(series) - len(series.failed) < 2:
        return "no tracks are drawn: fewer than two tests were identified"
    say("drawing the tracks")
    tracks = _lasting(series.tracks(over))
    folder.mkdir(exist_ok=True)
    for dof in dict.fromkeys(tracks.dof.tolist()):
        try:
            drawn = picture(lambda ax, dof=dof: plot_tracks(tracks, dof, ax=ax), (9.0, 5.0))
        except MissingDependencyError as exc:
            return str(exc)
        write_atomically(folder / picture_name(f"tracks_dof_{dof}"), drawn)
    return None


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
