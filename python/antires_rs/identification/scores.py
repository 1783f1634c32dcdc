r"""What speaks for an accepted antiresonance, beyond that it stands still.

===============  =====================================================================================
score            what it says
===============  =====================================================================================
rows             model orders of its chain (or those in which a persistent one was seen)
spread           relative standard deviation of its frequency over these orders
dominance        share of the curve that the pole owns at its frequency; 1 is all of it
how              "chain": stable in consecutive orders; "persistent": in most orders, without standing still;
                 "likeliest order": accepted at once from the fit of the order that the data support;
                 "double root": two roots or more of several forces that are not told apart, as their mean;
                 "windows": seen by most of the fits over windows;
                 "directions": seen again by most of the perturbed local fits
residual         relative misfit of the fit around the value
prominence_db    height of its peak in the summed transmissibilities
grade            "sure", "fair" or "weak", :func:`graded`; averaged records only
doubt            what the data check finds fatal about all channels; only then
second           second eigenvalue of the spectral matrix over the first, beside it; averaged records only
averages         independent averages behind its standard deviation, where it is told by segments
===============  =====================================================================================

None of them tells true from false alone: a true antiresonance in the noise may have no peak at all, a false
one may own its curve or lie where the fit is perfect. Together they do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import (
    LEAST_DOMINANCE,
    LEAST_PROMINENCE_DB,
    MORE_ROWS,
    MOST_RESIDUAL,
    MOST_SPREAD,
    SURE_DEPTH_DB,
    SURE_SHARE,
    SURE_SPREAD,
    ResponseTable,
)
from ..signals import channel_checks as channels
from ..signals.findings import DataCheck
from ..signals.one_force import NOISE, ONE_FORCE, UNEXPLAINED
from ..signals.repeats import DIFFER
from ..signals.spectra import prominent_peaks
from ..support.checks import ComplexArray, FloatArray, members
from .stabilization import PERSISTENT_SNR, StabilizationDiagram, flanked

WEAK_SHARE, WEAK_DEPTH_DB = 0.7, 4.0  # of fits over windows

# A value's surroundings, in half-power bandwidths 2 zeta f; never fewer lines than the last number.
NEAR_WIDTHS, LEAST_LINES = 3.0, 4
# The foot of a peak: from so many bandwidths on, to so many. A single peak lies 14 to 22 dB over it.
FOOT_WIDTHS = (2.5, 7.5)


def scored(
    table: ResponseTable,
    freq_hz: FloatArray,
    background: FloatArray,
    data: ComplexArray,
    fitted: ComplexArray,
) -> ResponseTable:
    """The same antiresonances with the misfit of the fit around each, and its height over its foot in dB."""
    power, spacing = np.abs(background) ** 2, float(np.median(np.diff(freq_hz)))
    residual, prominence = np.full((2, len(table)), np.nan)
    for i, (value, damping) in enumerate(zip(table.freq_hz, table.damping_ratio, strict=True)):
        width = max(2.0 * abs(damping) * value, LEAST_LINES * spacing / 2.0)
        off = np.abs(freq_hz - value)
        near = np.flatnonzero(off <= NEAR_WIDTHS * width)
        if near.size:
            some = slice(near[0], near[-1] + 1)
            size = np.maximum(np.sum(np.abs(fitted[:, some]) ** 2, axis=0), 1e-300)
            misfit = np.sum(np.abs(data[:, some] - fitted[:, some]) ** 2, axis=0)
            residual[i] = np.sqrt((misfit / size).mean())
        peak, foot = off <= 0.5 * width, (off <= FOOT_WIDTHS[1] * width) & (off > FOOT_WIDTHS[0] * width)
        if peak.any() and foot.any():
            low = max(median(power[foot].tolist()), 1e-300)
            prominence[i] = 10.0 * np.log10(max(float(power[peak].mean()), 1e-300) / low)
    return table.with_scores(residual=residual, prominence_db=prominence)


def graded(table: ResponseTable) -> ResponseTable:
    """The antiresonances of averaged records with a grade: "sure" passes four or five tests, "fair" three.

    What is not known (NaN) is not passed. Limits were set on 317 values of chain8 (seeds 100 to 102). Of
    other records (0 to 10 % noise; ten other structures) 0.3 % of 1680 "sure" values were false, 2.3 % of
    261 "fair" and 10 % of 51 "weak" ones, and 95 % of the errors were below 0.06, 0.3 and 0.4 %.
    """
    tests = [
        table.rows > MORE_ROWS,
        table.spread <= MOST_SPREAD,
        table.dominance >= LEAST_DOMINANCE,
        table.residual <= MOST_RESIDUAL,
        table.prominence_db >= LEAST_PROMINENCE_DB,
    ]
    passed = np.sum([np.asarray(test, dtype=int) for test in tests], axis=0)
    return table.with_scores(grade=np.where(passed >= 4, "sure", np.where(passed == 3, "fair", "weak")))


def window_grades(share: FloatArray, spread: FloatArray, depth_db: FloatArray) -> Any:
    """One word for each antiresonance of fits over windows.

    On six states of a measured plate 1 of 104 "sure" values, 2 of 27 "fair" and 10 of 20 "weak" ones had no
    dip of 3 dB. Three tests of one plate had 26 of 48 "sure", 9 of 15 "fair" and 2 of 13 "weak" ones in
    common.
    """
    sure = (share >= SURE_SHARE) & (spread <= SURE_SPREAD) & (depth_db >= SURE_DEPTH_DB)
    weak = (share < WEAK_SHARE) | (depth_db < WEAK_DEPTH_DB)
    return np.where(sure, "sure", np.where(weak, "weak", "fair"))


# -- What the data check says of the data a value rests on
#
# A channel of which it says that it holds nothing has no value. Where more than one force acts in
# much of the band, or none is told from noise beside a value, it is weak whatever the fits say.

LOST = {  #: Fatal findings of channels, or of all of them, and what is said of their values.
    channels.DEAD: "only noise in this channel",
    channels.CLIPPED: "channel clipped",
    channels.QUANTIZED: "channel of too few steps",
    channels.TIME_SHIFT: "channel on another clock",
    channels.DUPLICATED: "all channels hold one signal",
    NOISE: "nothing rises over the noise",
}
#: Fatal findings that leave no value sure, and the doubt.
MISLEADING = {
    ONE_FORCE: "second force",
    DIFFER: "records differ",
    channels.LENGTH: "record too short",
    channels.RESOLUTION: "lines too far apart",
}
#: Width about a value, as a share of it, over which eigenvalues are looked at, and never fewer lines.
BESIDE, LINES_BESIDE = 0.015, 5
BLIND = "fewer forces than named above noise"  # why a value of several forces is left out


def of_lost_channels(
    found: dict[Any, StabilizationDiagram], checked: DataCheck | None
) -> dict[Any, StabilizationDiagram]:
    """Diagrams in which channels that hold nothing have no values, and say so."""
    made = dict(found)
    for one in () if checked is None else checked.findings:
        if one.severity == "fatal" and one.name in LOST:
            for dof in set(one.where or found) & set(found):
                made[dof] = _left_out(made[dof], np.arange(len(made[dof].accepted)), LOST[one.name])
    return made


def of_blind_lines(
    found: dict[Any, StabilizationDiagram], freq_hz: FloatArray, known: NDArray[np.bool_]
) -> dict[Any, StabilizationDiagram]:
    """Diagrams without values beside which most lines are not ``known``: they hold no direction."""
    made = {}
    for dof, one in found.items():
        here = [bool(np.median(known[_beside(freq_hz, f)]) < 1.0) for f in one.accepted.freq_hz.tolist()]
        made[dof] = _left_out(one, np.flatnonzero(here), BLIND)
    return made


def _beside(freq_hz: FloatArray, value: float) -> NDArray[np.intp]:
    """Lines near a value, a few at least."""
    off = np.abs(freq_hz - value)
    last = min(LINES_BESIDE, freq_hz.size) - 1
    return np.flatnonzero(off <= max(BESIDE * value, float(np.partition(off, last)[last])))


def with_second(table: ResponseTable, checked: DataCheck | None) -> ResponseTable:
    """Antiresonances with the second eigenvalue over the first beside each, weak where it is large.

    Of r forces the one beyond r over that of r. All are weak where the check finds something fatal about all
    channels: a record too short for its resonances misplaces what it shows clearly.
    """
    if checked is None:
        return table
    fatal = [
        MISLEADING[one.name] for one in checked.findings if one.severity == "fatal" and one.name in MISLEADING
    ]
    if fatal and "grade" in table.scores:
        doubt = np.full(len(table), ", ".join(dict.fromkeys(fatal)))
        table = table.with_scores(grade=np.full(len(table), "weak"), doubt=doubt)
    if checked.freq_hz is None or checked.second_expected is None:
        return table
    assert checked.eigenvalues is not None
    order = len(members(checked.excitation))
    if checked.eigenvalues.shape[1] <= order:
        return table
    share = checked.eigenvalues[:, order] / np.maximum(checked.eigenvalues[:, order - 1], 1e-300)
    shares = np.array([median(share[_beside(checked.freq_hz, f)].tolist()) for f in table.freq_hz])
    if "grade" in table.scores:
        table = table.with_scores(grade=np.where(shares > UNEXPLAINED, "weak", table.scores["grade"]))
    return table.with_scores(second=shares)


# -- Where a curve has a dip, and how deep it is: as far as the curve climbs on both sides, within a reach or
# until it falls below the minimum, the lower of the two (the prominence of the minimum)

# On either side a dip is followed this far, as a share of its frequency; never less than the second number
# of lines. A zero of 4 % damping makes a dip of 3 dB.
DIP_REACH, DIP_LINES = 0.04, 4


def dips(
    freq_hz: FloatArray, level_db: FloatArray, least_db: float, around_hz: tuple[float, float] | None = None
) -> tuple[NDArray[np.intp], FloatArray]:
    """Lines at which a curve has a dip, and the depths in dB."""

    def climb(side: FloatArray, floor: float) -> float:
        below = np.flatnonzero(side < floor)
        some = side[: below[0]] if below.size else side
        return float(some.max(initial=floor) - floor)

    lines = prominent_peaks(-level_db, least_db)  # No dip is deeper within its reach than without bounds.
    if around_hz is not None:
        lines = lines[(freq_hz[lines] >= around_hz[0]) & (freq_hz[lines] <= around_hz[1])]
    step = float(np.median(np.diff(freq_hz)))
    depths = np.empty(lines.size)
    for i, line in enumerate(lines.tolist()):
        reach = max(DIP_LINES, int(DIP_REACH * freq_hz[line] / step))
        left, right = level_db[max(line - reach, 0) : line][::-1], level_db[line + 1 : line + 1 + reach]
        depths[i] = min(climb(left, level_db[line]), climb(right, level_db[line]))
    deep = depths >= least_db
    return np.asarray(lines[deep], dtype=np.intp), depths[deep]


# A peak of the curve behind a diagram this high, after averaging the power over so many lines, is named
# where no accepted antiresonance lies within this share of its frequency.
PEAK_DB, PEAK_LINES, EXPLAINED_WITHIN = 10.0, 5, 0.02


def unexplained(
    freq_hz: FloatArray, background: FloatArray, known_hz: FloatArray, snr: FloatArray
) -> FloatArray:
    """Frequencies in Hz of high peaks of a curve, not of noise, beside which nothing was seen."""
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

# Roots of all responses this close, relative to abs(s), are one common factor of the numerators.
SHARED = 0.003
# Largest spread over the channels of a value that they share. On measured frames and beams at most 0.41 %;
# antiresonances of neighbouring parts of a chain came within 0.6 %.
COMMON = 0.005
#: Why such a value is left out: a harmonic of a strong mode, a line of the force, a mode it hardly excites.
COMMON_TO_ALL = "all responses share it"
# Depth of a dip from which it is the response's own, though all others have one beside it.
COMMON_DEPTH_DB = 10.0


def shared(values: Any, others: Sequence[Any], within: float = SHARED) -> NDArray[np.bool_]:
    """Whether all of two or more ``others`` have a member within this share of each value, (n,).

    Values may be roots or frequencies. One of ``others`` may be (n, m), with members of its own for each.
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
    """Diagrams that leave out what all of three or more dofs have, spread by no more than ``COMMON``.

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
                scores = found[dof].accepted.scores
                depths = [scores[name][i] for name in ("depth_db", "own_depth_db") if name in scores]
                if not (depths and np.fmin(*depths) >= COMMON_DEPTH_DB):
                    drop[dof].add(i)
    return {
        dof: _left_out(d, np.array(sorted(drop[dof]), dtype=np.intp), COMMON_TO_ALL)
        for dof, d in found.items()
    }


def _left_out(one: StabilizationDiagram, rows: NDArray[np.intp], why: str) -> StabilizationDiagram:
    """The diagram with some of its values among those left out."""
    if not rows.size:
        return one
    out = one.accepted.take(rows).with_scores(why=np.full(rows.size, why))
    left = ResponseTable.concatenated([one.left_out, out]) if len(one.left_out) else out
    return replace(
        one, accepted=one.accepted.take(np.delete(np.arange(len(one.accepted)), rows)), left_out=left
    )
