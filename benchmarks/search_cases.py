"""Damage problems for the race of searches: two structures, one to three damages, three kinds of targets.

- ``exact``: targets of the very model that is searched, so that the question is the search alone;
- ``noisy``: the same with 0.1 % of scatter on every value;
- ``wrong``: the tested structure has every element off by up to 4 % besides, and nobody updated the model.

The exhaust is what the search was developed on; the tower had no part in that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import antires_rs as ar

KINDS = ("exact", "noisy", "wrong")
SCATTER, MODEL_ERROR = 1e-3, 0.04
#: Severities are drawn from here.
LOSSES = (0.25, 0.85)


@dataclass(frozen=True)
class Tested:
    """A model, its candidates, and what is measured on it."""

    model: ar.FrameModel
    candidates: tuple[int, ...]
    excitation: int
    responses: tuple[int, ...]
    band_hz: tuple[float, float]

    def zeros(self, model):
        """Antiresonances of a model as they would be measured."""
        low, high = self.band_hz
        found = model.antiresonances(list(self.responses), self.excitation, f_max_hz=high)
        return ar.AntiresonanceSet(
            self.excitation, {dof: f[f >= low] for dof, f in zip(self.responses, found, strict=True)}
        )

    def problem(self, damages, kind, seed):
        """(problem, severities of its candidates) with so many damages."""
        rng = np.random.default_rng([seed, damages, KINDS.index(kind)])
        n = len(self.candidates)
        truth = np.zeros(n)
        truth[rng.choice(n, damages, replace=False)] = rng.uniform(*LOSSES, damages)
        factors = 1.0 - truth
        if kind == "wrong":
            factors *= 1.0 + MODEL_ERROR * rng.uniform(-1.0, 1.0, n)
        stiffness = ar.stiffness_factor(list(self.candidates), bounds=(0.05, 1.5))
        intact = self.zeros(self.model)
        exact = self.zeros(ar.UpdatingProblem(self.model, stiffness, intact).model_at(factors))
        scatter = 0.0 if kind == "exact" else SCATTER
        measured = ar.AntiresonanceSet(
            self.excitation,
            {dof: np.sort(f * (1.0 + scatter * rng.standard_normal(f.size))) for dof, f in exact.items()},
        )
        reductions = ar.stiffness_reduction(list(self.candidates))
        return ar.UpdatingProblem(self.model, reductions, measured, penalty="scaled"), truth


def exhaust():
    """The exhaust of 49 beams, 30 candidates, about 50 values."""
    case = ar.cases.exhaust()
    return Tested(
        case.model, tuple(case.candidates), case.excitation, tuple(case.responses), case.damage_band_hz
    )


def tower(panels=6):
    """A braced plane tower, all of its members candidates; the sensors look across."""
    nodes = [(x, 0.5 * level) for level in range(panels + 1) for x in (0.0, 0.4)]
    elements = []
    for level in range(panels):
        left, right = 2 * level, 2 * level + 1
        brace = (left, right + 2) if level % 2 else (right, left + 2)
        elements += [
            (left, left + 2, "leg"),
            (right, right + 2, "leg"),
            (*brace, "brace"),
            (left + 2, right + 2, "rung"),
        ]
    steel = (210e9, 7850.0)
    sections = {
        "leg": ar.Tube(0.03, 0.002, *steel),
        "brace": ar.Tube(0.016, 0.0015, *steel),
        "rung": ar.Rectangle(0.02, 0.01, *steel),
    }
    model = ar.FrameModel(nodes, elements, sections, fixed=[0, 1])
    sensors = [model.dof(2 * level + side, "u") for level in range(1, panels + 1) for side in (0, 1)]
    return Tested(model, tuple(range(len(elements))), sensors[4], tuple(sensors), (20.0, 420.0))


STRUCTURES = {"exhaust": exhaust, "tower": tower}
