"""The frequencies of responses whose file does not hold them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..support.validation import FloatArray, finite_scalar, reject
from ..support.wording import Passed, Wording
from ._common import unsuitable

__all__ = ["GivenAxis", "given_axis"]


class GivenAxis:
    """Frequencies that the caller gives: all of them, or their spacing from 0 Hz on.

    Attributes
    ----------
    size : int or None
        Number of lines; None where only the spacing is given.
    """

    def __init__(self, freq_hz: Any = None, df_hz: Any = None) -> None:
        self._df_hz = (
            None if df_hz is None else finite_scalar("df_hz", df_hz, low=0.0, low_open=True, unit="Hz")
        )
        self._freq_hz = None if freq_hz is None else _axis(freq_hz)
        self.size = None if self._freq_hz is None else self._freq_hz.size

    def lines(self, path: Path, count: int) -> FloatArray:
        """The frequencies of ``count`` values."""
        if self._freq_hz is None:
            return float(self._df_hz or 0.0) * np.arange(count, dtype=np.float64)
        if self._freq_hz.size != count:
            unsuitable(
                path,
                f"with {count} values of each response",
                f"{self._freq_hz.size}, one for each of freq_hz",
                "Give the frequencies of this file.",
            )
        return self._freq_hz


def given_axis(freq_hz: Any, df_hz: Any) -> GivenAxis | None:
    """The axis by ``freq_hz`` or ``df_hz``; None where neither is given."""
    if freq_hz is None and df_hz is None:
        return None
    if freq_hz is not None and df_hz is not None:
        reject(
            "df_hz",
            "it beside freq_hz",
            "one of them",
            Wording("Leave out {}, which the frequencies tell.", Passed("df_hz")),
        )
    return GivenAxis(freq_hz, df_hz)


def _axis(freq_hz: Any) -> FloatArray:
    try:
        lines = np.asarray(freq_hz, dtype=np.float64)
        got = f"an array of shape {lines.shape}"
    except (TypeError, ValueError):
        lines, got = np.empty((0, 0)), type(freq_hz).__name__
    if lines.ndim != 1 or not np.isfinite(lines).all():
        reject("freq_hz", got, "finite frequencies in Hz, one for each line", "Pass a sequence of numbers.")
    return lines
