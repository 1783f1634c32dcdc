"""A measured set as values, by what was prepared: no question to the model."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..damage.measured_states import ASSUMED_STD, LEAST_STD, Responses, Values
from ..damage.question import Question
from ..damage.same_data import note_of_same_data, same_data
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import FloatArray, reject
from ..updating.complex_zeros import looked_up_to, real_zeros, sorted_out, usual_damping, zero_series
from ..updating.model_dofs import model_dof

__all__ = ["Expected", "expected_of", "values_of"]

#: Beyond the highest value of the baseline (as a factor) zeros of the model are known.
_BEYOND = 1.3


@dataclass(frozen=True)
class Expected:
    """What a set with one force may hold: the number of each response, and the model's real and complex zeros
    (Hz) there."""

    number: dict[Any, int]
    real: dict[Any, FloatArray]
    complex: dict[Any, tuple[FloatArray, FloatArray]]
    sees: str | None
    channels: tuple[Any, ...]


def expected_of(question: Question, responses: Responses) -> dict[Any, Expected]:
    """By force label."""
    found = {}
    model = question.model
    for each, labels in zip(question.measured, responses.labels, strict=True):
        assert isinstance(each, AntiresonanceSet)
        force = model_dof(model, "excitation", each.excitation)
        dofs = [model_dof(model, "measured dof", label) for label in labels]
        limit_hz = looked_up_to(_BEYOND * max(each[dof].max(initial=0.0) for dof in each))
        real = real_zeros(model, dofs, force, limit_hz)
        found[each.excitation] = Expected(
            labels,
            dict(zip(labels, real, strict=True)),
            {
                label: zero_series(model, dof, force, limit_hz)
                for label, dof in zip(labels, dofs, strict=True)
            },
            each.sees,
            tuple(each.channels or ()),
        )
    return found


def _columns(one: AntiresonanceSet) -> dict[Hashable, tuple[FloatArray, FloatArray]]:
    """Values and their standard deviations by response."""
    return {(label, one.excitation): (table.freq_hz, table.std_hz) for label, table in one.tables.items()}


def values_of(
    sets: Sequence[AntiresonanceSet], expected: dict[Any, Expected], scatter: float
) -> tuple[Values, list[str], list[str], bool]:
    """Values, notes on those that are left out, what the plan does not hold, and whether some lack a standard
    deviation."""
    rows: list[tuple[int, int, float, float]] = []
    asked: list[tuple[int, int]] = []
    notes: list[str] = []
    strange: list[str] = []
    assumed = False
    twice = same_data([_columns(one) for one in sets])
    notes += note_of_same_data("zeros", twice)
    for nth, one in enumerate(sets):
        first = _columns(sets[twice[nth]]) if nth in twice else {}
        plan = expected.get(one.excitation)
        if plan is None:
            known = ", ".join(map(repr, expected))
            reject(
                "zeros",
                f"a set with the force at {one.excitation!r}",
                f"the force of the baseline: {known}",
                "Make an Assessor from a baseline with the force there too.",
            )
        if one.sees != plan.sees or set(one.channels or ()) != set(plan.channels):
            strange.append("it was identified from other responses than the baseline")
        usual = usual_damping(one)
        for label, table in one.tables.items():
            if (label, one.excitation) in first and first[label, one.excitation][0].size:
                continue
            number = plan.number.get(label)
            if number is None:
                if len(table):
                    strange.append(f"the baseline does not have dof {label}")
                continue
            asked.append((number, nth))
            keep = np.ones(len(table), dtype=bool)
            if usual is not None:
                series = partial(plan.complex.__getitem__, label)
                notes += sorted_out(label, table, usual, plan.real[label], series, keep)
            least = ASSUMED_STD if "share" in table.scores else LEAST_STD
            std = np.where(np.isfinite(table.std_hz), table.std_hz / table.freq_hz, ASSUMED_STD)
            assumed |= not bool(np.isfinite(table.std_hz[keep]).all())
            rows += [
                (nth, number, f, max(s, least))
                for f, s in zip(np.log(table.freq_hz[keep]).tolist(), std[keep].tolist(), strict=True)
            ]
    if not rows:
        reject("zeros", "no antiresonance", "at least one", "Identify in the band of the baseline.")
    rows.sort()
    columns = list(zip(*rows, strict=True))
    values = Values(
        np.array(columns[1], dtype=np.intp),
        np.array(columns[2], dtype=np.float64),
        scatter * np.array(columns[3], dtype=np.float64),
        np.array(columns[0], dtype=np.intp),
        asked=np.array(asked, dtype=np.intp),
    )
    return values, notes, strange, assumed
