"""From lines to one stabilization diagram for each response, by fits over windows."""

from __future__ import annotations

import numpy as np

from ...order_sweep.diagram import StabilizationDiagram
from ...order_sweep.limits import CLUSTER
from ...order_sweep.scores import scored
from ...order_sweep.table import ResponseTable
from ...support.pickling import frozen
from ...support.progress import step
from ...support.validation import ComplexArray, FloatArray
from ..lines import Lines
from ..options import IdentificationOptions
from .consensus import agreed
from .fit import LocalFit
from .grid import LocalWindow, local_windows
from .sightings import AROUND, Sightings, sightings_of


def local_diagrams(
    lines: Lines, n_responses: int, band_hz: tuple[float, float], options: IdentificationOptions
) -> list[StabilizationDiagram]:
    """One diagram for each of the first ``n_responses`` rows of ``lines``."""
    windows = local_windows(lines.freq_hz)
    parts: list[Sightings] = []
    owner: list[int] = []
    fitted = np.zeros(lines.vectors.shape, dtype=np.complex128)
    centre = np.full(lines.freq_hz.size, np.inf)
    for number, window in enumerate(windows):
        step(f"window {number + 1} of {len(windows)}")
        some = lines.part(window.first, window.last)
        fit = LocalFit(some, options.max_order)
        for order in fit.orders(AROUND, options.min_order):
            parts.append(
                sightings_of(fit, some, order, len(owner), n_responses, options.rule, options.use_force)
            )
            owner.append(number)
        _keep_nearest(fitted, centre, lines.freq_hz, window, fit)
    seen = Sightings.joined(parts).of_tests(lines.n_tests)
    seen = seen.where((seen.freq_hz >= band_hz[0]) & (seen.freq_hz <= band_hz[1]))
    of_fit = [windows[number] for number in owner]
    return [
        _diagram(seen.where(seen.row == row), of_fit, lines, row, fitted, band_hz, options)
        for row in range(n_responses)
    ]


def _keep_nearest(
    fitted: ComplexArray, centre: FloatArray, freq_hz: FloatArray, window: LocalWindow, fit: LocalFit
) -> None:
    """At each line the numerators of the window in whose middle it lies best."""
    at = slice(window.first, window.last)
    middle = 0.5 * (freq_hz[window.first] + freq_hz[window.last - 1])
    off = np.abs(freq_hz[at] - middle) / (freq_hz[window.last - 1] - freq_hz[window.first])
    nearer = off < centre[at]
    fitted[:, at][:, nearer] = fit.numerators(fit.best.order)[:, nearer]
    centre[at][nearer] = off[nearer]


def _diagram(
    seen: Sightings,
    of_fit: list[LocalWindow],
    lines: Lines,
    row: int,
    fitted: ComplexArray,
    band_hz: tuple[float, float],
    options: IdentificationOptions,
) -> StabilizationDiagram:
    """What the fits agree on, with all zeros by order."""
    rule = options.rule
    inside = np.stack([w.inside(lines.freq_hz, seen.freq_hz) for w in of_fit], axis=1)
    covers = np.stack([w.covers(lines.freq_hz, seen.freq_hz) for w in of_fit], axis=1)
    accepted, left_out = agreed(seen, inside, covers, rule)
    quotients = lines.quotients(row)[0]
    own = fitted[row]
    own = np.where(np.abs(own) > 0.0, own, 1e-300)
    background = np.abs(quotients.sum(axis=0))
    accepted = scored(accepted, lines.freq_hz, background, quotients, np.delete(fitted, row, axis=0) / own)
    orders = np.unique(seen.order) if seen.order.size else np.array([options.min_order])
    by_order = [seen.where(seen.order == order) for order in orders]
    ranks = [np.argsort(one.freq_hz, kind="stable") for one in by_order]
    freq = [one.freq_hz[rank] for one, rank in zip(by_order, ranks, strict=True)]
    tol = CLUSTER * rule.freq_tol
    return StabilizationDiagram(
        orders=frozen(orders),
        freq_hz=tuple(frozen(one) for one in freq),
        damping_ratio=tuple(frozen(one.damping_ratio[r]) for one, r in zip(by_order, ranks, strict=True)),
        stable=tuple(frozen(_near(one, accepted, tol)) for one in freq),
        accepted=accepted,
        background_freq_hz=frozen(lines.freq_hz),
        background=frozen(background),
        band_hz=band_hz,
        left_out=left_out,
    )


def _near(freq_hz: FloatArray, accepted: ResponseTable, tol: float) -> FloatArray:
    """Whether a zero belongs to an accepted antiresonance."""
    if not len(accepted):
        return np.zeros(freq_hz.size, dtype=bool)
    return np.asarray(np.abs(freq_hz[:, None] / accepted.freq_hz - 1.0).min(axis=1, initial=np.inf) <= tol)
