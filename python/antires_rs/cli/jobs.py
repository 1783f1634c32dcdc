"""``antires init``, ``update``, ``damage`` and ``resume``."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from ..io.other_programs import conversion
from ..jobs import Job, read_job, template
from ..jobs.files import RunFolder
from ..jobs.formats import FORMATS, format_of
from ..jobs.values import UNSET
from ..support.files import write_atomically
from ..support.validation import reject
from .terminal import arguments, existing, print_json, say

__all__ = ["init", "resume", "search"]


def init(args: argparse.Namespace) -> int:
    """Write a commented job."""
    job: Path = args.job
    if job.suffix != ".toml":
        reject(
            "JOB",
            repr(str(job)),
            "a file that ends in .toml",
            f"As in 'antires init {job.stem or 'job'}.toml'.",
        )
    if job.exists() and not args.overwrite:
        reject(
            "JOB", f"{str(job)!r}, which exists", "a new file", "Choose another name, or pass --overwrite."
        )
    if not job.parent.is_dir():
        reject("JOB", repr(str(job)), "a file in a folder that exists", f"Make {str(job.parent)!r} first.")
    options: dict[str, Any] = {}
    if args.data is not None:
        options = {"data": Path(os.path.relpath(args.data, job.parent)).as_posix()} | _channels(args.data)
    text = template(args.task, args.model, name=job.name, **options)
    write_atomically(job, text.encode())
    what = ' Put dofs in place of each "?", and fill in the rest' if f'"{UNSET}"' in text else " Fill it in"
    print(f"Wrote {job}.{what}, then: antires {args.task} {job}")
    return 0


def _channels(file: Path) -> dict[str, Any]:
    """Channels of a measurement and its force, without dofs: numbers would be valid, and mostly wrong."""
    existing("--data", file, "Name the file of the measurement.")
    kind = format_of(file.name)
    if kind is None:
        reject(
            "--data",
            repr(str(file)),
            "a file that ends in " + ", ".join(e for ends in FORMATS.values() for e in ends),
            "Convert it first, or write the job without --data and name its format there."
            + conversion(file.name),
        )
    from ..io.uff_force import force_of
    from ..jobs.reading import read_signal
    from ..measured.antiresonance_set import AntiresonanceSet

    with arguments({"path": "--data"}):
        if kind == "antiresonances":
            found = AntiresonanceSet.load(file)
            force, names = found.excitation, list(found)
        else:
            force = force_of(file) if kind == "uff" else None
            names = list(read_signal(file, kind, {}).dofs)
    dofs: dict[str, object] = {str(name): UNSET for name in names}
    if force is not None and not isinstance(force, int):
        dofs.setdefault(str(force), UNSET)
    if all(isinstance(name, int) for name in names):  # the file knows them already
        return {"excitation": UNSET if force is None else str(force)} if kind != "antiresonances" else {}
    return {"dofs": dofs, "excitation": UNSET if force is None else str(force)}


def search(args: argparse.Namespace) -> int:
    """Carry out a job."""
    job = read_job(args.job)
    if job.task != args.task:
        sections = {"damage": "[damage]", "update": "[[parameters]]", "series": "[series]"}
        reject(
            "JOB",
            f"{str(args.job)!r}, which has {sections[job.task]}",
            f"a job with {sections[args.task]}",
            f"Use 'antires {job.task} {args.job}'.",
        )
    return _run(job, args, fresh=args.fresh)


def resume(args: argparse.Namespace) -> int:
    """Go on with a job."""
    job = read_job(_job_of(args.target))
    if job.task == "series":
        from .series import series

        args.job = job.path
        return series(args)
    folder = RunFolder.of(job)
    if not folder.unfinished and folder.state not in (None, "searching") and folder.result.is_file():
        from ..jobs.run import out_of_time
        from ..updating.results import UpdateResult

        done = UpdateResult.load(folder.result)
        interrupted = folder.state == "interrupted"
        if interrupted and job.section("damage").get("baseline"):
            reject(
                "JOB",
                f"{str(args.target)!r}, whose assessment was interrupted",
                "a search that is kept on disk",
                f"Begin anew with 'antires {job.task} {_shown(job.path)}': with a baseline it takes seconds "
                "and keeps no checkpoint.",
            )
        if interrupted or out_of_time(done):
            how = "was interrupted" if interrupted else "ran out of time"
            reject(
                "JOB",
                f"{str(args.target)!r}, whose search {how} and kept no checkpoint",
                "a search that is kept on disk",
                f"Begin anew with 'antires {job.task} "
                f"{_shown(job.path)}', and checkpoint = true under [search].",
            )
        print(f"antires: this search has finished ({done.status}); nothing is left to do", file=sys.stderr)
        if job.section("output").get("report", True) and not folder.report.exists():
            print(f"antires: for its report: antires report {_shown(folder.folder)}", file=sys.stderr)
        if args.json:
            print(folder.summary.read_text(encoding="utf-8"), end="")
        else:
            print(done.summary())
        return 0
    return _run(job, args, resume=True)


def _job_of(target: Path) -> Path:
    """The job file: itself, or that of a results folder or checkpoint."""
    if target.suffix == ".toml":
        return target
    folder = RunFolder(target if target.is_dir() else target.parent)
    record = folder.read_record()
    if not record or "job" not in record:
        what = "where no job has run" if target.exists() else "which does not exist"
        reject(
            "JOB",
            f"{str(target)!r}, {what}",
            "a job file, its results folder or its checkpoint",
            "The folder of a run holds run.json.",
        )
    job = folder.job_path(record)
    if not job.is_file():
        reject(
            "JOB",
            f"{str(target)!r}, whose job {job.name!r} is gone",
            "a run whose job file is where it was",
            "Put the job file back, or pass it by its new name.",
        )
    return job


def _run(job: Job, args: argparse.Namespace, **how: bool) -> int:
    from ..jobs.run import run
    from ..jobs.summary import text_of

    outcome = run(job, workers=args.workers, say=say, **how)
    if args.json:
        print_json(outcome.summary)
    else:
        print(text_of(outcome.result))
        written = sorted(path.name for path in outcome.folder.folder.iterdir())
        print(f"\nIn {_shown(outcome.folder.folder)}: {', '.join(written)}")
    for note in outcome.notes:
        print(f"antires: warning: {note}", file=sys.stderr)
    if outcome.interrupted:
        waits = outcome.folder.unfinished
        print(
            "antires: interrupted, the best so far is kept; "
            + (
                f"go on with: antires resume {_shown(job.path)}"
                if waits
                else f"begin anew with: antires {job.task} {_shown(job.path)}"
                if job.section("damage").get("baseline")
                else "without a checkpoint"
            ),
            file=sys.stderr,
        )
        return 130
    if outcome.folder.unfinished:
        print(f"antires: out of time; go on with: antires resume {_shown(job.path)}", file=sys.stderr)
    return 0


def _shown(path: Path) -> str:
    """A path as the user would write it."""
    relative = os.path.relpath(path)
    return relative if not relative.startswith("..") else str(path)
