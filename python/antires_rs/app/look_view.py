"""What ``antires look`` shows: a view of a measurement or of a set of antiresonances."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..figures.page_session import RovingHammer, Session, SetView, View
from ..measured.replay import Asked, asked_in
from .arguments import model_of
from .command import arguments
from .job import read_job
from .keys import format_of
from .reading import Call, check_files, hits_of, measured_of, refuse_beside, several_hits


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    first: Path = args.files[0]
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
