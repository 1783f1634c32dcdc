r"""Order sweep, stability marks and the automatic choice of what is physical.

A pole is *stable* if the next lower order has one within 1 % in frequency and 10 % in damping. A value is
accepted if more than ten consecutive orders are stable, and if the pole acts on the curve: its *dominance*,
its own peak norm(residues) / abs(Re s) over the norm of the fitted curve there. A spurious pole sits on a
zero and cancels: on simulated records of an 8-mass chain (0 to 5 % noise) true poles had at least 0.90,
spurious ones that survived ten rows at most 6e-4. With that test the damping tolerance can be 10 %, which
finds 1.5 values of 28 more at 5 % noise than the customary 5 % does, and costs no false one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.averaging import MOST_LINES
from ..support.checks import ComplexArray, FloatArray
from ..support.progress import one_blas_thread
from ..support.values import ReadOnly, frozen
from ..views import Viewed
from .options import FitOptions
from .rational_fit import NestedFit, dominance, prepare

# Limits here, in scores and in selection were set on simulated structures (chains, random stiffness, a plane
# frame; seeds 100-119), never on the records that the published tables are made from; those of dips and of
# fits over windows on six states of a measured plate, and judged on measured frames and a beam.

# Damping ratio up to which changes of damping are taken relative to this where both signs are allowed.
SMALL_DAMPING = 0.01

# -- Which roots of successive orders belong together


def physical(
    every: list[ComplexArray], band: tuple[float, float], rule: FitOptions, added: float
) -> list[ComplexArray]:
    """Of each order: upper half, left half plane, in the band, lightly damped; ascending."""
    order = np.repeat(np.arange(len(every)), [s.size for s in every])
    s = np.concatenate([np.empty(0, dtype=np.complex128), *every])
    size = np.abs(s)
    freq = size / (2 * np.pi)
    keep = np.flatnonzero(
        (s.imag > 0)
        & ((s.real < 0) | rule.both_sides)
        & (np.abs(s.real + added) <= rule.max_damping * size)
        & (freq >= band[0])
        & (freq <= band[1])
    )
    keep = keep[np.lexsort((freq[keep], order[keep]))]
    return np.split(s[keep], np.searchsorted(order[keep], np.arange(1, len(every))))


def link(rows: list[ComplexArray], rule: FitOptions) -> tuple[list[list[tuple[int, int]]], list[Any]]:
    """Chains of (row, index) over consecutive orders, one to one, best pairs first; and the stable marks."""
    counts = np.array([s.size for s in rows])
    s = np.concatenate([np.empty(0, dtype=np.complex128), *rows])
    at = np.repeat(np.arange(counts.size), counts), np.concatenate([np.arange(n) for n in counts])
    number = np.full((counts.size, counts.max(initial=0)), -1)
    number[at] = np.arange(s.size)
    size, damping = np.full((2, *number.shape), np.nan)
    size[at] = np.abs(s)
    damping[at] = -s.real / size[at]
    # Every root of an order, in rows, beside every one of the order before, in columns.
    d_freq = np.abs(size[1:, :, None] / size[:-1, None] - 1.0) / rule.freq_tol
    row, new, before = near = np.nonzero(d_freq <= 1.0)
    old = damping[row, before]
    # About zero damping a relative change says nothing.
    scale = np.maximum(np.abs(old), SMALL_DAMPING if rule.both_sides else 0.0)
    d_damping = np.abs(damping[row + 1, new] - old) / scale / rule.damping_tol
    best_first = np.lexsort((d_freq[near] + d_damping, row))
    best_first = best_first[d_damping[best_first] <= 1.0]
    pairs = np.stack([number[row + 1, new], number[row, before]], axis=1)[best_first]
    linked: dict[int, int] = {}
    taken: set[int] = set()
    for one, other in pairs.tolist():
        if one not in linked and other not in taken:
            linked[one] = other
            taken.add(other)
    chains: list[list[tuple[int, int]]] = []
    of_root: list[list[tuple[int, int]]] = []
    for i, place in enumerate(zip(*(part.tolist() for part in at), strict=True)):
        if i not in linked:
            chains.append([])
        of_root.append(of_root[linked[i]] if i in linked else chains[-1])
        of_root[i].append(place)
    stable = np.zeros(s.size, dtype=bool)
    stable[list(linked)] = True
    return chains, np.split(stable, np.cumsum(counts)[:-1])


@dataclass(frozen=True, repr=False)
class StabilizationDiagram(ReadOnly, Viewed):
    """Poles of every order, which of them are stable, and the values accepted.

    Attributes
    ----------
    orders : (n_orders,) int
    freq_hz, damping_ratio, stable : tuple of n_orders arrays
        Poles of each order inside the band, left half plane, by ascending frequency.
    accepted : ResponseTable
        What was accepted, with its scores, see :mod:`~antires_rs.identification.scores`.
    background_freq_hz, background : (n_freq,)
        ``abs(sum over outputs)`` of the data, for drawing behind the poles.
    band_hz : (low, high)
    left_out : ResponseTable
        What fits over windows and local fits see and was not accepted, with the score "why".
    unexplained_hz : (n,)
        Peaks of the curve behind the poles beside which nothing was accepted or left out.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(1.0, 20.0, 400)
    >>> noise = 1e-3 * np.random.default_rng(1).standard_normal(400)
    >>> diagram = ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + noise, max_order=20)
    >>> diagram, diagram.identified_damping.round(3)
    (StabilizationDiagram(orders 2-20, band 1-20 Hz, identified [5] Hz), array([0.01]))
    """

    orders: FloatArray
    freq_hz: tuple[FloatArray, ...]
    damping_ratio: tuple[FloatArray, ...]
    stable: tuple[Any, ...]
    accepted: ResponseTable
    background_freq_hz: FloatArray
    background: FloatArray
    band_hz: tuple[float, float]
    left_out: ResponseTable = field(default_factory=lambda: ResponseTable([]))
    unexplained_hz: FloatArray = field(default_factory=lambda: frozen(np.empty(0)))

    @property
    def identified(self) -> FloatArray:
        """Accepted values in Hz, ascending."""
        return self.accepted.freq_hz

    @property
    def identified_damping(self) -> FloatArray:
        """Damping ratios of the accepted values."""
        return self.accepted.damping_ratio

    def plot(self, ax: Any | None = None) -> Any:
        """Draw order against frequency with matplotlib; returns the axes."""
        return self._view("plot")(self, ax=ax)

    def __repr__(self) -> str:
        values = ", ".join(f"{f:.4g}" for f in self.identified)
        return (
            f"StabilizationDiagram(orders {self.orders[0]:.0f}-{self.orders[-1]:.0f}, "
            f"band {self.band_hz[0]:g}-{self.band_hz[1]:g} Hz, identified [{values}] Hz)"
        )


def of_zeros(
    zeros: tuple[Any, Any, Any],
    least_order: int,
    accepted: ResponseTable,
    left_out: ResponseTable,
    within: float,
    lines_hz: FloatArray,
    background: FloatArray,
    band_hz: tuple[float, float],
) -> StabilizationDiagram:
    """A diagram of zeros (order, frequency, damping) that many fits see; stable are those beside a value."""
    rank = np.lexsort((zeros[1], zeros[0]))
    order, freq, damping = (column[rank] for column in zeros)
    orders, first = np.unique(order, return_index=True)
    if not rank.size:
        orders, first = np.array([least_order]), np.array([0])
    beside = np.abs(freq[:, None] / accepted.freq_hz - 1.0).min(axis=1, initial=np.inf) <= within

    def by_order(column: Any) -> tuple[Any, ...]:
        return tuple(frozen(part) for part in np.split(column, first[1:]))

    zeros = by_order(freq), by_order(damping), by_order(beside)
    lines, curve = frozen(lines_hz), frozen(background)
    return StabilizationDiagram(frozen(orders), *zeros, accepted, lines, curve, band_hz, left_out)


@one_blas_thread
def stabilization(
    freq_hz: Any,
    values: Any,
    *,
    max_order: int = 60,
    min_order: int = 2,
    band_hz: Sequence[float] | None = None,
    weights: Any | None = None,
    freq_tol: float = 0.01,
    damping_tol: float = 0.10,
    min_rows: int = 10,
    max_damping: float = 0.10,
    min_dominance: float = 0.05,
) -> StabilizationDiagram:
    """Fit rational functions of rising order and keep the poles that stay.

    Parameters
    ----------
    freq_hz : array_like, (n_freq,)
    values : array_like, (n_freq,) or (n_outputs, n_freq)
        Complex curves with common poles. For the antiresonances of dof j: the transmissibilities T_pj.
    max_order, min_order : int
        Orders in s, step one. The highest must exceed the true order by ``min_rows`` and some.
    band_hz : (low, high), optional
        Lines fitted, and limits of the poles kept.
    weights : array_like, (n_freq,), optional
        See :func:`~antires_rs.fit_rational`.
    freq_tol, damping_tol, min_rows, max_damping, min_dominance
        See :class:`~antires_rs.FitOptions`. Poles without damping are dropped.

    Returns
    -------
    StabilizationDiagram

    Raises
    ------
    InvalidInputError
        Malformed data or options; a band outside the data or with too few lines.

    Notes
    -----
    The rule of V. Meruane, J. Sound Vib. 332 (2013) 807-820 (there 5 % in damping). Chains follow the
    "low" solutions; each of their poles is then replaced by the nearest pole of the "norm" solution if that
    lies within ``freq_tol``, and the value is the median over the chain.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f, rng = np.linspace(1.0, 20.0, 400), np.random.default_rng(1)
    >>> t = 25 / (5**2 - f**2 + 0.1j * f) + 100 / (10**2 - f**2 + 0.2j * f)
    >>> t = t + 1e-3 * (rng.standard_normal(400) + 1j * rng.standard_normal(400))
    >>> ar.stabilization(f, t, max_order=30).identified.round(2).tolist()
    [5.0, 10.0]
    """
    accepted = {"freq_tol": freq_tol, "damping_tol": damping_tol, "min_rows": min_rows}
    accepted |= {"max_damping": max_damping, "min_dominance": min_dominance}
    rule, (min_order, max_order) = FitOptions.of_sweep(min_order, max_order, **accepted)
    freq, array, weight = prepare(freq_hz, values, max_order, band_hz, weights, "max_order")
    band = (float(freq[0]), float(freq[-1])) if band_hz is None else (float(band_hz[0]), float(band_hz[1]))
    sweep = PoleSweep(NestedFit(freq, array, weight, max_order))
    return diagram(sweep, range(min_order, max_order + 1), band, rule, freq, np.abs(array.sum(axis=0)))


class Sweep(Protocol):
    """What the selection asks of the fits of rising order."""

    refines: bool  #: Whether there is a second, finer solution.

    def roots(self, order: int, norm: bool = False) -> ComplexArray:
        """All roots in rad/s; ``norm`` for those of the second, finer solution if there is one."""

    def dominances(self, order: int | NDArray[np.int64], s: ComplexArray) -> FloatArray:
        """Share of each root in the curve at its frequency; ``order`` is that of all, or of each of them."""


class PoleSweep:
    """Roots of the common denominator, order by order; :class:`ZeroSweep` has those of one numerator."""

    refines = True

    def __init__(self, nested: NestedFit) -> None:
        self.nested = nested
        self._grams: dict[int, FloatArray] = {}
        self._solutions: dict[tuple[int, bool], FloatArray] = {}
        self._roots: dict[tuple[int, bool], ComplexArray] = {}

    def _solution(self, order: int, norm: bool) -> FloatArray:
        if (order, norm) not in self._solutions:
            if order not in self._grams:
                self._grams[order] = self.nested.gram(order)
            gram = self._grams[order]
            found = np.linalg.eigh(gram)[1][:, 0] if norm else self.nested.denominator(gram)
            self._solutions[order, norm] = found
        return self._solutions[order, norm]

    def roots(self, order: int, norm: bool = False) -> ComplexArray:
        """All roots in rad/s, kept: several tests ask for them."""
        if (order, norm) not in self._roots:
            self._roots[order, norm] = self._find(self._solution(order, norm))
        return self._roots[order, norm]

    def _find(self, solution: FloatArray) -> ComplexArray:
        return self.nested.poles(solution)

    def curves(self, order: int) -> tuple[ComplexArray, ComplexArray]:
        """Data and fit on the lines, (n_outputs, n_freq) each."""
        n, d = self._on_lines(order)
        return self.nested.values, np.asarray(n / d)

    def _on_lines(self, order: int) -> tuple[ComplexArray, ComplexArray]:
        """Numerators and denominator on the lines."""
        d = self._solution(order, False)
        turn = 1j ** np.arange(order + 1)
        above = (self.nested.numerator_basis.p[:, : order + 1] * turn) @ self.nested.numerators(d).T
        below = (self.nested.denominator_basis.p[:, : order + 1] * turn) @ d
        return np.asarray(above.T), np.asarray(below)

    def dominances(self, order: int | NDArray[np.int64], s: ComplexArray) -> FloatArray:
        """Share of each root's own peak in the fitted curves at its frequency."""
        each, share = np.broadcast_to(order, s.shape), np.empty(s.shape)
        for one in np.unique(each).tolist():
            share[each == one] = self._share(one, s[each == one])
        return share

    def _share(self, order: int, s: ComplexArray) -> FloatArray:
        nested, d = self.nested, self._solution(order, False)
        above = (nested.numerator_basis, nested.numerators(d))
        return dominance(above, (nested.denominator_basis, d), s / (2 * np.pi * nested.scale_hz))


class ZeroSweep(PoleSweep):
    """Roots of one numerator of a joint fit; solutions are shared with the ``parent`` sweep."""

    def __init__(self, parent: PoleSweep, output: int) -> None:
        self.nested, self.output = parent.nested, output
        self._grams, self._solutions = parent._grams, parent._solutions
        self._roots = {}

    def _find(self, solution: FloatArray) -> ComplexArray:
        return self.nested.zeros(solution, self.output)

    def curves(self, order: int) -> tuple[ComplexArray, ComplexArray]:
        """Reciprocal of the curve, data and fit, (1, n_freq) each."""
        n, d = self._on_lines(order)
        own = self.nested.values[self.output][None, :]
        return np.asarray(1.0 / np.where(own == 0.0, 1e-300, own)), np.asarray(d / n[self.output][None, :])

    def _share(self, order: int, s: ComplexArray) -> FloatArray:
        """Of each root's own peak in the reciprocal of the fitted curve."""
        nested, d = self.nested, self._solution(order, False)
        below = (nested.numerator_basis, nested.numerators(d)[self.output])
        return dominance((nested.denominator_basis, d[None, :]), below, s / (2 * np.pi * nested.scale_hz))


def diagram(
    sweep: Sweep,
    orders: range,
    band: tuple[float, float],
    rule: FitOptions,
    freq_hz: FloatArray,
    background: FloatArray,
    added_decay_per_s: float = 0.0,
) -> StabilizationDiagram:
    """Sweep, link, select; ``added_decay_per_s`` of the exponential window is taken off every root."""
    rows = physical([sweep.roots(order) for order in orders], band, rule, added_decay_per_s)
    chains, stable = link(rows, rule)
    # n poles in a row are n - 1 stable orders and the one they start from.
    long = [chain for chain in chains if len(chain) - 1 > rule.min_rows]
    linked = [[(orders[row], rows[row][i]) for row, i in chain] for chain in long]
    values, shares = [], []
    for members, share in zip(linked, _shares(sweep, linked), strict=True):
        if share >= rule.min_dominance:
            values.append(_value(sweep, members, rule.freq_tol, added_decay_per_s))
            shares.append(share)
    freq, damping, counts, spread = np.array(values).reshape(-1, 4).T
    found = ResponseTable.of_sweep(freq, damping, rows=counts, spread=spread, dominance=shares, how="chain")
    # Chains closer than the tolerance are one pole, interrupted or split by noise; the longest stays.
    kept: list[int] = []
    for i, value in enumerate(found.freq_hz):
        if kept and value - found.freq_hz[kept[-1]] <= rule.freq_tol * value:
            kept[-1] = max(kept[-1], i, key=lambda at: found.rows[at])
        else:
            kept.append(i)
    rows = [s + added_decay_per_s for s in rows]
    sizes = [np.abs(s) for s in rows]
    return StabilizationDiagram(
        orders=frozen(np.array(orders)),
        freq_hz=tuple(frozen(size / (2 * np.pi)) for size in sizes),
        damping_ratio=tuple(frozen(-s.real / size) for s, size in zip(rows, sizes, strict=True)),
        stable=tuple(frozen(mark) for mark in stable),
        accepted=found.take(kept),
        background_freq_hz=frozen(freq_hz),
        background=frozen(background),
        band_hz=band,
    )


def _shares(sweep: Sweep, linked: list[list[tuple[int, complex]]]) -> list[float]:
    """Median dominance of some members of every chain."""
    some = [members[:: max(1, len(members) // 5)] for members in linked]
    orders = np.array([order for members in some for order, _ in members], dtype=np.int64)
    roots = np.array([s for members in some for _, s in members], dtype=np.complex128)
    shares = iter(sweep.dominances(orders, roots).tolist())
    return [median([next(shares) for _ in members]) for members in some]


def _value(
    sweep: Sweep, members: list[tuple[int, complex]], tol: float, added: float
) -> tuple[float, float, int, float]:
    """Frequency, damping, length, spread of a chain; its members give way to roots of the second solution."""
    refined = []
    for order, s in members:
        if not sweep.refines:
            refined.append(s)
            continue
        others = sweep.roots(order, norm=True)
        near = others[np.argmin(np.abs(others - s))] if others.size else s
        refined.append(near if abs(near - s) <= tol * abs(s) else s)
    roots = np.array(refined) + added
    size = np.abs(roots)
    middle = median(size.tolist())
    damping = median((-roots.real / size).tolist())
    return middle / (2 * np.pi), damping, len(members), float(np.std(size) / middle)


# -- A value in the middle of a valley of noise is believed only if the response is seen on both of its flanks

FLANK = (0.02, 0.20)  # they lie this far on either side of it, as shares of its frequency
PERSISTENT_SNR = 4.0  # signal-to-noise power there that a persistent value needs (6 dB)


def flanked(freq_hz: FloatArray, snr: FloatArray, at_hz: FloatArray, least_snr: float) -> Any:
    """Whether half the lines at least of either flank of ``at_hz`` (n,) reach ``least_snr``; no flank, no."""
    good = np.concatenate([[0], np.cumsum(snr >= least_snr)])

    def half(low: float, high: float) -> Any:
        a, b = np.searchsorted(freq_hz, at_hz * (1.0 + low)), np.searchsorted(freq_hz, at_hz * (1.0 + high))
        return (good[b] - good[a]) / np.maximum(b - a, 1) >= 0.5

    return half(-FLANK[1], -FLANK[0]) & half(*FLANK)


# -- A second way to accept a value: it is there in most orders, though it does not stand still
#
# Where a response lies near its noise, the pole of one antiresonance moves by more than the stability
# tolerance from order to order, and its damping may come out slightly negative. Without the condition on the
# flanks the edge of the band, where only noise is left, collects poles just as faithfully.

WIDTH = 0.02  # poles within this share of a frequency are taken for the same value
PRESENCE = 0.75  # in this share of the orders from the first appearance on there must be one
# Spurious poles of a noisy fit are not all weak: here a pole must own the curve at its frequency.
PERSISTENT_DOMINANCE, PERSISTENT_DAMPING = 0.7, 0.05


def add_persistent(
    found: StabilizationDiagram,
    sweep: Sweep,
    rule: FitOptions,
    channel_snr: FloatArray,
    added_decay_per_s: float,
) -> StabilizationDiagram:
    """The diagram with persistent values added; ``channel_snr`` is that of the response at its lines."""
    orders = found.orders.astype(int)
    pool = _dominant(sweep, orders, found, channel_snr, added_decay_per_s)
    new: list[tuple[float, float, int, float]] = []
    while len(pool):
        first = np.searchsorted(pool[:, 0], pool[:, 0] * (1.0 - WIDTH))
        last = np.searchsorted(pool[:, 0], pool[:, 0] * (1.0 + WIDTH))
        counts = np.array([np.unique(pool[a:b, 1]).size for a, b in zip(first, last, strict=True)])
        best = int(np.argmax(counts))
        if counts[best] <= rule.min_rows:
            break
        group = pool[first[best] : last[best]]
        value = float(np.median(group[:, 0]))
        # The second appearance opens the count: a single early one may be chance.
        opened = np.unique(group[:, 1])[1]
        present = (counts[best] - 1) / (orders[-1] - opened + 1)
        if present >= PRESENCE:
            new.append(
                (value, float(np.median(group[:, 2])), int(counts[best]), float(np.std(group[:, 0]) / value))
            )
        keep = (pool[:, 0] < value * (1.0 - WIDTH)) | (pool[:, 0] > value * (1.0 + WIDTH))
        keep[first[best] : last[best]] = False
        pool = pool[keep]
    if not new:
        return found
    freq, damping, rows, spread = np.array(new).T
    more = ResponseTable.of_sweep(
        freq, damping, rows=rows, spread=spread, dominance=np.full(len(new), np.nan), how="persistent"
    )
    return replace(found, accepted=ResponseTable.concatenated([found.accepted, more]))


def _dominant(
    sweep: Sweep, orders: Any, found: StabilizationDiagram, snr: FloatArray, added: float
) -> FloatArray:
    """(n, 3) of frequency, order, damping of the poles that may count, by frequency: not yet identified, and
    with a signal beside them."""
    rows: list[tuple[float, float, float]] = []
    grid = found.background_freq_hz
    beside = flanked(grid, snr, grid, PERSISTENT_SNR)
    for order in orders:
        s = sweep.roots(int(order))
        moved = s + added
        size = np.abs(moved)
        freq = size / (2 * np.pi)
        near = (
            (s.imag > 0)
            & (freq >= found.band_hz[0])
            & (freq <= found.band_hz[1])
            & (np.abs(moved.real) <= PERSISTENT_DAMPING * size)
            & beside[np.clip(np.searchsorted(grid, freq), 0, grid.size - 1)]
        )
        if found.identified.size:
            near &= np.abs(freq[:, None] / found.identified - 1.0).min(axis=1) > WIDTH
        if near.any():
            for i in np.flatnonzero(near)[sweep.dominances(int(order), s[near]) >= PERSISTENT_DOMINANCE]:
                rows.append((float(freq[i]), float(order), float(-moved[i].real / size[i])))
    return np.array(sorted(rows)).reshape(-1, 3)


# -- Wide bands are fitted in windows that overlap by half: orders up to 60 cannot carry all their modes

WINDOW_LINES = 2500
MARGIN = 0.05  # values this close to a cut, as a share of the window's width, are left to the neighbour


@dataclass(frozen=True)
class Window:
    """Lines ``first`` to ``last`` (exclusive), and the frequencies whose values and poles it may report."""

    first: int
    last: int
    report_hz: tuple[float, float]
    core_hz: tuple[float, float]


def windows(freq_hz: FloatArray, band_hz: tuple[float, float]) -> list[Window]:
    """One window, or several that overlap by half."""
    n = freq_hz.size
    if n <= MOST_LINES:
        return [Window(0, n, band_hz, band_hz)]
    count = int(np.ceil(2.0 * n / WINDOW_LINES)) - 1
    width = 2.0 * n / (count + 1)
    cuts = [(round(i * width / 2), min(round(i * width / 2 + width), n)) for i in range(count)]
    low, high = (freq_hz[[at[0] for at in cuts]], freq_hz[[at[1] - 1 for at in cuts]])
    middles = (0.5 * (high[:-1] + low[1:])).tolist()
    margin = MARGIN * (high - low)
    first, last = [band_hz[0], *(low + margin)[1:].tolist()], [*(high - margin)[:-1].tolist(), band_hz[1]]
    reports = zip(first, last, strict=True)
    cores = zip([band_hz[0], *middles], [*middles, band_hz[1]], strict=True)
    return [Window(*at, report, core) for at, report, core in zip(cuts, reports, cores, strict=True)]


def join(
    parts: list[StabilizationDiagram], cut: list[Window], band_hz: tuple[float, float], tol: float
) -> StabilizationDiagram:
    """One diagram of all windows: each shows the poles of its core; values found twice count once."""
    if len(parts) == 1:
        return parts[0]

    def joined(arrays: Sequence[Any], freq_hz: Sequence[FloatArray]) -> Any:
        inside = [(f >= w.core_hz[0]) & (f < w.core_hz[1]) for f, w in zip(freq_hz, cut, strict=True)]
        return frozen(np.concatenate([own[keep] for own, keep in zip(arrays, inside, strict=True)]))

    # Orders follow the data: windows need not have swept the same ones.
    orders = np.unique(np.concatenate([d.orders for d in parts]))
    at = [{order: k for k, order in enumerate(d.orders.tolist())} for d in parts]

    def column(name: str, order: int) -> list[Any]:
        values = [getattr(d, name) for d in parts]
        return [v[k[order]] if order in k else v[0][:0] for v, k in zip(values, at, strict=True)]

    columns: dict[str, Any] = {
        name: tuple(joined(column(name, order), column("freq_hz", order)) for order in orders.tolist())
        for name in ("freq_hz", "damping_ratio", "stable")
    }
    lines = [d.background_freq_hz for d in parts]
    return replace(
        parts[0],
        orders=frozen(orders),
        band_hz=band_hz,
        background_freq_hz=joined(lines, lines),
        background=joined([d.background for d in parts], lines),
        accepted=_once([d.accepted for d in parts], tol),
        **columns,
    )


def _once(tables: list[ResponseTable], tol: float) -> ResponseTable:
    """All antiresonances of the windows; of those found twice the better one."""
    every = [(part, i) for part, table in enumerate(tables) for i in range(len(table))]
    # Poles that stand still before those that only stay near; long chains before short ones.
    every.sort(key=lambda at: (tables[at[0]].how[at[1]] != "chain", -tables[at[0]].rows[at[1]]))
    kept: list[list[int]] = [[] for _ in tables]
    freq: list[float] = []
    for part, i in every:
        value = tables[part].freq_hz[i]
        if all(abs(value / other - 1.0) > tol for other in freq):
            freq.append(value)
            kept[part].append(i)
    return ResponseTable.concatenated([table.take(some) for table, some in zip(tables, kept, strict=True)])
