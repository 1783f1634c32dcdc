"""Hypotheses and their probabilities, as a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.checks import FloatArray
from ..support.values import Value
from ..updating.problem import few_alone, mostly_paired
from ..views import Viewed

# -- Probabilities and intervals in percent, as they are printed


def span(low: float, high: float) -> str:
    """An interval in percent; ends that are not the same do not look the same."""
    digits = _digits(low, high)
    return f"{100 * low:.{digits}f} to {100 * high:.{digits}f}"


def loss(severity: float, low: float, high: float, unit: str = "") -> str:
    """A loss with its interval, in the same digits: it does not look as if it lay outside."""
    return f"{100 * severity:.{_digits(low, high)}f}{unit} ({span(low, high)})"


def _digits(low: float, high: float) -> int:
    return 1 if high - low >= 2e-3 or high == low else 2


def percent(probability: float) -> str:
    """A probability in percent; what is nearly 0 or 1 is not rounded to it."""
    if probability > 0.999:
        return "above 99.9 %"
    return "below 0.1 %" if probability < 0.001 else f"{100 * probability:.1f} %"


def figure(share: float) -> str:
    """A share in percent with two digits that count, however small."""
    value = 100.0 * share
    return f"{value:.0f} %" if value >= 9.95 or value == 0.0 else f"{float(f'{value:.2g}'):g} %"


UNKNOWN: tuple[int, ...] = (-1,)  # what stands for the elements of a change that is no damage of an element
_SHOWN = 8


@dataclass(frozen=True)
class Hypothesis:
    """One explanation of the values.

    Attributes
    ----------
    elements : tuple of int
        Damaged elements, zero-based; empty for no damage, ``(-1,)`` for a change that no element explains.
    probability : float
        After the test.
    severities : tuple of float
        Most probable stiffness losses.
    low, high : tuple of float
        90 % intervals of these, given the hypothesis.
    candidate : bool
        False for an element that was no candidate, and for what is in no element.
    kind : str
        ``'element'``: a loss of stiffness; ``'crack'``: a hinge in an element, whose severity is the loss of
        the whole element that is as flexible; ``'crack and element'``: one of each; ``'joint'``,
        ``'support'``, ``'mass'``, ``'sensor'``: something else, of which ``elements`` is ``(-1,)``;
        ``'unknown'``.
    place : str
        Where a crack or something else is, with the 90 % interval of a crack's place.

    Examples
    --------
    >>> import antires_rs as ar
    >>> one = ar.Hypothesis((4,), 0.97, (0.55,), (0.52,), (0.58,), candidate=True)
    >>> one.unknown, one.probability
    (False, 0.97)
    """

    elements: tuple[int, ...]
    probability: float
    severities: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    candidate: bool
    kind: str = "element"
    place: str = ""

    @property
    def unknown(self) -> bool:
        """Whether no element explains the change."""
        return self.elements == UNKNOWN


class Hypotheses(Viewed):
    """All hypotheses that were judged, the most probable first; a sequence that prints as a table.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> result = ar.assess_damage(case.model, case.exact(level=1), baseline=case.exact(level=0))
    >>> result.hypotheses[0].elements, round(result.hypotheses[0].severities[0], 2)
    ((4,), 0.55)
    """

    def __init__(self, rows: Sequence[Hypothesis], names: dict[int, str]) -> None:
        self._rows, self._names = tuple(rows), names

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, at: Any) -> Any:
        return self._rows[at]

    def __iter__(self) -> Iterator[Hypothesis]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Hypotheses) and (self._rows, self._names) == (other._rows, other._names)

    def __hash__(self) -> int:
        return hash(self._rows)

    @property
    def names(self) -> dict[int, str]:
        """What the model's elements are called, by number."""
        return dict(self._names)

    def called(self, one: Hypothesis) -> str:
        """A hypothesis in words."""
        if one.unknown:
            return one.place or "something else"
        if not one.elements:
            return "no damage"
        crack = f": {one.place}" if one.place else ""
        return self.named(one.elements) + crack + ("" if one.candidate else " (no candidate)")

    def named(self, elements: Sequence[int]) -> str:
        """Elements by name."""
        return " and ".join(self._names[e] for e in elements)

    @property
    def probability(self) -> FloatArray:
        """Probabilities, (n,)."""
        return np.array([one.probability for one in self._rows])

    def to_dataframe(self) -> Any:
        """As a pandas table: the attributes of :class:`Hypothesis`."""
        return self._view("to_dataframe")(self)

    def plot(self, ax: Any = None, most: int = 8) -> Any:
        """Bars of the probabilities; see :func:`antires_rs.figures.plot_hypotheses`."""
        return self._view("plot")(self, ax=ax, most=most)

    def __str__(self) -> str:
        lines = []
        for one in self._rows[:_SHOWN]:
            columns = zip(one.severities, one.low, one.high, strict=True)
            losses = ", ".join(loss(*row, " %") for row in columns)
            lines.append((f"{one.probability:.3f}", self.called(one), losses))
        wide = max(len(words) for _, words, _ in lines)
        shown = ["probability  hypothesis" + " " * max(wide - 8, 2) + "stiffness loss (90 %)"]
        shown += [f"      {p}  {words:<{wide}}  {losses}".rstrip() for p, words, losses in lines]
        if len(self._rows) > _SHOWN:
            rest = sum(one.probability for one in self._rows[_SHOWN:])
            shown.append(f"      {rest:.3f}  {len(self._rows) - _SHOWN} others together")
        return "\n".join(shown)

    def __repr__(self) -> str:
        return f"Hypotheses({len(self._rows)}, {self.called(self._rows[0])}: {self._rows[0].probability:.3f})"


# -- What an assessment came to: hypotheses, how well the best explains the values, how wrong the model is

_HARDLY = 1e-3  # below this probability of so large a chi-square, the best explanation does not explain
#: A model that needs factors which scatter more is of another structure: that of the exhaust, never updated,
#: 0.22; chains and frames with every term up to 20 % off 0.16; a wrong support or dof 0.3 and more.
_FAR_OFF = 0.3
#: Nor is one that misses frequencies by so much whatever its factors: the frame of the exhaust, never updated
#: and up to 39 % off, 0.04; models with a wrong dof, force or unit 0.08 to 0.15.
_MISSED = 0.06


@dataclass(frozen=True, kw_only=True)
class Taught:
    """What the baseline has told, as an assessment and what is prepared for it have it."""

    threshold: float | None  # log odds of damage to declare it; where a rate of false alarms was asked for
    detectable: tuple[float, ...]  # severity of each candidate that nine of ten such tests would show
    assumed_std: bool  # whether some values had no standard deviation
    n_intact: int  # values of the baseline
    n_intact_matched: int  # of these with a partner in the model
    n_baselines: int  # tests, the most with one force
    scatter: float  # between these over their standard deviations, which were multiplied by it
    notes: tuple[str, ...] = ()
    odd_baselines: tuple[int, ...] = ()  # positions of the sets that contradict the others
    baseline_gap: float = 0.0  # how far these are from the others, relative
    usual_gap: float = 0.0  # how far the others are apart
    n_intact_roots: int = 0  # of the model among the values of the baseline; 0: not counted
    missing_support: str = ""  # where one more would make the model explain the baseline far better


@dataclass(frozen=True, eq=False, kw_only=True)
class Assessment(Value, Taught):
    """The answer to a baseline assessment, without the model."""

    hypotheses: Hypotheses
    group: tuple[Hypothesis, ...]  # the most probable damage of candidates and what cannot be told from it
    declared: tuple[int, ...]  # elements declared damaged
    chi_square: float  # of the most probable hypothesis, reduced; NaN where no value has a partner
    n_values: int  # of now
    n_matched: int  # of these with a partner among the model's roots
    kappa: float  # share of a predicted change that counts as its error
    factor_std: float  # relative scatter of the model's stiffness and mass factors
    root_std: float  # relative error of a frequency that no factor explains
    baseline: bool
    interrupted: bool = False
    moved_alike: float = 0.0  # relative change of all values alike, where that is what has happened
    n_risen: int = 0  # values that have risen, where most have and no hypothesis explains them
    n_moved: int = 0  # of so many that have moved
    hint: str = ""  # a mistake of units that would account for a misfit of the model or of both states
    unfit: str = ""  # what the data check of a test calls fatal

    @property
    def best(self) -> Hypothesis:
        """The most probable hypothesis."""
        return next(iter(self.hypotheses))

    @property
    def probability_of_nothing(self) -> float:
        """That nothing has changed."""
        return sum(one.probability for one in self.hypotheses if not one.elements)

    @property
    def probability_elsewhere(self) -> float:
        """That something has changed which none of the candidates explains."""
        return sum(one.probability for one in self.hypotheses if not one.candidate)

    @property
    def model_fits(self) -> bool:
        """Whether the model, its factors adjusted, explains the intact structure."""
        matched = few_alone(self.n_intact_matched, self.n_intact)
        paired = mostly_paired(self.n_intact_matched, self.n_intact, self.n_intact_roots or self.n_intact)
        return not self.baseline or bool(matched and paired and self.near and not self.missing_support)

    @property
    def near(self) -> bool:
        """Whether the model's own errors are such as a model of the structure may have."""
        return self.factor_std <= _FAR_OFF and self.root_std <= _MISSED

    @property
    def states_fit(self) -> bool:
        """Whether both states can be of one structure: half of the values of now have a partner in the model,
        or something has changed that no element explains and no mistake of units either."""
        few = 2 * self.n_matched < self.n_values
        return not (self.baseline and few) or bool(self.best.unknown and not self.hint)

    @property
    def explained(self) -> bool:
        """Whether the values are what the most probable hypothesis leads to expect, errors considered."""
        from scipy.special import chdtrc

        spare = max(self.n_matched - len(self.best.severities), 1)
        fits = float(chdtrc(spare, self.chi_square * spare)) > _HARDLY
        return bool(fits and (not self.best.unknown or self.best.place))

    @property
    def answer(self) -> Hypothesis | None:
        """The hypothesis that was declared; None where nothing was."""
        return next((one for one in self.hypotheses if self.declared and one.elements == self.declared), None)

    @property
    def severities(self) -> dict[int, float]:
        """Losses of the elements declared damaged."""
        one = self.answer
        return dict(zip(one.elements, one.severities, strict=True)) if one else {}

    @property
    def intervals(self) -> dict[int, tuple[float, float]]:
        """90 % intervals of these."""
        one = self.answer
        return dict(zip(one.elements, zip(one.low, one.high, strict=True), strict=True)) if one else {}

    def marginal(self, element: int) -> float:
        """Probability that a candidate is damaged."""
        own = [one.probability for one in self.hypotheses if one.candidate and element in one.elements]
        return min(float(np.sum(own)), 1.0)


#: A group holds this share of the probability of its kind; and has at most so many hypotheses.
_GROUPED, _MOST_ALTERNATIVES = 0.9, 4


def together(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The most probable damage of candidates with its alternatives; none where more than a few are needed."""
    damage = [one for one in hypotheses if one.candidate and one.elements]
    shares = np.cumsum([one.probability for one in damage])
    count = 1 + int(np.searchsorted(shares, _GROUPED * shares[-1])) if damage else 0
    return damage[:count] if count <= _MOST_ALTERNATIVES else []


# -- Sets whose further elements lose next to nothing are the same answer as the smaller set

#: A loss below it is none; nor is one of so small a share of the largest, in ln(1 - loss), which errors of
#: the model make beside it: so many times the scatter of its factors, at most the latter.
_IDLE, _OF_FACTORS, _BESIDE = 0.005, 0.5, 0.02
_NONE = 5e-4  # intervals of losses that begin below it hold none


def without_idle(found: Assessment) -> Assessment:
    """The same with the probability of each such set added to the smaller one."""
    rows: list[Hypothesis] = list(found.hypotheses)
    beside = min(_OF_FACTORS * found.factor_std, _BESIDE)
    smaller = [_smaller(one, beside) for one in rows]
    first = smaller[0]
    # The answer itself: no damage, where every loss may be none.
    possible = first.candidate and any(not one.elements and one.probability > 0.0 for one in rows)
    if possible and first.severities and max(first.severities) < _IDLE and max(first.low) < _NONE:
        smaller[0] = replace(first, elements=(), severities=(), low=(), high=())
    if smaller == rows:
        return found
    what, less = (  # elements, or what else has changed
        [(one.elements, one.place if one.unknown else "") for one in own] for own in (rows, smaller)
    )
    merged = dict(zip(reversed(less), reversed(smaller), strict=True)) | dict(zip(what, rows, strict=True))
    share: dict[tuple[Any, ...], float] = {}
    for one, key in zip(rows, less, strict=True):
        share[key] = share.get(key, 0.0) + one.probability
    summed = {key: replace(merged[key], probability=p) for key, p in share.items()}
    of = {key: summed[smaller_key] for key, smaller_key in zip(what, less, strict=True)}
    first, declared = of[what[0]], of.get((found.declared, ""))
    ordered = sorted(summed.values(), key=lambda one: (one is not first, -one.probability, one.elements))
    group = tuple([*dict.fromkeys(of[one.elements, ""] for one in found.group)] or together(ordered))
    named = Hypotheses(ordered, found.hypotheses._names)
    kept = found.declared if declared is None else declared.elements
    return replace(found, hypotheses=named, group=group, declared=kept)


def _smaller(one: Hypothesis, beside: float) -> Hypothesis:
    """The set without the elements that lose next to nothing; itself where all of them do."""
    columns = zip(one.elements, one.severities, one.low, one.high, strict=False)
    least = max(_IDLE, -float(np.expm1(beside * np.log1p(-max(one.severities, default=0.0)))))
    kept = [row for row in columns if row[1] >= least]
    if not kept or len(kept) == len(one.severities):
        return one
    elements, severities, low, high = zip(*kept, strict=True)
    ends = tuple(f"in element {e}" for e in elements)
    places = [place for place in one.place.split("; ") if place.endswith(ends)]
    kind = "crack and element" if places else "element"
    kind, place = "crack" if len(places) == len(elements) else kind, "; ".join(places)
    return replace(one, elements=elements, severities=severities, low=low, high=high, kind=kind, place=place)


class Answered:
    """What everything has that holds an assessment of elements with severities."""

    if TYPE_CHECKING:

        @property
        def assessment(self) -> Assessment:
            """What it rests on."""

        @property
        def severity(self) -> Mapping[int, float]:
            """Stiffness loss of each candidate."""

    @property
    def damaged(self) -> list[int]:
        """Elements with damage, the worst first."""
        return sorted((e for e, beta in self.severity.items() if beta > 0), key=lambda e: -self.severity[e])

    @property
    def probability(self) -> dict[int, float]:
        """Probability that each candidate is damaged, summed over all hypotheses."""
        return {e: self.assessment.marginal(e) for e in self.severity}

    @property
    def interval(self) -> dict[int, tuple[float, float]]:
        """90 % interval of each severity, given the elements declared damaged; (0, 0) of the others."""
        limits = self.assessment.intervals
        return {e: limits.get(e, (0.0, 0.0)) for e in self.severity}

    @property
    def hypotheses(self) -> Hypotheses:
        """The explanations that were judged, the most probable first; of an ``Assessor`` from 0.1 % on."""
        return self.assessment.hypotheses

    @property
    def probability_of_damage(self) -> float:
        """Probability that anything has changed, be it what none of the candidates explains."""
        return 1.0 - self.assessment.probability_of_nothing

    @property
    def probability_elsewhere(self) -> float:
        """Probability that something has changed which none of the candidates explains."""
        return self.assessment.probability_elsewhere

    @property
    def chi_square(self) -> float:
        """Chi-square of the most probable hypothesis, over its degrees of freedom."""
        return self.assessment.chi_square
