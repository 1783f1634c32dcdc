"""From [damage] of a job to a call of ``assess_damage``, its options found valid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from typing import Any

from ..damage.assess import assess_damage
from ..damage.measured_states import measured_states
from ..damage.prior import DamagePrior
from ..damage.result import DamageResult
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..support.validation import finite_scalar
from ..updating.penalty import DamagePenalty
from ..updating.problem import UpdatingProblem
from .job import Job, nearest
from .lines import Path as Keys
from .unknowns import elements_of

__all__ = ["damage_search"]


def damage_search(
    job: Job, model: StructuralModel, measured: Any, baseline: list[AntiresonanceSet]
) -> Callable[..., DamageResult]:
    """The assessment of a job, to be called with what every search takes."""
    table = job.section("damage")
    options = {key: table[key] for key in ("gamma1", "gamma2", "snap", "weights") if key in table}
    elements = elements_of(job)
    chosen = (
        model.default_elements if elements is None else [elements] if isinstance(elements, int) else elements
    )
    prices = (options.get("gamma1"), options.get("gamma2"), options.get("snap", DamagePenalty.snap))
    places: list[Keys] = [("damage", "elements", i) for i in range(len(chosen))]
    with job.blame(("damage",), {"measured": ("data",), "parameters": places}):
        UpdatingProblem(
            model, stiffness_reduction(chosen), measured, penalty=prices, weights=options.get("weights")
        )
    if not baseline:
        return partial(assess_damage, model, measured, elements=elements, **options)
    prior = _prior(job)
    rate, common = table.get("false_alarm_rate"), table.get("std_common")
    with job.blame(("damage",), {"measured": ("data",)}):  # known before anything is written
        if rate is not None:
            finite_scalar("false_alarm_rate", rate, low=0.0, high=0.5, low_open=True)
        if common is not None:
            finite_scalar("std_common", common, low=0.0, high=0.1)
        measured_states(model, baseline, measured if isinstance(measured, list) else [measured])

    def judged(*, optimizer: Any, checkpoint: Any, **how: Any) -> DamageResult:
        """Nothing is searched, so that there is nothing to keep."""
        return assess_damage(
            model,
            measured,
            baseline=baseline,
            elements=elements,
            prior=prior,
            false_alarm_rate=rate,
            std_common=common,
            **how,
        )

    return judged


def _prior(job: Job) -> DamagePrior | None:
    given = job.section("damage").get("prior")
    if given is None:
        return None
    at: Keys = ("damage", "prior")
    known = [field.name for field in fields(DamagePrior)]
    for name in given:
        if name not in known:
            remedy = nearest(name, known) or "What belongs to none of them is unknown."
            job.reject((*at, name), repr(name), "one of " + ", ".join(known), remedy)
    with job.blame(at, {"prior": at}):
        return DamagePrior(**given)
