"""Losses, names and alternatives in words."""

from __future__ import annotations

from collections.abc import Callable

from .assessment import Assessment
from .hypotheses import Hypothesis
from .percent import percent, span

__all__ = ["Label", "alternatives", "in_words", "intervals", "loss_of", "named", "others", "unseen"]

Label = Callable[[int], str]
#: Alternatives from this probability on are named, so many of them.
_WORTH_A_WORD, _MOST_WORDS = 0.01, 3
#: Intervals wider than this tell nothing.
_UNSEEN = 0.8
#: A loss that is printed as 0.0 %.
_NO_LOSS = 5e-4


def alternatives(found: Assessment, label: Label) -> str:
    """Every damage worth a word."""
    return in_words([one for one in found.hypotheses if one.elements], label)


def others(found: Assessment, declared: Hypothesis, label: Label) -> str:
    """Whatever else is worth a word."""
    return in_words([one for one in found.hypotheses if one is not declared], label)


def in_words(hypotheses: list[Hypothesis], label: Label) -> str:
    """Those worth a word, each with its probability."""
    worth = [one for one in hypotheses if one.probability > _WORTH_A_WORD][:_MOST_WORDS]
    if not worth:
        return "many explanations, none of them probable"
    return "; ".join(
        (
            "nothing"
            if not one.elements
            else "a change that no element explains"
            if one.unknown
            else f"damage of {label(one.elements[0])}, which these values do not show"
            if unseen(one) or max(one.severities) < _NO_LOSS
            else loss_of(one, label)
        )
        + f" ({percent(one.probability)})"
        for one in worth
    )


def unseen(one: Hypothesis) -> bool:
    """Whether the values tell nothing of a loss."""
    return not one.unknown and one.high[0] - one.low[0] > _UNSEEN


def loss_of(one: Hypothesis, label: Label) -> str:
    """Losses in words, without intervals."""
    first, *rest = (
        (label(e), f"{100 * severity:.1f} %")
        for e, severity in zip(one.elements, one.severities, strict=True)
    )
    more = [f"{name} {loss}" for name, loss in rest]
    return " and ".join([f"{first[0]} has lost {first[1]} of its stiffness", *more])


def intervals(one: Hypothesis) -> str:
    """The intervals of all losses."""
    spans = [span(low, high) for low, high in zip(one.low, one.high, strict=True)]
    return f"90 % interval{'s' if len(spans) > 1 else ''} of the loss {' and '.join(spans)} %"


def named(elements: tuple[int, ...], label: Label) -> str:
    """Elements by name."""
    return " and ".join(label(e) for e in elements)
