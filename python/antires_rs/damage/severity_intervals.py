"""Intervals of severities as a value: ends, draws, and what sampling says of the hypotheses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..support.validation import FloatArray, reject
from ..updating.parameter_intervals import ParameterIntervals

__all__ = ["SampledSet", "SeverityIntervals"]


@dataclass(frozen=True)
class SampledSet:
    """A hypothesis whose severities were drawn.

    Attributes
    ----------
    elements : tuple of int
        Damaged elements, zero-based.
    candidate : bool
        False for an element that was no candidate.
    probability : float
        As in ``result.hypotheses``.
    confirmed : float
        With the evidence by sampling; the same as ``probability`` where none was drawn (``'laplace'``).
    effective : float
        How many independent draws those of the severities are worth.
    points : int
        Draws before those of little weight were left out.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.SampledSet((4,), True, 0.970, 0.968, 250.0, 310).confirmed
    0.968
    """

    elements: tuple[int, ...]
    candidate: bool
    probability: float
    confirmed: float
    effective: float
    points: int


@dataclass(frozen=True, eq=False)
class SeverityIntervals(ParameterIntervals):
    """Intervals of severities after an assessment against a baseline. ``intervals[element]`` is one of them.

    What :class:`ParameterIntervals` has, of the severities **given the elements declared damaged**: (0, 0) of
    all others. ``words`` are "two-sided"; "from 0 on" or "up to 0.99", where the most probable severity is at
    that bound; "not damaged". ``model_error`` is what no factor of the model explains of the baseline.

    Attributes
    ----------
    elements : tuple of int, (n,)
        Candidates, in the order of ``names``.
    mixture : ndarray, (k, n)
        Draws of severities over no damage and all near sets of candidates, each as often as it is probable;
        exactly 0 where an element is not in the set drawn.
    sets : tuple of SampledSet
        Hypotheses of some probability, the most probable first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8(perturbation=0.05, rng=3)
    >>> damage = ar.assess_damage(case.model, case.exact(level=1), baseline=case.exact(level=0))
    >>> quick = damage.intervals()
    >>> quick[4] == damage.interval[4], quick.words[4], quick.mixture.shape
    (True, 'two-sided', (1000, 7))
    """

    elements: tuple[int, ...]
    mixture: FloatArray
    sets: tuple[SampledSet, ...]

    def __getitem__(self, name: Any) -> tuple[float, float]:
        if isinstance(name, str):
            return super().__getitem__(name)
        if name not in self.elements:
            reject("element", name, "a candidate", f"One of {', '.join(map(str, self.elements))}.")
        nth = self.elements.index(name)
        return float(self.low[nth]), float(self.high[nth])
