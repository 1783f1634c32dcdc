"""The story of ``antires demo``: an eight-mass chain from its records to the damaged spring.

The tested structure differs from the model by up to 8 % in every mass and spring. It is recorded undamaged,
and the model updated; then recorded damaged, and the loss found with the updated model, and against the
undamaged record with the model as it was. The pipeline sees records only: the truth is printed beside its
answers, never used for them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import cases
from ..cases.chain8 import Chain8
from ..damage.assess import assess_damage
from ..damage.result import DamageResult
from ..identification.identify import identify_antiresonances
from ..measured.antiresonance_set import AntiresonanceSet
from ..optimize.island_ga import IslandGA
from ..signals.recording import Recording
from ..updating.results import UpdateResult
from ..updating.search import update

__all__ = ["MAX_EVALUATIONS", "PERTURBATION", "Story", "tell"]

PERTURBATION = 0.08
#: Budget of the updating: a flat valley (common scale, mass 0) keeps it from ending by itself. Over eight
#: seeds this one, half the default, left 0.05 to 0.42 % as the largest difference, in a second.
MAX_EVALUATIONS = 100_000


@dataclass(frozen=True)
class Story:
    """What happened, stage by stage."""

    case: Chain8
    seed: int
    noise: float
    record: Recording
    undamaged: AntiresonanceSet
    updated: UpdateResult
    damaged: AntiresonanceSet
    damage: DamageResult
    damage_nominal: DamageResult
    damage_baseline: DamageResult
    seconds: dict[str, float]


def tell(
    *,
    seed: int = 0,
    noise: float = 0.01,
    workers: int | None = None,
    max_evaluations: int = MAX_EVALUATIONS,
    say: Callable[[str], Any] = str,
) -> Story:
    """Run the whole chain: two virtual tests, two identifications, one updating, three assessments.

    Parameters
    ----------
    seed : int
        Of the structure, the records and the searches.
    noise : float
        Sensor noise as a fraction of each channel's rms.
    workers : int, optional
        Threads of the searches.
    max_evaluations : int
        Budget of the updating.
    say : callable
        Receives a line before each stage; nobody does by default.

    Returns
    -------
    Story

    Raises
    ------
    InvalidInputError
        So much noise that no antiresonance is found.

    Examples
    --------
    >>> from antires_rs.cli import story
    >>> told = story.tell(noise=0.0, max_evaluations=5000)
    >>> told.damage.damaged
    [4]
    """
    structure, first, second, *searches = np.random.default_rng(seed).spawn(6)
    case = cases.chain8(perturbation=PERTURBATION, rng=structure)
    seconds: dict[str, float] = {}

    def timed(name: str, text: str, work: Callable[[], Any]) -> Any:
        say(text)
        start = time.perf_counter()
        answer = work()
        seconds[name] = round(time.perf_counter() - start, 3)
        if getattr(answer, "status", "") == "interrupted":
            raise KeyboardInterrupt  # a search returns its best so far on Ctrl-C; a demo has no use for it
        return answer

    def identify(record: Recording) -> AntiresonanceSet:
        return identify_antiresonances(record, excitation=case.excitation, band_hz=case.band_hz)

    def assess(model: Any, rng: Any) -> DamageResult:
        return assess_damage(model, damaged, rng=rng, workers=workers)

    record = timed(
        "recording", "recording the undamaged structure", lambda: case.experiment(0, noise=noise, rng=first)
    )
    undamaged = timed("identification", "identifying its antiresonances", lambda: identify(record))
    ga = IslandGA(max_evaluations=max_evaluations)
    updated = timed(
        "updating",
        "updating 15 parameters of the model",
        lambda: update(case.updating_problem(undamaged), optimizer=ga, rng=searches[0], workers=workers),
    )
    damaged = timed(
        "damaged",
        "recording and identifying the damaged structure",
        lambda: identify(case.experiment(1, noise=noise, rng=second)),
    )
    damage = timed("damage", "looking for the damage", lambda: assess(updated.model, searches[1]))
    nominal = timed(
        "damage_nominal", "... and once more without the updating", lambda: assess(case.model, searches[2])
    )
    baseline = timed(
        "damage_baseline",
        "... and against the undamaged record, without the updating",
        lambda: assess_damage(case.model, damaged, baseline=undamaged, workers=workers),
    )
    return Story(case, seed, noise, record, undamaged, updated, damaged, damage, nominal, baseline, seconds)
