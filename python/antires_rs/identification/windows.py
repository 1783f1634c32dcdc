"""From lines to one stabilization diagram for each response, by fits over windows."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.spectra import LEAST_NOISE as ROUNDING, aligned, noise_shares
from ..support.checks import ComplexArray, FloatArray
from ..support.progress import step
from ..support.values import frozen
from .limits import CLUSTER, DIP_OVER_NOISE, LEAST_DIP_DB, ONE_DIP, OWN_DIP_WITHIN, OWNER_WITHIN
from .lines import FORCE, SNR_CAP, Lines, unit
from .numerators import Likeliest, likeliest
from .options import FitOptions, IdentificationOptions
from .scores import dips, scored, window_grades
from .selection import Influence, combined, excess
from .stabilization import StabilizationDiagram

# -- Where the windows lie: on a grid that depends on the spacing of the lines, never on the band
#
# Of each scale the edges ascend by a fourth of a window, so that every frequency lies well inside three. A
# window is as wide as a given ratio of frequencies or, at low frequency, as a given number of lines.


#: (highest over lowest frequency, least number of lines) of the windows of each scale: the wide ones hold
#: several modes and know the trend between them, the narrow ones suffer less from what is not rational.
SCALES = ((1.5, 96), (1.25, 48))
#: Windows of one scale that cover a frequency.
OVERLAP = 4
#: A window that the band cuts must keep this share of its width, and so many lines.
LEAST_SHARE, LEAST_LINES = 0.6, 24
#: This share of a window at either end is its margin: what lies there others see better.
MARGIN = 0.08


@dataclass(frozen=True)
class LocalWindow:
    """Lines ``first`` to ``last`` (exclusive)."""

    first: int
    last: int

    def inside(self, freq_hz: FloatArray, at_hz: FloatArray) -> NDArray[np.bool_]:
        """Which frequencies lie in the window but not in its margins."""
        low, high = freq_hz[self.first], freq_hz[self.last - 1]
        margin = MARGIN * (high - low)
        return np.asarray((at_hz > low + margin) & (at_hz < high - margin))

    def covers(self, freq_hz: FloatArray, at_hz: FloatArray) -> NDArray[np.bool_]:
        """Which frequencies lie in the window."""
        return np.asarray((at_hz >= freq_hz[self.first]) & (at_hz <= freq_hz[self.last - 1]))


def local_windows(freq_hz: FloatArray) -> list[LocalWindow]:
    """All windows that the lines fill well enough; the whole if there is none."""
    step = float(np.median(np.diff(freq_hz)))
    found = []
    for ratio, lines in SCALES:
        edges = _edges(step, float(freq_hz[-1]), ratio, lines)
        for low, high in zip(edges[:-OVERLAP], edges[OVERLAP:], strict=True):
            kept = min(high, freq_hz[-1]) - max(low, freq_hz[0])
            first, last = np.searchsorted(freq_hz, low), np.searchsorted(freq_hz, high)
            if kept >= LEAST_SHARE * (high - low) and last - first >= max(LEAST_LINES, lines // 2):
                found.append(LocalWindow(int(first), int(last)))
    return found or [LocalWindow(0, freq_hz.size)]


def _edges(step_hz: float, highest_hz: float, ratio: float, lines: int) -> list[float]:
    """From zero up, each a fourth of a window above the one before."""
    edges = [0.0]
    while edges[-1] < highest_hz * ratio:
        edges.append(max(edges[-1] * ratio ** (1.0 / OVERLAP), edges[-1] + lines * step_hz / OVERLAP))
    return edges


# -- The likeliest numerators of one window
#
# The channels are brought to equal noise, and to the few directions that hold their signal: numerators of
# order m span at most m + 1 of them, however many channels there are. Where nothing tells the noise, the
# residual of a first fit does, by channel and by line; a second fit is weighted by it, so that lines and
# channels at which the structure is not what the fit can be (a joint that slips, tests at which a mode had
# moved) lose their say. Noise that came with the curves keeps its weights, and errors are never less than
# it makes them.


#: Highest order of a window, and lines that each order needs.
HIGHEST_ORDER, LINES_PER_ORDER = 16, 5
#: Directions kept of the channels: those in which there is more signal than noise, within these numbers.
LEAST_DIRECTIONS, MOST_DIRECTIONS = 3, 14
#: Iterations of weights and order in each of the fits, the second with the noise from the first's residual.
ITERATIONS = (3, 3)
#: Lines over which a residual is averaged, and the least share of its median that one may have.
RESIDUAL_LINES, LEAST_RESIDUAL = 15, 0.05


class LocalFit:
    """Numerators of all rows of ``lines`` at the likeliest order and its neighbours."""

    def __init__(self, lines: Lines, max_order: int) -> None:
        self.freq_hz = lines.freq_hz
        most = max(2, min(max_order, HIGHEST_ORDER, lines.freq_hz.size // LINES_PER_ORDER))
        self._highest = most
        directions = aligned(lines.vectors)
        row, line = np.ones(len(directions)), 1.0 / lines.snr
        #: Standard deviation of the rows of the directions, (n_rows, n_freq).
        self.noise = np.sqrt(row[:, None] * line)
        if lines.segments is not None:
            self._more = 1.0
            self._fit(lines, row, most, sum(ITERATIONS))
            return
        start = None
        self._more = 1.0
        for iterations in ITERATIONS:
            if start is not None:
                given = self.noise
                row, line = self._residual_noise(directions)
                self.noise = np.sqrt(row[:, None] * line)
                if lines.noise_given:
                    # The residual of a fit that follows the noise is less than the noise that is known.
                    self._more = max(1.0, float(np.median(given / self.noise)))
                    row, line = np.ones(len(directions)), 1.0 / lines.snr
            scaled = directions / np.sqrt(row)[:, None]
            power = np.sum(np.abs(scaled) ** 2, axis=0)
            weighed = Lines(self.freq_hz, unit(scaled), power / line, runs=_rescaled(lines.runs, row))
            self._fit(weighed, row, most, iterations, start)
            start = (
                self.best.order,
                np.sum(np.abs(self.best.fit.values(self.best.coefficients)) ** 2, axis=1),
            )

    def _fit(
        self,
        lines: Lines,
        row_noise: FloatArray,
        max_order: int,
        iterations: int,
        start: tuple[int, FloatArray] | None = None,
    ) -> None:
        """Fit lines of equal noise; ``row_noise`` is what their rows were divided by, in power."""
        v = lines.vectors
        power, held = np.linalg.eigh(np.real((v * lines.snr) @ v.conj().T))
        # Noise alone has the power of one in each direction and line.
        signal = int(np.sum(power > 2.0 * lines.freq_hz.size))
        held = held[:, -min(max(signal, LEAST_DIRECTIONS), MOST_DIRECTIONS) :]
        self._mix = np.sqrt(row_noise)[:, None] * held
        self._lines = lines.projected(held)
        self.best: Likeliest = likeliest(
            self.freq_hz,
            self._lines.covariance,
            SNR_CAP,
            lines.independent,
            max_order,
            iterations=iterations,
            start=start,
        )

    def _residual_noise(self, directions: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Noise power of rows and lines that the residual tells."""
        from scipy.ndimage import uniform_filter1d  # slow to import

        fitted = self.numerators(self.best.order)
        size = np.maximum(np.sum(np.abs(fitted) ** 2, axis=0), 1e-300)
        along = np.sum(fitted.conj() * directions, axis=0) / size
        left = np.abs(directions - fitted * along) ** 2
        row, line = noise_shares(uniform_filter1d(left, RESIDUAL_LINES, axis=1, mode="nearest"))
        line = np.maximum(line, LEAST_RESIDUAL * float(np.median(line)))
        return row, np.maximum(line, ROUNDING)

    def orders(self, around: tuple[int, ...], lowest: int) -> list[int]:
        """Orders this far from the likeliest one, those that there are."""
        some = {min(max(self.best.order + k, lowest), self._highest) for k in around} | {self.best.order}
        return sorted(some)

    def coefficients(self, order: int) -> FloatArray:
        """Coefficients of all rows, (order + 1, n_rows)."""
        return np.asarray(self._own(order) @ self._mix.T)

    def numerators(self, order: int) -> ComplexArray:
        """All rows at the lines, (n_rows, n_freq)."""
        return np.asarray(self._mix @ self.best.fit.values(self._own(order)).T)

    def zeros(self, order: int) -> list[ComplexArray]:
        """Roots of every row in rad/s."""
        c = self.coefficients(order)
        return [self.best.fit.zeros(own) for own in c.T]

    def standard_deviations(self, row: int, s: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Of zeros of the likeliest order in Hz: by noise, and by the scatter between tests (0 for one)."""
        within, between = self._influence.variances(self._mix[row], s)
        # Where there are several tests, the noise is what they differ by.
        more = self._more if self._lines.runs is None else 1.0
        return more * np.sqrt(within), np.sqrt(between)

    def _own(self, order: int) -> FloatArray:
        """Coefficients of the directions that are held."""
        return self.best.coefficients if order == self.best.order else self.best.fit.likeliest(order)[0]

    @cached_property
    def _influence(self) -> Influence:
        lines = self._lines.by_test()
        return Influence(self.best.fit, self.best.coefficients, self.best.misfit, lines)


def _rescaled(runs: ComplexArray | None, row_noise: FloatArray) -> ComplexArray | None:
    """Unit vectors of every test with their rows brought to equal noise."""
    if runs is None:
        return None
    scaled = runs / np.sqrt(row_noise)[:, None]
    return np.asarray(scaled / np.maximum(np.linalg.norm(scaled, axis=1, keepdims=True), 1e-300))


# -- What one fit of one window sees: the zeros of each response, and which of them make a dip
#
# A numerator has more roots than antiresonances: heavily damped ones that shape the trend, and pairs that
# all rows share, which cancel. So a root counts only where the fitted response has a dip in the responses'
# direction, which is a peak of the transmissibilities to it; each dip belongs to the root that is nearest
# to it in the complex plane. Where the size of the responses is known (FRFs, one impact), a dip of the
# response itself is looked for too: where a sensor lies on the node of a mode the others resonate and it
# does not, which is a peak of its transmissibilities, but no dip of its own curve.


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
    fit: LocalFit, lines: Lines, order: int, number: int, n_responses: int, rule: FitOptions, use_force: bool
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


def _needed(noise: FloatArray, shoulder_db: FloatArray, rule: FitOptions) -> FloatArray:
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


# -- What most of the fits that could see it do see
#
# Sightings of one response that lie within a tolerance are one antiresonance, the most frequent first. Its
# share is the number of fits that have it over the number of fits of windows in whose interior it lies. Its
# frequency is the median; its error is the larger of two: the noise, as the fits tell it, and how far the
# fits disagree, which holds the noise too, leakage, the choice of the order and what is not rational in the
# curves.


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
    seen: Sightings, inside: NDArray[np.bool_], covers: NDArray[np.bool_], rule: FitOptions
) -> tuple[ResponseTable, ResponseTable]:
    """The antiresonances of one response, and what was left out with the score "why"."""
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
    seen: Sightings, inside: NDArray[np.bool_], covers: NDArray[np.bool_], rule: FitOptions
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
    found: list[tuple[float, ...]], hidden: list[tuple[float, ...]], rule: FitOptions
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
        for order in fit.orders(AROUND, options.rule.min_order):
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
    orders = np.unique(seen.order) if seen.order.size else np.array([options.rule.min_order])
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
