"""``antires look``: the page is opened at once, and what it shows is read while the browser begins.

Of a result it is the report.
"""

from __future__ import annotations

import argparse
import webbrowser
from importlib import import_module
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..figures.live_canvas import require_bokeh
from ..figures.page import opened
from .command import existing, new_file

COMPLETE = {".json", ".toml", ".uff", ".unv"}  # files that tell the place of the force, or have none


def look(args: argparse.Namespace) -> int:
    """Serve the page until it is closed, or open the report of a result."""
    first: Path = args.files[0]
    inside = first / "result.npz" if first.is_dir() else first
    if inside.name == "result.npz" and inside.is_file():
        return _result(args, inside)
    require_bokeh()
    for file in args.files:
        if not file.is_dir():
            existing("FILE", file, "Name a measurement, antiresonances or a result.")
    new_file("--out", args.out, ".json")
    if args.edits is not None:
        existing("--edits", args.edits, "Name a set that was saved.")
    at_once = args.excitation is None and first.suffix.lower() not in COMPLETE

    def made() -> Any:
        # Imported here: the page is being opened meanwhile.
        return import_module(f"{__package__}.look_view").view_of(args)

    view = made() if at_once else None  # which will say what is missing, if anything is

    opened(
        lambda: view or made(),
        first.name,
        wait=True,
        browser=not args.no_browser,
        say=lambda line: print(line, flush=True),
    )
    return 0


def _result(args: argparse.Namespace, file: Path) -> int:
    """Open the report beside a result; it is written where there is none."""
    from .reading import refuse_beside
    from .studies import write_report_of

    if len(args.files) > 1:
        got = f"{len(args.files)} of them, with a result"
        reject("FILE", got, "a result alone", "Look at one at a time.")
    refuse_beside(args, "a result", "Leave it out: nothing is identified there.", "out", "edits")
    report = file.with_name("report.html").resolve()
    if not report.is_file():
        write_report_of(file, report)
    print(f"looking at {report.as_uri()}")
    if not (args.no_browser or webbrowser.open(report.as_uri())):
        print("No browser was found; open that address.")
    return 0
