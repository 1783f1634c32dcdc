"""What further sensor or place of the force would tell apart the damages that a test leaves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..damage.hypotheses import Hypothesis
from ..damage.measured_states import ASSUMED_STD
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import End
from ..support.checks import FloatArray, members
from .placement import ExpectedErrors, Information, Layout, information, virtual_roots

if TYPE_CHECKING:
    from ..damage.assess import DamageResult

_MOST = 60_000  # above so many dofs times responses looking takes too long, and the sentence tells how to ask
#: Alternatives from this probability on; least gain that is worth a test, and the largest that is said.
_WORTH_IT, _HELPS, _MANY = 0.05, 1.1, 100.0
_TELLS = 3.0  # standard deviations that a test should put between them
_LEAST_LOSS = 0.05  # smaller losses, as of elements that no value sees yet, are asked for as if they were it
_WIDER = 1.02  # the band is that of the values, and so much more


def separating_test(result: DamageResult) -> str:
    """A sentence; '' where one damage is left, or modes were measured.

    Losses b of the elements A are told from any of B, to first order, by
    sqrt(b' (I_AA - I_AB I_BB^-1 I_BA) b) standard deviations, I being the information of the test.
    """
    found, measured = result.assessment, result._asked().measured
    sets = [each for each in measured if isinstance(each, AntiresonanceSet)]
    left = [h for h in found.group or found.hypotheses[:4] if h.candidate and h.elements]
    left = [h for h in left if h.probability >= _WORTH_IT]
    ways = {h.elements: h for h in reversed(left)}
    if len(ways) < 2 or not sets:
        return ""
    model, elements = result.problem.model, sorted({e for own in ways for e in own})
    first, *others = (h for h in left if ways[h.elements] is h)
    named = found.hypotheses.named
    what = f"To tell {named(first.elements)} from {' or '.join(named(h.elements) for h in others)}: "
    sensors: dict[End, list[int]] = {}
    for s in sets:
        dofs = (dof for key in s for dof in members(model._end("dof", key)))
        sensors[model._end("excitation", s.excitation)] = list(dict.fromkeys(dofs))
    sees = {model._end("excitation", s.excitation): s.sees or "frf" for s in sets}
    free, used = model._sensor_dofs, sorted({dof for own in sensors.values() for dof in own})
    every = sorted({*free, *used})
    if model.n_dof * (len(sensors) * len(every) + len(used) ** 2) > _MOST:
        how = f"n_sensors={len(used) + 1}, excitations={list(sensors)}"
        return f"{what}ask ar.plan_test(model, {elements}, {how}) where to measure next."
    values = np.concatenate([each[dof] for each in sets for dof in each])
    stated = (each.std_hz[dof] / each[dof] for each in sets for dof in each if dof in each.std_hz)
    std = np.concatenate([np.empty(0), *stated])
    known = std[np.isfinite(std)]
    errors = ExpectedErrors(0.0, 1.0, 0.01, float(np.median(known)) if known.size else ASSUMED_STD)
    band = float(values.min()) / _WIDER, float(values.max()) * _WIDER

    def told(force: End, dofs: Sequence[int], seen: str) -> Information:
        parameters = tuple(stiffness_reduction(elements))
        layout = Layout(model, tuple(dofs), force, band, seen)
        roots = virtual_roots(layout, parameters, np.zeros(len(elements)), errors, 1)
        return information(roots, layout, np.ones(len(elements)), 2)

    nothing = found.probability_of_nothing >= _WORTH_IT  # may be left, too

    def apart(of_test: FloatArray) -> float:
        least = min(_apart(of_test, elements, first, h) for h in others)
        return min(least, *(_seen(of_test, elements, h) for h in (first, *others))) if nothing else least

    by_force = {force: told(force, every, sees[force]) for force in sensors}
    at = {force: [every.index(dof) for dof in own] for force, own in sensors.items()}
    now = np.sum([by_force[force].of(at[force]) for force in sensors], axis=0)
    further: list[tuple[float, str]] = []
    for nth, dof in enumerate(every):
        if dof not in used:
            more = np.sum([by_force[force].of([*at[force], nth]) for force in sensors], axis=0)
            further.append((apart(more), f"a sensor at {model.dof_label(dof)} as well"))
    for force in used:
        if force not in sensors:
            more = now + told(force, used, next(iter(sees.values()))).of(range(len(used)))
            further.append((apart(more), f"the force at {model.dof_label(force)} in a second test"))
    best, place = max(further, default=(0.0, ""), key=lambda one: one[0])
    if best < max(_TELLS, _HELPS * apart(now)):
        where = "no further sensor or place of the force would in the band of these values"
        return f"{what}{where}; a wider band, longer or repeated tests may."
    times = best / max(apart(now), best / _MANY)
    much = f"{times:.{1 if times < 9.95 else 0}f} times as far apart"
    return f"{what}{place} would set them {much}; longer or repeated tests may too."


def _seen(of_test: FloatArray, elements: list[int], one: Hypothesis) -> float:
    """Standard deviations between a damage and none."""
    a, loss = [elements.index(e) for e in one.elements], np.maximum(one.severities, _LEAST_LOSS)
    return float(np.sqrt(loss @ of_test[np.ix_(a, a)] @ loss))


def _apart(of_test: FloatArray, elements: list[int], one: Hypothesis, other: Hypothesis) -> float:
    """Standard deviations between two damages, the nearer way round; a set is no other than a larger one."""
    found = []
    for own, theirs in ((one, other), (other, one)):
        if {*own.elements} <= {*theirs.elements}:
            continue
        a, b = ([elements.index(e) for e in each.elements] for each in (own, theirs))
        loss = np.maximum(own.severities, _LEAST_LOSS)
        seen = of_test[np.ix_(b, a)] @ loss
        # The inverse of what is seen: there may be losses that no value sees.
        explained = seen @ np.linalg.pinv(of_test[np.ix_(b, b)], rcond=1e-12, hermitian=True) @ seen
        found.append(float(np.sqrt(max(loss @ of_test[np.ix_(a, a)] @ loss - explained, 0.0))))
    return min(found)
