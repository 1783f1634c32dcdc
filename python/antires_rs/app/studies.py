"""``antires init``, ``identify``, ``report``, ``explain``, ``update``, ``damage`` and ``resume``."""

from __future__ import annotations

import argparse
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import InvalidInputError, reject
from ..figures.canvas import picture
from ..io.matrix_files import read_matrices
from ..io.registry import CONVERT
from ..io.uff import force_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.matrix_model import MatrixModel
from ..support.files import write_atomically
from ..support.messages import explain as entries
from ..updating.result import UpdateResult
from . import run as runs
from .arguments import model_of
from .command import arguments, existing, hint, new_file, say, show
from .job import read_job
from .keys import HEADINGS, MATRICES, MODELS, READING, SIGNAL_ENDINGS, UNSET, format_of, template
from .parser import printable
from .reading import Call, check_files, identified, measured_of, modes_in, read_of, read_signal, refuse_beside
from .run import RunFolder


def identify(args: argparse.Namespace) -> int:
    """Antiresonances of a file, or of the [data] of a job."""
    check_files(args)
    out: Path | None = args.out
    new_file("--out", out, ".json")
    file: Path = args.files[0]
    if file.suffix == ".toml":
        refuse_beside(args, "a job", "Put it under [data] or [identification] of the job.", "drop", "add")
        job = read_job(file)
        model = model_of(job)
        if args.modes:
            found: list[Any] = [each.modes() for each in read_of(job, model)]
        else:
            found = [each.found for each in measured_of(job, model)]
    else:
        if format_of(file.name, args.format) == "antiresonances":
            refuse_beside(args, "antiresonances that are identified already", "Leave it out.")
        found = [modes_in(args) if args.modes else identified(args)]
    for i, each in enumerate(found):
        if out is not None:
            each.save(out.with_stem(f"{out.stem}_{i}") if i else out)
        if args.pictures is not None:
            _draw_diagrams(each, args.pictures, f"{i}_" if i else "")
    numbers = [(_modes if args.modes else _numbers)(each) for each in found]
    show(args.json, numbers if len(found) > 1 else numbers[0], "\n".join(map(str, found)))
    return 0


def _draw_diagrams(found: AntiresonanceSet | ModalSet, folder: Path, prefix: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    diagrams = {"modes": found.diagram} if isinstance(found, ModalSet) else found.diagrams
    for dof, diagram in diagrams.items():
        name = f"dof {dof}" if isinstance(dof, int) else str(dof)
        file = folder / runs.picture_name(f"{prefix}stabilization_{name}")
        write_atomically(file, picture(lambda ax, d=diagram: d.plot(ax=ax), (9.0, 5.0)))


def _numbers(found: AntiresonanceSet) -> dict[str, Any]:
    """A set as JSON; null where a value is not known."""
    rows: list[dict[str, Any]] = []
    for dof in found:
        columns = found.columns(dof).items()
        rows.append({"dof": dof, **{name: list(map(runs.number, column)) for name, column in columns}})
    checked = None if found.data_check is None else found.data_check.warnings
    return {"excitation": found.excitation, "antiresonances": rows, "data_check": checked}


def _modes(found: ModalSet) -> dict[str, Any]:
    """Modes as JSON, the shapes by their real and imaginary parts."""
    parts = {"real": np.real(found.shapes).tolist(), "imaginary": np.imag(found.shapes).tolist()}
    damping: Any = found.damping_ratio
    rows = runs.rows_of(freq_hz=found.freq_hz.tolist(), damping_ratio=damping.tolist(), **parts)
    return {"dofs": list(found.dofs), "modes": rows}


def report(args: argparse.Namespace) -> int:
    """The report of a result."""
    file: Path = args.result / "result.npz" if args.result.is_dir() else args.result
    existing("RESULT", file, "'antires update' and 'antires damage' write result.npz into their folder.")
    out: Path = args.out or file.with_name("report.html")
    new_file("--out", out, ".html", ".htm")
    with arguments({"path": "RESULT"}):
        result = UpdateResult.load(file)
    say("writing the report")
    folder = RunFolder(file.parent)
    beside = runs.beside_of(folder, result, folder.read_record())
    drawn = runs.drawings(result, runs.evidence_in(folder, result), beside)
    runs.report(result, out, folder, drawn, args.title)
    written: list[Path] = []
    if args.pictures is not None:
        args.pictures.mkdir(parents=True, exist_ok=True)
        written = runs.pictures(drawn, args.pictures)
    numbers = {"report": str(out), "pictures": [str(file) for file in written]}
    show(args.json, numbers, "\n".join(f"Wrote {path}" for path in (out, *written)))
    return 0


def explain(args: argparse.Namespace) -> int:
    """What is known of the names of warnings."""
    print(entries(*args.names))
    return 0


def init(args: argparse.Namespace) -> int:
    """Write a commented job."""
    job: Path = args.job
    if job.exists() and not args.overwrite:
        got, remedy = f"{str(job)!r}, which exists", "Choose another name, or pass --overwrite."
        reject("JOB", got, "a new file", remedy)
    new_file("JOB", job, ".toml")
    kind, known = args.model, None
    options: dict[str, Any] = {"band_hz": args.band}
    if kind not in MODELS:
        existing("--model", Path(kind), f"Give {', '.join(MODELS)}, or the .npz of 'antires model'.")
        with arguments({"path": "--model"}):
            known = read_matrices(kind)
        options["model_file"], kind = _from(job, kind), MATRICES
    if args.data is not None:
        own = {key.name: getattr(args, key.name) for key in READING}
        reading = {name: value for name, value in own.items() if value is not None}
        options |= {"data": _from(job, args.data), "reading": reading}
        options |= _channels(args.data, known, reading)
        if args.points is not None:  # these find the channels
            existing("--points", args.points, "Name the table of the points.")
            options["reading"] = reading | {"points": _from(job, args.points)}
            options["channels"] = []
    if args.excitation is not None:
        options["excitation"] = str(args.excitation)
    if args.baseline is not None:
        options["baseline"] = _from(
            job, existing("--baseline", args.baseline, "Name the intact measurement.")
        )
    text = template(args.task, kind, name=job.name, **options)
    write_atomically(job, text.encode())
    what = ' Put dofs in place of each "?", and fill in the rest, then:' if f'"{UNSET}"' in text else ""
    if not what:
        what = " Now:" if known and args.band and args.excitation else " Fill it in, then:"
    print(f"Wrote {job}.{what} antires {args.task} {job}")
    return 0


def _from(job: Path, file: str | Path) -> str:
    """A file as a job names it."""
    return Path(os.path.relpath(file, job.parent)).as_posix()


def _channels(file: Path, model: MatrixModel | None, reading: dict[str, Any]) -> dict[str, Any]:
    """Channels of a measurement and its force, without dofs: numbers would be valid, and mostly wrong.

    What a model knows by its name needs none.
    """
    existing("--data", file, "Name the file of the measurement.")
    kind = format_of(file.name, reading.get("format"))
    if kind is None:
        wanted = f"a file that ends in {' '.join(SIGNAL_ENDINGS)}"
        remedy = f"Say by --format if it is one of these; {CONVERT}"
        reject("--data", repr(str(file)), wanted, remedy)
    with arguments({"path": "--data"}):
        if kind == "antiresonances":
            found = AntiresonanceSet.load(file)
            force, names = found.excitation, list(found if found.order == 1 else found.channels)
        else:
            force = force_of(file) if kind == "uff" else None
            names = list(read_signal(file, kind, reading, Call.spelled).dofs)
    known = all(isinstance(name, int) for name in names)  # the file has dofs already
    if known and kind == "antiresonances":
        return {}
    options: dict[str, Any] = {"excitation": UNSET if force is None else str(force)}
    if not known:
        channels = [str(name) for name in names]
        if force is not None and not isinstance(force, int):
            channels.append(str(force))
        options["channels"] = [name for name in dict.fromkeys(channels) if not _has(model, name)]
    return options


def _has(model: MatrixModel | None, name: str) -> bool:
    with suppress(InvalidInputError):
        return model is not None and model.dof(name) >= 0
    return False


# -- ``antires update``, ``damage`` and ``resume``


def search(args: argparse.Namespace) -> int:
    """Carry out a job."""
    job = read_job(args.job)
    if job.task != args.command:
        got = f"{str(args.job)!r}, which has {HEADINGS[job.task]}"
        reject("JOB", got, f"a job with {HEADINGS[args.command]}", f"Use 'antires {job.task} {args.job}'.")
    return runs.run(job, args, fresh=args.fresh)


def resume(args: argparse.Namespace) -> int:
    """Go on with a job."""
    job = read_job(args.job)
    if job.task == "series":
        from .watch import series

        return series(args)
    folder = RunFolder.of(job)
    state = folder.read_record().get("state")  # None where no run has begun
    if folder.unfinished or state in (None, "searching") or not folder.result.is_file():
        return runs.run(job, args, resume=True)
    done = UpdateResult.load(folder.result)
    if state != "interrupted" and not runs.out_of_time(done):
        hint(f"this search has finished ({done.status}); nothing is left to do")
        if job.sections["output"].get("report", True) and not folder.report.exists():
            hint(f"for its report: antires report {runs.near(folder.folder)}")
        text = folder.summary.read_text(encoding="utf-8") if args.json else f"{done.summary()}\n"
        print(printable(text), end="")
        return 0
    got = f"{str(args.job)!r}, whose run was stopped and kept no checkpoint"
    remedy = f"Begin anew with 'antires {job.task} {runs.near(job.path)}'; a search, where there is no "
    remedy += "baseline, keeps one by checkpoint = true under [search]."
    reject("JOB", got, "a search that is kept on disk", remedy)
