"""Many tests: ``antires series`` carries out a job of them, ``antires watch`` judges files as they come."""

from __future__ import annotations

import argparse
import re
import time
import warnings
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..damage.assess import Assessor
from ..exceptions import AntiresWarning, InvalidInputError, MissingDependencyError, reject
from ..figures.canvas import picture
from ..figures.sets import plot_tracks
from ..io.common import Signal
from ..io.options import ENDINGS
from ..io.registry import natural
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.track import Tracks
from ..signals.alignment import align
from ..signals.recording import Recording
from ..support.files import write_atomically
from ..watch.conditions import condition_table
from ..watch.identify_series import identify_series
from ..watch.monitor import LEAST, Watched, monitor
from ..watch.series import Series
from ..watch.sources import is_measurement
from ..watch.store import LastingStore
from .command import arguments, existing, hint, say, show
from .job import Job, Spell, read_job
from .keys import FOLDER, format_of, shown
from .parser import printable
from .reading import EDITS, OPTIONS, Call, places_of, read_signal
from .run import RunFolder, picture_name, write_json

_OF_A_FILE = re.compile(r"^\w+: got '[^']*', ")  # what an error of a file begins with, which its line names
LEAST_SHARE = 0.3  # tracks that fewer of the tests have are not drawn


@dataclass(frozen=True)
class JobReader:
    """Reads one file of the series, or a folder of one FRF a file, by the keys of [data]."""

    table: Mapping[str, Any]
    #: How an argument of a reader is written in messages.
    spell: Spell = field(default=Job.spelled, repr=False)

    def __call__(self, file: Path) -> Signal:
        """The signal of a file."""
        kind = FOLDER if file.is_dir() else format_of(file.name, self.table.get("format"))
        signal = read_signal(file, kind or "", self.table, self.spell)
        return align([signal]) if self.table.get("align") and isinstance(signal, Recording) else signal


def series(args: argparse.Namespace) -> int:
    """Identify all tests of a job; run again it goes on, and takes in what has come since."""
    job = read_job(args.job)
    if job.task != "series":
        got = f"{str(args.job)!r}, a job for 'antires {job.task}'"
        reject("JOB", got, "a job with [series]", "'antires init --task series' writes one.")
    folder = RunFolder.of(job)
    made = _series_of(job, folder.folder, args.workers)
    over = job.sections["series"].get("over")
    columns = (*made.conditions, "times", "names")
    if over is not None and over not in columns:
        wanted = f"one of {', '.join(map(repr, columns))}"
        job.reject(("series", "over"), shown(over), wanted, "Name a column of the conditions.")
    summary = _summary(made)
    write_json(folder.summary, summary)
    note = _draw(made, folder.pictures, over) if job.sections["output"].get("pictures", True) else None
    show(args.json, summary, f"{made}\n\nIn {folder.folder}: {folder.contents}")
    if note is not None:
        hint(f"warning: {note}")
    if made.interrupted:
        hint(f"interrupted; go on with: antires series {args.job}")
        return 130
    if made.failed and len(made.failed) == len(made):
        hint(f"no test could be identified; of the first: {next(iter(made.failed.values()))}")
        return 1
    return 0


def _series_of(job: Job, folder: Path, workers: int | None) -> Series:
    """The series, kept in the folder of the job."""
    place, table, own = job.data_places[0], job.data[0], job.sections["series"]
    sources = job.file(table["file"])
    job.check_data(place, table)
    for key in ("repeats", *EDITS):
        if key in table:
            job.reject((*place, key), f"{key} for many tests", "what all tests have alike", "Remove it.")
    if "format" in table:
        job.one_of((*place, "format"), table["format"], ENDINGS, "Leave it out: the endings tell.")
    conditions = own.get("conditions")
    if conditions is not None:
        conditions = job.existing(("series", "conditions"), conditions)
    if not sources.is_dir() and "*" not in sources.name:
        job.existing((*place, "file"), table["file"], 'a folder, or a pattern such as "records/*.npz"')
    folder.mkdir(parents=True, exist_ok=True)
    say("identifying the series")
    elsewhere: Any = {"sources": (*place, "file"), "store": ("output", "folder"), **OPTIONS}
    elsewhere |= {name: ("series", name) for name in ("conditions", "workers")}
    with job.blame(place, elsewhere):
        return identify_series(
            sources,
            excitation=_named_dof(table["excitation"], table.get("dofs")),
            band_hz=table["band_hz"],
            conditions=conditions,
            store=folder / "series.parquet",
            workers=workers if workers is not None else own.get("workers"),
            reading=JobReader(table),
            **job.sections["identification"],
        )


def _named_dof(given: Any, dofs: Any) -> Any:
    """The dofs of the forces, for which the names of their channels stand."""
    names = dofs if isinstance(dofs, dict) else {}
    forces = places_of(given, names)
    named = [names[force] if names.get(force, False) is not False else force for force in forces]
    return named[0] if len(named) == 1 else named


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
    kept = np.flatnonzero(np.sum(~np.isnan(tracks.freq_hz), axis=0) >= LEAST_SHARE * len(tracks.conditions))
    freq_hz, std_hz = tracks.freq_hz[:, kept], tracks.std_hz[:, kept]
    return replace(tracks, dof=tracks.dof[kept], freq_hz=freq_hz, std_hz=std_hz, events=())


# -- Files that arrive in a folder: which of them are complete

SETTLED_S = 2.0  # a file that has not changed for so long is complete


class Arrivals:
    """The measurements of a folder, by their names; ``beside`` are files, and folders, that are none."""

    def __init__(self, folder: Path, beside: tuple[Path, ...] = ()) -> None:
        self._folder, self._beside = folder, {path.resolve() for path in beside}
        self.growing = False  # whether the last look found files that still grow

    def complete(self) -> list[Path]:
        """Those that have stopped changing; a test in a folder of its own counts by its latest file."""
        found, self.growing = [], False
        for path in sorted(self._folder.iterdir(), key=natural):
            if not is_measurement(path) or any(one.is_relative_to(path.resolve()) for one in self._beside):
                continue
            try:
                inside = path.iterdir() if path.is_dir() else ()
                # A clock that is ahead dates files in the future.
                if abs(time.time() - max(one.stat().st_mtime for one in (path, *inside))) >= SETTLED_S:
                    found.append(path)
                    continue
            except OSError as exc:
                # Renamed while it was looked at; or what will never be read, which is told.
                if path.is_symlink() or not isinstance(exc, FileNotFoundError):
                    found.append(path)
                    continue
            self.growing = True
        return found


# -- Names of the tests whose lines were printed, kept over a restart


class Told:
    """A name a line; one that a kill has cut short is told again."""

    def __init__(self, path: Path) -> None:
        text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
        *names, self._torn = text.split("\n")
        self._path, self._names = path, set(names)

    def tell(self, name: str, line: str) -> None:
        """Print the line of a test once, for good."""
        if name in self._names:
            return
        print(printable(line), flush=True)
        self._names.add(name)
        with open(self._path, "a", encoding="utf-8", errors="replace") as file:
            file.write(f"\n{name}\n" if self._torn else f"{name}\n")
        self._torn = ""


def watch(args: argparse.Namespace) -> int:
    """Until Ctrl-C, or once."""
    if not args.folder.is_dir():
        got, remedy = f"{str(args.folder)!r}, which does not exist", "Make it first."
        if args.folder.is_file():
            got = f"{str(args.folder)!r}, which is a file"
            remedy = f"Name its folder, {str(args.folder.parent)!r}; 'antires identify' takes files."
        reject("FOLDER", got, "the folder in which measurements arrive", remedy)
    if args.conditions is not None:
        existing("--conditions", args.conditions, "Correct its name.")
    assessor = None
    if args.assessor is not None:
        existing("--assessor", args.assessor, "Name the file that Assessor.save wrote.")
        with arguments({"path": "--assessor"}):
            assessor = Assessor.load(args.assessor)
    args.out.mkdir(parents=True, exist_ok=True)
    call = Call(args)
    arrivals = Arrivals(args.folder, tuple(path for path in (args.out, args.conditions) if path is not None))
    teller = _Teller(args, assessor)
    judged: list[Path] = []
    try:
        while True:
            files = arrivals.complete()
            if files and files != judged:
                series = _identified(files, args, call, teller)
                if series is not None:
                    if series.interrupted:
                        return 130
                    judged = files
                    teller.tell(series)
            if args.once and not arrivals.growing:
                return 1 if teller.without_baseline else 0
            # a file that grows is looked at again when it should be complete.
            time.sleep(min(args.every, SETTLED_S) if arrivals.growing else args.every)
    except KeyboardInterrupt:
        return 130


def _identified(files: list[Path], args: argparse.Namespace, call: Call, teller: _Teller) -> Series | None:
    """The series; None while the table of conditions is being written."""
    reading = dict(call.data[0])
    force, band_hz = reading.pop("excitation"), reading.pop("band_hz")
    try:
        with call.blame(("data",)):
            return identify_series(
                files,
                excitation=_named_dof(force, reading.get("dofs")),
                band_hz=band_hz,
                conditions=condition_table(args.conditions)[0],
                store=LastingStore(args.out / "series.parquet"),
                reading=JobReader(reading, call.spelled) if reading else None,
                **call.sections["identification"],
            )
    except (InvalidInputError, FileNotFoundError, UnicodeDecodeError) as exc:
        about = isinstance(exc, InvalidInputError) and str(exc.argument).startswith("conditions")
        if args.once or args.conditions is None or (isinstance(exc, InvalidInputError) and not about):
            raise
        teller.say_once(f"--conditions cannot be used as it is and is read again at the next look: {exc}")
        return None


class _Teller:
    """What is new since the last time."""

    def __init__(self, args: argparse.Namespace, assessor: Assessor | None) -> None:
        self._args, self._assessor = args, assessor
        self._told = Told(args.out / "told.txt")
        self._warned = False
        self._said = ""
        self.without_baseline = False  # too many of its tests failed

    def say_once(self, text: str) -> None:
        """Print, unless that was the last word."""
        if text != self._said:
            print(printable(text), flush=True)
        self._said = text

    def tell(self, series: Series) -> None:
        """Judge all tests, print what is new, write the page."""
        count, wanted = len(series), self._args.baseline
        for i, why in series.failed.items():
            if min(i, count - 1) < wanted:
                self._told.tell(series.names[i], _line_of(series.names[i], f"failed, {why}"))
        if count < wanted:
            lack = f"{wanted - count} more are needed, or give --baseline N, at least {LEAST}"
            print(f"{count} of {wanted} baseline tests, {len(series.failed)} failed; {lack}", flush=True)
            return
        failed = [i for i in series.failed if i < wanted]
        self.without_baseline = wanted - len(failed) < LEAST
        if self.without_baseline:
            why = _OF_A_FILE.sub("", series.failed[failed[0]])
            self.say_once(
                f"{len(failed)} of {wanted} baseline files not read or identified; "
                f"{series.names[failed[0]]}: {why}"
            )
            return
        with warnings.catch_warnings():
            if self._warned:
                warnings.simplefilter("ignore", AntiresWarning)
            watched = monitor(series, slice(0, wanted), self._args.rate, assessor=self._assessor)
        rates = Counter(_rate_hz(one) for one in series.sets[:wanted])
        for i in range(wanted, count):
            found = series.sets[i]
            unfit = [] if found is None or found.data_check is None else found.data_check.cautions
            rate, usual = _rate_hz(found), rates.most_common(1)[0][0]
            if rate and usual and abs(rate - usual) > 1e-3 * usual:
                unfit.insert(0, f"{rate:g} Hz, the baseline has {usual:g} Hz")
            self._told.tell(series.names[i], _line(watched, i, unfit))
        if not self._warned:
            print(printable(watched), flush=True)
        self._warned = True
        try:
            watched.report(self._args.out / "watch.html")
        except MissingDependencyError as exc:
            print(f"no page: {exc}", flush=True)


def _line_of(name: str, what: str) -> str:
    """The line of a test; a line end in the name of its file makes no other."""
    return f"{name!r}: {what}" if "\n" in name else f"{name}: {what}"


def _rate_hz(found: AntiresonanceSet | None) -> float:
    """The sampling rate of a test; 0 where it is not known."""
    return 0.0 if found is None else float(found.options.get("fs_hz", 0.0))


def _line(watched: Watched, test: int, unfit: Iterable[str]) -> str:
    """One test, and why its data are ``unfit`` to be judged."""
    name = watched.names[test]
    if test in watched.failed:
        return _line_of(name, f"failed, {watched.failed[test]}")
    faults = "".join(f"; sensor fault: dof {one.dof}, {one.text}" for one in watched.faults.get(test, ()))
    faults += "".join(f"; {why}" for why in unfit)
    if watched.unjudged[test]:
        return _line_of(name, f"not judged{faults}")
    verdict = f"ALARM ({', '.join(watched.why(test))})" if watched.alarm[test] else "no alarm"
    run = next((first for first, last in watched.runs if first <= test <= last), None)
    found = watched.assessments.get(run) if watched.alarm[test] and run is not None else None
    damage = "" if found is None else f"\n  {found.headline}"
    return _line_of(name, f"{verdict}, {watched.statistic[test]:.2f} of the limit{faults}{damage}")
