"""Report and pictures of a run."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .._files import write_atomically
from ..exceptions import AntiresWarning, MissingDependencyError, UnsuitableDataError
from ..results import DamageResult, UpdateResult
from .evidence import Evidence
from .files import RunFolder
from .job import Job

__all__ = ["draw", "evidence_in", "origin_of", "pictures", "report"]


def draw(job: Job, result: UpdateResult, folder: RunFolder, evidence: Evidence,
         say: Callable[[str], Any]) -> list[str]:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.section("output")
    try:
        if output.get("report", True):
            say("writing the report")
            report(result, folder.report, folder, evidence, output.get("title"))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            pictures(result, folder.pictures, evidence)
    except MissingDependencyError as exc:
        return [str(exc)]
    return []


def report(result: UpdateResult, file: Path, folder: RunFolder, evidence: Evidence,
           title: str | None) -> None:
    """Write the report of a result with what its folder knows of the run."""
    from ..report import write_report
    from ..report.facts import named_diagrams
    record = folder.read_record() or {}
    sets = result.problem.measured
    about = record.get("measurement")
    shown = named_diagrams(evidence.diagrams, [each.excitation for each in sets], result.problem.model
                           ) if any(evidence.diagrams) else None
    write_report(result, file, title=title or record.get("title"), origin=origin_of(folder),
                 measurement=about if about and len(about) == len(sets) else None,
                 response=evidence.response, warnings=record.get("warnings"), diagrams=shown)


def evidence_in(folder: RunFolder, result: UpdateResult) -> Evidence:
    """What the run of a folder kept beside its result; nothing where no job ran or the file is damaged."""
    if not folder.evidence.is_file():
        return Evidence()
    try:
        kept = Evidence.load(folder.evidence)
    except UnsuitableDataError as exc:
        warnings.warn(f"the report has no diagrams: {exc}", AntiresWarning, stacklevel=2)
        return Evidence()
    return kept if len(kept.diagrams) == len(result.problem.measured) else Evidence()


def origin_of(folder: RunFolder) -> dict[str, str | list[str]]:
    """What repeats the run of a folder, for its report; empty where no job ran."""
    record = folder.read_record() or {}
    if not {"job", "task", "inputs"} <= record.keys():
        return {}
    name = Path(record["job"]).name
    made = ", ".join(f"{what} {version}" for what, version in record.get("versions", {}).items())
    return {"Repeat with": [f"antires {record['task']} {name}", "in the folder of that file"],
            "Files, SHA-256": [f"{file}  {digest}" for file, digest in record["inputs"].items()],
            "Run with": made}


def pictures(result: UpdateResult, folder: Path, evidence: Evidence) -> list[Path]:
    """Write every picture of a result as PNG; returns the files."""
    from .. import plotting
    from ..plotting.canvas import picture
    from ..report.figures import model_picture
    written = {"differences": picture(lambda ax: plotting.plot_differences(result.table, ax=ax), (9.5, 4.6)),
               "convergence": picture(lambda ax: plotting.plot_convergence(result, ax=ax), (9.0, 4.4))}
    if isinstance(result, DamageResult):
        width = max(7.0, 0.32 * len(result.x) + 1.5)
        written["damage"] = picture(lambda ax: plotting.plot_damage(result, ax=ax), (width, 4.4))
    drawn = model_picture(result)
    if drawn is not None:
        written["model"] = picture(lambda ax: drawn[0](ax=ax), drawn[1])
    for i, table in enumerate(evidence.diagrams):
        for dof, diagram in table.items():
            name = f"stabilization_{f'{i + 1}_' if i else ''}{dof}"
            written[name] = picture(lambda ax, d=diagram: d.plot(ax=ax), (9.0, 5.2))
    return [write_atomically(folder / f"{name}.png", png) for name, png in written.items()]
