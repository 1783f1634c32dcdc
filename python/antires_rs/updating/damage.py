"""Damage assessment: the stiffness loss of each element that explains the measurement."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np

from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import IslandGA
from ..support.validation import reject, shape_of
from .problem import Measured, UpdatingProblem
from .results import DamageResult
from .search import search

__all__ = ["assess_damage"]


def assess_damage(
    model: StructuralModel,
    measured: Measured,
    *,
    elements: Any = None,
    gamma1: float | None = None,
    gamma2: float | None = None,
    snap: float = 1e-3,
    weights: Any = None,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: int | None = None,
    callback: Callable[[dict[str, Any]], bool | None] | None = None,
    x0: Any = None,
    progress: bool | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
) -> DamageResult:
    """Locate and size damage: the stiffness loss of each element that explains the measurement.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The undamaged structure, best updated first on an undamaged measurement.
    measured : AntiresonanceSet, ModalSet, or several of one kind
        The structure as it is now: antiresonances, one set for each position of the force; or resonances with
        their shapes, for the comparison objective. See :class:`UpdatingProblem`.
    elements : sequence of int, optional
        Candidate elements, zero-based. Default: all springs between masses, all beams,
        all stiffness terms.
    gamma1, gamma2 : float, optional
        Penalties on the sum and the number of damages; small damage costs more than it explains, see
        ``DamageResult.detectable``. Default: as :meth:`DamagePenalty.scaled` gives them, 0.1 for every 28
        values of weight one, so that the same data given three times leave the answer. The paper's are
        0.1 and 0.1. ``result.problem.penalty`` has the numbers in force.
    snap : float
        Severities below count as exactly 0; within [0, 1e-3], 0 for the algorithm as printed.
    weights : 'std' or array_like, optional
        As for :class:`UpdatingProblem`.
    optimizer, rng, workers, callback, x0, progress, checkpoint
        As in :func:`update`.

    Returns
    -------
    DamageResult
        ``.severity`` {element: beta}, ``.detectable`` {element: smallest visible beta}.

    Raises
    ------
    InvalidInputError
        An element outside the model or listed twice, measured dofs outside the model.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 300.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, dict(enumerate(damaged.antiresonances([0, 1, 2, 3], 0))))
    >>> result = ar.assess_damage(intact, measured, rng=0)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}
    {0: 0.0, 1: 0.4, 2: 0.0}
    """
    if not isinstance(model, StructuralModel):
        reject(
            "model",
            model,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Build the model as one of these first.",
        )
    chosen = (
        model.default_elements
        if elements is None
        else ([elements] if shape_of(elements) == () else list(elements))
    )
    if not chosen:
        reject(
            "elements",
            "no candidate",
            "at least one stiffness term",
            "Give the MatrixModel its stiffness_terms.",
        )
    problem = UpdatingProblem(
        model, stiffness_reduction(chosen), measured, penalty=(gamma1, gamma2, snap), weights=weights
    )
    found, seed = search(problem, optimizer, rng, workers, callback, x0, progress, checkpoint)
    return DamageResult(problem, found, seed)
