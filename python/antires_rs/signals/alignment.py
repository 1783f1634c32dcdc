"""Records of sensors with clocks of their own, joined by their instants to one recording.

A sensor's clock is a smooth line through its instants: jitter of single ones is that of the stamps, not of
the samples. Samples are interpolated at the instants of the slowest sensor by a symmetric windowed sinc,
which has no phase of its own; its passband ends at 0.8 of the lower Nyquist frequency. Missed samples are
those that leave the smallest error of an autoregression of their own channel (Janssen, Veldhuis and Vries,
IEEE Trans. ASSP 34 (1986) 317-330, doi 10.1109/TASSP.1986.1164824).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..exceptions import part, reject
from ..support.checks import FloatArray, IntArray
from ..support.messages import some, warn
from .recording import Recording

_HALF = 32  # zero crossings of the kernel on either side
_BETA = 9.0  # of its Kaiser window: images 90 dB down
_DECIMATED = 0.9  # cut of a slower rate, so that the transition ends at its Nyquist frequency
_MOST_MISSED = 10  # samples in one gap that are made up
_ORDER = 32  # of the autoregression
_SMOOTHED = 65  # instants that make one of the clock
_SAME = 1e-3  # part of a step by which instants that are the same may differ
_WRAPS_S = (2.0**32 * 1e-6, 2.0**32 * 1e-3)  # ranges of counters of 32 bits in us and ms
_SHARED = "records whose instants overlap, on a clock that all share"


class _Clocked(NamedTuple):
    """Even samples, channels first, and the instant of each on the clock."""

    rows: FloatArray
    time_s: FloatArray

    @property
    def step_s(self) -> float:
        return float(self.time_s[-1] - self.time_s[0]) / (self.time_s.size - 1)


def align(records: Iterable[Recording], *, dofs: Sequence[Any] | None = None) -> Recording:
    """Join sensors that were recorded each by itself, by the instants of their samples.

    Parameters
    ----------
    records : sequence of Recording
        Each with its ``time_s``, as readers of tables and arrays keep it; one with gaps is read by
        ``align=True``. Clocks have to be one and the same, or synchronized.
    dofs : sequence, optional
        A dof for each channel, record by record; None leaves one out. By default those of the records, which
        then have to differ.

    Returns
    -------
    Recording
        Over the interval that all share, at the lowest rate. Samples of sensors that tick together are as
        they were; others are interpolated and lose 32 samples at the ends of their record. Up to 10 samples
        missed in a row are made up.

    Raises
    ------
    InvalidInputError
        A record without instants, no common interval, a longer gap, jitter of half a step and more, two
        channels of one dof, or several forces.

    Warns
    -----
    AntiresWarning
        Clocks that all begin at zero, which may not be one; a counter of 32 bits that began again; more than
        1 % of a record's samples missed.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> t = np.arange(2000) / 100.0
    >>> base = ar.Recording([np.sin(t)], 100.0, dofs=["base"], time_s=5.0 + t)
    >>> roof = ar.Recording([np.sin(t + 2.0)], 100.0, dofs=["roof"], time_s=7.0 + t)
    >>> ar.align([base, roof])
    Recording(2 channels, 18 s at 100 Hz, dofs=('base', 'roof'), no force)
    """
    every = list(records) if isinstance(records, Iterable) else [records]
    if not every:
        reject("records", "none", "one record or more", "Read each sensor's file.")
    for i, rec in enumerate(every):
        if not isinstance(rec, Recording) or rec.time_s is None:
            got = "a record without instants" if isinstance(rec, Recording) else type(rec).__name__
            remedy = "Read it with its column of time. Without a common clock nothing joins the sensors."
            reject(part("records", i), got, "a Recording with time_s", remedy)
    labels = _labels(every, dofs)
    forces = [rec for rec in every if rec.force is not None]
    if len(forces) > 1:
        reject(
            "records", f"{len(forces)} with a force", "one force at most", "Read the others by force=None."
        )
    clocked = _unwrapped([_clocked(i, rec) for i, rec in enumerate(every)])
    slowest = int(np.argmax([each.step_s for each in clocked]))
    rows, instants = _on_one_clock(clocked, clocked[slowest])
    n = [rec.n_channels for rec in every]
    pushed = next((row[-1] for row, rec in zip(rows, every, strict=True) if rec.force is not None), None)
    responses = np.vstack([row[:count] for row, count in zip(rows, n, strict=True)])
    kept = [i for i, label in enumerate(labels) if label is not None]
    return Recording(responses[kept], every[slowest].fs_hz, [labels[i] for i in kept], pushed, instants)


def _labels(records: Sequence[Recording], dofs: Sequence[Any] | None) -> list[Any]:
    own = [dof for rec in records for dof in rec.dofs]
    labels = own if dofs is None else list(dofs)
    if len(labels) != len(own):
        got = f"{len(labels)} dofs"
        reject("dofs", got, f"{len(own)}, one for each of {own}", "Name them record by record.")
    twice = [dof for dof, count in Counter(labels).items() if count > 1 and dof is not None]
    if twice:
        remedy = "Name every channel: dofs=[...], record by record."
        reject("dofs", f"{some(map(repr, twice))} more than once", "dofs that differ", remedy)
    return labels


def _clocked(number: int, rec: Recording) -> _Clocked:
    """The samples with those that were missed, over a smooth clock."""
    from scipy.ndimage import uniform_filter1d

    name, time_s = part("records", number), np.asarray(rec.time_s)
    counts = np.rint(np.diff(time_s) * rec.fs_hz).astype(int)
    if counts.min() < 1:
        at = time_s[int(np.argmin(counts))]
        got = f"instants that jitter by half a step at {at:.9g} s"
        reject(name, got, f"steps of {1.0 / rec.fs_hz:.4g} s", "Cut out the part that is even.")
    if counts.max() > _MOST_MISSED + 1:
        at, long = time_s[int(np.argmax(counts))], int(counts.max()) - 1
        got = f"a gap of {long} samples at {at:.9g} s"
        reject(name, got, f"at most {_MOST_MISSED} missed in a row", "Cut the records before or after it.")
    index = np.concatenate([[0], np.cumsum(counts)])
    rows = np.vstack([rec.responses, *([] if rec.force is None else [rec.force])])
    full = rows
    if index[-1] >= index.size:
        missed = int(index[-1]) + 1 - index.size
        if missed > 0.01 * index.size:
            said = f"{name}: {missed} of {index[-1] + 1} samples are missing and made up"
            warn("dropouts", f"{said}. Prefer a record without gaps.")
        full = np.vstack([_made_up(row, index) for row in rows])
    count = np.arange(full.shape[1])
    stamps = np.interp(count, index, time_s)
    line = np.polynomial.Polynomial.fit(count, stamps, 1)(count)
    jitter = stamps - line
    if np.abs(jitter).max() > _SAME / rec.fs_hz:
        jitter = uniform_filter1d(jitter, min(_SMOOTHED, jitter.size), mode="nearest")
    return _Clocked(full, line + jitter)


def _made_up(row: FloatArray, index: IntArray) -> FloatArray:
    """A row with the samples that were missed."""
    at = np.arange(int(index[-1]) + 1)
    full, known = np.interp(at, index, row), np.isin(at, index)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(index) > 1) + 1, [index.size]])
    first, last = max(pairwise(edges.tolist()), key=lambda pair: pair[1] - pair[0])
    piece = row[first : min(last, first + 4096)]
    order = min(_ORDER, (piece.size - 1) // 3)
    if order < 1:
        return full
    mean = piece.mean()
    past = np.lib.stride_tricks.sliding_window_view(piece - mean, order + 1)
    weights = np.linalg.lstsq(past[:, :-1], past[:, -1], rcond=1e-10)[0]
    error = np.concatenate([-weights, [1.0]])
    gaps = [np.arange(a + 1, b) for a, b in pairwise(index.tolist()) if b > a + 1]
    for gap in 2 * gaps:  # twice, as gaps beside one another see each other's samples
        low, high = max(int(gap[0]) - order, 0), min(int(gap[-1]) + order, at.size - 1)
        size = high - low + 1
        errors = np.zeros((max(size - order, 0), size))
        for i, line in enumerate(errors):
            line[i : i + order + 1] = error
        unknown = np.isin(np.arange(low, high + 1), gap)
        rest = errors[:, ~unknown] @ (full[low : high + 1][~unknown] - mean)
        full[gap] = mean + np.linalg.lstsq(errors[:, unknown], -rest, rcond=None)[0]
    full[known] = row
    return full


def _unwrapped(clocked: list[_Clocked]) -> list[_Clocked]:
    """The clocks, of which one may have begun again before the others did; refused where none overlap."""

    def overlap(those: Sequence[_Clocked]) -> float:
        return float(min(c.time_s[-1] for c in those) - max(c.time_s[0] for c in those))

    step = max(each.step_s for each in clocked)
    if overlap(clocked) < 3 * _HALF * step:
        last = max(float(each.time_s[0]) for each in clocked)
        for wrap in _WRAPS_S:
            if not all(each.time_s[0] >= 0.0 and each.time_s[-1] < 2.0 * wrap for each in clocked):
                continue
            moved = [
                c._replace(time_s=c.time_s + wrap) if c.time_s[-1] + wrap > last > c.time_s[-1] else c
                for c in clocked
            ]
            if overlap(moved) >= 3 * _HALF * step:
                said = (
                    f"records: clocks are joined where a counter of 32 bits began again, after {wrap:.9g} s"
                )
                warn("own_clocks", f"{said}. See that all are of one test.")
                return moved
        spans = some((f"{c.time_s[0]:.9g} to {c.time_s[-1]:.9g} s" for c in clocked), 6)
        remedy = "Sensors that were not synchronized cannot be joined: identify each setup by itself."
        reject("records", f"no common interval: {spans}", _SHARED, remedy)
    if len(clocked) > 1 and all(abs(each.time_s[0]) < 0.5 * each.step_s for each in clocked):
        said = "records: every clock begins at zero, as if all sensors had been started by one trigger"
        warn("own_clocks", f"{said}. If each began by itself, they cannot be joined.")
    return clocked


def _on_one_clock(clocked: Sequence[_Clocked], slowest: _Clocked) -> tuple[list[FloatArray], FloatArray]:
    """Samples of all at the instants of the slowest that all have, and these instants."""
    begin, end = max(c.time_s[0] for c in clocked), min(c.time_s[-1] for c in clocked)
    places = {}
    for each in clocked:
        place = np.interp(slowest.time_s, each.time_s, np.arange(each.time_s.size))
        inside = (slowest.time_s >= begin - _SAME * each.step_s) & (
            slowest.time_s <= end + _SAME * each.step_s
        )
        if np.abs(place - np.rint(place))[inside].max(initial=0.0) > _SAME:
            half = _HALF * max(slowest.step_s, each.step_s)  # the kernel stays within the record
            begin, end = max(begin, each.time_s[0] + half), min(end, each.time_s[-1] - half)
        places[id(each)] = place
    slack = _SAME * slowest.step_s
    inside = (slowest.time_s >= begin - slack) & (slowest.time_s <= end + slack)
    if np.count_nonzero(inside) < 2 * _HALF:
        reject("records", f"{max(end - begin, 0.0):.4g} s in common", _SHARED, "Record longer together.")
    instants = slowest.time_s[inside]
    return [_at(each, places[id(each)][inside], slowest.step_s) for each in clocked], instants


def _at(each: _Clocked, place: FloatArray, step_s: float) -> FloatArray:
    """Samples at places between them, in steps; whole places are samples."""
    whole = np.rint(place).astype(int)
    if np.abs(place - whole).max() <= _SAME:
        return each.rows[:, whole]
    ratio = each.step_s / step_s
    cut = 1.0 if ratio > 0.98 else _DECIMATED * ratio
    half = int(np.ceil(_HALF / min(ratio, 1.0)))
    grid = np.linspace(0.0, half, 2**16)
    kernel = np.sinc(cut * grid) * np.i0(_BETA * np.sqrt(1.0 - (grid / half) ** 2)) / np.i0(_BETA)
    base = np.floor(place).astype(int)
    out, total = np.zeros((len(each.rows), place.size)), np.zeros(place.size)
    for tap in range(1 - half, half + 1):
        weight = np.interp(np.abs(place - base - tap), grid, kernel)
        out += weight * each.rows[:, np.clip(base + tap, 0, each.rows.shape[1] - 1)]
        total += weight
    return out / total
