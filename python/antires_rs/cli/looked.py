"""What ``antires look`` shows: a view of a measurement, of a set of antiresonances, or of a result."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..explore.page.commands import SetView
from ..explore.page.session import Session
from ..explore.page.view import View
from ..measured.replay import Asked
from ..measured.replay_file import asked_in
from ..support.validation import reject
from .measurement import NAMES, files_of, kind_of, measurement, refuse_beside
from .terminal import arguments, say

__all__ = ["view_of"]


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    first: Path = args.files[0]
    result = result_file(first)
    if result is not None:
        from .looked_result import result_view  # a measurement does not wait for these imports

        if len(args.files) > 1:
            reject(
                "FILE",
                f"{len(args.files)} of them, with a result",
                "a result alone",
                "Look at one at a time.",
            )
        refuse_beside(args, "a result", "Leave it out: nothing is identified there.", "out", "edits")
        return result_view(result)
    files_of(args)
    if first.suffix == ".toml":
        refuse_beside(args, "a job", "Put it under [data] or [identification] of the job.")
        return SetView(_of_job(args), first.name)
    kind = kind_of(args)
    edits = _edits(args)
    if kind == "antiresonances":
        refuse_beside(args, "antiresonances that are identified already", "Name the measurement to identify.")
        with arguments(NAMES):
            zeros, asked = asked_in(first)
        session = Session(zeros, save_to=args.out)
        session.opened(asked, first if args.out is None else None)
        session.make_again(edits)
        return SetView(session, first.name)
    session = _of_files(args, kind)
    session.make_again(edits)
    return SetView(
        session, first.name if len(args.files) == 1 else f"{first.name} and {len(args.files) - 1} more"
    )


def _of_files(args: argparse.Namespace, kind: str) -> Session:
    """Measurements, to be identified as ``antires identify`` does."""
    source: Any
    if args.roving is not None and len(args.files) > 1:
        from ..explore.page.roving import RovingHammer
        from .setups import hits_of

        hits, options = hits_of(args, kind, band_needed=False)
        source, force = RovingHammer(hits, args.roving), args.roving
    else:
        given = measurement(args, kind, band_needed=False)
        source, force, options = given.signal, given.force, given.options
    with arguments(NAMES):
        return Session(
            None,
            source,
            excitation=force,
            band_hz=args.band,
            max_order=args.max_order,
            options={name: value for name, value in options.items() if name != "max_order"},
            save_to=args.out or f"{args.files[0].stem}_antiresonances.json",
        )


def result_file(path: Path) -> Path | None:
    """The result that a path names: a folder of a run, or its file; None for what is none."""
    inside = path / "result.npz" if path.is_dir() else path
    if not inside.is_file() or inside.suffix != ".npz":
        return None
    return inside if inside.name == "result.npz" or _says_result(inside) else None


def _says_result(file: Path) -> bool:
    """Whether a file under another name begins as a result does."""
    from zipfile import BadZipFile, ZipFile

    from ..io.npz import TEXT

    try:
        with ZipFile(file) as archive, archive.open(f"{TEXT}.npy") as text:
            return b'"antires_rs.result"' in text.read(300)
    except (OSError, BadZipFile, KeyError, ValueError, NotImplementedError, RuntimeError):
        return False


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
