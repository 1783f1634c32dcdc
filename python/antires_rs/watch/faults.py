"""Sensors that fail, told from damage.

Damage beside the force may move the antiresonances of one response alone; so a response that deviates alone
is no fault by that. It is one if the test lacks it, if the data check names its channel where that of the
baseline did not, or if it lost its antiresonances while those of all other responses are where they should
be. One that has as many as before elsewhere has lost none: large damage moved them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from .association import Places, Values

#: Findings of the data check that tell of a channel, not of the structure.
SENSOR = (
    "dead_channel",
    "clipped_channel",
    "duplicated_channels",
    "dropouts",
    "spikes",
    "time_shift",
    "quadrature",
    "signal_to_noise",
)
#: A finding that so large a part of the baseline has as well says nothing new.
_USUAL = 0.1
#: A place that is nearly always there; a response has lost its antiresonances if fewer than so many remain.
_SURE, _LEFT = 0.8, 0.34
#: Of the antiresonances that are not in their places, so many may be new values of the response, at most.
_ELSEWHERE = 0.5
#: The other responses are in place if so many of theirs are there.
_OTHERS = 0.7


@dataclass(frozen=True)
class Fault:
    """A response that a test could not be judged by.

    Attributes
    ----------
    dof : int or str
    text : str
        Why.

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
    told = [{} if one is None else _findings(one) for one in sets]
    usual = Counter(key for i in baseline for key in told[i])
    sure = places.rate >= _SURE
    found: dict[int, list[Fault]] = {}
    for i, one in enumerate(sets):
        if one is None:
            continue
        here: dict[Any, str] = {}
        for (dof, name), text in told[i].items():
            if dof in places.dofs and usual[dof, name] <= _USUAL * len(baseline):
                here.setdefault(dof, text)
        there = ~np.isnan(values.log_hz[i])
        for dof in places.dofs:
            own = (places.dof == dof) & sure
            others = ~np.isin(places.dof, [dof, *here]) & sure & values.looked[i]
            if dof in here or not own.any():
                continue
            if dof not in one:
                here[dof] = "not in this test"
            elif (
                own.sum() >= 2
                and not there[own].any()
                and not _moved(values, i, dof, int(own.sum()))
                and np.mean(there[others] if others.any() else 0) >= _OTHERS
            ):
                here[dof] = f"none of its {own.sum()} antiresonances, those of the others in place"
        if here:
            found[i] = [Fault(dof, text) for dof, text in here.items()]
    return found


def lost_alone(
    values: Values, places: Places, test: int, without: dict[Any, float], limit: float
) -> Fault | None:
    """A response that alone makes a test alarm and that has lost its antiresonances.

    Parameters
    ----------
    values, places, test
    without : mapping of dof to float
        Statistic of the test without each response.
    limit : float
        Below which the others are as they should be.
    """
    there = ~np.isnan(values.log_hz[test])
    for dof, statistic in sorted(without.items(), key=lambda item: item[1]):
        own = (places.dof == dof) & (places.rate >= _SURE)
        others = (places.dof != dof) & (places.rate >= _SURE) & values.looked[test]
        lost = int(own.sum() - there[own].sum())
        if (
            own.sum() >= 2
            and np.mean(there[own]) <= _LEFT
            and statistic < limit
            and not _moved(values, test, dof, lost)
            and np.mean(there[others] if others.any() else 0) >= _OTHERS
        ):
            return Fault(dof, f"{lost} of its {own.sum()} antiresonances lost, those of the others in place")
    return None


def _moved(values: Values, test: int, dof: Any, lost: int) -> bool:
    """Whether a response has as many antiresonances elsewhere as are not in their places."""
    return sum(bool(one == dof) for one, _ in values.strange[test]) > _ELSEWHERE * lost


def _findings(one: AntiresonanceSet) -> dict[tuple[Any, str], str]:
    """What the data check says of single channels, by (dof, name)."""
    if one.data_check is None:
        return {}
    found: dict[tuple[Any, str], str] = {}
    for finding in one.data_check.findings:
        name, where = getattr(finding, "name", ""), getattr(finding, "where", ())
        if finding.severity != "note" and name in SENSOR:
            for dof in where:
                found[dof, name] = f"data check: {name.replace('_', ' ')}"
    return found
