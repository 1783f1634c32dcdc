"""Damage assessed where alarms stand together: tests of a run against the baseline, at one condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assessor.answer import AssessedTest
from ..assessor.assessor import Assessor
from ..damage.assess import assess_damage
from ..damage.result import DamageResult
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..support.validation import FloatArray
from .association import Places, Values
from .learned import Learned
from .nuisance import directions

__all__ = ["assessed", "runs_of"]

#: Alarms with so many quiet tests between them, at most, are of one run.
_QUIET = 5
#: Tests of a run that are put together, the latest.
_MOST = 50
#: Strange values of several tests are one if they are this near.
_SAME = 0.01
#: What moves all values alike between two tests, relative, at least; as for ``assess_damage``.
_COMMON = 5e-4


def runs_of(alarm: NDArray[np.bool_], judged: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last test of each run of alarms; tests that could not be judged do not end one."""
    found: list[tuple[int, int]] = []
    quiet = 0
    for i in range(alarm.size):
        if alarm[i]:
            if found and quiet <= _QUIET:
                found[-1] = (found[-1][0], i)
            else:
                found.append((i, i))
            quiet = 0
        else:
            quiet += int(judged[i])
    return found


def assessed(
    by: StructuralModel | Assessor,
    run: tuple[int, int],
    learned: Learned,
    values: Values,
    places: Places,
    sets: Sequence[AntiresonanceSet | None],
    conditions: Mapping[str, FloatArray],
    options: Mapping[str, Any],
) -> DamageResult | AssessedTest | None:
    """``assess_damage`` of the tests of a run against the baseline, or an assessor's answer; None if they
    have no antiresonance."""
    first = next(one for one in sets if one is not None)
    tests = np.array([i for i in range(run[0], run[1] + 1) if values.looked[i].any()][-_MOST:])
    regular = places.regular
    own = {name: column[tests] for name, column in conditions.items()}
    middle = {name: np.array([np.nan]) for name in conditions}  # not known: at its middle
    reference = learned.expected(middle, 1)[0]
    rest = values.log_hz[tests][:, regular] - learned.expected(own, len(tests))
    seen, looked = ~np.isnan(rest), values.looked[tests][:, regular]
    count = seen.sum(axis=0)
    kept = count >= np.maximum(1, 0.5 * looked.sum(axis=0))
    moved = np.array([np.median(rest[seen[:, k], k]) if kept[k] else np.nan for k in range(count.size)])
    std = np.sqrt(learned.variance * np.pi / 2.0 / np.maximum(count, 1))  # of a median
    base_std = np.sqrt(learned.variance * learned.regression.inverse[0, 0])
    new = _again([values.strange[i] for i in tests.tolist()])
    dofs = [dof for dof in places.dofs if np.any(looked[:, places.dof[regular] == dof]) or dof in new]
    now: dict[Any, tuple[list[float], list[float]]] = {dof: ([], []) for dof in dofs}
    for k in np.flatnonzero(kept).tolist():
        dof = places.dof[regular][k]
        freq = float(np.exp(reference[k] + moved[k]))
        now[dof][0].append(freq)
        now[dof][1].append(freq * float(std[k]))
    usual = float(np.median(np.sqrt(learned.variance)))
    for dof, freqs in new.items():
        now[dof][0].extend(freqs)
        now[dof][1].extend(f * usual / np.sqrt(len(tests)) for f in freqs)
    if not any(freqs for freqs, _ in now.values()):
        return None
    sight: dict[str, Any] = {"sees": first.sees, "channels": first.channels or None}
    measured = AntiresonanceSet(
        first.excitation,
        {d: f for d, (f, _) in now.items()},
        std_hz={d: s for d, (_, s) in now.items()},
        **sight,
    )
    if isinstance(by, Assessor):
        return by.assess(measured)
    at = {dof: places.dof[regular] == dof for dof in dofs}
    hz = np.exp(reference)
    baseline = AntiresonanceSet(
        first.excitation,
        {dof: hz[rows] for dof, rows in at.items()},
        std_hz={dof: (hz * base_std)[rows] for dof, rows in at.items()},
        **sight,
    )
    unsure = [directions(learned, own, i, free=False) for i in range(len(tests))]
    common = max([_COMMON] + [float(np.sqrt(np.mean(g**2)) * np.sqrt(g.shape[1])) for g in unsure if g.size])
    given = {"std_common": min(common, 0.1), "progress": False} | dict(options)
    return assess_damage(by, measured, baseline=baseline, **given)


def _again(strange: Sequence[Sequence[tuple[Any, float]]]) -> dict[Any, list[float]]:
    """Values at no place that at least half of the tests have, by response."""
    groups: list[tuple[Any, list[float]]] = []
    for own in strange:
        for dof, freq in own:
            near = [g for d, g in groups if d == dof and abs(freq / float(np.median(g)) - 1.0) < _SAME]
            if near:
                near[0].append(freq)
            else:
                groups.append((dof, [freq]))
    found: dict[Any, list[float]] = {}
    for dof, group in groups:
        if 2 * len(group) >= len(strange):
            found.setdefault(dof, []).append(float(np.median(group)))
    return found
