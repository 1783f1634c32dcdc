"""All figures of a result, by the names that its pictures have too."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..damage.result import DamageResult
from ..damage.supersets import without_idle
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from .convergence import convergence_figure
from .differences import differences_figure
from .hypotheses import hypotheses_figure
from .losses import losses_figure
from .response import response_figure
from .structure import structure_figure

if TYPE_CHECKING:
    from ..signals.frequency_response import FrequencyResponse
    from ..updating.results import UpdateResult

__all__ = ["result_figures"]


def result_figures(
    result: UpdateResult, response: FrequencyResponse | None = None, truth: Mapping[int, float] | None = None
) -> dict[str, Any]:
    """All figures of a result that there are, by name.

    Parameters
    ----------
    result : UpdateResult or DamageResult
    response : FrequencyResponse, optional
        What was measured with the first position of the force: FRFs or transmissibilities.
    truth : mapping of int to float, optional
        True stiffness loss by element.

    Returns
    -------
    dict of str to bokeh.plotting.figure
        Of damage, hypotheses, model, differences, response and convergence those that there are.

    Raises
    ------
    MissingDependencyError
        bokeh is not installed.
    """
    problem, model = result.problem, result.problem.model
    damage = isinstance(result, DamageResult)
    names = ("without damage", "with the damage found") if damage else ("before updating", "after updating")
    first = problem.measured[0]
    figures: dict[str, Any] = {}
    loss = None
    if isinstance(result, DamageResult):
        loss = {element: 100.0 * beta for element, beta in result.severity.items()}
        figures["damage"] = losses_figure(result, truth)
        if result.has_baseline:
            figures["hypotheses"] = hypotheses_figure(without_idle(result.assessment).hypotheses)
    if isinstance(model, MassSpringChain | FrameModel):
        at = (list(first), first.excitation) if isinstance(first, AntiresonanceSet) else ((), None)
        figures["model"] = structure_figure(model, loss, *at)
    if result.table.measured_hz.size:
        figures["differences"] = differences_figure(result.table, names)
    if response is not None and isinstance(first, AntiresonanceSet):
        figures["response"] = response_figure(response, model, result.model, first.excitation, names)
    if result.history.cost.size:
        figures["convergence"] = convergence_figure(result)
    return figures
