"""Faults of single channels: dead, clipped, duplicated, interrupted, spiked, buried in noise."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..support.checks import FloatArray
from .findings import Finding, NotTested, Said
from .one_force import Evidence
from .segments import pieces

DEAD, CLIPPED, DUPLICATED = "dead_channel", "clipped_channel", "duplicated_channels"
DROPOUTS, SPIKES, NOISE = "dropouts", "spikes", "signal_to_noise"

# Part of a channel's range that counts as one level, and how many levels below the extreme are compared with
# it.
LEVEL = 1e-3
LEVELS_BELOW = 3
# A pile of so many samples at an extreme, this many times what the levels below hold, is a clipped one. A
# slow sine piles up by 3.
PILE, PILE_RATIO = 8, 5.0
# Extremes are looked for in this part of a channel's range.
HIGH = 0.25
# Correlation of two channels above which they are one signal.
SAME = 1.0 - 1e-9
# Equal samples in a row that make a dropout, unless the digits are so coarse that this share repeat anyway.
RUN, REPEATED = 20, 0.01
# Second differences this far out, in robust standard deviations, are spikes: Gaussian ones never reach 8.
SPIKE_SIGMAS = 15.0
# So many second differences tell their standard deviation within a per cent.
MEDIAN_SAMPLES = 16384
# A channel of which others explain less of its power in the band carries no response.
EXPLAINED = 0.25
LEAST_AVERAGES = 4.0
DEAD_ADVICE = "Check sensor, cable and gain; leave the channel out."
# Share of the band that a channel may spend under its noise without a note.
BURIED = 0.25


def constant(data: FloatArray, labels: tuple[Any, ...]) -> tuple[list[Finding], list[int]]:
    """Channels that never move; also their rows."""
    still = [p for p, x in enumerate(data) if x.max() == x.min()]
    return [
        Finding(
            DEAD,
            "fatal",
            (labels[p],),
            0.0,
            0.0,
            f"Dof {labels[p]!r} gives the constant {data[p, 0]:.3g}: no signal at all.",
            DEAD_ADVICE,
            f"the constant {data[p, 0]:.3g}",
        )
        for p in still
    ], still


def clipped(data: Iterable[FloatArray], labels: tuple[Any, ...]) -> Said:
    """Channels whose samples pile up at their largest or smallest value."""
    found: Said = []
    for label, x in zip(labels, data, strict=True):
        low, high = float(x.min()), float(x.max())
        above, below = x[x >= high - HIGH * (high - low)], x[x <= low + HIGH * (high - low)]
        piles = {high: _pile(np.sort(above), high - low, x), low: _pile(np.sort(-below), high - low, x, -1.0)}
        count = sum(piles.values())
        if count == 0:
            continue
        share = count / x.size
        where = " and ".join(f"{value:.4g}" for value, pile in piles.items() if pile)
        text = f"Channel {label!r} is clipped at {where}: {count} samples, {100 * share:.2g} % of the record."
        advice = (
            "Lower the gain or the force and record again; clipping adds harmonics that look like "
            "noise of the channel."
        )
        brief = f"clipped at {where}, {100 * share:.2g} % of the record"
        found.append(Finding(CLIPPED, "warning", (label,), share, PILE / x.size, text, advice, brief))
    return found


def _pile(high: FloatArray, spread: float, x: FloatArray, sign: float = 1.0) -> int:
    """Samples at the largest of ``sign * x`` if they are a pile, else 0; ``high`` are its high ones."""
    largest = float(high[-1])
    steps = np.diff(high)
    steps = steps[steps > 1e-9 * spread]
    # Levels as wide as the digits of the converter, where these are coarse.
    level = max(LEVEL * spread, 1.5 * float(steps.min()) if steps.size else 0.0)
    count = int(np.count_nonzero(high >= largest - level))
    more = int(np.count_nonzero(high >= largest - (1 + LEVELS_BELOW) * level))
    if count < PILE or count <= PILE_RATIO * (more - count) / LEVELS_BELOW:
        return 0
    # Rest is no pile: the force between two impacts.
    return count if largest - sign * np.median(x) > level else 0


def duplicated(data: FloatArray, labels: tuple[Any, ...]) -> tuple[list[Finding], list[int]]:
    """Pairs of channels that are one signal up to a factor; also the rows to leave out."""
    mean = data.mean(axis=1, keepdims=True)
    products = np.zeros((len(data), len(data)))
    for some in pieces(data.shape[1], len(data)):
        moved = data[:, some] - mean
        products += moved @ moved.T
    norm = np.sqrt(np.diag(products))
    same = np.abs(products) / np.maximum(norm[:, None] * norm, 1e-300)
    found, extra = [], []
    for p, q in zip(*np.nonzero(np.triu(same > SAME, 1)), strict=True):
        if q in extra:
            continue
        extra.append(int(q))
        factor = float(products[p, q]) / float(norm[p]) ** 2
        text = f"Channels {labels[p]!r} and {labels[q]!r} hold one signal, up to a factor of {factor:.4g}."
        found.append(
            Finding(
                DUPLICATED,
                "warning",
                (labels[p], labels[q]),
                float(same[p, q]),
                SAME,
                text,
                "Check the wiring and the channel list; leave one of them out.",
                f"one signal, up to a factor of {factor:.4g}",
            )
        )
    return found, extra


def interrupted(data: FloatArray, labels: tuple[Any, ...], fs_hz: float) -> Said:
    """Channels that stand still for a while within a steady record, or jump."""
    found: Said = []
    for label, x in zip(labels, data, strict=True):
        step = np.diff(x)
        still = step == 0.0
        run = _longest_run(still)
        if (
            run[1] >= RUN
            and still.mean() < max(REPEATED, 2.0 * run[1] / x.size)
            and x.min() < x[run[0]] < x.max()
        ):
            text = f"Channel {label!r} stands still for {run[1]} samples at {run[0] / fs_hz:.3g} s."
            found.append(
                Finding(
                    DROPOUTS,
                    "warning",
                    (label,),
                    float(run[1]),
                    RUN,
                    text,
                    "Look for a loose contact or lost data; use the part of the record without it.",
                    f"still for {run[1]} samples at {run[0] / fs_hz:.3g} s",
                )
            )
        second = np.diff(step)
        scale = float(np.median(np.abs(second[:: max(1, second.size // MEDIAN_SAMPLES)]))) / 0.6745
        largest = max(float(second.max()), -float(second.min()))
        if scale > 0.0 and largest > SPIKE_SIGMAS * scale:
            second = np.abs(second)
            count = int(np.count_nonzero(second > SPIKE_SIGMAS * scale))
            text = (
                f"Channel {label!r} jumps: {count} second differences lie beyond {SPIKE_SIGMAS:g} "
                f"standard deviations, the largest at {largest / scale:.0f}, "
                f"{int(np.argmax(second)) / fs_hz:.3g} s into the record."
            )
            found.append(
                Finding(
                    SPIKES,
                    "warning",
                    (label,),
                    largest / scale,
                    SPIKE_SIGMAS,
                    text,
                    "Look for loose contacts, electric switching or blows; use the part of the "
                    "record without them.",
                    f"{count} jumps, the largest at {largest / scale:.0f} standard deviations",
                )
            )
    return found


def _longest_run(still: Any) -> tuple[int, int]:
    """Start of the longest run of equal samples, and its length in samples."""
    if not still.any():
        return 0, 1
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    starts, lengths = edges[::2], edges[1::2] - edges[::2]
    best = int(np.argmax(lengths))
    return int(starts[best]), int(lengths[best]) + 1


def unrelated(seen: Evidence) -> Said:
    """Channels that share nothing with any other in the band: only noise."""
    if seen.explained is None:
        return [
            NotTested(DEAD, "one average does not tell a response from noise; constant channels are found")
        ]
    if len(seen.dofs) < 2:
        return [NotTested(DEAD, "a single channel has nothing to be compared with; a constant one is found")]
    if seen.n_averages < LEAST_AVERAGES:
        return [
            NotTested(
                DEAD,
                f"{seen.n_averages:.1f} independent averages explain noise by noise; "
                "constant channels are found",
            )
        ]
    # Noise explains 1/n of noise.
    limit = max(EXPLAINED, 2.0 / seen.n_averages)
    lost = [p for p, share in enumerate(seen.explained) if share < limit]
    if len(lost) == 2 and len(seen.dofs) == 2:
        text = (
            f"Dofs {seen.dofs[0]!r} and {seen.dofs[1]!r} have nothing in common in the band: either "
            f"explains {100 * seen.explained.max():.0f} % of the other's power. One of them, or both, "
            "hold only noise."
        )
        return [
            Finding(
                DEAD,
                "fatal",
                seen.dofs,
                float(seen.explained.max()),
                limit,
                text,
                "Check cables, sensors and the band.",
            )
        ]
    return [
        Finding(
            DEAD,
            "fatal",
            (seen.dofs[p],),
            float(seen.explained[p]),
            limit,
            f"Dof {seen.dofs[p]!r} holds only noise in the band: no other channel explains more than "
            f"{100 * seen.explained[p]:.0f} % of its power (limit {100 * limit:.0f} %).",
            DEAD_ADVICE,
            f"only noise in the band, of which no other explains more than {100 * seen.explained[p]:.0f} %",
        )
        for p in lost
    ]


BURIED_ADVICE = (
    "Antiresonances there come from the other channels or not at all; force harder or average longer."
)


def buried(seen: Evidence, skip: set[Any]) -> Said:
    """Channels that spend much of the band under their noise."""
    if seen.signal is None:
        return [NotTested(NOISE, "the noise of a single average is not known")]
    share = np.mean(seen.signal < 1.0, axis=1)
    return [
        Finding(
            NOISE,
            "note",
            (dof,),
            float(part),
            BURIED,
            f"Dof {dof!r} lies under its own noise in {100 * part:.0f} % of the band.",
            BURIED_ADVICE,
            f"under its noise in {100 * part:.0f} % of the band",
        )
        for dof, part in zip(seen.dofs, share, strict=True)
        if part > BURIED and dof not in skip
    ]
