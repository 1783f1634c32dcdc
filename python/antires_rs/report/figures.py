"""The pictures of a result, each drawn once, with the sentences that stand under it and in place of it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.result import DamageResult
from ..damage.supersets import without_idle
from ..explore.result import result_figures
from ..explore.stabilization import stabilization_figure
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..plotting import (
    plot_chain,
    plot_convergence,
    plot_damage,
    plot_differences,
    plot_frame,
    plot_hypotheses,
    plot_responses,
    plot_transmissibility,
)
from ..plotting.canvas import picture
from ..plotting.responses import MOST_RESPONSES
from .facts import dof_name, named_diagrams
from .live import library, packed

if TYPE_CHECKING:
    from ..order_sweep.diagram import StabilizationDiagram
    from ..signals.frequency_response import FrequencyResponse
    from ..updating.results import UpdateResult

__all__ = ["Drawings", "Figure", "drawings_of", "fitting", "largest", "states"]

#: Colours kept: lines and their soft edges need no more, and a third of the bytes is left.
COLOURS_KEPT = 128
#: Pictures and figures together, so that a report stays below 3 MB: diagrams beyond are left out.
MOST_BYTES = 2_750_000

Draw = Callable[..., Any]


@dataclass(frozen=True)
class Figure:
    """One picture, drawn when first asked for; what stands under it, and what is read out in its place."""

    draw: Draw
    size_in: tuple[float, float]
    caption: str
    alt: str
    explore: Callable[[], Any] | None = None

    @cached_property
    def live(self) -> str:
        """As a figure to be explored, packed; empty where there is none, or nothing that makes it."""
        return packed(self.explore) if self.explore is not None else ""

    @cached_property
    def png(self) -> bytes:
        """As a file of its own."""
        return picture(lambda ax: self.draw(ax=ax), self.size_in)

    @cached_property
    def uri(self) -> str:
        """As it stands in a page, in few colours."""
        return "data:image/png;base64," + b64encode(_small(self.png)).decode("ascii")


@dataclass(frozen=True)
class Drawings:
    """All pictures of a result: by name, and the stabilization diagrams by that of their response."""

    figures: Mapping[str, Figure]
    diagrams: Mapping[Any, Figure]


def drawings_of(
    result: UpdateResult,
    response: FrequencyResponse | None = None,
    truth: Mapping[int, float] | None = None,
    diagrams: Mapping[Any, StabilizationDiagram] | None = None,
) -> Drawings:
    """Pictures of a result; ``diagrams`` are by default those that its measured sets carry."""
    modal = result.problem.objective == "modal"
    shown = _carried(result) if diagrams is None else diagrams
    live = cache(partial(result_figures, result, response, truth))
    figures = _figures(result, response, truth)
    return Drawings(
        {name: replace(one, explore=partial(_one_of, live, name)) for name, one in figures.items()},
        {name: _diagram(name, diagram, modal) for name, diagram in shown.items()},
    )


def _one_of(live: Callable[[], dict[str, Any]], name: str) -> Any:
    return live().get(name)


def fitting(drawn: Drawings, room: int = MOST_BYTES) -> tuple[list[tuple[Figure, str]], int]:
    """Diagrams for which a page has room, each with its packed figure, and how many were left out.

    What is no diagram comes first; pictures of all come before figures to be explored.
    """
    room -= len(library()) + sum(len(one.uri) + len(one.live) for one in drawn.figures.values())
    kept: list[Figure] = []
    for one in drawn.diagrams.values():
        room -= len(one.uri)
        if room < 0:
            break
        kept.append(one)
    shown = []
    for one in kept:
        fits = room > 0 and len(one.live) <= room
        room -= len(one.live) if fits else 0
        shown.append((one, one.live if fits else ""))
    return shown, len(drawn.diagrams) - len(kept)


def _carried(result: UpdateResult) -> dict[Any, StabilizationDiagram]:
    """Diagrams that the measured sets carry, by the name of the response."""
    problem = result.problem
    sets = problem.measured
    if problem.objective == "modal":
        return {i: each.diagram for i, each in enumerate(sets) if each.diagram is not None}
    return named_diagrams([each.diagrams for each in sets], [each.excitation for each in sets], problem.model)


def _figures(
    result: UpdateResult, response: FrequencyResponse | None, truth: Mapping[int, float] | None
) -> dict[str, Figure]:
    """All pictures but the diagrams, by name."""
    problem, names = result.problem, states(result)
    what = "resonance" if problem.objective == "modal" else "antiresonance"
    figures: dict[str, Figure] = {}
    if isinstance(result, DamageResult):
        figures |= _damage(result, truth)
    drawn = _model_picture(result)
    if drawn is not None:
        figures["model"] = Figure(*drawn)
    table = result.table
    figures["differences"] = Figure(
        lambda ax: plot_differences(table, ax=ax, names=names),
        (9.5, 4.6),
        f"Difference of each {what} to the measured one, {names[0]} and {names[1]}.",
        f"Bar chart of {table.measured_hz.size} differences, given in the table above: the largest is "
        f"{largest(table.largest_before_percent)} {names[0]} and {largest(table.largest_after_percent)} "
        f"{names[1]}",
    )
    if response is not None:
        figures["response"] = _response(result, response, names)
    history = result.history
    if history.cost.size:  # nothing is searched against a baseline
        figures["convergence"] = Figure(
            partial(plot_convergence, result),
            (9.0, 4.2),
            "The search: best objective of each island.",
            f"Curves by evaluations of the best objective of {history.cost.shape[1]} islands, from "
            f"{history.cost[0].min():.4g} to {history.cost[-1].min():.4g}",
        )
    return figures


def _response(result: UpdateResult, response: FrequencyResponse, names: tuple[str, str]) -> Figure:
    """Measured curves beside those of the models."""
    model, force = result.problem.model, result.problem.measured[0].excitation
    if response.kind == "frf":
        dofs = [dof for dof in response.dofs if dof in result.problem.measured[0]] or list(response.dofs)
        shown = dofs[:MOST_RESPONSES]
        some = "" if len(shown) == len(response.dofs) else f"The first {len(shown)}. "
        return Figure(
            lambda ax: plot_responses(
                response, model, result.model, excitation=force, dofs=shown, ax=ax, names=names
            ),
            (9.0, 2.0 + 1.2 * len(shown)),
            f"FRFs of the responses; the dips are their antiresonances. {some}The depth of the dips in the "
            "models follows from an assumed damping of 1 %.",
            f"Curves by frequency of {len(shown)} FRFs: measured, and of the model {names[0]} and {names[1]}",
        )
    over = dof_name(model, response.reference)
    return Figure(
        lambda ax: plot_transmissibility(
            response, model, result.model, dof=None, excitation=force, ax=ax, names=names
        ),
        (9.0, 4.4),
        f"Transmissibilities over {over}, summed; the peaks are the antiresonances of that dof. Their "
        "height in the models follows from an assumed damping of 1 %.",
        f"Curves by frequency of the transmissibilities over {over}: measured, and of the model "
        f"{names[0]} and {names[1]}",
    )


def _damage(result: DamageResult, truth: Mapping[int, float] | None) -> dict[str, Figure]:
    """Losses by element, and where they were judged the hypotheses."""
    label, judged = result.problem.model.element_label, result.has_baseline
    width = max(7.0, 0.32 * len(result.x) + 1.5)
    more = ", with 90 % intervals; above, the probability of each; empty bars, what may have it instead"
    losses = ", ".join(f"{label(e)} {100 * result.severity[e]:.1f} %" for e in result.damaged)
    figures = {
        "damage": Figure(
            partial(plot_damage, result, truth=truth),
            (width, 4.7 if judged else 4.4),
            f"Stiffness loss by element{more if judged else ''}. Ticks: the smallest that would be seen.",
            "Bar chart: " + (losses or "no damage in any element"),
        )
    }
    if judged:
        hypotheses = without_idle(result.assessment).hypotheses
        rows = min(len(hypotheses), 9)
        figures["hypotheses"] = Figure(
            partial(plot_hypotheses, hypotheses),
            (8.0, 1.3 + 0.5 * rows),
            "Probabilities of what may explain the measurement, with losses and their 90 % intervals.",
            "Bar chart of the table above",
        )
    return figures


def _diagram(name: Any, diagram: StabilizationDiagram, modal: bool) -> Figure:
    of = "all responses" if modal or name is None else f"dof {name}" if isinstance(name, int) else str(name)
    found = ", ".join(f"{f:.2f}" for f in diagram.identified)
    return Figure(
        diagram.plot,
        (9.0, 5.0),
        f"Stabilization diagram of {of}: poles of rational fits of rising order; those that stay are "
        f"{'the resonances' if modal else 'its antiresonances'}.",
        f"Stabilization diagram of {of}, {diagram.band_hz[0]:g} to {diagram.band_hz[1]:g} Hz: "
        + (f"accepted at {found} Hz" if found else "no antiresonance accepted"),
        partial(stabilization_figure, diagram, dof=name),
    )


def _model_picture(result: UpdateResult) -> tuple[Draw, tuple[float, float], str, str] | None:
    """How to draw the model, its size, caption and alternative; None for matrices, which have no shape."""
    problem, model = result.problem, result.problem.model
    first = problem.measured[0]
    at: dict[str, Any] = {}
    if isinstance(first, AntiresonanceSet):
        at = {"sensors": list(first), "excitation": first.excitation}
    loss = None
    said = "sensors as arrows, the force as a heavier one"
    caption = f"The model; {said}." if at else "The model."
    if isinstance(result, DamageResult):
        loss = {e: 100.0 * beta for e, beta in result.severity.items()}
        at |= {"label": "Stiffness loss (%)"}
        caption = "The model with the stiffness losses found" + (f"; {said}." if "sensors" in at else ".")
    if isinstance(model, MassSpringChain):
        return (
            partial(_drawn, plot_chain, model, loss, at),
            (9.0, 2.9),
            caption,
            f"Drawing of a chain of {model.n_dof} masses",
        )
    if isinstance(model, FrameModel):
        beams = None if loss is None else {e: v for e, v in loss.items() if e < len(model.elements)}
        points = np.ptp(model.nodes_m, axis=0)
        height = 6.5 if points[1:].max() > 0.6 * points[0] else 4.6
        return (
            partial(_drawn, plot_frame, model, beams, at),
            (9.0, height),
            f"{caption} Numbers upright are of elements, slanted ones of nodes.",
            f"Drawing of a frame of {len(model.elements)} elements",
        )
    return None


def _drawn(plot: Any, model: Any, loss: Any, at: dict[str, Any], ax: Any) -> Any:
    return plot(model, loss, ax, **at)


def states(result: UpdateResult) -> tuple[str, str]:
    """What the model is called before and after."""
    return (
        ("without damage", "with the damage found")
        if isinstance(result, DamageResult)
        else ("before updating", "after updating")
    )


def largest(percent: float) -> str:
    """The largest difference in words."""
    return f"{percent:.2f} %" if np.isfinite(percent) else "no partner at all"


def _small(png: bytes) -> bytes:
    """The same picture in few colours."""
    from PIL import Image  # matplotlib writes PNG with it, so it is there

    few = Image.open(BytesIO(png)).convert("RGB").quantize(COLOURS_KEPT, dither=Image.Dither.NONE)
    file = BytesIO()
    few.save(file, "PNG", optimize=True)
    return file.getvalue()
