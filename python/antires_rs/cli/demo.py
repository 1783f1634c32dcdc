"""``antires demo``: tells the story of the eight-mass chain, and draws it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import MissingDependencyError
from ..signals.recording import Recording
from ..signals.transfer_functions import transmissibility
from ..support.files import write_atomically
from .story import MAX_EVALUATIONS, Story, tell
from .story_tables import summary, text

__all__ = ["command"]

#: Segments of the transmissibilities that are drawn, 16 s.
NPERSEG = 8192


def write_pictures(story: Story, folder: Path) -> None:
    """The paper's pictures, as PNG."""
    from .. import plotting
    from ..plotting.canvas import picture

    case, updated = story.case, story.updated
    table: Any = updated.table  # of antiresonances
    worst = int(table.dof[np.argmax(np.nan_to_num(np.abs(table.before_percent)))])
    neighbour = worst - 1 if worst else 1

    def transmissibilities(axes: Any) -> None:
        for ax, reference, dof in zip(axes, (0, worst), (None, neighbour), strict=True):
            plotting.plot_transmissibility(
                _drawn(story.record, reference),
                case.model,
                updated.model,
                dof=dof,
                excitation=case.excitation,
                band_hz=case.band_hz,
                ax=ax,
            )

    truth = case.truth(1)["severity"]
    for name, png in {
        "stabilization": picture(lambda ax: story.undamaged.diagrams[0].plot(ax=ax), (9.0, 5.2)),
        "transmissibility": picture(transmissibilities, (9.0, 8.0), rows=2),
        "differences": picture(lambda ax: plotting.plot_differences(updated.table, ax=ax), (9.5, 4.6)),
        "damage": picture(lambda ax: plotting.plot_damage(story.damage, ax=ax, truth=truth), (7.0, 4.4)),
        "convergence": picture(lambda ax: plotting.plot_convergence(updated, ax=ax), (9.0, 4.4)),
    }.items():
        write_atomically(folder / f"{name}.png", png)


def write_reports(story: Story, folder: Path) -> None:
    """``updating.html`` and ``damage.html``."""
    from ..report import write_report

    write_report(
        story.updated,
        folder / "updating.html",
        title="antires demo: the updated model",
        response=_drawn(story.record, 0),
    )
    write_report(
        story.damage,
        folder / "damage.html",
        title="antires demo: the damaged spring",
        truth=story.case.truth(1)["severity"],
        diagrams={0: story.damaged.diagrams[0]},
    )


def _drawn(record: Recording, reference: int) -> Any:
    return transmissibility(record, reference, nperseg=NPERSEG, estimator="rank1")


def command(
    out: Path, *, seed: int, noise: float, workers: int | None, as_json: bool, say: Callable[[str], Any] = str
) -> int:
    """What ``antires demo`` does; returns its exit code."""
    out.mkdir(parents=True, exist_ok=True)
    story = tell(seed=seed, noise=noise, workers=workers, max_evaluations=MAX_EVALUATIONS, say=say)
    numbers = json.dumps(summary(story), indent=1, allow_nan=False) + "\n"
    write_atomically(out / "summary.json", numbers.encode("utf-8"))
    print(numbers if as_json else text(story), end="" if as_json else "\n")
    missing = ""
    try:
        say("drawing pictures and writing reports")
        write_pictures(story, out)
        write_reports(story, out)
    except MissingDependencyError as exc:
        missing = str(exc)
    closing = [
        f"Open {out / 'damage.html'} (where the damage is) and {out / 'updating.html'} (the model).",
        f"The pictures are beside them as PNG, all numbers in {out / 'summary.json'}.",
    ]
    if missing:
        closing = [f"All numbers are in {out / 'summary.json'}. Not everything was drawn:", missing]
    print("", *closing, sep="\n", file=sys.stderr if as_json else sys.stdout)
    return 0
