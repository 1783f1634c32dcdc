"""Report and pictures of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .._files import write_atomically
from ..exceptions import MissingDependencyError, UnsuitableDataError
from ..results import DamageResult, UpdateResult
from ..signals import FrequencyResponse, Recording
from .files import RunFolder
from .job import Job
from .measured import Measured

__all__ = ["draw", "origin_of", "pictures"]


def draw(job: Job, result: UpdateResult, folder: RunFolder, measured: list[Measured],
         say: Callable[[str], Any]) -> list[str]:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.section("output")
    try:
        if output.get("report", True):
            from ..report import write_report
            say("writing the report")
            write_report(result, folder.report, title=output.get("title"),
                         response=_response(job, measured), origin=origin_of(folder))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            diagrams = {dof: d for m in measured for dof, d in m.found.diagrams.items()}
            pictures(result, folder.pictures, diagrams)
    except MissingDependencyError as exc:
        return [str(exc)]
    return []


def origin_of(folder: RunFolder) -> dict[str, str | list[str]]:
    """What repeats the run of a folder, for its report; empty where no job ran."""
    record = folder.read_record() or {}
    if not {"job", "task", "inputs"} <= record.keys():
        return {}
    name = Path(record["job"]).name
    return {"Repeat with": f"antires {record['task']} {name}",
            "Files, SHA-256": [f"{file}  {digest}" for file, digest in record["inputs"].items()]}


def pictures(result: UpdateResult, folder: Path, diagrams: Mapping[Any, Any]) -> list[Path]:
    """Write every picture of a result as PNG; returns the files."""
    from .. import plotting
    from ..plotting.canvas import picture
    written = {"differences": picture(lambda ax: plotting.plot_differences(result.table, ax=ax), (9.5, 4.6)),
               "convergence": picture(lambda ax: plotting.plot_convergence(result, ax=ax), (9.0, 4.4))}
    if isinstance(result, DamageResult):
        width = max(7.0, 0.32 * len(result.x) + 1.5)
        written["damage"] = picture(lambda ax: plotting.plot_damage(result, ax=ax), (width, 4.4))
    for dof, diagram in diagrams.items():
        written[f"stabilization_{dof}"] = picture(lambda ax, d=diagram: d.plot(ax=ax), (9.0, 5.2))
    return [write_atomically(folder / f"{name}.png", png) for name, png in written.items()]


def _response(job: Job, measured: list[Measured]) -> FrequencyResponse | None:
    """Transmissibilities over the first response that has antiresonances, where they can be had."""
    first = measured[0]
    if isinstance(first.signal, FrequencyResponse):
        return first.signal if first.signal.kind == "transmissibility" else None
    dof = next((dof for dof, values in first.found.items() if values.size), None)
    if not isinstance(first.signal, Recording) or dof is None or first.signal.n_channels < 2:
        return None
    from ..segment_length import choose_nperseg
    from ..spectra import transmissibility
    try:
        length = job.section("identification").get("nperseg") or choose_nperseg(
            first.signal, job.data[0]["band_hz"])
        whole = transmissibility(first.signal, dof, nperseg=length, estimator="rank1")
    except UnsuitableDataError:  # a single hit has no averages
        return None
    low, high = job.data[0]["band_hz"]
    keep = (whole.freq_hz >= low) & (whole.freq_hz <= high)
    return FrequencyResponse(whole.freq_hz[keep], whole.values[:, keep], whole.dofs, whole.kind, dof)
