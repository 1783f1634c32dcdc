"""What ``antires look`` shows: a view of a measurement, of a set of antiresonances, or of a result."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..figures.page import ResultView
from ..figures.page_session import RovingHammer, Session, SetView, View
from ..figures.report_parts import answer_of, tables_of
from ..measured.replay import Asked, asked_in
from ..updating.result import UpdateResult
from .arguments import model_of
from .command import arguments
from .job import read_job
from .keys import format_of
from .reading import Call, check_files, hits_of, measured_of, refuse_beside, several_hits
from .run import RunFolder, drawings, evidence_in


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    first: Path = args.files[0]
    result = result_file(first)
    if result is not None:
        if len(args.files) > 1:
            got = f"{len(args.files)} of them, with a result"
            reject("FILE", got, "a result alone", "Look at one at a time.")
        refuse_beside(args, "a result", "Leave it out: nothing is identified there.", "out", "edits")
        return result_view(result)
    check_files(args)
    edits: tuple[Asked, ...] = ()
    if args.edits is not None:
        with arguments({"path": "--edits"}):
            edits = asked_in(args.edits)[1]
    if first.suffix == ".toml":
        refuse_beside(args, "a job", "Put it under [data] or [identification] of the job.")
        session = _of_job(args)
    elif format_of(first.name, args.format) == "antiresonances":
        refuse_beside(args, "antiresonances that are identified already", "Name the measurement to identify.")
        with arguments({"path": "FILE"}):
            zeros, asked = asked_in(first)
        session = Session(zeros, save_to=args.out)
        session.opened(asked, first if args.out is None else None)
    else:
        session = _of_files(args)
    session.make_again(edits)
    more = f" and {len(args.files) - 1} more" if len(args.files) > 1 else ""
    return SetView(session, first.name + more)


def _of_files(args: argparse.Namespace) -> Session:
    """Measurements, to be identified as ``antires identify`` does."""
    source: Any
    if several_hits(args):
        hits, call = hits_of(args, band_needed=False)
        source, force = RovingHammer(hits, args.roving), args.roving
    else:
        call = Call(args, band_needed=False)
        one = call.read(args.files)
        source, force = one.signal, one.force
    with call.blame(("data",)):
        return _session(args, call.sections["identification"], None, source, args.band_hz, excitation=force)


def _of_job(args: argparse.Namespace) -> Session:
    """The one measurement of a job, with the options and the edits that stand there."""
    job = read_job(args.files[0])
    found = measured_of(job, model_of(job))
    if len(found) > 1:
        got = f"a job of {len(found)} measurements"
        reject("FILE", got, "one to look at", "Name the file of one of them.")
    (one,) = found
    options = {name: value for name, value in job.sections["identification"].items() if name != "dofs"}
    return _session(args, options, one.found, one.signal, one.table.get("band_hz"))


def _session(
    args: argparse.Namespace, options: dict[str, Any], found: Any, source: Any, band_hz: Any, **more: Any
) -> Session:
    order, others = options.get("max_order"), {k: v for k, v in options.items() if k != "max_order"}
    save_to = args.out or f"{args.files[0].stem}_antiresonances.json"
    more |= {"band_hz": band_hz, "max_order": order, "options": others, "save_to": save_to}
    return Session(found, source, **more)


def result_file(path: Path) -> Path | None:
    """The result that a path names: a folder of a run, or its file; None for what is none."""
    inside = path / "result.npz" if path.is_dir() else path
    return inside if inside.is_file() and inside.name == "result.npz" else None


# -- The page of a result: what its report tells, to be explored


def result_view(file: Path) -> ResultView:
    """The view of a saved result."""
    with arguments({"path": "FILE"}):
        result = UpdateResult.load(file)
    drawn = drawings(result, evidence_in(RunFolder(file.parent), result))
    figures = [*drawn.figures.values(), *drawn.diagrams.values()]
    tables = list(tables_of(result, assumed=True).values())
    return ResultView(file.parent.resolve().name, answer_of(result), figures, tables)
