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

__all__ = ["draw", "pictures"]


def draw(job: Job, result: UpdateResult, folder: RunFolder, measured: list[Measured],
         say: Callable[[str], Any]) -> list[str]:
    """Write what the job asks for; what is left out for want of a package is returned as a note."""
    output = job.section("output")
    try:
        if output.get("report", True):
            from ..report import write_report
            say("writing the report")
            write_report(result, folder.report, title=output.get("title"), response=_response(job, measured))
        if output.get("pictures", True):
            say("drawing the pictures")
            folder.pictures.mkdir(exist_ok=True)
            diagrams = {dof: d for m in measured for dof, d in m.found.diagrams.items()}
            pictures(result, folder.pictures, diagrams)
    except MissingDependencyError as exc:
        return [str(exc)]
    return []


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
        return transmissibility(first.signal, dof, nperseg=length, estimator="rank1")
    except UnsuitableDataError:  # a single hit has no averages
        return None
