"""Where a curve has a dip, and how deep it is.

The depth of a local minimum is what an eye would say: how far the curve climbs on both sides, within a reach
or until it falls below the minimum, the lower of the two (the prominence of the minimum).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.half_spectra import prominent_peaks
from ..support.checks import FloatArray
from .rule import (
    COMMON,
    COMMON_DEPTH_DB,
    DIP_LINES,
    DIP_REACH,
    EXPLAINED_WITHIN,
    PEAK_DB,
    PEAK_LINES,
    PERSISTENT_SNR,
    SHARED,
)
from .stabilization import StabilizationDiagram, flanked


def dips(
    freq_hz: FloatArray, level_db: FloatArray, least_db: float, around_hz: tuple[float, float] | None = None
) -> tuple[NDArray[np.intp], FloatArray]:
    """Lines at which a curve has a dip, and the depths in dB."""

    # No dip is deeper within its reach than without bounds.
    lines = prominent_peaks(-level_db, least_db)
    if around_hz is not None:
        lines = lines[(freq_hz[lines] >= around_hz[0]) & (freq_hz[lines] <= around_hz[1])]
    step = float(np.median(np.diff(freq_hz)))
    at, depths = [], []
    for line in lines.tolist():
        reach = max(DIP_LINES, int(DIP_REACH * freq_hz[line] / step))
        left = level_db[max(line - reach, 0) : line][::-1]
        depth = min(
            _climb(left, level_db[line]), _climb(level_db[line + 1 : line + 1 + reach], level_db[line])
        )
        if depth >= least_db:
            at.append(line)
            depths.append(depth)
    return np.array(at, dtype=np.intp), np.array(depths)


def _climb(side: FloatArray, floor: float) -> float:
    """How far a side rises over the minimum before it falls below it."""
    below = np.flatnonzero(side < floor)
    some = side[: below[0]] if below.size else side
    return float(some.max(initial=floor) - floor)


# -- Peaks of the curve behind a diagram that no accepted antiresonance explains


def unexplained(
    freq_hz: FloatArray, background: FloatArray, known_hz: FloatArray, snr: FloatArray
) -> FloatArray:
    """Frequencies in Hz of high peaks of a curve beside which no antiresonance was seen.

    A response must rise out of its noise on both flanks of a peak.
    """
    if freq_hz.size < 2 * PEAK_LINES:
        return np.empty(0)
    power = np.convolve(np.abs(background) ** 2, np.full(PEAK_LINES, 1.0 / PEAK_LINES), mode="same")
    at, _ = dips(freq_hz, -10.0 * np.log10(np.maximum(power, 1e-300)), PEAK_DB)
    peaks = freq_hz[at]
    peaks = peaks[flanked(freq_hz, snr, peaks, PERSISTENT_SNR)]
    if not known_hz.size:
        return np.asarray(peaks)
    off = np.abs(peaks[:, None] / known_hz - 1.0).min(axis=1, initial=np.inf)
    return np.asarray(peaks[off > EXPLAINED_WITHIN])


# -- What all channels share is no property of one of them
#
# A root that all numerators have is a common factor, which cancels in every transmissibility. A value that
# all of three or more responses have is the zero beside a mode that the force hardly excites.


def shared(values: Any, others: Sequence[Any], within: float = SHARED) -> NDArray[np.bool_]:
    """Whether all of two or more ``others`` have a member within this share of each value, (n,).

    Values may be roots in the complex plane or frequencies. One of ``others`` may be (n, m), with members
    of its own for each value.
    """
    if len(others) < 2:
        return np.zeros(values.size, dtype=bool)
    size = within * np.abs(values)
    every = np.ones(values.size, dtype=bool)
    for other in others:
        every &= np.abs(other - values[:, None]).min(axis=1, initial=np.inf) <= size
        if not every.any():
            break
    return every


def without_common(found: dict[Any, StabilizationDiagram]) -> dict[Any, StabilizationDiagram]:
    """Diagrams less the values that all of three or more dofs have, spread by no more than ``COMMON``.

    Where depths are known, a deep dip stays: what all share takes little of each curve.
    """
    if len(found) < 3:
        return found
    drop: dict[Any, set[int]] = {dof: set() for dof in found}
    values = [d.identified for d in found.values()]
    first, *others = values
    for value in first[shared(first, others, COMMON)]:
        nearest = [int(np.argmin(np.abs(each - value))) for each in values]
        same = [each[i] for each, i in zip(values, nearest, strict=True)]
        # A mode gives each channel one such value; two in one channel belong to two parts of the structure.
        once = all(np.sum(np.abs(each - value) <= COMMON * value) <= 1 for each in values)
        if once and max(same) - min(same) <= COMMON * value:
            for dof, i in zip(found, nearest, strict=True):
                if not _deep(found[dof].accepted, i):
                    drop[dof].add(i)
    return {
        dof: replace(d, accepted=d.accepted.take([i for i in range(d.identified.size) if i not in drop[dof]]))
        for dof, d in found.items()
    }


def _deep(table: ResponseTable, i: int) -> bool:
    """Whether an antiresonance of fits over windows has a deep dip."""
    if "depth_db" not in table.scores:
        return False
    return float(np.fmin(table.scores["depth_db"][i], table.scores["own_depth_db"][i])) >= COMMON_DEPTH_DB
