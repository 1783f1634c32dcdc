"""``antires watch``: the files of a folder, judged as they come."""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from threading import Event

from ..damage.assessor import Assessor
from ..exceptions import AntiresWarning, InvalidInputError, MissingDependencyError, reject
from ..watch.conditions import condition_table
from ..watch.identify_series import identify_series
from ..watch.monitor import Watched, monitor
from ..watch.series import Series
from ..watch.sources import is_measurement, natural
from ..watch.store import LastingStore
from .command import arguments, existing

# -- Files that arrive in a folder: which of them are complete, and a wait for more


#: A file that has not changed for so long is complete.
SETTLED_S = 2.0


class Arrivals:
    """The measurements of a folder, by their names; ``beside`` are files, and folders, that are none."""

    def __init__(self, folder: Path, beside: tuple[Path, ...] = ()) -> None:
        self._folder, self._beside = folder, {path.resolve() for path in beside}
        #: Whether the last look found files that still grow.
        self.growing = False

    @property
    def at_once(self) -> bool:
        """Whether the package that tells of changes is installed."""
        return find_spec("watchdog") is not None

    def complete(self) -> list[Path]:
        """Those that have stopped changing; a test in a folder of its own counts by its latest file."""
        found, self.growing = [], False
        for path in sorted(self._folder.iterdir(), key=natural):
            if not is_measurement(path) or any(one.is_relative_to(path.resolve()) for one in self._beside):
                continue
            try:
                if time.time() - _changed(path) >= SETTLED_S:
                    found.append(path)
                else:
                    self.growing = True
            except FileNotFoundError:  # renamed while it was looked at
                self.growing = True
        return found

    @contextmanager
    def waiting(self) -> Iterator[Callable[[float], None]]:
        """A function that waits for seconds, or less if something changes and watchdog is there."""
        if not self.at_once:
            yield time.sleep
            return
        from watchdog.events import FileSystemEventHandler
        from watchdog.observers import Observer

        changed = Event()

        class Handler(FileSystemEventHandler):
            def on_any_event(self, event: object) -> None:
                changed.set()

        observer = Observer()
        observer.daemon = True
        observer.schedule(Handler(), str(self._folder), recursive=True)
        observer.start()

        def wait(seconds: float) -> None:
            # A file that grows is looked at again when it should be complete.
            if changed.wait(min(seconds, SETTLED_S) if self.growing else seconds):
                changed.clear()
                time.sleep(min(seconds, 0.5 * SETTLED_S))

        try:
            yield wait
        finally:
            observer.stop()


def _changed(path: Path) -> float:
    """When a file, or the latest in a folder, was last changed."""
    inside = [one.stat().st_mtime for one in path.iterdir()] if path.is_dir() else []
    return max([path.stat().st_mtime, *inside])


# -- Names of the tests whose lines were printed, kept over a restart


class Told:
    """A name a line; one that a kill has cut short is told again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
        self._names = set(text.split("\n")[:-1])
        if text and not text.endswith("\n"):
            self._write("\n")

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def add(self, name: str) -> None:
        """One more, for good."""
        self._names.add(name)
        self._write(f"{name}\n")

    def _write(self, text: str) -> None:
        with open(self._path, "a", encoding="utf-8", errors="replace") as file:
            file.write(text)


def watch(args: argparse.Namespace) -> int:
    """Until Ctrl-C, or once."""
    if not args.folder.is_dir():
        reject("FOLDER", repr(str(args.folder)), "a folder that exists", "Make it first.")
    if args.conditions is not None and not args.conditions.is_file():
        reject("--conditions", repr(str(args.conditions)), "a file that exists", "Correct its name.")
    assessor = None
    if args.assessor is not None:
        existing("--assessor", args.assessor, "Name the file that Assessor.save wrote.")
        with arguments({"path": "--assessor"}):
            assessor = Assessor.load(args.assessor)
    args.out.mkdir(parents=True, exist_ok=True)
    arrivals = Arrivals(args.folder, tuple(path for path in (args.out, args.conditions) if path is not None))
    teller = _Teller(args, assessor)
    if not arrivals.at_once:
        every = f"the folder is looked at every {args.every:g} s"
        print(f'{every}; at once with: pip install "antires-rs[watch]"', flush=True)
    judged: list[Path] = []
    try:
        with arrivals.waiting() as wait:
            while True:
                files = arrivals.complete()
                if files and files != judged:
                    series = _identified(files, args, teller)
                    if series is not None:
                        if series.interrupted:
                            return 130
                        judged = files
                        teller.tell(series)
                if args.once and not arrivals.growing:
                    return 0
                wait(args.every)
    except KeyboardInterrupt:
        return 130


def _identified(files: list[Path], args: argparse.Namespace, teller: _Teller) -> Series | None:
    """The series; None while the table of conditions is being written."""
    try:
        return identify_series(
            files,
            excitation=args.excitation,
            band_hz=args.band,
            conditions=condition_table(args.conditions)[0],
            store=LastingStore(args.out / "series.parquet"),
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

    def say_once(self, text: str) -> None:
        """Print, unless that was the last word."""
        if text != self._said:
            print(text, flush=True)
        self._said = text

    def tell(self, series: Series) -> None:
        """Judge all tests, print what is new, write the page."""
        self._said = ""
        count, wanted = len(series), self._args.baseline
        if count < wanted:
            print(f"{count} of {wanted} baseline tests, {len(series.failed)} failed", flush=True)
            return
        with warnings.catch_warnings():
            if self._warned:
                warnings.simplefilter("ignore", AntiresWarning)
            watched = monitor(series, slice(0, wanted), self._args.rate, assessor=self._assessor)
        for i in range(wanted, count):
            if series.names[i] not in self._told:
                print(_line(watched, i), flush=True)
                self._told.add(series.names[i])
        if not self._warned:
            print(str(watched), flush=True)
        self._warned = True
        try:
            watched.report(self._args.out / "watch.html")
        except MissingDependencyError as exc:
            print(f"no page: {exc}", flush=True)


def _line(watched: Watched, test: int) -> str:
    """One test."""
    name = watched.names[test]
    if test in watched.failed:
        return f"{name}: failed, {watched.failed[test]}"
    faults = "".join(f"; sensor fault: dof {one.dof}, {one.text}" for one in watched.faults.get(test, ()))
    if watched.unjudged[test]:
        return f"{name}: not judged{faults}"
    verdict = f"ALARM ({', '.join(watched.why(test))})" if watched.alarm[test] else "no alarm"
    run = next((first for first, last in watched.runs if first <= test <= last), None)
    found = watched.assessments.get(run) if watched.alarm[test] and run is not None else None
    damage = "" if found is None else f"\n  {found.headline}"
    return f"{name}: {verdict}, {watched.statistic[test]:.2f} of the limit{faults}{damage}"
