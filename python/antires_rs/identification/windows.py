"""From lines to one stabilization diagram for each response, by fits over windows."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.spectra import LEAST_DIRECTION_NOISE as ROUNDING, aligned, noise_shares
from ..support.checks import ComplexArray, FloatArray
from ..support.progress import step
from .lines import FORCE, SNR_CAP, Lines, unit
from .numerators import Influence, Likeliest, combined, excess, likeliest
from .options import FitOptions, IdentificationOptions
from .scores import dips, scored, window_grades
from .stabilization import StabilizationDiagram, of_zeros

# -- Where the windows lie: on a grid that depends on the spacing of the lines, never on the band
#
# Of each scale the edges ascend by a fourth of a window, so that every frequency lies well inside three. A
# window is as wide as a given ratio of frequencies or, at low frequency, as a given number of lines.

# (highest over lowest frequency, least number of lines) of the windows of each scale: the wide ones hold
# several modes and know the trend between them, the narrow ones suffer less from what is not rational.
SCALES = ((1.5, 96), (1.25, 48))
OVERLAP = 4  # windows of one scale that cover a frequency
# A window that the band cuts must keep this share of its width, and so many lines.
LEAST_SHARE, LEAST_LINES = 0.6, 24
MARGIN = 0.08  # this share of a window at either end is its margin: what lies there others see better


def local_windows(freq_hz: FloatArray) -> list[slice]:
    """Lines of all windows that they fill well enough; the whole if there is none."""
    step_hz, highest_hz = float(np.median(np.diff(freq_hz))), float(freq_hz[-1])
    found = []
    for ratio, lines in SCALES:
        edges = [0.0]
        while edges[-1] < highest_hz * ratio:
            edges.append(max(edges[-1] * ratio ** (1.0 / OVERLAP), edges[-1] + lines * step_hz / OVERLAP))
        for low, high in zip(edges[:-OVERLAP], edges[OVERLAP:], strict=True):
            kept = min(high, highest_hz) - max(low, freq_hz[0])
            first, last = np.searchsorted(freq_hz, low), np.searchsorted(freq_hz, high)
            if kept >= LEAST_SHARE * (high - low) and last - first >= max(LEAST_LINES, lines // 2):
                found.append(slice(int(first), int(last)))
    return found or [slice(0, freq_hz.size)]


# -- The likeliest numerators of one window
#
# The channels are brought to equal noise, and to the few directions that hold their signal. Where nothing
# tells the noise, the residual of a first fit does, by channel and by line, and weights a second one: lines
# and channels at which the structure is not what the fit can be (a joint that slips) lose their say.

HIGHEST_ORDER, LINES_PER_ORDER = 16, 5  # highest order of a window, and lines that each order needs
# Directions kept of the channels: those in which there is more signal than noise, within these numbers.
LEAST_DIRECTIONS, MOST_DIRECTIONS = 3, 14
# Iterations of weights and order in each of the fits, the second with the noise from the first's residual.
ITERATIONS = (3, 3)
# Lines over which a residual is averaged, and the least share of its median that one may have.
RESIDUAL_LINES, LEAST_RESIDUAL = 15, 0.05


class LocalFit:
    """Numerators of all rows of ``lines`` at the likeliest order and its neighbours."""

    def __init__(self, lines: Lines, max_order: int) -> None:
        self.freq_hz = lines.freq_hz
        self.highest = max(2, min(max_order, HIGHEST_ORDER, lines.freq_hz.size // LINES_PER_ORDER))
        directions = aligned(lines.vectors)
        row, line = np.ones(len(directions)), 1.0 / lines.snr
        #: Standard deviation of the rows of the directions, (n_rows, n_freq).
        self.noise = np.sqrt(row[:, None] * line)
        self._more = 1.0
        if lines.segments is not None:
            self._fit(lines, row, sum(ITERATIONS))
            return
        start = None
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
            runs = None if lines.runs is None else unit(lines.runs / np.sqrt(row)[:, None], axis=1)
            self._fit(Lines(self.freq_hz, unit(scaled), power / line, runs=runs), row, iterations, start)
            size = np.sum(np.abs(self.best.fit.values(self.best.coefficients)) ** 2, axis=1)
            start = (self.best.order, size)

    def _fit(
        self,
        lines: Lines,
        row_noise: FloatArray,
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
            self.highest,
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

    def numerators(self, order: int) -> ComplexArray:
        """All rows at the lines, (n_rows, n_freq)."""
        return np.asarray(self._mix @ self.best.fit.values(self._own(order)).T)

    def zeros(self, order: int) -> list[ComplexArray]:
        """Roots of every row in rad/s."""
        return [self.best.fit.zeros(own) for own in np.asarray(self._own(order) @ self._mix.T).T]

    def variances(self, row: int, s: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Of zeros of the likeliest order in Hz^2: by noise, and by the scatter between tests (0 for one)."""
        within, between = self._influence.variances(self._mix[row], s)
        # Where there are several tests, the noise is what they differ by.
        return (self._more**2 if self._lines.runs is None else 1.0) * within, between

    def _own(self, order: int) -> FloatArray:
        """Coefficients of the directions that are held."""
        return self.best.coefficients if order == self.best.order else self.best.fit.likeliest(order)[0]

    @cached_property
    def _influence(self) -> Influence:
        return Influence(self.best, self._lines.by_test())


# -- What one fit of one window sees: the zeros of each response, and which of them make a dip
#
# A numerator has more roots than antiresonances. So a root counts only where the fitted response has a dip in
# the responses' direction, a peak of the transmissibilities to it; each dip belongs to the root that is
# nearest in the complex plane. Where the size of the responses is known, a dip of the response itself is
# looked for too: on the node of a mode there is a peak of the transmissibilities, but no dip of its own
# curve.

AROUND = (-1, 0, 1)  # orders that are looked at, relative to the likeliest
# How far the root that a dip belongs to may lie from it, and a dip of the response's own curve from that of
# its direction, as shares of the frequency.
OWNER_WITHIN, OWN_DIP_WITHIN = 0.01, 0.02
# A dip must be so many standard deviations of the noise beside it deep, where that is less than the rule
# asks for: what is shallow is believed only of curves that are as good as exact. Shallower ones never count.
DIP_OVER_NOISE, LEAST_DIP_DB = 35.0, 0.5

# A zero that a fit sees: ``row`` is that of the response, ``fit`` numbers the fits of all windows; the
# variances by noise and between tests are NaN but for the likeliest order, ``own_depth_db`` where the size
# of the responses is not known. Zeros without a dip have ``depth_db`` 0: they are for the diagram, and
# ``apart_hz`` tells those beside a resonance from a pair that all responses share: how far the nearest zero
# of that response lies which has none so near (NaN for one response).
SIGHTING = np.dtype(
    [(name, np.intp) for name in ("row", "fit", "order")]
    + [
        (name, np.float64)
        for name in ("freq_hz", "damping_ratio", "within", "between", "depth_db", "own_depth_db", "apart_hz")
    ]
)
Sightings = NDArray[np.void]


def sightings_of(
    fit: LocalFit, lines: Lines, order: int, number: int, n_responses: int, rule: FitOptions, use_force: bool
) -> Sightings:
    """Zeros of the first ``n_responses`` rows at one order; ``number`` is that of the fit."""
    numerators, roots = fit.numerators(order), fit.zeros(order)
    size = np.linalg.norm(numerators, axis=0)
    own = _own_levels(numerators, lines, use_force)
    tables = []
    for row in range(n_responses):
        s, hz = roots[row], np.abs(roots[row]) / (2 * np.pi)
        s = s[(s.imag > 0.0) & (hz >= lines.freq_hz[0]) & (hz <= lines.freq_hz[-1])]
        level = _level(numerators[row], size)
        at, depth = dips(lines.freq_hz, level, LEAST_DIP_DB)
        # Of its shoulders: what the dip needs to be more than noise.
        relative = fit.noise[row][at] / 10.0 ** ((level[at] + depth) / 20.0)
        enough = DIP_OVER_NOISE * 20.0 / np.log(10.0) * relative
        needed = np.minimum(np.maximum(enough, LEAST_DIP_DB), rule.min_depth_db)
        deep = depth >= needed
        at, depth, needed = at[deep], depth[deep], needed[deep]
        others = [roots[k] for k in range(n_responses) if k != row]
        owner, dip = _owners(lines.freq_hz, s, at, others)
        moved = s + lines.added_decay_per_s
        table = np.zeros(s.size, dtype=SIGHTING)
        for name in ("within", "between", "own_depth_db", "apart_hz"):
            table[name] = np.nan
        table["row"], table["fit"], table["order"] = row, number, order
        table["freq_hz"], table["damping_ratio"] = np.abs(moved) / (2 * np.pi), -moved.real / np.abs(moved)
        table["depth_db"][owner] = depth[dip]
        if order == fit.best.order and owner.size:
            table["within"][owner], table["between"][owner] = fit.variances(row, s[owner])
        if own is not None:
            table["own_depth_db"] = 0.0
            for root, k in zip(owner, dip, strict=True):
                value = float(lines.freq_hz[at[k]])
                around = (value * (1.0 - OWN_DIP_WITHIN), value * (1.0 + OWN_DIP_WITHIN))
                seen = dips(lines.freq_hz, own[row], LEAST_DIP_DB, around)[1].max(initial=0.0)
                table["own_depth_db"][root] = seen if seen >= needed[k] else 0.0
        if others:
            nearest = [np.abs(s[:, None] - other).min(axis=1, initial=np.inf) for other in others]
            table["apart_hz"] = np.max(nearest, axis=0) / (2 * np.pi)
        tables.append(table[np.abs(table["damping_ratio"]) <= rule.max_damping])
    return np.concatenate(tables)


def _level(values: ComplexArray, size: FloatArray) -> FloatArray:
    """In dB."""
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(values) / np.maximum(size, 1e-300), 1e-300)))


def _own_levels(numerators: ComplexArray, lines: Lines, use_force: bool) -> FloatArray | None:
    """The responses' own curves in dB as far as they are of the fitted form; None if nothing tells."""
    if use_force:
        return _level(numerators, np.abs(numerators[FORCE]))
    if lines.size is None:
        return None
    power = np.maximum(np.sum(np.abs(numerators) ** 2, axis=0), 1e-300)
    along = np.abs(np.sum(numerators.conj() * lines.vectors, axis=0)) / power
    return _level(numerators * (along * lines.size), np.ones(lines.freq_hz.size))


def _owners(
    freq_hz: FloatArray, s: ComplexArray, at: NDArray[np.intp], others: list[ComplexArray]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of each root that owns a dip its index, and that of its first dip."""
    found: dict[int, int] = {}
    step_hz = float(np.median(np.diff(freq_hz)))
    for k, line in enumerate(at.tolist()):
        value = freq_hz[line]
        within = np.abs(np.abs(s) / (2 * np.pi) - value) <= max(OWNER_WITHIN * value, 2.0 * step_hz)
        for root in np.argsort(np.abs(s - 2j * np.pi * value)).tolist():
            # A root cancels if all of two or more other rows have it too, nearer than it lies to the axis.
            reach = max(abs(s[root].real), np.pi * step_hz)
            distances = (np.abs(other - s[root]).min(initial=np.inf) for other in others)
            if within[root] and not (len(others) > 1 and all(each < reach for each in distances)):
                found.setdefault(root, k)
                break
    return np.array(list(found), dtype=np.intp), np.array(list(found.values()), dtype=np.intp)


# -- What most of the fits that could see it do see
#
# Sightings of one response within a tolerance are one antiresonance, the most frequent first. Its frequency
# is the median; its error is the larger of the noise, as the fits tell it, and of how far the fits disagree.

# Zeros of several fits are one antiresonance within this share of the frequency tolerance; two that are
# accepted lie at least ONE_DIP apart.
CLUSTER, ONE_DIP = 0.7, 0.01
ONLY_TRANSMISSIBILITY = "seen by transmissibilities only"
TOO_FEW = "in too few fits"
BESIDE = "beside an accepted one"
HIDDEN = "hidden by a resonance beside it"
# Of a zero without a dip: most damping, most scatter between the fits (relative), and how many times further
# the zeros of another response lie. A pair of roots that shapes a trend is damped more and wanders, one that
# all responses share cancels. Of 30 chains with a resonance beside antiresonances these scatter by up to
# 2.5e-4, roots that follow the trend of a measured plate by 6e-4 and more.
HIDDEN_DAMPING, HIDDEN_SCATTER, HIDDEN_APART = 0.03, 4e-4, 5.0
# Narrow windows know less than all fits together do: the noise is taken as this quantile of what fits tell.
BEST_INFORMED = 0.25
WORTH_MENTIONING = 0.25  # what is in fewer fits is not worth mentioning


def agreed(
    seen: Sightings, std_hz: FloatArray, inside: Any, covers: Any, rule: FitOptions
) -> tuple[ResponseTable, ResponseTable]:
    """The antiresonances of one response, and what was left out with the score "why".

    ``inside`` and ``covers``, (n_seen, n_fits), tell in which windows a zero lies, margins left out or not.
    """
    kept: list[tuple[float, ...]] = []
    out: list[tuple[tuple[float, ...], str]] = []
    dipped = seen["depth_db"] > 0.0
    groups = _groups(seen, np.flatnonzero(dipped), inside, covers, rule)
    for group, share in sorted(groups, key=lambda one: -one[1]):
        if share < WORTH_MENTIONING:
            continue
        one = _row(seen[group], std_hz[group], share)
        *_, own_depth, _ = one
        if _beside(one, kept):
            if share >= rule.min_share:
                out.append((one, BESIDE))
        elif share < rule.min_share:
            out.append((one, TOO_FEW))
        elif own_depth <= 0.0:
            out.append((one, ONLY_TRANSMISSIBILITY))
        else:
            kept.append(one)
    visible = [*kept, *(one for one, _ in out)]
    for group, share in _groups(seen, np.flatnonzero(~dipped), inside, covers, rule):
        if share >= rule.min_share and _stands_alone(seen[group]):
            one = _row(seen[group], std_hz[group], share)
            if not _beside(one, visible):
                out.append((one, HIDDEN))
    out.sort(key=lambda left: left[0][0])
    whys = np.array([why for _, why in out], dtype=np.str_)
    return _table(kept), _table([row for row, _ in out]).with_scores(why=whys)


def _groups(
    seen: Sightings, left: NDArray[np.intp], inside: Any, covers: Any, rule: FitOptions
) -> list[tuple[NDArray[np.intp], float]]:
    """Sightings that are one zero, the most frequent first, each with its share of the fits."""
    freq_hz = seen["freq_hz"]
    left = left[np.argsort(freq_hz[left], kind="stable")]
    groups = []
    while left.size:
        freq = freq_hz[left]
        near = np.abs(freq[:, None] / freq - 1.0) <= CLUSTER * rule.freq_tol
        counts = np.array([np.unique(seen["fit"][left[own]]).size for own in near])
        best = near[int(np.argmax(counts))]
        group, left = left[best], left[~best]
        middle = group[group.size // 2]
        asked = inside[middle] if inside[middle].any() else covers[middle]
        counted = group[asked[seen["fit"][group]]]
        share = np.unique(seen["fit"][counted]).size / max(int(asked.sum()), 1)
        groups.append((counted if counted.size else group, share))
    return groups


def _stands_alone(group: Sightings) -> bool:
    """Whether fits agree on a zero that is lightly damped and that not all responses have."""
    damping, freq = float(np.median(group["damping_ratio"])), float(np.median(group["freq_hz"]))
    scatter = float(np.median(np.abs(group["freq_hz"] - freq)))
    steady = scatter <= min(HIDDEN_SCATTER * freq, float(np.median(group["apart_hz"])) / HIDDEN_APART)
    return steady and 0.0 < damping <= HIDDEN_DAMPING


def _row(group: Sightings, noise: FloatArray, share: float) -> tuple[float, ...]:
    """Frequency, damping, std, fits, spread, depth, depth of the own curve, share."""
    value, spread = float(np.median(group["freq_hz"])), float(np.std(group["freq_hz"]))
    noise = noise[np.isfinite(noise)]
    own = group["own_depth_db"]
    return (
        value,
        float(np.median(group["damping_ratio"])),
        max(float(np.quantile(noise, BEST_INFORMED)), spread) if noise.size else np.nan,
        np.unique(group["fit"]).size,
        spread / value,
        float(np.median(group["depth_db"])),
        float(np.median(own)) if np.isfinite(own).all() else np.nan,
        share,
    )


def _beside(one: tuple[float, ...], others: list[tuple[float, ...]]) -> bool:
    """Whether another is the same dip."""
    return any(abs(one[0] / other[0] - 1.0) <= ONE_DIP for other in others)


def _table(rows: list[tuple[float, ...]]) -> ResponseTable:
    columns: FloatArray = np.array(sorted(rows, key=lambda row: row[0]), dtype=np.float64).reshape(-1, 8).T
    freq, damping, std, fits, spread, depth, own, share = columns
    table = ResponseTable.of_sweep(
        freq, damping, std, rows=fits, spread=spread, dominance=np.full(len(rows), np.nan), how="windows"
    )
    grade = window_grades(share, spread, np.fmin(depth, own))
    return table.with_scores(share=share, depth_db=depth, own_depth_db=own, grade=grade)


def local_diagrams(
    lines: Lines, n_responses: int, band_hz: tuple[float, float], options: IdentificationOptions
) -> list[StabilizationDiagram]:
    """One diagram for each of the first ``n_responses`` rows of ``lines``."""
    cut, rule = local_windows(lines.freq_hz), options.rule
    parts: list[Sightings] = []
    owner: list[int] = []
    # At each line the numerators of the window in whose middle it lies best.
    fitted = np.zeros(lines.vectors.shape, dtype=np.complex128)
    centre = np.full(lines.freq_hz.size, np.inf)
    for number, at in enumerate(cut):
        step(f"window {number + 1} of {len(cut)}")
        some = lines.part(at.start, at.stop)
        fit = LocalFit(some, options.max_order)
        best = fit.best.order
        for order in sorted({min(max(best + k, rule.min_order), fit.highest) for k in AROUND} | {best}):
            parts.append(sightings_of(fit, some, order, len(owner), n_responses, rule, options.use_force))
            owner.append(number)
        low, high = some.freq_hz[[0, -1]]
        off = np.abs(some.freq_hz - 0.5 * (low + high)) / (high - low)
        nearer = off < centre[at]
        fitted[:, at][:, nearer] = fit.numerators(best)[:, nearer]
        centre[at][nearer] = off[nearer]
    seen = np.concatenate(parts)
    std = np.sqrt(seen["within"])
    if lines.n_tests > 1:
        told = np.isfinite(std)
        q = excess(seen["between"][told], seen["within"][told], lines.n_tests)
        std = np.sqrt(combined(seen["between"], seen["within"], lines.n_tests, q))
    ends = lines.freq_hz[np.array([(cut[number].start, cut[number].stop - 1) for number in owner])]
    in_band = (seen["freq_hz"] >= band_hz[0]) & (seen["freq_hz"] <= band_hz[1])
    low, high = ends.T
    margin = MARGIN * (high - low)
    diagrams = []
    for row in range(n_responses):
        some_seen = in_band & (seen["row"] == row)
        own, freq = seen[some_seen], seen["freq_hz"][some_seen, None]
        inside = (freq > low + margin) & (freq < high - margin)
        tables = agreed(own, std[some_seen], inside, (freq >= low) & (freq <= high), rule)
        quotients = lines.quotients(row)[0]
        numerator = np.where(np.abs(fitted[row]) > 0.0, fitted[row], 1e-300)
        background = np.abs(quotients.sum(axis=0))
        by_fit = np.delete(fitted, row, axis=0) / numerator
        accepted = scored(tables[0], lines.freq_hz, background, quotients, by_fit)
        zeros, within = (own["order"], own["freq_hz"], own["damping_ratio"]), CLUSTER * rule.freq_tol
        tables = accepted, tables[1]
        diagrams.append(of_zeros(zeros, rule.min_order, *tables, within, lines.freq_hz, background, band_hz))
    return diagrams
