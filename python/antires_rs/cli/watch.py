"""``antires watch``: the files of a folder, judged as they come."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

from ..exceptions import AntiresWarning, MissingDependencyError
from ..monitoring.monitor import monitor
from ..monitoring.watched import Watched
from ..series.identify_series import identify_series
from ..series.series import Series
from ..support.validation import reject
from .arrivals import Arrivals

__all__ = ["watch"]


def watch(args: argparse.Namespace) -> int:
    """Until Ctrl-C, or once."""
    if not args.folder.is_dir():
        reject("FOLDER", repr(str(args.folder)), "a folder that exists", "Make it first.")
    args.out.mkdir(parents=True, exist_ok=True)
    arrivals = Arrivals(args.folder, () if args.conditions is None else (args.conditions,))
    judged: list[Path] = []
    teller = _Teller(args)
    if not arrivals.at_once:
        every = f"the folder is looked at every {args.every:g} s"
        print(f'{every}; at once with: pip install "antires-rs[watch]"', flush=True)
    try:
        with arrivals.waiting() as wait:
            while True:
                files = arrivals.complete()
                if files and files != judged:
                    series = identify_series(
                        files,
                        excitation=args.excitation,
                        band_hz=args.band,
                        conditions=args.conditions,
                        store=args.out / "series.parquet",
                    )
                    if series.interrupted:
                        return 130
                    judged = files
                    teller.tell(series)
                if args.once and not arrivals.growing:
                    return 0
                wait(args.every)
    except KeyboardInterrupt:
        return 130


class _Teller:
    """What is new since the last time."""

    def __init__(self, args: argparse.Namespace) -> None:
        self._args = args
        self._told: set[str] = set()
        self._warned = False

    def tell(self, series: Series) -> None:
        """Judge all tests, print what is new, write the page."""
        new = [i for i, name in enumerate(series.names) if name not in self._told]
        self._told |= set(series.names)
        count, wanted = len(series), self._args.baseline
        if count < wanted:
            print(f"{count} of {wanted} baseline tests, {len(series.failed)} failed", flush=True)
            return
        with warnings.catch_warnings():
            if self._warned:
                warnings.simplefilter("ignore", AntiresWarning)
            watched = monitor(series, baseline=slice(0, wanted), false_alarm_rate=self._args.rate)
        for i in new:
            if i >= wanted:
                print(_line(watched, i), flush=True)
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
    if watched.statistic[test] != watched.statistic[test]:
        return f"{name}: not judged{faults}"
    verdict = f"ALARM ({', '.join(watched.why(test))})" if watched.alarm[test] else "no alarm"
    return f"{name}: {verdict}, {watched.statistic[test]:.2f} of the limit{faults}"
