"""What most of the fits that could see it do see.

Sightings of one response that lie within a tolerance are one antiresonance, the most frequent first. Its
share is the number of fits that have it over the number of fits of windows in whose interior it lies. Its
frequency is the median; its error is the larger of two: the noise, as the fits tell it, and how far the fits
disagree, which holds the noise too, leakage, the choice of the order and what is not rational in the curves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...order_sweep.limits import CLUSTER, ONE_DIP
from ...order_sweep.rule import Rule
from ...order_sweep.scores import window_grades
from ...order_sweep.table import ResponseTable
from ...support.validation import FloatArray
from .sightings import Sightings

ONLY_TRANSMISSIBILITY = "seen by transmissibilities only"
TOO_FEW = "in too few fits"
BESIDE = "beside an accepted one"
HIDDEN = "hidden by a resonance beside it"
#: Of a zero without a dip: most damping, most scatter between the fits (relative), and how many times further
#: the zeros of another response lie. A pair of roots that shapes a trend is damped more and wanders, one that
#: all responses share cancels. Of 30 chains with a resonance beside antiresonances these scatter by up to
#: 2.5e-4, roots that follow the trend of a measured plate by 6e-4 and more.
HIDDEN_DAMPING, HIDDEN_SCATTER, HIDDEN_APART = 0.03, 4e-4, 5.0
#: Narrow windows know less than all fits together do: the noise is taken as this quantile of what fits tell.
BEST_INFORMED = 0.25
#: What is in fewer fits is not worth mentioning.
WORTH_MENTIONING = 0.25


def agreed(
    seen: Sightings, inside: NDArray[np.bool_], covers: NDArray[np.bool_], rule: Rule
) -> tuple[ResponseTable, ResponseTable]:
    """The antiresonances of one response, and what was left out with the score "why".

    Parameters
    ----------
    seen : Sightings
        Of one response, (n,).
    inside, covers : (n, n_fits) bool
        Whether the frequency of each lies in the interior of the window of each fit, or in it at all.
    rule : Rule
    """
    dipped = seen.depth_db > 0.0
    groups = _groups(seen.where(dipped), inside[dipped], covers[dipped], rule)
    found = [_row(seen.where(dipped), group, share) for group, share in groups if share >= WORTH_MENTIONING]
    flat = seen.where(~dipped)
    hidden = [
        _row(flat, group, share)
        for group, share in _groups(flat, inside[~dipped], covers[~dipped], rule)
        if share >= rule.min_share and _stands_alone(flat, group)
    ]
    return _chosen(found, hidden, rule)


def _groups(
    seen: Sightings, inside: NDArray[np.bool_], covers: NDArray[np.bool_], rule: Rule
) -> list[tuple[NDArray[np.intp], float]]:
    """Sightings that are one zero, the most frequent first, each with its share of the fits."""
    left = np.argsort(seen.freq_hz, kind="stable")
    groups: list[tuple[NDArray[np.intp], float]] = []
    while left.size:
        freq = seen.freq_hz[left]
        tol = CLUSTER * rule.freq_tol
        near = np.abs(freq[:, None] / freq - 1.0) <= tol
        counts = np.array([np.unique(seen.fit[left[own]]).size for own in near])
        best = int(np.argmax(counts))
        group = left[near[best]]
        groups.append(_share(seen, group, inside, covers))
        left = left[~near[best]]
    return groups


def _stands_alone(seen: Sightings, group: NDArray[np.intp]) -> bool:
    """Whether fits agree on a zero that is lightly damped and that not all responses have."""
    damping, freq = float(np.median(seen.damping_ratio[group])), float(np.median(seen.freq_hz[group]))
    scatter = float(np.median(np.abs(seen.freq_hz[group] - freq)))
    steady = scatter <= min(HIDDEN_SCATTER * freq, float(np.median(seen.apart_hz[group])) / HIDDEN_APART)
    return steady and 0.0 < damping <= HIDDEN_DAMPING


def _share(
    seen: Sightings, group: NDArray[np.intp], inside: NDArray[np.bool_], covers: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], float]:
    """The sightings of a group that count, and the share of the fits that have it."""
    middle = group[np.argsort(seen.freq_hz[group], kind="stable")[group.size // 2]]
    asked = inside[middle] if inside[middle].any() else covers[middle]
    counted = group[asked[seen.fit[group]]]
    if not counted.size:
        return group, 0.0
    return counted, np.unique(seen.fit[counted]).size / max(int(asked.sum()), 1)


def _row(seen: Sightings, group: NDArray[np.intp], share: float) -> tuple[float, ...]:
    """Frequency, damping, std, fits, spread, depth, depth of the own curve, share."""
    freq = seen.freq_hz[group]
    value = float(np.median(freq))
    spread = float(np.std(freq))
    noise = seen.std_hz[group]
    noise = noise[np.isfinite(noise)]
    own = seen.own_depth_db[group]
    return (
        value,
        float(np.median(seen.damping_ratio[group])),
        max(float(np.quantile(noise, BEST_INFORMED)), spread) if noise.size else np.nan,
        np.unique(seen.fit[group]).size,
        spread / value,
        float(np.median(seen.depth_db[group])),
        float(np.median(own)) if np.isfinite(own).all() else np.nan,
        share,
    )


def _chosen(
    found: list[tuple[float, ...]], hidden: list[tuple[float, ...]], rule: Rule
) -> tuple[ResponseTable, ResponseTable]:
    """Accepted and left out, the most agreed first where two are one dip."""
    kept: list[tuple[float, ...]] = []
    out: list[tuple[tuple[float, ...], str]] = []
    for one in sorted(found, key=lambda row: -row[7]):
        if any(abs(one[0] / other[0] - 1.0) <= ONE_DIP for other in kept):
            if one[7] >= rule.min_share:
                out.append((one, BESIDE))
            continue
        if one[7] < rule.min_share:
            out.append((one, TOO_FEW))
        elif one[6] <= 0.0:
            out.append((one, ONLY_TRANSMISSIBILITY))
        else:
            kept.append(one)
    dips = [*kept, *(one for one, _ in out)]
    for one in hidden:
        if not any(abs(one[0] / other[0] - 1.0) <= ONE_DIP for other in dips):
            out.append((one, HIDDEN))
    out.sort(key=lambda left: left[0][0])
    whys = np.array([why for _, why in out], dtype=np.str_)
    return _table(kept), _table([row for row, _ in out]).with_scores(why=whys)


def _table(rows: list[tuple[float, ...]]) -> ResponseTable:
    columns: FloatArray = np.array(rows, dtype=np.float64).reshape(-1, 8).T
    freq, damping, std, fits, spread, depth, own, share = columns
    table = ResponseTable.of_sweep(
        freq, damping, std, rows=fits, spread=spread, dominance=np.full(len(rows), np.nan), how="windows"
    )
    rank = np.argsort(freq, kind="stable")
    return table.with_scores(
        share=share[rank],
        depth_db=depth[rank],
        own_depth_db=own[rank],
        grade=window_grades(share, spread, np.fmin(depth, own))[rank],
    )
