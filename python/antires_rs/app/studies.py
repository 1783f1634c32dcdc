"""``antires demo``, ``identify`` and ``report``."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..io.registry import conversion
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.files import write_atomically
from ..support.messages import explain as told
from .command import arguments, existing, new_file, print_json, say
from .job import Job, read_job
from .keys import FORMATS, UNSET, format_of, template
from .measurement import NAMES, edited, files_of, kind_of, measurement, refuse_beside
from .run import RunFolder


def demo(args: argparse.Namespace) -> int:
    """The whole study of the eight-mass chain."""
    from . import demo as story

    return story.command(
        args.out, seed=args.seed, noise=args.noise, workers=args.workers, as_json=args.json, say=say
    )


def identify(args: argparse.Namespace) -> int:
    """Antiresonances of a file, or of the [data] of a job."""
    files_of(args)
    out: Path | None = args.out
    new_file("--out", out, ".json")
    found = _of_job(args) if args.file.suffix == ".toml" else [_of_file(args)]
    for i, each in enumerate(found):
        if out is not None:
            each.save(out.with_stem(f"{out.stem}_{i}") if i else out)
        if args.pictures is not None:
            _diagrams(each, args.pictures, f"{i}_" if i else "")
    if args.json:
        print_json([_numbers(each) for each in found] if len(found) > 1 else _numbers(found[0]))
        return 0
    for each in found:
        print(each)
        if each.cross_check is not None:
            print(each.cross_check)
    return 0


def _of_job(args: argparse.Namespace) -> list[AntiresonanceSet]:
    from .arguments import model_of
    from .job import read_job
    from .reading import measured_of

    remedy = "Put it under [data] or [identification] of the job."
    refuse_beside(args, "a job", remedy, "drop", "add")
    job = read_job(args.file)
    return [each.found for each in measured_of(job, model_of(job), say)]


def _of_file(args: argparse.Namespace) -> AntiresonanceSet:
    kind = kind_of(args)
    if kind == "antiresonances":
        refuse_beside(args, "antiresonances that are identified already", "Leave it out.")
        with arguments(NAMES):
            return edited(AntiresonanceSet.load(args.file), args)
    if args.roving is not None and len(args.files) > 1:
        from .measurement import of_setups

        return edited(of_setups(args, kind), args)
    from ..identification.identify import identify_antiresonances
    from ..identification.options import sorted_out

    given = measurement(args, kind)
    _reached(args, given.signal)
    say(f"identifying the antiresonances of {len(given.signal.dofs)} responses")
    with arguments(NAMES):
        found = identify_antiresonances(
            given.signal, excitation=given.force, band_hz=args.band, **sorted_out(given.options)
        )
    return edited(found, args)


def _reached(args: argparse.Namespace, signal: Any) -> None:
    """Refuse to add what the measurement cannot tell of."""
    from ..signals.frequency_response import covered_hz

    low, high = covered_hz(signal)
    for dof, freq_hz, _ in args.add or ():
        if not low <= freq_hz <= high:
            wanted = f"a frequency from {low:g} to {high:g} Hz, as the data reach"
            reject("--add", f"{freq_hz:g} Hz at dof {dof!r}", wanted, "Correct it.")


def _diagrams(found: AntiresonanceSet, folder: Path, prefix: str) -> None:
    from ..figures.canvas import picture
    from ..support.files import write_atomically
    from .run import picture_name

    folder.mkdir(parents=True, exist_ok=True)
    for dof, diagram in found.diagrams.items():
        name = f"dof {dof}" if isinstance(dof, int) else str(dof)
        write_atomically(
            folder / picture_name(f"{prefix}stabilization_{name}"),
            picture(lambda ax, d=diagram: d.plot(ax=ax), (9.0, 5.0)),
        )


def _numbers(found: AntiresonanceSet) -> dict[str, Any]:
    """A set as JSON; null where a value is not known."""

    def plain(values: Any) -> list[float | None]:
        return [float(v) if v == v else None for v in values]

    checked = found.data_check
    rows = [
        {"dof": dof, **{name: plain(column) for name, column in found.columns(dof).items()}} for dof in found
    ]
    return {
        "excitation": found.excitation,
        "antiresonances": rows,
        "data_check": None if checked is None else checked.warnings,
    }


def report(args: argparse.Namespace) -> int:
    """The report of a result."""
    from ..updating.result import UpdateResult
    from .run import RunFolder, drawings, evidence_in, pictures, report as write

    file: Path = args.result / "result.npz" if args.result.is_dir() else args.result
    existing("RESULT", file, "'antires update' and 'antires damage' write result.npz into their folder.")
    out: Path = args.out or file.with_name("report.html")
    new_file("--out", out, ".html", ".htm")
    with arguments({"path": "RESULT"}):
        result = UpdateResult.load(file)
    say("writing the report")
    folder = RunFolder(file.parent)
    drawn = drawings(result, evidence_in(folder, result))
    write(result, out, folder, drawn, args.title)
    written: list[Path] = []
    if args.pictures is not None:
        args.pictures.mkdir(parents=True, exist_ok=True)
        written = pictures(drawn, args.pictures)
    if args.json:
        print_json({"report": str(out), "pictures": [str(file) for file in written]})
    else:
        print("\n".join(f"Wrote {path}" for path in (out, *written)))
    return 0


# -- ``antires explain``: what a warning means


def explain(args: argparse.Namespace) -> int:
    """Print what is known of the names."""
    print(told(*args.names))
    return 0


# -- ``antires init``, ``update``, ``damage`` and ``resume``


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
    from ..io.uff import force_of
    from ..measured.antiresonance_set import AntiresonanceSet
    from .reading import read_signal

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
        args.job = job.path
        return series(args)
    folder = RunFolder.of(job)
    if not folder.unfinished and folder.state not in (None, "searching") and folder.result.is_file():
        from ..updating.result import UpdateResult
        from .run import out_of_time

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
    from .run import run, text_of

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


# -- ``antires series``


def series(args: argparse.Namespace) -> int:
    """Carry out a job of many tests."""
    from .series import run_series

    job = read_job(args.job)
    if job.task != "series":
        got = f"{str(args.job)!r}, a job for 'antires {job.task}'"
        reject("JOB", got, "a job with [series]", "'antires init --task series' writes one.")
    outcome = run_series(job, workers=args.workers, say=say)
    if args.json:
        print_json(outcome.summary)
    else:
        print(outcome.series)
        print(f"\nIn {outcome.folder}: {', '.join(sorted(path.name for path in outcome.folder.iterdir()))}")
    for note in outcome.notes:
        print(f"antires: warning: {note}", file=sys.stderr)
    if outcome.series.interrupted:
        print(f"antires: interrupted; go on with: antires series {args.job}", file=sys.stderr)
        return 130
    failed = outcome.series.failed
    if failed and len(failed) == len(outcome.series):
        first = next(iter(failed.values()))
        said = f"antires: no test could be identified; of the first: {first}"
        print(said, file=sys.stderr)
        return 1
    return 0
