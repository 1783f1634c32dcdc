"""Report and pictures of a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..exceptions import MissingDependencyError, UnsuitableDataError
from ..report.facts import named_diagrams
from ..report.figures import Drawings, drawings_of
from ..support.files import write_atomically
from ..support.warned import warn
from ..updating.results import UpdateResult
from .evidence import Evidence
from .files import RunFolder, picture_name
from .job import Job

__all__ = ["draw", "drawings", "evidence_in", "origin_of", "pictures", "report"]


def draw(
    job: Job, result: UpdateResult, folder: RunFolder, evidence: Evidence, say: Callable[[str], Any]
) -> list[str]:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.section("output")
    try:
        drawn = drawings(result, evidence)
        if output.get("report", True):
            say("writing the report")
            report(result, folder.report, folder, drawn, output.get("title"))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            pictures(drawn, folder.pictures)
    except MissingDependencyError as exc:
        return [str(exc)]
    return []


def drawings(result: UpdateResult, evidence: Evidence) -> Drawings:
    """Pictures for the report and the folder, each drawn once."""
    sets, model = result.problem.measured, result.problem.model
    shown = (
        named_diagrams(evidence.diagrams, [each.excitation for each in sets], model)
        if any(evidence.diagrams)
        else None
    )
    return drawings_of(result, evidence.response, diagrams=shown)


def report(result: UpdateResult, file: Path, folder: RunFolder, drawn: Drawings, title: str | None) -> None:
    """Write the report of a result with what its folder knows of the run."""
    from ..report import write_report

    record = folder.read_record() or {}
    sets = result.problem.measured
    about = record.get("measurement")
    write_report(
        result,
        file,
        title=title or record.get("title"),
        origin=origin_of(folder),
        measurement=about if about and len(about) == len(sets) else None,
        warnings=record.get("warnings"),
        baseline=record.get("baseline"),
        drawn=drawn,
    )


def evidence_in(folder: RunFolder, result: UpdateResult) -> Evidence:
    """What the run of a folder kept beside its result; nothing where no job ran or the file is damaged."""
    if not folder.evidence.is_file():
        return Evidence()
    try:
        kept = Evidence.load(folder.evidence)
    except UnsuitableDataError as exc:
        warn("report_without_diagrams", f"the report has no diagrams: {exc}")
        return Evidence()
    return kept if len(kept.diagrams) == len(result.problem.measured) else Evidence()


def origin_of(folder: RunFolder) -> dict[str, str | list[str]]:
    """What repeats the run of a folder, for its report; empty where no job ran."""
    record = folder.read_record() or {}
    if not {"job", "task", "inputs"} <= record.keys():
        return {}
    name = Path(record["job"]).name
    made = ", ".join(f"{what} {version}" for what, version in record.get("versions", {}).items())
    return {
        "Repeat with": [f"antires {record['task']} {name}", "in the folder of that file"],
        "Files, SHA-256": [f"{file}  {digest}" for file, digest in record["inputs"].items()],
        "Run with": made,
    }


def pictures(drawn: Drawings, folder: Path) -> list[Path]:
    """Write every picture as PNG; returns the files."""
    named = {**drawn.figures, **{f"stabilization_{name}": one for name, one in drawn.diagrams.items()}}
    return [write_atomically(folder / picture_name(name), one.png) for name, one in named.items()]
