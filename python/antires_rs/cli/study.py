"""``antires demo``, ``identify`` and ``report``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..jobs.formats import FOLDER, FORMATS, format_of
from ..jobs.keys_data import DATA
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from ..support.warned import warn
from ..support.wording import LeftOut, Part
from .terminal import arguments, existing, print_json, say

__all__ = ["demo", "identify", "report"]

#: Options of ``identify`` by the arguments of the functions behind it.
_NAMES = {
    "path": "FILE",
    "files": "FILE",
    "format": "--format",
    "signal": "FILE",
    "source": "FILE",
    "band_hz": "--band",
    "dofs": "--dof",
    "fs_hz": "--fs",
    "df_hz": "--df",
    "pairs": "--pairs",
    "run": "--run",
    "pattern": "--pattern",
    "cross_check": "--cross-check",
    "max_order": "--max-order",
    **{name: f"--{name}" for name in ("excitation", "unit", "force", "kind", "first", "reference", "preset")},
}
_READING = ("kind", "reference", "force", "fs_hz", "unit", "first", "df_hz", "pairs", "of_run", "pattern")
_CHOICES = ("preset", "max_order", "cross_check")
_SEE = "See 'antires identify --help'."


def demo(args: argparse.Namespace) -> int:
    """The whole study of the eight-mass chain."""
    from . import demo as story

    return story.command(
        args.out, seed=args.seed, noise=args.noise, workers=args.workers, as_json=args.json, say=say
    )


def identify(args: argparse.Namespace) -> int:
    """Antiresonances of a file, or of the [data] of a job."""
    for file in args.files:
        if not file.is_dir():
            existing("FILE", file, "Name a measurement, or a job.")
    args.file = args.files[0]
    if len(args.files) > 1:
        _of_one_kind(args.files)
    out: Path | None = args.out
    if out is not None and (out.suffix != ".json" or not out.parent.is_dir()):
        reject(
            "--out",
            repr(str(out)),
            "a file that ends in .json, in a folder that exists",
            "Choose another name.",
        )
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
    from ..jobs import read_job
    from ..jobs.measured import measured_of
    from ..jobs.model import model_of

    for name in ("band", "excitation", "format", "dofs", *_READING, *_CHOICES):
        if getattr(args, name) is not None:
            option = {"dofs": "--dof", "fs_hz": "--fs", "df_hz": "--df", "of_run": "--run"}.get(
                name, "--" + name.replace("_", "-")
            )
            reject(
                option,
                "it beside a job",
                "it with a measurement alone",
                "Put it under [data] or [identification] of the job.",
            )
    job = read_job(args.file)
    return [each.found for each in measured_of(job, model_of(job), say)]


def _of_file(args: argparse.Namespace) -> AntiresonanceSet:
    kind = FOLDER if args.file.is_dir() else format_of(args.file.name, args.format)
    if kind is None:
        reject(
            "FILE",
            repr(str(args.file)),
            "an ending out of " + " ".join(e for ends in FORMATS.values() for e in ends),
            "Say by --format what it is.",
        )
    if kind == "antiresonances":
        with arguments(_NAMES):
            return AntiresonanceSet.load(args.file)
    if args.excitation is None and kind == "uff" and args.reference is None:
        from ..io.uff_force import force_of

        with arguments(_NAMES):
            args.excitation = force_of(args.file)
        if args.excitation is not None:
            say(f"the force is at {args.excitation}, as the file states")
    for name in ("band", "excitation"):
        if getattr(args, name) is None:
            wanted = {
                "band": "--band LOW HIGH, in Hz",
                "excitation": "--excitation DOF, where the force acts",
            }[name]
            reject(f"--{name}", "nothing", wanted, _SEE)
    from ..identification.identify import identify_antiresonances
    from ..jobs.reading import read_signal
    from ..signals.repeats import one_source

    options = {
        name.removeprefix("of_"): getattr(args, name) for name in _READING if getattr(args, name) is not None
    }
    if kind == FOLDER and args.format is not None:
        options["format"] = args.format
    if args.dofs:
        options["dofs"] = dict(args.dofs)
    chosen = {name: getattr(args, name) for name in _CHOICES if getattr(args, name) is not None}
    with arguments(_NAMES):
        signals = []
        for file in args.files:
            say(f"reading {file.name}")
            signals.append(read_signal(file, kind, options, _as_option))
        signal = one_source(signals)
        say(f"identifying the antiresonances of {len(signal.dofs)} responses")
        # A channel that is left out still names the place of the force, which need not be recorded.
        named = options.get("dofs", {}).get(args.excitation, False)
        force = args.excitation if named is False else named
        if force not in signal.dofs and args.excitation not in options.get("dofs", {}):
            _warn_unmeasured(force, signal.dofs)
        return identify_antiresonances(signal, excitation=force, band_hz=args.band, **chosen)


def _of_one_kind(files: list[Path]) -> None:
    """Several files are repeats of one test: measurements of one format."""
    ending = files[0].suffix.lower()
    for file in files:
        if file.suffix.lower() in (".toml", ".json") or file.suffix.lower() != ending:
            reject(
                "FILE",
                repr(str(file)) + " among several",
                "measurements of one format: other impacts or runs of the same test",
                "Name a job or a file of antiresonances alone.",
            )


def _warn_unmeasured(force: Any, dofs: tuple[Any, ...]) -> None:
    """The antiresonances do not depend on the name, so that a slip of the pen would pass in silence."""
    from ..jobs.job import nearest

    hint = nearest(str(force), map(str, dofs))
    warn(
        "force_not_measured",
        f"--excitation: {force!r} is none of the channels {', '.join(map(repr, dofs))}, so that "
        f"the place of the force cannot be tested.{' ' * bool(hint)}{hint}",
    )


def _as_option(part: Part) -> str:
    """An argument of a reader as this command has it; those it lacks a job has."""
    if isinstance(part, LeftOut):
        from ..jobs.reading import LEAVE_OUT

        return LEAVE_OUT
    option = _NAMES.get(part.name)
    if option is None or not option.startswith("--"):
        return f"{part.name} (in a job)" if DATA.key(part.name) else part.name
    return option if part.value is None else f"{option} {part.value}"


def _diagrams(found: AntiresonanceSet, folder: Path, prefix: str) -> None:
    from ..jobs.files import picture_name
    from ..plotting.canvas import picture
    from ..support.files import write_atomically

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
    from ..jobs.drawing import drawings, evidence_in, pictures
    from ..jobs.drawing import report as write
    from ..jobs.files import RunFolder
    from ..updating.results import UpdateResult

    file: Path = args.result / "result.npz" if args.result.is_dir() else args.result
    existing("RESULT", file, "'antires update' and 'antires damage' write result.npz into their folder.")
    out: Path = args.out or file.with_name("report.html")
    if out.suffix not in (".html", ".htm") or not out.parent.is_dir():
        reject(
            "--out",
            repr(str(out)),
            "a file that ends in .html, in a folder that exists",
            "Choose another name.",
        )
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
