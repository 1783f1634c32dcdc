"""Probabilities and intervals in percent, as they are printed."""

from __future__ import annotations

__all__ = ["percent", "span"]


def span(low: float, high: float) -> str:
    """An interval in percent; ends that are not the same do not look the same.

    Examples
    --------
    >>> span(0.389, 0.412), span(0.3998, 0.4003)
    ('38.9 to 41.2', '39.98 to 40.03')
    """
    digits = 1 if high - low >= 2e-3 or high == low else 2
    return f"{100 * low:.{digits}f} to {100 * high:.{digits}f}"


def percent(probability: float) -> str:
    """A probability in percent; what is nearly 0 or 1 is not rounded to it."""
    if probability > 0.999:
        return "above 99.9 %"
    return "below 0.1 %" if probability < 0.001 else f"{100 * probability:.1f} %"
