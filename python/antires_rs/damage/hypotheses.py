"""Hypotheses and their probabilities, as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..support.checks import FloatArray
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


#: Elements of the hypothesis that something else has changed.
UNKNOWN = (-1,)
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
        False for an element that was no candidate, and for the unknown change.

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

    @property
    def unknown(self) -> bool:
        """Whether no element explains the change."""
        return self.elements == UNKNOWN


class Hypotheses(Viewed):
    """All hypotheses that were judged, the most probable first; a sequence that prints as a table.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 300.0, 500.0])
    >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
    ...                for m in (intact, damaged))
    >>> result = ar.assess_damage(intact, now, baseline=before)
    >>> result.hypotheses[0].elements, round(result.hypotheses[0].severities[0], 2)
    ((1,), 0.4)
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
            return "something else"
        if not one.elements:
            return "no damage"
        words = " and ".join(self._names[e] for e in one.elements)
        return words if one.candidate else f"{words} (no candidate)"

    @property
    def probability(self) -> FloatArray:
        """Probabilities, (n,)."""
        return np.array([one.probability for one in self._rows])

    def to_dataframe(self) -> Any:
        """As a pandas table: elements, probability, severities, low, high, candidate."""
        return self._view("to_dataframe")(self)

    def plot(self, ax: Any = None, most: int = 8) -> Any:
        """Bars of the probabilities; see :func:`antires_rs.figures.plot_hypotheses`."""
        return self._view("plot")(self, ax=ax, most=most)

    def __str__(self) -> str:
        lines = []
        for one in self._rows[:_SHOWN]:
            losses = ", ".join(
                loss(s, low, high, " %")
                for s, low, high in zip(one.severities, one.low, one.high, strict=True)
            )
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
