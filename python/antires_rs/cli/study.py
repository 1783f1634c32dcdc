"""``antires demo``, ``identify`` and ``report``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from .measurement import NAMES, edited, files_of, kind_of, measurement, refuse_beside
from .terminal import arguments, existing, new_file, print_json, say

__all__ = ["demo", "identify", "report"]


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
    from ..jobs import read_job
    from ..jobs.measured import measured_of
    from ..jobs.model import model_of

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
        from .setups import of_setups

        return edited(of_setups(args, kind), args)
    from ..identification.identify import identify_antiresonances

    given = measurement(args, kind)
    _reached(args, given.signal)
    say(f"identifying the antiresonances of {len(given.signal.dofs)} responses")
    with arguments(NAMES):
        found = identify_antiresonances(
            given.signal, excitation=given.force, band_hz=args.band, **given.options
        )
    return edited(found, args)


def _reached(args: argparse.Namespace, signal: Any) -> None:
    """Refuse to add what the measurement cannot tell of."""
    from ..signals.band import covered_hz

    low, high = covered_hz(signal)
    for dof, freq_hz, _ in args.add or ():
        if not low <= freq_hz <= high:
            wanted = f"a frequency from {low:g} to {high:g} Hz, as the data reach"
            reject("--add", f"{freq_hz:g} Hz at dof {dof!r}", wanted, "Correct it.")


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
