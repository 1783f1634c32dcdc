"""``antires look``: the page is opened at once, and what it shows is read while the browser begins."""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
from typing import Any

from ..exceptions import InvalidInputError
from ..figures.live_canvas import require_bokeh
from ..figures.page import opened
from .command import existing, new_file

COMPLETE = {".json", ".uff", ".unv"}  # files that tell the place of the force, or have none


def look(args: argparse.Namespace) -> int:
    """Serve the page until it is closed."""
    first: Path = args.files[0]
    require_bokeh()
    for file in args.files:
        if file.suffix.lower() == ".toml" or (file / "run.json").is_file():
            got, wanted = f"{str(file)!r}, a job or its results", "a measurement, or antiresonances"
            raise InvalidInputError("FILE", got, wanted, "'antires report' writes the page of a result.")
        if not file.is_dir():
            existing("FILE", file, "Name a measurement, or antiresonances.")
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
