r"""Values that are known, looked for in a test: local fits around the place of each.

Around every value the direction of the responses is fitted over stretches of three widths by three orders
(``identification.local_fits``). Zeros that several of these fits have are candidates. Which
candidate is which value is one assignment of least cost over a response
(:func:`~antires_rs.measured.matching.paired`), in which a candidate counts by how many fits see it, about the
change that all values have in common; so values that all move by a tenth are not taken for their neighbours.
What has moved is fitted again around its new place. The frequency is the median over all fits that see the
value, its standard deviation the scatter of fits to perturbed directions (halves of the segments or of the
hits; else what the fit leaves is added once more, at random phases) with what differs between widths and
orders.

The *share* is the part of the perturbed fits that see a value, within 1.5 %. It is seen from the same
``min_share`` on as one that is new, from half of it where it was expected, within the scatter it had, and
from 0.8 on if it moved by more than 3 %.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..measured.antiresonance_set import NOT_SEEN, AntiresonanceSet
from ..measured.matching import KNOWN, paired
from ..measured.response_table import ResponseTable
from ..support.checks import ComplexArray, FloatArray
from .lines import Lines
from .local_fits import LEAST_LINES, SCALES, LocalFits, Stretch, around, chebyshev_roots, fits
from .stability import APART, MOST_DAMPING, SEED, SEEN_WITHIN, Look, interior, leave_out, left_out, moved

#: Largest relative change that is followed, beside what all values do if there are so many; and that after
#: which a value is fitted around its new place, and must be as sure as one can be.
REACH, FEWEST, AGAIN = 0.15, 3, 0.03
#: Zeros of several fits this close are one candidate; values this close share their stretches.
ONE, TOGETHER = 0.01, 0.02
#: Share of the fits from which zeros are a candidate, and fits that could have seen it, at least.
LEAST_SHARE, LEAST_FITS = 0.3, 3
#: Scales that are fitted to perturbed directions, the next where less than this share of them sees a value,
#: and how many directions are made where there are none.
JUDGES, SURE, VIEWS = (2, 1), 0.8, 6
#: Standard deviations within which a value was expected, and what part of ``min_share`` is enough there.
EXPECTED, ENOUGH = 4.0, 0.5


def look_of(lines: Lines) -> Look:
    """The one look that curves allow, or spectra of segments that are too short for others."""
    vectors = lines.vectors.T[None]
    return Look(
        lines.freq_hz, vectors, lines.capped_snr, np.zeros(vectors.shape[1:]), lines.added_decay_per_s
    )


@dataclass(frozen=True)
class Found:
    """Values followed, (n,) each; NaN where one is not seen."""

    freq_hz: FloatArray
    damping_ratio: FloatArray
    std_hz: FloatArray
    share: FloatArray
    fits: FloatArray


def follow(
    look: Look, row: NDArray[np.intp], near_hz: FloatArray, std_hz: FloatArray, min_share: float
) -> Found:
    """Values of the responses ``row``, (n,), near where they were; their deviations may be NaN."""
    variance = np.nan_to_num(std_hz) ** 2
    at = near_hz
    for last in (False, True):
        zeros, inside, fitted = _zeros(look, row, at)
        some = [
            _candidates(
                zeros[:, row == own].reshape(2, -1, zeros.shape[-1]), inside[row == own].reshape(-1, 2)
            )
            for own in np.unique(row)
        ]
        found = _assigned(row, near_hz, variance, some)
        shift = np.log(found[0] / near_hz)[~np.isnan(found[0])]
        common = float(np.exp(np.median(shift))) if shift.size >= FEWEST else 1.0
        found = _assigned(row, near_hz * common, variance, some)
        away = np.abs(found[0] / at - 1.0) > AGAIN
        if last or not away.any():
            break
        at = np.where(away, found[0], at)
    there = np.flatnonzero(~np.isnan(found[0]))
    if not there.size:
        return Found(*np.full((5, row.size), np.nan))
    freq, damping, between, _ = found[:, there]
    told = np.zeros((3, there.size))
    for scale in JUDGES:
        unsure = np.flatnonzero(told[1] < SURE)
        if unsure.size:
            which = there[unsure]
            new = _perturbed(look, row[which], at[which], freq[unsure], scale, fitted)
            told[:, unsure] = np.where(new[1] > told[1, unsure], new, told[:, unsure])
    std, share, count = told
    off = np.abs(freq - common * near_hz[there])
    expected = off <= EXPECTED * np.sqrt(variance[there])
    least = np.where(off > AGAIN * near_hz[there], max(SURE, min_share), min_share)
    seen = share >= np.where(expected, ENOUGH * min_share, least)
    columns = np.full((5, row.size), np.nan)
    columns[:, there[seen]] = np.stack([freq, damping, np.hypot(std, between), share, count])[:, seen]
    return Found(*columns)


def _assigned(
    row: NDArray[np.intp], near_hz: FloatArray, variance: FloatArray, some: Sequence[FloatArray]
) -> FloatArray:
    """Of the candidates of each response those that are values, (4, k); NaN where none is."""
    found = np.full((4, row.size), np.nan)
    for own, candidates in zip(np.unique(row), some, strict=True):
        places = np.flatnonzero(row == own)
        spread = np.broadcast_to(variance[places, None], (places.size, candidates.shape[1]))
        worth = np.clip((candidates[3] - LEAST_SHARE) / (SURE - LEAST_SHARE), 0.0, 1.0)
        for i, k in paired(near_hz[places], candidates[0], REACH, spread, worth):
            found[:, places[i]] = candidates[:, k]
    return found


def _fitted(
    look: Look, at: FloatArray, scale: int, vectors: Callable[[Stretch], ComplexArray]
) -> tuple[list[LocalFits], NDArray[np.intp]]:
    """Fits of one scale around values, (k,), and which of them is that of each."""
    grid, which = np.unique(np.round(np.log(at) / TOGETHER), return_inverse=True)
    ratio, least, orders = SCALES[scale]
    over = [around(look.freq_hz, float(middle), ratio, least) for middle in np.exp(grid * TOGETHER)]
    return fits(over, look.freq_hz, list(map(vectors, over)), look.weights, orders), which


def _roots(
    look: Look, local: list[LocalFits], which: NDArray[np.intp], row: NDArray[np.intp], order: int
) -> FloatArray:
    """Frequencies and damping ratios of the zeros of some rows, (2, n_views, k, order)."""
    c = np.stack([local[i].by_order[order][:, :, own] for i, own in zip(which, row, strict=True)], axis=1)
    edges = np.array([(one.stretch.low_hz, one.stretch.high_hz) for one in local])[which]
    half = 0.5 * np.diff(edges)
    return np.stack(moved(edges.mean(axis=1)[:, None] + half * chebyshev_roots(c), look.decay_per_s))


def _zeros(
    look: Look, row: NDArray[np.intp], at: FloatArray
) -> tuple[FloatArray, FloatArray, dict[tuple[int, float], ComplexArray]]:
    """Light zeros of all fits around values (k,), (2, k, n_fits, order) with NaN, where they count, and the
    directions that were fitted, by scale and middle of the stretch."""
    highest = max(orders[-1] for *_, orders in SCALES)
    every, inside = [], []
    fitted: dict[tuple[int, float], ComplexArray] = {}
    for scale, (_, _, orders) in enumerate(SCALES):
        local, which = _fitted(look, at, scale, lambda one: look.vectors[:1, one.lines])
        ends = np.array([interior(one.stretch, look.freq_hz) for one in local])[which]
        for order in orders:
            zeros = np.full((2, at.size, highest), np.nan)
            own = _roots(look, local, which, row, order)[:, 0]
            light = np.abs(own[1]) < MOST_DAMPING
            counts = light & (own[0] >= ends[:, :1]) & (own[0] <= ends[:, 1:])
            zeros[..., :order] = np.where(counts, own, np.nan)
            every.append(zeros)
            inside.append(ends)
        fitted |= {(scale, one.stretch.middle_hz): one.fitted for one in local}
    return np.stack(every, axis=2), np.stack(inside, axis=1), fitted


def _candidates(zeros: FloatArray, inside: FloatArray) -> FloatArray:
    """Of zeros (2, n_fits, order) of one response: frequency, damping, its error, share of fits, (4, n)."""
    freq = zeros[0]
    each = np.sort(freq[~np.isnan(freq)])
    off = np.nan_to_num(np.abs(freq / each[:, None, None] - 1.0), nan=np.inf)
    nearest = off.argmin(axis=2)
    could = (inside[:, 0] <= each[:, None]) & (inside[:, 1] >= each[:, None])
    seen = (off.min(axis=2) <= ONE) & could
    share = seen.sum(axis=1) / np.maximum(could.sum(axis=1), LEAST_FITS)
    left, found = share >= LEAST_SHARE, []
    while left.any():
        best = int(np.argmax(np.where(left, share, -1.0)))
        left &= np.abs(each / each[best] - 1.0) > APART
        own = zeros[:, np.arange(freq.shape[0]), nearest[best]][:, seen[best]]
        scatter = np.median(np.abs(own[0] - np.median(own[0])))
        found.append((*np.median(own, axis=1), scatter, share[best]))
    return np.array(found).reshape(-1, 4).T


def _perturbed(
    look: Look,
    row: NDArray[np.intp],
    at: FloatArray,
    found: FloatArray,
    scale: int,
    fitted: dict[tuple[int, float], ComplexArray],
) -> FloatArray:
    """Of values ``found`` by perturbed fits: scatter, the share that see each, and how many, (3, k)."""
    rng = np.random.default_rng(SEED)

    def noisy(one: Stretch) -> ComplexArray:
        own, along = look.vectors[0, one.lines], fitted[scale, one.middle_hz]
        rest = own - along * np.sum(along.conj() * own, axis=1, keepdims=True)
        drawn = rng.standard_normal((2, VIEWS, len(own), 1))
        return leave_out(own + rest * (drawn[0] + 1j * drawn[1]) * np.sqrt(0.5))

    halves = len(look.vectors) > 1
    local, which = _fitted(look, at, scale, (lambda one: look.vectors[1:, one.lines]) if halves else noisy)
    there = np.any(look.vectors[1:] != 0.0, axis=1) if halves else ~left_out(VIEWS, look.vectors.shape[2])
    scatter, count = [], []
    for order in SCALES[scale][2]:
        freq, damping = _roots(look, local, which, row, order)
        off = np.where(np.abs(damping) < 1.5 * MOST_DAMPING, np.abs(freq / found[:, None] - 1.0), np.inf)
        best = off.argmin(axis=2)[..., None]
        near = there[:, row] & (np.take_along_axis(off, best, 2)[..., 0] <= SEEN_WITHIN)
        own = np.take_along_axis(freq, best, 2)[..., 0] - found
        n = near.sum(axis=0)
        mean, square = ((near * own**power).sum(axis=0) / np.maximum(n, 1) for power in (1, 2))
        scatter.append(np.where(n > 1, np.sqrt((square - mean**2) * n / np.maximum(n - 1, 1)), 0.0))
        count.append(n)
    total = np.sum(count, axis=0)
    share = total / np.maximum(len(count) * there[:, row].sum(axis=0), 1)
    return np.stack([np.median(scatter, axis=0), share, total])


def tables_of(
    look: Look, dofs: Sequence[Any], near: AntiresonanceSet, band_hz: tuple[float, float], min_share: float
) -> tuple[dict[Any, ResponseTable], dict[Any, ResponseTable]]:
    """By dof, values of ``near`` inside the band as they are now, and where those were that are not seen."""
    low, high = band_hz
    inside = {dof: np.flatnonzero((near[dof] >= low) & (near[dof] <= high)) for dof in near if dof in dofs}
    if not sum(own.size for own in inside.values()):
        got = f"a set without a value of {', '.join(map(repr, dofs))} in {low:g} to {high:g} Hz"
        reject("near", got, "values that this test could show", "Name another set, or widen the band.")
    if look.freq_hz.size < 2 * LEAST_LINES:
        needed = f"a band with at least {2 * LEAST_LINES} lines for local fits"
        reject("band_hz", f"({low:g}, {high:g}) Hz", needed, "Widen the band, or record for longer.")
    row = np.concatenate([np.full(own.size, dofs.index(dof)) for dof, own in inside.items()])
    known = [near.tables[dof].take(own) for dof, own in inside.items()]
    places, std_hz = (np.concatenate([getattr(one, name) for one in known]) for name in ("freq_hz", "std_hz"))
    found = follow(look, row, places, std_hz, min_share)
    tables, gone = {}, {}
    for (dof, own), table in zip(inside.items(), known, strict=True):
        now = Found(*(getattr(found, one.name)[row == dofs.index(dof)] for one in fields(Found)))
        seen = ~np.isnan(now.freq_hz)
        # What spoke for a value speaks for it still, but for what this test says itself.
        of_one_test = ("averages", "expected_false")
        scores = {name: values[seen] for name, values in table.scores.items() if name not in of_one_test}
        scores |= {
            "rows": now.fits[seen].astype(np.int64),
            "spread": (now.std_hz / now.freq_hz)[seen],
            "share": now.share[seen],
            "how": np.full(seen.sum(), "followed"),
            "followed": own[seen],
            KNOWN: table.freq_hz[seen],
        }
        tables[dof] = ResponseTable(now.freq_hz[seen], now.damping_ratio[seen], now.std_hz[seen], scores)
        gone[dof] = ResponseTable(
            table.freq_hz[~seen], scores={"why": np.full(np.sum(~seen), NOT_SEEN), "followed": own[~seen]}
        )
    return tables, gone


def with_search(
    tables: Mapping[Any, ResponseTable], searched: AntiresonanceSet, *, better: bool, new: bool
) -> dict[Any, ResponseTable]:
    """Values followed, as a search of the test has them where that is ``better``, and its ``new`` ones."""
    joined = {}
    for dof, own in tables.items():
        other = searched.tables[dof]
        off = np.abs(other.freq_hz[:, None] / own.freq_hz - 1.0)
        nearest = off.argmin(axis=0) if len(other) else np.empty(0, dtype=np.intp)
        same = np.flatnonzero(off.min(axis=0, initial=np.inf) <= APART) if better else np.empty(0, np.intp)
        kept = own.take(np.setdiff1d(np.arange(len(own)), same))
        which = {name: own.scores[name][same] for name in ("followed", KNOWN)}
        instead = other.take(nearest[same]).with_scores(**which)
        rest = other.take(np.flatnonzero(off.min(axis=1, initial=np.inf) > APART) if new else [])
        rest = rest.with_scores(followed=np.full(len(rest), -1))
        joined[dof] = ResponseTable.concatenated([kept, instead, rest])
    if new:  # responses of which nothing was known
        for dof, other in searched.tables.items():
            if dof not in tables:
                unknown = {"followed": np.full(len(other), -1), KNOWN: np.full(len(other), np.nan)}
                joined[dof] = other.with_scores(**unknown)
    return joined
