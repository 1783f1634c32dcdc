"""What a click means: the value, pole or dip that is nearest to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...measured.antiresonance_set import AntiresonanceSet
from ...plotting.stabilization import pole_table
from ...support.validation import FloatArray
from ..curve import Curve

__all__ = ["Click", "Pick", "picked"]

#: How far from a thing a click may be, in pixels.
REACH_PX = 9.0


@dataclass(frozen=True)
class Click:
    """Where in a figure: its name, the place in units of the axes, and how much of them a pixel is."""

    figure: str
    x: float
    y: float
    x_per_px: float
    y_per_px: float


@dataclass(frozen=True)
class Pick:
    """What to do: "drop" or "add" a value, or "restore" one that was dropped."""

    action: str
    freq_hz: float
    damping_ratio: float | None = None
    std_hz: float | None = None


def picked(zeros: AntiresonanceSet, dof: Any, click: Click, curve: Curve | None = None) -> Pick | None:
    """What a click at a response asks for; None where nothing is near.

    On a pole it adds it, on a value it drops it, on the place of a dropped one it brings that back. On a
    curve it adds the dip. The line of a value goes before what lies beside it: zoom in to tell them apart.
    """
    now, gone = zeros[dof], _gone(zeros, dof)
    for values, action in ((now, "drop"), (gone, "restore")):
        at = _nearest(values, click)
        if at is not None:
            return Pick(action, float(values[at]))
    if click.figure == "stabilization" and dof in zeros.diagrams:
        return _seen(zeros, dof, click) or _pole(zeros, dof, click)
    if click.figure == "curve" and curve is not None:
        return _dip(curve, click)
    return None


def _gone(zeros: AntiresonanceSet, dof: Any) -> FloatArray:
    before = zeros.original()[dof]
    return before[~np.isin(before, zeros[dof])]


def _nearest(values: FloatArray, click: Click) -> int | None:
    if not values.size:
        return None
    off = np.abs(values - click.x)
    at = int(np.argmin(off))
    return at if off[at] <= REACH_PX * click.x_per_px else None


def _pole(zeros: AntiresonanceSet, dof: Any, click: Click) -> Pick | None:
    order, freq, damping, stable = pole_table(zeros.diagrams[dof])
    if not freq.size:
        return None
    off = np.hypot((freq - click.x) / click.x_per_px, (order - click.y) / click.y_per_px)
    # Of two that are nearly as near, the stable one is meant.
    at = int(np.argmin(off + np.where(stable, 0.0, 0.3 * REACH_PX)))
    return Pick("add", float(freq[at]), float(damping[at])) if off[at] <= REACH_PX else None


def _seen(zeros: AntiresonanceSet, dof: Any, click: Click) -> Pick | None:
    """What fits saw and did not accept; its marks stand above the poles."""
    diagram = zeros.diagrams[dof]
    table = diagram.left_out
    at = _nearest(table.freq_hz, click)
    if at is None or click.y < float(diagram.orders[-1]) + 0.2 - REACH_PX * click.y_per_px:
        return None
    damping, std = float(table.damping_ratio[at]), float(table.std_hz[at])
    return Pick(
        "add",
        float(table.freq_hz[at]),
        None if np.isnan(damping) else damping,
        None if np.isnan(std) else std,
    )


def _dip(curve: Curve, click: Click) -> Pick | None:
    """The lowest line near the click, if it is lower than its neighbours on both sides."""
    near = np.flatnonzero(np.abs(curve.freq_hz - click.x) <= REACH_PX * click.x_per_px)
    if not near.size:
        near = np.array([int(np.argmin(np.abs(curve.freq_hz - click.x)))])
    at = int(near[np.argmin(curve.size[near])])
    if at in (0, curve.size.size - 1) or curve.size[at] > min(curve.size[at - 1], curve.size[at + 1]):
        return None
    return Pick("add", float(curve.freq_hz[at]))
