"""Probabilities and intervals in percent, as they are printed."""

from __future__ import annotations

__all__ = ["figure", "percent", "span"]


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


def figure(share: float) -> str:
    """A share in percent with two digits that count, however small.

    Examples
    --------
    >>> figure(0.0421), figure(0.00037), figure(0.6), figure(0.0)
    ('4.2 %', '0.037 %', '60 %', '0 %')
    """
    value = 100.0 * share
    return f"{value:.0f} %" if value >= 9.95 or value == 0.0 else f"{float(f'{value:.2g}'):g} %"
