"""What ``antires look`` shows: a view of a measurement, of a set of antiresonances, or of a result."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..explore.page.commands import SetView
from ..explore.page.session import Session
from ..explore.page.view import View
from ..measured.replay import Asked
from ..measured.replay_file import asked_in
from ..support.validation import reject
from .measurement import NAMES, files_of, kind_of, measurement
from .terminal import arguments, say

__all__ = ["view_of"]


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    first: Path = args.files[0]
    result = result_file(first)
    if result is not None:
        from .looked_result import result_view  # a measurement does not wait for these imports

        return result_view(result)
    files_of(args)
    if first.suffix == ".toml":
        return SetView(_of_job(args), first.name)
    kind = kind_of(args)
    edits = _edits(args)
    if kind == "antiresonances":
        with arguments(NAMES):
            zeros, asked = asked_in(first)
        session = Session(zeros, save_to=args.out)
        session.opened(asked, first if args.out is None else None)
        session.make_again(edits)
        return SetView(session, first.name)
    if args.roving is not None and len(args.files) > 1:
        reject(
            "--roving",
            f"it with {len(args.files)} files",
            "one file, or a set",
            "Join them by 'antires identify --roving ... --out zeros.json', and look at that.",
        )
    given = measurement(args, kind, band_needed=False)
    with arguments(NAMES):
        session = Session(
            None,
            given.signal,
            excitation=given.force,
            band_hz=args.band,
            max_order=args.max_order,
            options={name: value for name, value in given.options.items() if name != "max_order"},
            save_to=args.out or f"{first.stem}_antiresonances.json",
        )
    session.make_again(edits)
    return SetView(session, first.name)


def result_file(path: Path) -> Path | None:
    """The result that a path names: a folder of a run, or its result.npz; None for what is none."""
    inside = path / "result.npz" if path.is_dir() else path
    return inside if inside.name == "result.npz" and inside.is_file() else None


def _of_job(args: argparse.Namespace) -> Session:
    """The one measurement of a job, with the options and the edits that stand there."""
    from ..jobs import read_job
    from ..jobs.measured import measured_of
    from ..jobs.model import model_of

    job = read_job(args.file)
    found = measured_of(job, model_of(job), say)
    if len(found) > 1:
        reject(
            "FILE", f"a job of {len(found)} measurements", "one to look at", "Name the file of one of them."
        )
    one = found[0]
    options = {name: value for name, value in job.section("identification").items() if name != "dofs"}
    session = Session(
        one.found,
        one.signal,
        band_hz=one.table.get("band_hz"),
        max_order=options.pop("max_order", None),
        options=options,
        save_to=args.out or f"{args.file.stem}_antiresonances.json",
    )
    session.make_again(_edits(args))
    return session


def _edits(args: argparse.Namespace) -> tuple[Asked, ...]:
    """Those of a set that was saved."""
    if args.edits is None:
        return ()
    with arguments({"path": "--edits"}):
        return asked_in(args.edits)[1]
