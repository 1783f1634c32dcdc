"""Probabilities and intervals in percent, as they are printed."""

from __future__ import annotations

__all__ = ["figure", "loss", "percent", "span"]


def span(low: float, high: float) -> str:
    """An interval in percent; ends that are not the same do not look the same.

    Examples
    --------
    >>> span(0.389, 0.412), span(0.3998, 0.4003)
    ('38.9 to 41.2', '39.98 to 40.03')
    """
    digits = _digits(low, high)
    return f"{100 * low:.{digits}f} to {100 * high:.{digits}f}"


def loss(severity: float, low: float, high: float, unit: str = "") -> str:
    """A loss with its interval, in the same digits: it does not look as if it lay outside.

    Examples
    --------
    >>> loss(0.4, 0.389, 0.412), loss(0.0004, 0.0001, 0.0011, " %")
    ('40.0 (38.9 to 41.2)', '0.04 % (0.01 to 0.11)')
    """
    return f"{100 * severity:.{_digits(low, high)}f}{unit} ({span(low, high)})"


def _digits(low: float, high: float) -> int:
    return 1 if high - low >= 2e-3 or high == low else 2


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
