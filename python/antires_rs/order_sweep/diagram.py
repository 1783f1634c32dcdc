r"""Order sweep, stability marks and the automatic choice of what is physical.

A pole is *stable* if the next lower order has one within 1 % in frequency and 10 % in damping. A value is
accepted if more than ten consecutive orders are stable, and if the pole acts on the curve.

The second test is a pole's *dominance*: its own peak, norm(residues) / abs(Re s), over the norm of the fitted
curve at that frequency. A spurious pole sits on a zero and cancels. On simulated records of an 8-mass
chain (0 to 5 % noise) true poles had at least 0.90, spurious ones that survived ten rows at most 6e-4;
the limit of 0.05 lies between. With that test the damping tolerance can be 10 %, which finds 1.5 values of 28
more at 5 % noise than the customary 5 % does, and costs no false one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..rational.dominance import dominance
from ..rational.fit import NestedFit, prepare
from ..support.one_thread import one_blas_thread
from ..support.pickling import ReadOnly, frozen
from ..support.validation import ComplexArray, FloatArray, integer
from .chains import link, physical
from .rule import Rule
from .table import ResponseTable

__all__ = ["StabilizationDiagram", "stabilization"]


@dataclass(frozen=True, repr=False)
class StabilizationDiagram(ReadOnly):
    """Poles of every order, which of them are stable, and the values accepted.

    Attributes
    ----------
    orders : (n_orders,) int
    freq_hz, damping_ratio, stable : tuple of n_orders arrays
        Poles of each order inside the band, left half plane, by ascending frequency.
    accepted : ResponseTable
        What was accepted, with its scores, see :class:`~antires_rs.order_sweep.table.ResponseTable`.
    background_freq_hz, background : (n_freq,)
        ``abs(sum over outputs)`` of the data, for drawing behind the poles.
    band_hz : (low, high)
    left_out : ResponseTable
        What fits over windows see and was not accepted, with the score "why".
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
        from ..plotting import plot_stabilization  # matplotlib only when a picture is wanted

        return plot_stabilization(self, ax=ax)

    def __repr__(self) -> str:
        values = ", ".join(f"{f:.4g}" for f in self.identified)
        return (
            f"StabilizationDiagram(orders {self.orders[0]:.0f}-{self.orders[-1]:.0f}, "
            f"band {self.band_hz[0]:g}-{self.band_hz[1]:g} Hz, identified [{values}] Hz)"
        )


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
        See :func:`~antires_rs.rational.fit.fit_rational`.
    freq_tol, damping_tol : float
        Relative change from order to order up to which a pole is stable.
    min_rows : int
        Accepted are poles stable in *more than* this many consecutive orders.
    max_damping : float
        Poles with more damping are dropped, as are those with none.
    min_dominance : float
        Least share of the curve at the pole's own frequency, see the module. 0 switches the test off.

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
    >>> import numpy as np
    >>> from antires_rs.order_sweep.diagram import stabilization
    >>> f = np.linspace(1.0, 20.0, 400)
    >>> rng = np.random.default_rng(1)
    >>> t = 25 / (5**2 - f**2 + 0.1j * f) + 100 / (10**2 - f**2 + 0.2j * f)
    >>> t = t + 1e-3 * (rng.standard_normal(400) + 1j * rng.standard_normal(400))
    >>> stabilization(f, t, max_order=30).identified.round(2).tolist()
    [5.0, 10.0]
    """
    rule = Rule(freq_tol, damping_tol, min_rows, max_damping, min_dominance).checked()
    max_order = integer("max_order", max_order, low=2)
    min_order = integer("min_order", min_order, low=1)
    rule.check_span(min_order, max_order)
    freq, array, weight = prepare(freq_hz, values, max_order, band_hz, weights, "max_order")
    band = (float(freq[0]), float(freq[-1])) if band_hz is None else (float(band_hz[0]), float(band_hz[1]))
    sweep = PoleSweep(NestedFit(freq, array, weight, max_order))
    return diagram(sweep, range(min_order, max_order + 1), band, rule, freq, np.abs(array.sum(axis=0)))


class Sweep(Protocol):
    """What the selection asks of the fits of rising order."""

    #: Whether there is a second, finer solution.
    refines: bool

    def roots(self, order: int, norm: bool = False) -> ComplexArray:
        """All roots in rad/s; ``norm`` for those of the second, finer solution if there is one."""

    def dominances(self, order: int | NDArray[np.int64], s: ComplexArray) -> FloatArray:
        """Share of each root in the curve at its frequency; ``order`` is that of all, or of each of them."""


class PoleSweep:
    """Roots of the common denominator, order by order.

    A sweep answers three questions of an order: the roots under "low", those under "norm", and the dominance
    of a root. :class:`ZeroSweep` answers the same for one numerator.
    """

    refines = True

    def __init__(self, nested: NestedFit) -> None:
        self.nested = nested
        self._gram: dict[int, FloatArray] = {}
        self._low: dict[int, FloatArray] = {}
        self._norm: dict[int, FloatArray] = {}
        self._roots: dict[tuple[int, bool], ComplexArray] = {}

    def _solution(self, order: int, norm: bool) -> FloatArray:
        store = self._norm if norm else self._low
        if order not in store:
            if order not in self._gram:
                self._gram[order] = self.nested.gram(order)
            gram = self._gram[order]
            store[order] = np.linalg.eigh(gram)[1][:, 0] if norm else self.nested.denominator(gram)
        return store[order]

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
        d = self._solution(order, False)
        return dominance(
            (self.nested.numerator_basis, self.nested.numerators(d)),
            (self.nested.denominator_basis, d),
            s / (2 * np.pi * self.nested.scale_hz),
        )


class ZeroSweep(PoleSweep):
    """Roots of one numerator of a joint fit; solutions are shared with the ``parent`` sweep."""

    def __init__(self, parent: PoleSweep, output: int) -> None:
        self.nested, self.output = parent.nested, output
        self._gram, self._low, self._norm = parent._gram, parent._low, parent._norm
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
        d = self._solution(order, False)
        numerator = self.nested.numerators(d)[self.output]
        return dominance(
            (self.nested.denominator_basis, d[None, :]),
            (self.nested.numerator_basis, numerator),
            s / (2 * np.pi * self.nested.scale_hz),
        )


def diagram(
    sweep: Sweep,
    orders: range,
    band: tuple[float, float],
    rule: Rule,
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
    rows = [s + added_decay_per_s for s in rows]
    sizes = [np.abs(s) for s in rows]
    return StabilizationDiagram(
        orders=frozen(np.array(orders)),
        freq_hz=tuple(frozen(size / (2 * np.pi)) for size in sizes),
        damping_ratio=tuple(frozen(-s.real / size) for s, size in zip(rows, sizes, strict=True)),
        stable=tuple(frozen(mark) for mark in stable),
        accepted=_merged(found, rule),
        background_freq_hz=frozen(freq_hz),
        background=frozen(background),
        band_hz=band,
    )


def _shares(sweep: Sweep, linked: list[list[tuple[int, complex]]]) -> list[float]:
    """Median dominance of some members of every chain."""
    some = [members[:: max(1, len(members) // 5)] for members in linked]
    orders = np.array([order for members in some for order, _ in members], dtype=np.int64)
    roots = np.array([s for members in some for _, s in members], dtype=np.complex128)
    ends = np.cumsum([len(members) for members in some])
    return [float(np.median(own)) for own in np.split(sweep.dominances(orders, roots), ends)[: len(some)]]


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
    return (
        float(np.median(size)) / (2 * np.pi),
        float(np.median(-roots.real / size)),
        len(members),
        float(np.std(size) / np.median(size)),
    )


def _merged(found: ResponseTable, rule: Rule) -> ResponseTable:
    """Chains closer than the tolerance are one pole, interrupted or split by noise; the longest stays."""
    kept: list[int] = []
    for i, freq in enumerate(found.freq_hz):
        if kept and freq - found.freq_hz[kept[-1]] <= rule.freq_tol * freq:
            kept[-1] = max(kept[-1], i, key=lambda at: found.rows[at])
        else:
            kept.append(i)
    return found.take(kept)
