"""What may be given to the watch: a series or sets, its baseline, conditions, options of damage."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assessor.assessor import Assessor
from ..damage.assess import assess_damage
from ..damage.candidates import elements_of
from ..damage.prior import DamagePrior
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..series.condition_table import condition_table
from ..series.series import Series
from ..support.validation import FloatArray, finite_scalar, reject
from ..updating.problem import UpdatingProblem

__all__ = [
    "baseline_tests",
    "believed",
    "check_assessment",
    "check_assessor",
    "check_judge",
    "clocks",
    "conditions_of",
    "series_of",
]

#: Fewer tests than this are no baseline.
LEAST = 8
#: Further outside the baseline than so many times its range, a condition is an error of its logger.
_ABSURD = 10.0
#: Options of ``assess_damage`` that are for a search without a baseline, or that the watch fills itself.
_NOT_HERE = ("gamma1", "gamma2", "snap", "weights", "optimizer", "callback", "x0", "checkpoint")
_OWN = ("model", "measured", "baseline")


def series_of(given: Any) -> Series:
    """A series of what was given."""
    if isinstance(given, Series):
        return given
    if not isinstance(given, Sequence) or isinstance(given, str | Mapping):
        reject(
            "series", type(given).__name__, "a Series or a list of AntiresonanceSets", "Put them in a list."
        )
    for i, one in enumerate(given):
        if one is not None and not isinstance(one, AntiresonanceSet):
            reject(
                f"series[{i}]",
                type(one).__name__,
                "an AntiresonanceSet, or None for a test that failed",
                "Identify the records first: identify_series(records, ...).",
            )
    return Series.from_sets(list(given))


def baseline_tests(given: Any, series: Series) -> NDArray[np.intp]:
    """Indices of the baseline's tests that have a set."""
    n = len(series)
    wanted = f"a slice, a number of first tests, indices or a mask of the {n} tests"
    if isinstance(given, bool | np.bool_):
        reject("baseline", given, wanted, "As in baseline=slice(0, 100).")
    if isinstance(given, int | np.integer):
        if not 0 < given <= n:
            reject("baseline", int(given), wanted, f"Give a number from {LEAST} to {n}.")
        given = slice(0, int(given))
    try:
        at = np.asarray(given) if not isinstance(given, slice) else given
        chosen = np.unique(np.arange(n)[at])
    except (IndexError, TypeError, ValueError):
        reject("baseline", given, wanted, "As in baseline=slice(0, 100).")
    sound = np.array([i for i in chosen.tolist() if i not in series.failed], dtype=np.intp)
    if sound.size < LEAST:
        reject(
            "baseline",
            f"{sound.size} tests with antiresonances",
            f"at least {LEAST}, from which limits can be learned",
            "Take more tests of the intact structure; a rate of 1 % wants 50.",
        )
    return sound


def conditions_of(given: Any, series: Series) -> dict[str, FloatArray]:
    """Columns (n,) by name, of any table; by default those of the series."""
    found = dict(series.conditions)
    if given is not None:
        table, _ = condition_table(given)
        table.expect(len(series))
        rows = [table.at(i, name)[0] for i, name in enumerate(series.names)]
        table.over(len(series))
        found = {key: np.array([row[key] for row in rows]) for key in table.columns}
    return found


def clocks(conditions: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Those that only count the tests: a line over time would take damage that grows for weather."""
    found = []
    for name, column in conditions.items():
        known = column[~np.isnan(column)]
        if known.size > 2 and known[0] != known[-1]:
            steps = np.diff(known) * np.sign(known[-1] - known[0])
            if np.all(steps >= 0.0):
                found.append(name)
    return tuple(found)


def believed(column: FloatArray, baseline: NDArray[np.intp]) -> FloatArray:
    """A condition without what no weather makes, NaN there."""
    own = column[baseline][~np.isnan(column[baseline])]
    if not own.size or own.min() == own.max():
        return column
    reach = _ABSURD * (own.max() - own.min())
    return np.where((column < own.min() - reach) | (column > own.max() + reach), np.nan, column)


def check_judge(model: Any, assessor: Any, options: Mapping[str, Any]) -> None:
    """Refuse what cannot assess damage, and options that have no effect."""
    if model is not None and not isinstance(model, StructuralModel):
        reject(
            "model",
            model,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Leave it out to have alarms only.",
        )
    if assessor is not None and not isinstance(assessor, Assessor):
        reject("assessor", assessor, "an Assessor", "Load it first: Assessor.load(path).")
    if assessor is not None and (model is not None or options):
        name = "model" if model is not None else next(iter(options))
        reject(name, "together with an assessor", "only one of them", "The assessor has its own.")
    if assessor is None and model is None and options:
        name = next(iter(options))
        reject(name, "without a model", "a model= to assess damage with", "Pass the model, or leave it out.")


def check_assessor(assessor: Assessor, one: AntiresonanceSet) -> None:
    """Refuse one made for other tests now, not at the first alarm."""
    own = {each.excitation: tuple(each) for each in assessor.baseline}
    if one.excitation not in own:
        reject(
            "assessor",
            f"one for forces at {', '.join(map(repr, own))}",
            f"one for the force of these tests, {one.excitation!r}",
            "Make it from some of their baseline.",
        )
    if not set(own[one.excitation]) & set(one):
        reject(
            "assessor",
            f"one for dofs {', '.join(map(repr, own[one.excitation]))}",
            f"one for dofs of these tests: {', '.join(map(repr, one))}",
            "Make it from some of their baseline.",
        )


def check_assessment(model: StructuralModel, one: AntiresonanceSet, options: Mapping[str, Any]) -> None:
    """Refuse wrong options of ``assess_damage`` now, not at the first alarm."""
    known = [name for name in inspect.signature(assess_damage).parameters if name not in _OWN]
    for name, value in options.items():
        if name not in known:
            reject(name, "an unknown option", f"one of assess_damage: {', '.join(known)}", "Look for a typo.")
        if name in _NOT_HERE and value is not None:
            reject(name, value, "nothing, since the watch has a baseline", "Leave it out.")
    wanted = options.get("elements")
    if wanted is not None or model.default_elements:
        UpdatingProblem(model, stiffness_reduction(elements_of(model, wanted)), [one])
    std = options.get("std_common")
    if std is not None:
        finite_scalar("std_common", std, low=0.0, high=0.1)
    prior = options.get("prior")
    if prior is not None and not isinstance(prior, DamagePrior):
        reject("prior", prior, "a DamagePrior", "Leave it out for DamagePrior().")
