"""What one fit of one window sees: the zeros of each response, and which of them make a dip.

A numerator has more roots than antiresonances: heavily damped ones that shape the trend, and pairs that all
rows share, which cancel. So a root counts only where the fitted response has a dip in the responses'
direction, which is a peak of the transmissibilities to it; each dip belongs to the root that is nearest to
it in the complex plane. Where the size of the responses is known (FRFs, one impact), a dip of the response
itself is looked for too: where a sensor lies on the node of a mode the others resonate and it does not, which
is a peak of its transmissibilities, but no dip of its own curve.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ...order_sweep.dips import dips
from ...order_sweep.limits import DIP_OVER_NOISE, LEAST_DIP_DB, OWN_DIP_WITHIN, OWNER_WITHIN
from ...order_sweep.rule import Rule
from ...support.validation import ComplexArray, FloatArray
from ..lines import FORCE, Lines
from ..repeat_scatter import combined, excess
from .fit import LocalFit

#: Orders that are looked at, relative to the likeliest.
AROUND = (-1, 0, 1)


@dataclass(frozen=True)
class Sightings:
    """Zeros seen, one entry each, (n,).

    ``row`` is that of the response, ``fit`` numbers the fits of all windows; ``std_hz`` and ``between_hz``
    (the scatter between tests, 0 for one) are NaN but for the likeliest order, ``own_depth_db`` where the
    size of the responses is not known. Zeros without a dip have ``depth_db`` 0: they are for the diagram, and
    ``apart_hz`` tells those beside a resonance from a pair that all responses share: how far the nearest zero
    of that response lies which has none so near (NaN for one response).
    """

    row: NDArray[np.intp]
    fit: NDArray[np.intp]
    order: NDArray[np.intp]
    freq_hz: FloatArray
    damping_ratio: FloatArray
    std_hz: FloatArray
    between_hz: FloatArray
    depth_db: FloatArray
    own_depth_db: FloatArray
    apart_hz: FloatArray

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """All entries of some."""
        return cls(*(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(cls)))

    def of_tests(self, count: int) -> Self:
        """With the scatter between ``count`` tests in ``std_hz``, see :mod:`..repeat_scatter`."""
        if count < 2:
            return self
        known = np.isfinite(self.std_hz)
        within, between = self.std_hz**2, self.between_hz**2
        q = excess(between[known], within[known], count)
        return replace(self, std_hz=np.sqrt(combined(between, within, count, q)))

    def where(self, keep: NDArray[np.bool_]) -> Self:
        """Some of the entries."""
        return type(self)(*(getattr(self, one.name)[keep] for one in fields(self)))


def sightings_of(
    fit: LocalFit, lines: Lines, order: int, number: int, n_responses: int, rule: Rule, use_force: bool
) -> Sightings:
    """Zeros of the first ``n_responses`` rows at one order; ``number`` is that of the fit."""
    numerators, roots = fit.numerators(order), fit.zeros(order)
    size = np.linalg.norm(numerators, axis=0)
    own = _own_levels(numerators, lines, use_force)
    columns: list[FloatArray] = []
    for row in range(n_responses):
        s = _in_band(roots[row], lines)
        level = _level(numerators[row], size)
        at, depth = dips(lines.freq_hz, level, LEAST_DIP_DB)
        needed = _needed(fit.noise[row][at], level[at] + depth, rule)
        deep = depth >= needed
        at, depth, needed = at[deep], depth[deep], needed[deep]
        others = [roots[k] for k in range(n_responses) if k != row]
        owner, dip = _owners(lines.freq_hz, s, at, others)
        moved = s + lines.added_decay_per_s
        freq = np.abs(moved) / (2 * np.pi)
        table = np.full((10, s.size), np.nan)
        table[:3] = np.array([row, number, order])[:, None]
        table[3], table[4] = freq, -moved.real / np.abs(moved)
        table[7] = 0.0
        table[7, owner] = depth[dip]
        if order == fit.best.order and owner.size:
            table[5:7, owner] = fit.standard_deviations(row, s[owner])
        if own is not None:
            table[8] = 0.0
            seen = np.array([_own_depth(lines.freq_hz, own[row], int(at[k])) for k in dip])
            table[8, owner] = np.where(seen >= needed[dip], seen, 0.0)
        if others:
            table[9] = np.max([_nearest(s, other) for other in others], axis=0) / (2 * np.pi)
        columns.append(table[:, np.abs(table[4]) <= rule.max_damping])
    flat = np.concatenate(columns, axis=1)
    return Sightings(*flat[:3].astype(np.intp), *flat[3:])


def _in_band(s: ComplexArray, lines: Lines) -> ComplexArray:
    """One of each conjugate pair, between the first and the last line."""
    size = np.abs(s) / (2 * np.pi)
    return np.asarray(s[(s.imag > 0.0) & (size >= lines.freq_hz[0]) & (size <= lines.freq_hz[-1])])


def _level(values: ComplexArray, size: FloatArray) -> FloatArray:
    """In dB."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(values) / np.maximum(size, 1e-300), 1e-300)))


def _needed(noise: FloatArray, shoulder_db: FloatArray, rule: Rule) -> FloatArray:
    """Depths in dB that dips with such shoulders need to be more than noise."""
    relative = noise / 10.0 ** (shoulder_db / 20.0)
    enough = DIP_OVER_NOISE * 20.0 / np.log(10.0) * relative
    return np.asarray(np.minimum(np.maximum(enough, LEAST_DIP_DB), rule.min_depth_db), dtype=np.float64)


def _own_levels(numerators: ComplexArray, lines: Lines, use_force: bool) -> FloatArray | None:
    """The responses' own curves in dB as far as they are of the fitted form; None if nothing tells."""
    if use_force:
        return _level(numerators, np.abs(numerators[FORCE]))
    if lines.size is None:
        return None
    power = np.maximum(np.sum(np.abs(numerators) ** 2, axis=0), 1e-300)
    along = np.abs(np.sum(numerators.conj() * lines.vectors, axis=0)) / power
    return _level(numerators * (along * lines.size), np.ones(lines.freq_hz.size))


def _own_depth(freq_hz: FloatArray, level_db: FloatArray, line: int) -> float:
    """Depth of the deepest dip of the response's own curve beside a line; 0 without one."""
    reach = OWN_DIP_WITHIN * freq_hz[line]
    near = (freq_hz[line] - reach, freq_hz[line] + reach)
    return float(dips(freq_hz, level_db, LEAST_DIP_DB, near)[1].max(initial=0.0))


def _owners(
    freq_hz: FloatArray, s: ComplexArray, at: NDArray[np.intp], others: list[ComplexArray]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of each root that owns a dip its index, and that of its first dip."""
    found: dict[int, int] = {}
    step = float(np.median(np.diff(freq_hz)))
    for k, line in enumerate(at.tolist()):
        value = freq_hz[line]
        reach = max(OWNER_WITHIN * value, 2.0 * step)
        for root in np.argsort(np.abs(s - 2j * np.pi * value)).tolist():
            if abs(abs(s[root]) / (2 * np.pi) - value) > reach:
                continue
            if not _cancels(s[root], others, np.pi * step):
                found.setdefault(root, k)
                break
    return np.array(list(found), dtype=np.intp), np.array(list(found.values()), dtype=np.intp)


def _nearest(s: ComplexArray, others: ComplexArray) -> FloatArray:
    """How far the nearest of others is from each root; infinity without any."""
    return np.asarray(np.abs(s[:, None] - others).min(axis=1, initial=np.inf))


def _cancels(s: complex, others: list[ComplexArray], least: float) -> bool:
    """Whether all of two or more other rows have the root too, nearer than it lies to the axis."""
    reach = max(abs(s.real), least)
    return len(others) > 1 and all(np.abs(other - s).min(initial=np.inf) < reach for other in others)
