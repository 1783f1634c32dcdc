"""What ``antires look`` shows: a view of a measurement, of a set of antiresonances, or of a result."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..damage.assess import DamageResult
from ..exceptions import reject
from ..figures.page import ResultView, Table
from ..figures.page_session import Session, SetView, View
from ..figures.report_parts import (
    damage_rows,
    frequency_rows,
    hypothesis_rows,
    largest,
    parameter_rows,
    states,
)
from ..measured.replay import Asked, asked_in
from ..updating.result import UpdateResult
from .command import arguments, say
from .measurement import NAMES, files_of, kind_of, measurement, refuse_beside
from .run import RunFolder, drawings, evidence_in


def view_of(args: argparse.Namespace) -> View:
    """The view that the arguments name."""
    first: Path = args.files[0]
    result = result_file(first)
    if result is not None:
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
        from ..figures.page_session import RovingHammer
        from .measurement import hits_of

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

    from ..io.own_format import TEXT

    try:
        with ZipFile(file) as archive, archive.open(f"{TEXT}.npy") as text:
            return b'"antires_rs.result"' in text.read(300)
    except (OSError, BadZipFile, KeyError, ValueError, NotImplementedError, RuntimeError):
        return False


def _of_job(args: argparse.Namespace) -> Session:
    """The one measurement of a job, with the options and the edits that stand there."""
    from .arguments import model_of
    from .job import read_job
    from .reading import measured_of

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


# -- The page of a result: what its report tells, to be explored


def result_view(file: Path) -> ResultView:
    """The view of a saved result."""
    with arguments(NAMES):
        result = UpdateResult.load(file)
    drawn = drawings(result, evidence_in(RunFolder(file.parent), result))
    figures = [*drawn.figures.values(), *drawn.diagrams.values()]
    return ResultView(file.parent.resolve().name, _answer(result), figures, _tables(result))


def _answer(result: UpdateResult) -> list[str]:
    if isinstance(result, DamageResult):
        return list(result._headline())
    before, after = result.table.largest_before_percent, result.table.largest_after_percent
    return [f"Largest difference: {largest(before)} before, {largest(after)} after."]


def _tables(result: UpdateResult) -> list[Table]:
    tables = []
    if isinstance(result, DamageResult):
        judged = result.has_baseline
        columns = {"name": "Element", "value": "Loss, %"}
        columns |= (
            {"interval": "90 % interval, %", "probability": "Probability, %"}
            if judged
            else {"std": "Error, %"}
        )
        tables.append(
            _table("Stiffness losses", columns | {"visible": "Smallest seen, %"}, damage_rows(result, None))
        )
        found = result.assessment
        if found is not None:
            rows, others = hypothesis_rows(found)
            heads = {"name": "Hypothesis", "probability": "Probability, %", "losses": "Losses"}
            tables.append(_table(f"Hypotheses{f'; {others}' if others else ''}", heads, rows))
    else:
        heads = {"name": "Parameter", "value": "Value", "std": "Error", "change": "Change, %"}
        tables.append(_table("Parameters", heads, parameter_rows(result)))
    first, second = states(result)
    modal = "mode" in (frequency_rows(result) or [{}])[0]
    named = {"mode": "Mode"} if modal else {"dof": "Response", "force": "Force"}
    heads = named | {
        "measured": "Measured, Hz",
        "before": f"{first.capitalize()}, Hz",
        "before_percent": "Difference, %",
        "after": f"{second.capitalize()}, Hz",
        "after_percent": "Difference, %",
    }
    tables.append(_table("Resonances" if modal else "Antiresonances", heads, frequency_rows(result)))
    return tables


def _table(title: str, columns: dict[str, str], rows: list[dict[str, Any]]) -> Table:
    return Table(title, tuple(columns.values()), [[str(row.get(key, "")) for key in columns] for row in rows])
