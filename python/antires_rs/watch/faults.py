"""Sensors that fail, told from damage.

Damage may move the antiresonances of one response alone. A response is at fault if the test lacks it, if the
data check names its channel where that of the baseline did not, or if it lost its antiresonances, and has not
as many elsewhere, while those of all other responses are where they should be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from .association import Places, Values

#: Findings of the data check that tell of a channel, not of the structure.
SENSOR = {"dead_channel", "clipped_channel", "duplicated_channels", "dropouts", "spikes", "time_shift"}
SENSOR |= {"quadrature", "signal_to_noise"}
_USUAL = 0.1  # a finding that so large a part of the baseline has as well says nothing new
#: A place that is nearly always there; a response has lost its antiresonances if fewer than so many remain.
_SURE, _LEFT = 0.8, 0.34
#: Of the antiresonances that are not in their places, so many may be new values of the response, at most.
_ELSEWHERE = 0.5
_OTHERS = 0.7  # the other responses are in place if so many of theirs are there


@dataclass(frozen=True)
class Fault:
    """A response that a test could not be judged by.

    Attributes
    ----------
    dof, text : int or str, str
        Which, and why.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.Fault(3, "not in this test").text)
    not in this test
    """

    dof: Any
    text: str


def obvious(
    sets: Sequence[AntiresonanceSet | None], values: Values, places: Places, baseline: Sequence[int]
) -> dict[int, list[Fault]]:
    """Faults that need no chart, by test."""
    findings = [
        {  # what the data check says of single channels
            (dof, finding.name): f"data check: {finding.name.replace('_', ' ')}"
            for finding in (() if check is None else check.findings)
            if finding.severity != "note" and finding.name in SENSOR
            for dof in finding.where
        }
        for check in [None if one is None else one.data_check for one in sets]
    ]
    usual = Counter(key for i in baseline for key in findings[i])
    found: dict[int, list[Fault]] = {}
    for i, one in enumerate(sets):
        if one is None:
            continue
        here: dict[Any, str] = {}
        for (dof, name), text in findings[i].items():
            if dof in places.dofs and usual[dof, name] <= _USUAL * len(baseline):
                here.setdefault(dof, text)
        for dof in places.dofs:
            sure, lost = _lost(values, places, i, dof, here)
            if dof in here or not sure:
                continue
            if dof not in one:
                here[dof] = "not in this test"
            elif lost == sure:
                here[dof] = f"none of its {sure} antiresonances, those of the others in place"
        if here:
            found[i] = [Fault(dof, text) for dof, text in here.items()]
    return found


def lost_alone(
    values: Values, places: Places, test: int, without: dict[Any, float], limit: float
) -> Fault | None:
    """A response that has lost its antiresonances, ``without`` which the statistic is below ``limit``."""
    for dof, statistic in sorted(without.items(), key=lambda item: item[1]):
        sure, lost = _lost(values, places, test, dof)
        if lost and (sure - lost) / sure <= _LEFT and statistic < limit:
            return Fault(dof, f"{lost} of its {sure} antiresonances lost, those of the others in place")
    return None


def _lost(
    values: Values, places: Places, test: int, dof: Any, faulty: Collection[Any] = ()
) -> tuple[int, int]:
    """How many sure antiresonances a response has, and how many of them a test has lost.

    None is lost where it has one only, as many are there elsewhere, or those of the others are gone too.
    """
    there, sure = ~np.isnan(values.log_hz[test]), places.rate >= _SURE
    own = sure & (places.dof == dof)
    others = sure & values.looked[test] & ~np.isin(places.dof, [dof, *faulty])
    count = int(own.sum())
    lost = count - int(there[own].sum())
    moved = sum(bool(one == dof) for one, _ in values.strange[test]) > _ELSEWHERE * lost
    in_place = others.any() and np.mean(there[others]) >= _OTHERS
    return count, lost if count >= 2 and in_place and not moved else 0
