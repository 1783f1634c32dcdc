"""What ``antires look`` shows: a view of a measurement or of a set of antiresonances."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..figures.page_session import RovingHammer, Session, SetView, View
from ..measured.replay import Asked, asked_in
from .command import arguments
from .keys import format_of
from .reading import Call, check_files, hits_of, refuse_beside, several_hits


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    check_files(args)
    first: Path = args.files[0]
    edits: tuple[Asked, ...] = ()
    if args.edits is not None:
        with arguments({"path": "--edits"}):
            edits = asked_in(args.edits)[1]
    if format_of(first.name, args.format) == "antiresonances":
        refuse_beside(args, "antiresonances that are identified already", "Name the measurement to identify.")
        with arguments({"path": "FILE"}):
            zeros, asked = asked_in(first)
        session = Session(zeros, save_to=args.out)
        session.opened(asked, first if args.out is None else None)
    else:
        session = _of_files(args)
    session.make_again(edits)
    return SetView(session, first.name + (f" and {len(args.files) - 1} more" if len(args.files) > 1 else ""))


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
    options = dict(call.sections["identification"])
    order, save_to = options.pop("max_order", None), args.out or f"{args.files[0].stem}_antiresonances.json"
    given = {"excitation": force, "band_hz": args.band_hz, "max_order": order, "options": options}
    with call.blame(("data",)):
        return Session(None, source, **given, save_to=save_to)
