"""Intervals of parameters from draws of their posterior within the bounds, and profiles of the likelihood.

First the residuals over the unit box of the free parameters, what is known of their errors, and the best fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np

from ..exceptions import reject
from ..support.checks import BoolArray, FloatArray, IntArray
from ..support.messages import some
from ..support.progress import step
from ..support.values import FrozenDict, Value
from ..views import Viewed
from .discrepancy import likely_errors
from .problem import UpdatingProblem
from .targets import MODEL_ERROR

_ODD = 4.0  # residuals beyond so many standard deviations are named, beyond so many medians no model's error
STEP_OF_SLOPES = 1e-5  # of the range: the residuals carry rounding of 1e-13, so this leaves 1e-8 of error


class BoxResiduals:
    """Residuals (m,) as a function of u (n,) in the unit box, of values that at ``x`` are less than ``most``
    off, or less than some times the median."""

    def __init__(self, problem: UpdatingProblem, x: FloatArray, most: float = np.inf) -> None:
        self.problem, self.x = problem, x
        low, high = problem.bounds.T
        self.free = np.flatnonzero((high > low) & ~decided(problem, x))  # parameters that u holds
        self.low, self.high = low[self.free], high[self.free]
        # With the logarithm of the parameter: antiresonances hang on ratios of stiffness to mass, and a
        # common scale of all is then a straight line along which nothing changes.
        self.log = self.low > 0.0
        #: Slope of ln of the prior's density in u, which is uniform in the parameters themselves.
        self.tilt = np.zeros(self.free.size)
        self.tilt[self.log] = np.log(self.high[self.log] / self.low[self.log])
        value, kind, std = problem._targets.error_rows()
        weights = np.ones(len(problem.measured_hz)) if problem.weights is None else problem.weights
        off = np.abs((problem._core.pairs(x)[0] / problem.measured_hz) ** 2 - 1.0)  # NaN without a partner
        usual = np.nanmedian(off) if np.isfinite(off).any() else 0.0
        paired = off <= max(most, _ODD * float(usual))
        self.kept = (paired & (weights > 0.0))[value]
        self.hz = problem.measured_hz[value][self.kept]  # measured frequency that each residual belongs to
        #: 0 for frequencies, 1 for entries of shapes.
        self.kind, std, weights = kind[self.kept], std[self.kept], weights[value][self.kept]
        known, noun = np.isfinite(std), f"{problem.noun}s"
        stated, alone = bool(known.any()), [f"{hz:.4g} Hz" for hz in problem.measured_hz[~paired]]
        #: Standard deviations that the measurement states, and relative size of the error that it does not.
        self.stated = np.where(known, std, np.median(std[known])) if stated else None
        self.size = np.ones(std.size) if stated else 1.0 / weights
        self.turned: FloatArray | None = None
        assumed = {
            f"Left out, without a partner near them in the model: {some(alone)}.": alone,
            f"No errors of the measured {noun} are stated: the residuals tell them.": not stated,
            "Values without a standard deviation are given the median of others.": stated and not known.all(),
        }
        self.assumed = tuple(sentence for sentence, holds in assumed.items() if holds)

    def vector(self, u: FloatArray) -> FloatArray:
        """All parameters, (n,) or (k, n)."""
        x = np.broadcast_to(self.x, (*u.shape[:-1], self.x.size)).copy()
        even = self.low + u * (self.high - self.low)
        x[..., self.free] = np.where(self.log, self.low * np.exp(u * self.tilt), even)
        return x

    def place(self, x: FloatArray) -> FloatArray:
        """The u of all parameters ``x``, (n,), within the box."""
        held, low, high = x[self.free], self.low, self.high
        safe = np.where(self.log, low, 1.0)
        log = np.log(np.maximum(np.where(self.log, held, 1.0), safe) / safe)
        found = np.where(self.log, log / np.where(self.log, self.tilt, 1.0), (held - low) / (high - low))
        return np.asarray(np.clip(found, 0.0, 1.0))

    def at(self, u: FloatArray) -> FloatArray:
        """Residuals at one point, (m,), or combinations of them whose errors are independent."""
        e = self.problem._targets.errors(self.problem._core, self.vector(u))[self.kept]
        return np.asarray(e if self.turned is None else self.turned @ e)

    def many(self, u: FloatArray, workers: int) -> FloatArray:
        """Residuals at every row, (k, m): the same bits for any number of workers."""
        if workers == 1:
            return np.stack([self.at(row) for row in u])
        pool = ThreadPoolExecutor(workers)
        try:
            return np.stack(list(pool.map(self.at, u)))
        finally:  # after Ctrl-C what has not begun is not begun
            pool.shutdown(wait=False, cancel_futures=True)

    def jacobian(self, u: FloatArray) -> FloatArray:
        """Change of the residuals over the bounds' distances, (m, n), by central differences."""
        steps = STEP_OF_SLOPES * np.eye(u.size)
        columns = [(self.at(u + h) - self.at(u - h)) / (2.0 * STEP_OF_SLOPES) for h in steps]
        return np.stack(columns, axis=1) if columns else np.empty((self.size.size, 0))


def decided(problem: UpdatingProblem, x: FloatArray) -> BoolArray:
    """Damage at exactly 0: with penalties it is decided, not estimated."""
    reductions = np.array([p.quantity == "stiffness_reduction" for p in problem.parameters])
    return np.asarray(reductions & (x == 0.0) & (problem.penalty is not None))


# -- Errors of the measured values and of the model
#
# A residual e of omega squared has the variance ``s**2 + (tau g)**2``: s = 2 std_hz / freq_hz is what the
# measurement states, tau what the model leaves unexplained, learned from the residuals, and g the relative
# size of the term. Where errors are stated, tau is 0 with a prior probability of one half, else
# log-uniform; where none are, tau stands for both.
#
# Of stated antiresonances nearly all of tau**2 has the correlation of what a model lacks
# (:mod:`.discrepancy`). That widens the posterior and moves it nowhere: the fit goes by errors that are
# independent, since a correlation that is not quite right leads it far off, and the likelihood is that of the
# combinations of residuals that the fit goes by, with the variances that they have in truth. Reference:
# R. E. Chandler & S. Bate, Biometrika 94 (2007) 167-183.

LACKED = 0.98  # of tau**2 as the residuals tell it: what the model lacks; the rest is each value's own
OWN = 1.0  # what each value has of its own in those combinations, over tau**2: the correlation may be wrong
UNTOLD = 0.02  # error of a model that lacks something, before values to spare tell it; e times more or less
FLOOR = 1e-5  # no test and no model agrees better than this in omega squared: no interval has the width 0
#: Largest error of the model, in omega squared, and the step of ln(tau).
_MOST_ERROR, _STEP_ERROR_MODEL = 0.3, 0.05
_LEAST = 0.2  # errors of the model below this share of the stated ones make no difference
#: Factor below the estimate at which the grid begins, and above it at which the grid ends: with few values to
#: spare the tail falls as ``tau**-spare``, and one percent of it is left out.
_BELOW, _ABOVE, _TAIL = 6.0, 4.0, 100.0


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Errors of the model on a grid (G,)."""

    tau: FloatArray
    log_prior: FloatArray
    variance: FloatArray  # of the residuals, (G, m)
    learned: bool  # whether the residuals tell tau

    @classmethod
    def around(
        cls, stated: FloatArray | None, size: FloatArray, guess: float | None, spare: int
    ) -> ErrorModel:
        """Grid around the error that the residuals suggest; the parameters leave ``spare`` of them over.
        Without a ``guess``, of what a model lacks and its parameters have taken, all of it that may be."""
        s = np.zeros(size.size) if stated is None else np.maximum(stated, FLOOR)
        if spare <= 0:  # as many parameters as values: nothing is left to learn from
            tau = np.array([UNTOLD if guess is None else 0.0 if stated is not None else MODEL_ERROR])
            return cls(tau, np.zeros(1), s**2 + (tau[:, None] * size) ** 2, False)
        usual = FLOOR if stated is None else float(np.median(s / size))
        low = min(max(FLOOR, _LEAST * usual), 0.1 * _MOST_ERROR)
        first, last = low, _MOST_ERROR
        if guess is not None:
            first = min(max(low, guess / _BELOW), 0.5 * _MOST_ERROR)
            last = min(last, max(guess, usual, 2.0 * first) * _ABOVE * _TAIL ** (1.0 / spare))
        tau = np.exp(np.arange(np.log(first), np.log(last), _STEP_ERROR_MODEL))
        log_prior = np.full(tau.size, np.log(_STEP_ERROR_MODEL / np.log(_MOST_ERROR / low)))
        if guess is None:
            log_prior -= 0.5 * np.log(tau / UNTOLD) ** 2
        elif stated is not None:  # half and half: the factor cancels
            tau, log_prior = np.append(0.0, tau), np.append(0.0, log_prior)
        return cls(tau, log_prior, s**2 + (tau[:, None] * size) ** 2, True)

    def log_density(self, squares: FloatArray) -> FloatArray:
        """Logarithm of likelihood times prior, (k, G), of residuals whose squares (k, m) are given."""
        constant = self.log_prior - 0.5 * np.log(self.variance).sum(axis=1)
        return np.asarray(constant - 0.5 * squares @ (1.0 / self.variance).T)

    def marginal(self, residuals: FloatArray, jacobian: FloatArray) -> FloatArray:
        """Probability of each tau, (G,), with the parameters integrated out as if nothing bounded them."""
        found = np.empty(self.tau.size)
        for nth, variance in enumerate(self.variance):
            root = np.sqrt(variance)
            rows, singular, _ = np.linalg.svd(jacobian / root[:, None], full_matrices=False)
            seen = singular > 1e-9 * max(singular.max(initial=0.0), 1.0)
            z = residuals / root
            left = z @ z - np.sum((rows[:, seen].T @ z) ** 2)
            found[nth] = -np.log(root).sum() - np.log(singular[seen]).sum() - 0.5 * left
        return normalized(found + self.log_prior)


def normalized(log_weights: FloatArray) -> FloatArray:
    """Probabilities from logarithms, along the last axis."""
    p = np.exp(log_weights - log_weights.max(axis=-1, keepdims=True))
    return np.asarray(p / p.sum(axis=-1, keepdims=True))


def drawn(probabilities: FloatArray, uniform: FloatArray) -> IntArray:
    """Index of one outcome for each row of ``probabilities`` (k, G) or (G,), by uniform numbers (k,)."""
    cumulative = np.cumsum(np.atleast_2d(probabilities), axis=1)
    return np.asarray(np.minimum((uniform[:, None] > cumulative).sum(axis=1), cumulative.shape[1] - 1))


# -- The weighted least-squares solution near the parameters found: where the posterior is expanded

UNSEEN = 1e-5  # a combination whose residuals move less than this over the bounds' distance is not seen
_ROUNDS, _STEPS = 3, 20  # rounds of weights from residuals and residuals from weights, and steps of each
FAR, SAME = 4.0, 2e-3  # another solution differs by more standard deviations and share of omega squared
_ON_BOUND = 1e-6  # this near to a bound, as a share of the bounds' distance, a parameter is on it
_DAMPED = 1e-6  # share of the steepest column that a step costs: what no value sees stays where it is


@dataclass(frozen=True, eq=False)
class Fit:
    """Solution u (n,), residuals e (m,) and Jacobian (m, n) there, and the errors that they suggest.

    Where the model lacks something these are of combinations, and ``alone`` is the fit that they are of.
    """

    residuals: BoxResiduals
    u: FloatArray
    e: FloatArray
    jacobian: FloatArray
    spare: int  # values beyond the combinations of parameters that they tell
    chi_square: float  # reduced, by the stated errors; NaN where none are or nothing is left over
    errors: ErrorModel
    chances: FloatArray  # probabilities of the errors of the model on the grid, (G,)
    alone: Fit | None = None

    @cached_property
    def middle(self) -> int:
        """Number of the median error of the model."""
        return int(np.clip(np.searchsorted(np.cumsum(self.chances), 0.5), 0, self.chances.size - 1))

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations of the residuals at the median error of the model, (m,)."""
        return np.asarray(np.sqrt(self.errors.variance[self.middle]))

    @property
    def weighted(self) -> FloatArray:
        """The Jacobian over these, (m, n)."""
        return np.asarray(self.jacobian / self.sigma[:, None])

    def squares(self, u: FloatArray) -> float:
        """Sum of squares over the errors' variances at ``u``."""
        return float(np.sum((self.residuals.at(u) / self.sigma) ** 2))

    def held(self, j: int, u: FloatArray) -> tuple[float, FloatArray]:
        """The least sum of squares and its place, parameter j held as in ``u``, the others begun there."""
        u = least_squares(self.residuals, u, self.sigma, held=[j])
        return self.squares(u), u


def fitted(problem: UpdatingProblem, x: FloatArray) -> Fit:
    """Least squares within the bounds from ``x``, with the errors that its residuals suggest."""
    residuals = BoxResiduals(problem, x, _MOST_ERROR)
    fit = _fitted(problem, residuals, residuals.place(x))
    # Fewer values to spare than combinations of parameters cannot vouch for a model.
    right = 2 * fit.spare >= fit.e.size and fit.errors.tau[fit.middle] == 0.0
    if residuals.stated is None or right or fit.spare == fit.e.size:  # or no parameter is seen
        return fit
    alike = likely_errors(problem, x, residuals.kept)
    return fit if alike is None else _lacking(fit, np.maximum(residuals.stated, FLOOR), alike)


def _lacking(fit: Fit, unit: FloatArray, alike: FloatArray) -> Fit:
    """The same solution, its errors stated as ``unit`` (m,) and by what the model lacks, correlated so."""
    from scipy.linalg import eigh

    white = np.eye(unit.size)
    # How large errors of the model are all residuals tell, in combinations that make both kinds independent.
    # A parameter on a bound goes no further: what would push it there is an error.
    size, ways = np.linalg.eigh((LACKED * alike + (1.0 - LACKED) * white) / np.outer(unit, unit))
    rows = (ways / unit[:, None]).T
    errors = ErrorModel.around(np.ones(unit.size), np.sqrt(np.maximum(size, 0.0)), None, fit.spare)
    inside = (fit.u > _ON_BOUND) & (fit.u < 1.0 - _ON_BOUND)
    chances = errors.marginal(rows @ fit.e, rows @ fit.jacobian[:, inside])
    # What the parameters are those combinations tell that the fit goes by.
    ways, singular, _ = np.linalg.svd(fit.weighted, full_matrices=False)
    rows = (ways[:, singular > 1e-9 * singular.max()] / fit.sigma[:, None]).T
    size, ways = eigh(rows @ (alike + OWN * white) @ rows.T, (rows * unit**2) @ rows.T)
    turned = copy(fit.residuals)
    turned.turned = rows = ways.T @ rows
    variance = 1.0 + errors.tau[:, None] ** 2 * size
    errors = replace(errors, log_prior=np.log(np.maximum(chances, 1e-300)), variance=variance)
    own = {"residuals": turned, "e": rows @ fit.e, "jacobian": rows @ fit.jacobian}
    return replace(fit, **own, errors=errors, chances=chances, alone=fit)


def _fitted(problem: UpdatingProblem, residuals: BoxResiduals, u: FloatArray) -> Fit:
    """The same of these residuals, from ``u``."""
    stated, size = residuals.stated, residuals.size
    sigma = size * max(_rms(residuals.at(u) / size), FLOOR) if stated is None else np.maximum(stated, FLOOR)
    for _ in range(_ROUNDS):
        step("least squares")
        before, u = residuals.at(u), least_squares(residuals, u, sigma)
        moved = np.abs(residuals.at(u) - before)
        if np.any(moved > np.maximum(FAR * sigma, SAME)):  # it has led far
            starts = (residuals.place(problem.nominal), np.full(u.size, 0.5))
            found = [u, *(least_squares(residuals, start, sigma) for start in starts)]
            u = min(found, key=lambda u: float(np.sum((residuals.at(u) / sigma) ** 2)))
        e, jacobian = residuals.at(u), residuals.jacobian(u)
        rank = int(np.count_nonzero(np.linalg.svd(jacobian, compute_uv=False) > UNSEEN)) if u.size else 0
        sizes = size
        shape = residuals.kind == 1
        if stated is None and shape.any():  # errors of shapes have a unit of their own
            ratio = max(_rms((e / size)[shape]), FLOOR) / max(_rms((e / size)[~shape]), FLOOR)
            sizes = sizes * np.where(shape, ratio, 1.0)
        guess = _rms(e / sizes) * np.sqrt(e.size / max(e.size - rank, 1))
        errors = ErrorModel.around(stated, sizes, float(guess), e.size - rank)
        chances, spare = errors.marginal(e, jacobian), e.size - rank
        squares = np.nan if stated is None else float(np.sum((e / np.maximum(stated, FLOOR)) ** 2))
        chi_square = squares / spare if spare > 0 else np.nan
        fit = Fit(residuals, u, e, jacobian, spare, chi_square, errors, chances)
        change = fit.sigma / sigma
        if change.max() < 1.05 * change.min():
            break  # a common factor moves no minimum
        sigma = fit.sigma
    return fit


def least_squares(
    residuals: BoxResiduals, start: FloatArray, sigma: FloatArray, held: Sequence[int] = ()
) -> FloatArray:
    """Least squares of the residuals over ``sigma`` within the unit box, by Gauss-Newton; ``held`` stay."""
    from scipy.optimize import lsq_linear

    u = start.copy()
    free = np.setdiff1d(np.arange(u.size), np.array(held, dtype=int))
    if free.size == 0:
        return u
    z = residuals.at(u) / sigma
    for _ in range(_STEPS):
        slope = residuals.jacobian(u)[:, free] / sigma[:, None]
        damped = _DAMPED * max(np.linalg.norm(slope, axis=0).max(), 1.0)
        rows = np.vstack([slope, damped * np.eye(free.size)])
        ends = (np.minimum(-u[free], -1e-12), np.maximum(1.0 - u[free], 1e-12))
        move = lsq_linear(rows, np.append(-z, np.zeros(free.size)), ends, method="bvls").x
        cost, share = float(z @ z), 1.0
        while True:
            tried = u.copy()
            tried[free] = np.clip(u[free] + share * move, 0.0, 1.0)
            now = residuals.at(tried) / sigma
            if now @ now < cost:
                break
            share /= 2.0
            if share < 1e-3:
                return u
        u, z = tried, now
        if cost - z @ z < 1e-6 * cost + 1e-6:
            break  # less than any probability would show
    return u


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


Method = Literal["laplace", "ensemble"]


@dataclass(frozen=True, eq=False)
class ParameterIntervals(Value, Viewed):
    """Intervals of updated parameters, from draws of their posterior. ``intervals[name]`` is one of them.

    Attributes
    ----------
    names, method, level : tuple of str, (n,), {'laplace', 'ensemble'} and float
        ``level`` is the probability of each interval; of one-sided ones half the rest is beyond.
    low, high, center, std : ndarray, (n,)
        Ends of the intervals, median and standard deviation of the draws, in the parameters' units.
    words : tuple of str, (n,)
        "two-sided"; "two-sided, through the bounds of others"; "one-sided: its lower bound fits as well" (or
        upper: the interval begins there); "flat": any value within the bounds fits; "fixed": not estimated.
    draws : ndarray, (k, n)
        Independent draws (of an ensemble nearly independent), rows in no order.
    chi_square, model_error : float
        Reduced chi-square of the residuals by the stated errors alone, NaN where none are stated; and the
        standard deviation of what the model leaves unexplained, relative to omega squared, all of the error
        where none are stated.
    notes : tuple of str
        What was assumed, and what speaks against it.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.update(ar.cases.chain8().updating_problem(), rng=0).intervals().words[0]
    'flat'
    """

    names: tuple[str, ...]
    method: Method
    level: float
    low: FloatArray
    high: FloatArray
    center: FloatArray
    std: FloatArray
    words: tuple[str, ...]
    draws: FloatArray
    chi_square: float
    model_error: float
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> tuple[float, float]:
        if name not in self.names:
            reject("name", repr(name), "a parameter of the problem", f"One of {', '.join(self.names)}.")
        return self.interval[name]

    @property
    def interval(self) -> dict[str, tuple[float, float]]:
        """``(low, high)`` by name."""
        ends = zip(self.low.tolist(), self.high.tolist(), strict=True)
        return FrozenDict(zip(self.names, ends, strict=True))

    def to_dataframe(self) -> Any:
        """One row a parameter; needs pandas."""
        return self._view("to_dataframe")(self)

    def __str__(self) -> str:
        width = max(len(name) for name in self.names)
        lines = [f"intervals at {100 * self.level:g} %, {self.method}, {len(self.draws)} draws"]
        rows = zip(self.names, self.low, self.high, self.words, strict=True)
        lines += [f"{name:<{width}}  {a:#10.5g} to {b:#10.5g}  {words}" for name, a, b, words in rows]
        if np.isfinite(self.chi_square):
            lines.append(f"reduced chi-square by the stated errors: {self.chi_square:.3g}")
        lines.append(f"error that the model leaves, of frequencies: {50 * self.model_error:.2g} %")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


# -- The standard normal distribution between two limits, which may lie far out


def log_between(low: Any, high: Any) -> FloatArray:
    """ln of the probability between two limits, element by element."""
    _, _, _, bottom, top = _on_negative_side(np.asarray(low), high)
    return np.asarray(top + np.log1p(-np.exp(np.minimum(bottom - top, -1e-15))))


def between(low: FloatArray, high: Any, p: FloatArray) -> FloatArray:
    """Quantiles p of what lies between two limits."""
    from scipy.special import ndtri_exp

    flip, a, b, bottom, top = _on_negative_side(low, high)
    share = np.where(flip, 1.0 - p, p)
    # ln of (1 - share) e^bottom + share e^top
    z = ndtri_exp(top + np.log(share + (1.0 - share) * np.exp(np.minimum(bottom - top, 0.0))))
    z = np.clip(z, a, b)
    return np.asarray(np.where(flip, -z, z))


def _on_negative_side(low: FloatArray, high: Any) -> tuple[Any, FloatArray, FloatArray, Any, Any]:
    """Where limits are turned about 0, so that the tail is resolved; the limits and ln of what is below."""
    from scipy.special import log_ndtr

    flip = low > 0.0
    a, b = np.where(flip, -high, low), np.where(flip, -low, high)
    return flip, a, b, log_ndtr(a), log_ndtr(b)


# -- Draws of the parameters given the measured values: the residuals taken as linear around the fit
#
# Laplace's approximation with what it usually leaves out: the bounds, which cut it off, and the error of
# the model, which is drawn along with the parameters. Chains go through both in turn (Gibbs); each gives one
# draw. Within the box they move by hit-and-run along the principal axes of the Gaussian and along the edges:
# on any line the cut Gaussian is a normal distribution between two ends, drawn exactly.

_SWEEPS = 10  # sweeps of every chain, along all axes, and the error of the model after each
_WIDE = 1e4  # a normal distribution this much wider than the line is as good as uniform


class Linear:
    """Gaussians of the linear residuals within the box, times the prior, one a row of ``variance`` (G, m)."""

    def __init__(self, fit: Fit, variance: FloatArray, middle: int) -> None:
        self.fit, self.variance = fit, variance
        weighted = fit.jacobian.T[None] / variance[:, None, :]  # (G, n, m)
        self.precisions = weighted @ fit.jacobian
        self.slopes = weighted @ fit.e - fit.residuals.tilt
        self.typical = self.precisions[middle]
        #: Directions of the sweeps, (2n, n): principal axes, then the edges of the box.
        self.axes = np.vstack([np.linalg.eigh(self.typical)[1].T, np.eye(fit.u.size)])

    def residuals(self, u: FloatArray) -> FloatArray:
        """Linear residuals at every row, (k, m)."""
        return np.asarray(self.fit.e + (u - self.fit.u) @ self.fit.jacobian.T)

    def swept(self, u: FloatArray, which: IntArray, rng: np.random.Generator, axes: FloatArray) -> FloatArray:
        """Every chain ``u`` (k, n) moved once along each axis within the Gaussian that ``which`` names."""
        # Chain c has the density exp(-v' P v / 2 - b' v), v = u - center, P and b those number which[c].
        center = self.fit.u
        v = np.ascontiguousarray((u - center).T)  # (n, k)
        low_edge, high_edge = -center[:, None], 1.0 - center[:, None]
        for axis in axes:
            on = np.flatnonzero(np.abs(axis) > 1e-12)
            inverse = 1.0 / axis[on, None]
            up = inverse > 0.0
            ahead = (np.where(up, high_edge[on], low_edge[on]) - v[on]) * inverse
            behind = (np.where(up, low_edge[on], high_edge[on]) - v[on]) * inverse
            high = np.maximum(ahead.min(axis=0), 0.0)
            low = np.minimum(behind.max(axis=0), 0.0)
            forward = self.precisions @ axis  # (G, n)
            stiff = np.maximum(forward @ axis, 0.0)[which]
            pull = np.einsum("nk,nk->k", forward.T[:, which], v) + (self.slopes @ axis)[which]
            # Draws t of exp(-stiff t**2 / 2 - pull t) within [low, high].
            widest = _WIDE * np.maximum(high - low, 1e-300)
            std = np.minimum(1.0 / np.sqrt(np.maximum(stiff, 1e-300)), widest)
            mean = -pull * std**2
            z = between((low - mean) / std, (high - mean) / std, rng.random(np.shape(pull)))
            v[on] += np.clip(mean + std * z, low, high) * axis[on, None]
        return np.clip(v.T + center, 0.0, 1.0)

    def spread(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points to start from, (count, n): of the Gaussian without its box, put on the box where outside."""
        values, axes = np.linalg.eigh(self.typical)
        std = np.minimum(1.0 / np.sqrt(np.maximum(values, 1e-12)), 0.5)
        noise = rng.standard_normal((count, values.size)) * std
        return np.asarray(np.clip(self.fit.u + noise @ axes.T, 0.0, 1.0))


def linear_draws(fit: Fit, count: int, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
    """Draws of the free parameters in the unit box, (count, n), and the number of the error, (count,)."""
    which = drawn(fit.chances, rng.random(count))
    if fit.u.size == 0:
        return np.empty((count, 0)), which
    linear = Linear(fit, fit.errors.variance, fit.middle)
    u = linear.spread(count, rng)
    for nth in range(_SWEEPS):
        step(f"linear posterior, sweep {nth + 1} of {_SWEEPS}")
        u = linear.swept(u, which, rng, linear.axes)
        chances = normalized(fit.errors.log_density(linear.residuals(u) ** 2))
        which = drawn(chances, rng.random(count))
    return u, which


# -- Draws of a density that no Gaussian is near, and its integral: particles that go by steps and move
#
# Transitional Markov chain Monte Carlo (J. Ching and Y.-C. Chen, J. Eng. Mech. 133 (2007) 816-832): particles
# go from one density to the other, at each step as far as half of them still count, are drawn anew by their
# weights, and walk. A density near the wanted one may propose moves, which the true one accepts (Christen &
# Fox, J. Comput. Graph. Stat. 14 (2005) 795-810).

Density = Callable[[FloatArray], FloatArray]
#: Moves of all particles, and what they add to the log odds of being accepted.
Guide = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
_COUNTING, _ACCEPTED = 0.5, 0.3  # share of particles that count after a step; of walks to be accepted
_MOVES, _LAST, _MOST = 1.0, 3.0, 30  # accepted moves of a particle in a step and the last one; rounds
_GUIDED, _SHORT = 1.8, 0.2  # where moves are proposed, so many more are asked for, and a walk is a short way


def stepwise(
    u: FloatArray,
    start: Density,
    target: Density,
    top: float,
    rng: np.random.Generator,
    guided: Callable[[float], Guide] | None = None,
) -> tuple[FloatArray, float, float]:
    """Draws of ``target`` in the box from 0 to ``top``, from draws ``u`` (k, n) of ``start``; ln of the
    integral of the one over that of the other; share of the moves that were accepted."""
    from scipy.special import logsumexp

    count, n = u.shape
    first, last = start(u), target(u)
    share, log_integral, scale = 0.0, 0.0, 2.4 / np.sqrt(n)
    accepted, rounds = 0.0, 0

    def moved(proposed: FloatArray, bias: Any = 0.0) -> float:
        """Take the moves that chance and the density allow; the share that was taken."""
        nonlocal u, first, last
        inside = np.all((proposed >= 0.0) & (proposed <= top), axis=1)
        proposed = np.where(inside[:, None], proposed, u)
        new_first, new_last = start(proposed), target(proposed)
        gain = share * (new_last - last) + (1.0 - share) * (new_first - first) + bias
        taken = inside & (np.log(rng.random(count)) < gain)
        u = np.where(taken[:, None], proposed, u)
        first, last = np.where(taken, new_first, first), np.where(taken, new_last, last)
        return float(taken.mean())

    while share < 1.0:
        ahead = _longest_step(last - first, 1.0 - share)
        share = share + ahead if ahead < 1.0 - share else 1.0
        step(f"particles, {100 * share:.0f} % of the way")
        log_weight = ahead * (last - first)
        log_integral += float(logsumexp(log_weight) - np.log(count))
        chosen = evenly_chosen(normalized(log_weight), count, rng)
        u, first, last = u[chosen], first[chosen], last[chosen]
        sizes, axes = np.linalg.eigh(np.cov(u.T).reshape(n, n))  # of a matrix that may be singular
        spread = axes * np.sqrt(np.maximum(sizes, 1e-10))
        guide = guided(share) if guided else None
        wanted, done, most = (_LAST if share == 1.0 else _MOVES) * (_GUIDED if guide else 1.0), 0.0, _MOST
        while done < wanted and most:
            taken = moved(*guide(u)) if guide else 0.0
            walked = moved(u + scale * rng.standard_normal(u.shape) @ spread.T)
            scale = float(np.clip(scale * np.exp(walked - _ACCEPTED), 1e-3, 5.0))
            done += taken + _SHORT * walked if guide else walked
            accepted, rounds, most = accepted + taken + walked, rounds + 1, most - 1
    return u, log_integral, accepted / rounds


def _longest_step(gain: FloatArray, most: float) -> float:
    """The longest step towards a density of log weights ``gain`` after which enough particles count."""
    from scipy.optimize import brentq

    def counting(share: float) -> float:
        return 1.0 / float(np.sum(normalized(share * gain) ** 2)) / gain.size

    if counting(most) >= _COUNTING:
        return most
    return max(float(brentq(lambda share: counting(share) - _COUNTING, 0.0, most)), 1e-6)


def evenly_chosen(weight: FloatArray, count: int, rng: np.random.Generator) -> IntArray:
    """Numbers of points that have equal weights then, as evenly as can be."""
    places = (np.arange(count) + rng.random()) / count
    return np.minimum(np.searchsorted(np.cumsum(weight), places), weight.size - 1)


_START, _WIDER = 2.0, 1.1  # times wider than the linear posterior: the particles at first, the proposals


def ensemble_draws(
    fit: Fit, count: int, rng: np.random.Generator, workers: int
) -> tuple[FloatArray, IntArray, float]:
    """As :func:`linear_draws`, with the residuals that the model has; and the share of moves accepted."""
    if fit.u.size == 0:
        return np.empty((count, 0)), drawn(fit.chances, rng.random(count)), 1.0
    residuals, variance = fit.residuals, fit.errors.variance
    wide = _START**2 * variance[fit.middle]
    linear = Linear(fit, wide[None], 0)

    def start(u: FloatArray) -> FloatArray:
        return np.asarray(u @ residuals.tilt - 0.5 * np.sum(linear.residuals(u) ** 2 / wide, axis=1))

    def errors_at(u: FloatArray) -> FloatArray:
        return fit.errors.log_density(residuals.many(u, workers) ** 2)

    def target(u: FloatArray) -> FloatArray:
        return np.asarray(u @ residuals.tilt + np.logaddexp.reduce(errors_at(u), axis=1))

    def guided(share: float) -> Guide:
        """Sweeps there and back through the linear posterior of the step, its errors drawn."""
        own = Linear(fit, _WIDER**2 / ((1.0 - share) / wide + share / variance), fit.middle)
        axes = own.axes[: fit.u.size]

        def guide(u: FloatArray) -> tuple[FloatArray, FloatArray]:
            which = drawn(fit.chances, rng.random(count))
            proposed = own.swept(u, which, rng, np.vstack([axes, axes[::-1]]))
            logs = [
                v @ residuals.tilt - 0.5 * np.sum(own.residuals(v) ** 2 / own.variance[which], axis=1)
                for v in (u, proposed)
            ]
            return proposed, logs[0] - logs[1]

        return guide

    u = linear.spread(count, rng)
    for _ in range(_SWEEPS):
        u = linear.swept(u, np.zeros(count, dtype=np.intp), rng, linear.axes)
    u, _, accepted = stepwise(u, start, target, 1.0, rng, guided)
    return u, drawn(normalized(errors_at(u)), rng.random(count)), accepted


# -- Profile likelihood: how the fit falls when one parameter is held and all others are fitted again
#
# A parameter is open on the side where the sum of squares over the errors' variances, with it held at that
# bound and the others fitted within theirs, rises by less than the chi-square quantile (Raue et al.,
# Bioinformatics 25 (2009) 1923-1929). A side closed by the bound of another parameter alone is said to be so.

Kind = Literal["two-sided", "one-sided", "flat", "fixed"]

_RIDGE = 1e-12  # a combination seen this little, relative to the best, has no covariance of its own


def threshold(level: float) -> float:
    """Rise of the sum of squares at the ends of an interval: chi-square with one degree of freedom."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + level / 2.0) ** 2)


def variances(fit: Fit) -> FloatArray:
    """Of the free parameters as if nothing bounded them, (n,); huge where nothing is seen."""
    values, vectors = np.linalg.eigh(fit.weighted.T @ fit.weighted)
    least = _RIDGE * max(float(values.max(initial=0.0)), 1.0)
    return np.asarray(np.diag((vectors / np.maximum(values, least)) @ vectors.T))


def open_sides(fit: Fit, level: float, refit: bool) -> list[tuple[bool, bool, bool]]:
    """For every free parameter: open below, open above, and closed only by the bounds of others."""
    limit, spread, least = threshold(level), variances(fit), fit.squares(fit.u)
    sides = []
    for j, center in enumerate(fit.u):
        opened, by_others = [], False
        for bound in (0.0, 1.0):
            alone = (bound - center) ** 2 / spread[j]  # as if the others had no bounds
            if alone > 4.0 * limit or (not refit and alone > limit):
                opened.append(False)
                continue
            rise = _rise_at(fit, j, bound, refit) - least
            opened.append(bool(rise < limit))
            by_others |= rise >= limit > alone
        sides.append((opened[0], opened[1], by_others))
    return sides


def kind_of(low_open: bool, high_open: bool) -> Kind:
    """Which it is by the sides that are open."""
    return "flat" if low_open and high_open else "one-sided" if low_open or high_open else "two-sided"


def words_of(low_open: bool, high_open: bool, by_others: bool) -> str:
    """What the data say of a parameter."""
    kind = kind_of(low_open, high_open)
    if kind == "one-sided":
        return f"one-sided: its {'lower' if low_open else 'upper'} bound fits as well"
    return f"{kind}, through the bounds of others" if kind == "two-sided" and by_others else kind


def _rise_at(fit: Fit, j: int, bound: float, refit: bool) -> float:
    """Sum of squares with parameter j at a bound and the others fitted within theirs."""
    from scipy.optimize import lsq_linear

    others = np.delete(np.arange(fit.u.size), j)
    weighted = fit.weighted
    shifted = fit.e / fit.sigma + weighted[:, j] * (bound - fit.u[j])
    u = fit.u.copy()
    u[j] = bound
    if others.size:
        ends = (np.minimum(-u[others], -1e-12), np.maximum(1.0 - u[others], 1e-12))
        found = lsq_linear(weighted[:, others], -shifted, ends, method="bvls")
        if not refit:
            return float(2.0 * found.cost)
        u[others] = np.clip(u[others] + found.x, 0.0, 1.0)
    elif not refit:
        return float(shifted @ shifted)
    return fit.held(j, u)[0]


_REACH = 4.0  # standard deviations within which most points of a profile lie
#: Points that are added on each side, until those around the end differ by this share of the limit's root.
_REFINED, _NEAR = 8, 0.25


@dataclass(frozen=True, eq=False)
class ProfileLikelihood(Value):
    """Likelihood of one parameter, all others fitted again at every value.

    Attributes
    ----------
    name, kind : str
        ``kind`` is "two-sided", "one-sided" or "flat".
    values, rise : ndarray, (k,)
        Values at which the parameter was held, rising, in its unit; and the rise of the sum of squares over
        the errors' variances above its least there.
    threshold, level, low, high : float
        Rise up to which a value is within the interval, the probability of this, and its ends: a bound where
        the profile does not close on that side.
    others_on_bound : tuple of tuple of str, (k,)
        Other parameters that rest on a bound at each value.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.update(ar.cases.chain8().damage_problem(), rng=0)
    >>> found.profile(found.problem.names[4], points=5).kind
    'two-sided'
    """

    name: str
    values: FloatArray
    rise: FloatArray
    threshold: float
    level: float
    low: float
    high: float
    kind: Kind
    others_on_bound: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        lines = [f"{self.name}: {self.kind}, {100 * self.level:g} % within [{self.low:.6g}, {self.high:.6g}]"]
        for value, rise, names in zip(self.values, self.rise, self.others_on_bound, strict=True):
            on = f"  {', '.join(names)} on a bound" if names else ""
            lines.append(f"{value:12.6g} {rise:12.4g}{on}")
        return "\n".join(lines)


@dataclass(frozen=True)
class Section:
    """Parameter ``j`` of u (n,), within [0, top], through the best point; its spread where it is free."""

    j: int
    u: FloatArray
    squares: float  # least sum of squares over the errors' variances
    std: float
    top: float
    #: The least sum of squares and its place, the parameter held as in u, the others begun there.
    refitted: Callable[[FloatArray], tuple[float, FloatArray]]
    value: Callable[[float], float]  # of the parameter, in its unit
    resting: Callable[[FloatArray], tuple[str, ...]]  # other parameters on a bound

    def profile(self, name: str, level: float, points: int) -> ProfileLikelihood:
        """The likelihood along it."""
        found = {float(self.u[self.j]): (self.squares, self.u)}

        def hold(u: FloatArray, place: float) -> FloatArray:
            step(f"{name} held at {self.value(place):.5g}")
            u = u.copy()
            u[self.j] = place
            found[place] = self.refitted(u)
            return found[place][1]

        for bound, count in ((0.0, points // 2), (self.top, points - points // 2)):
            u = self.u
            for place in self._places(bound, count):
                u = hold(u, place)
        limit = threshold(level)
        (low, low_open), (high, high_open) = (_end(found, hold, side, limit) for side in (-1.0, 1.0))
        places = sorted(found)
        rise = np.array([found[place][0] for place in places])
        values, kind = np.array([self.value(place) for place in places]), kind_of(low_open, high_open)
        resting = tuple(self.resting(found[place][1]) for place in places)
        told = limit, level, self.value(low), self.value(high), kind, resting
        return ProfileLikelihood(name, values, rise - rise.min(), *told)

    def _places(self, bound: float, count: int) -> list[float]:
        """Values away from the center: most within a few standard deviations, then the bound."""
        center = float(self.u[self.j])
        reach = min(_REACH * self.std, abs(bound - center))
        if reach < 1e-9:
            return []
        near = center + np.sign(bound - center) * reach * np.arange(1, count + 1) / count
        return [*near.tolist(), *([] if abs(near[-1] - bound) < 1e-9 else [bound])]


def _end(
    found: dict[float, tuple[float, FloatArray]],
    hold: Callable[[FloatArray, float], FloatArray],
    side: float,
    limit: float,
) -> tuple[float, bool]:
    """Where the rise passes the limit on one side, and whether it never does; adds points to ``found``."""
    for _ in range(_REFINED):
        best = min(found, key=lambda place: found[place][0])
        places = sorted((place for place in found if (place - best) * side >= 0.0), key=lambda p: p * side)
        rise = np.array([found[place][0] for place in places]) - found[best][0]
        over = np.flatnonzero(rise > limit)
        if over.size == 0:
            return places[-1], True
        k = int(over[0])
        root = np.sqrt(rise[k - 1 : k + 1])  # a parabola's root is a line
        share = float((np.sqrt(limit) - root[0]) / (root[1] - root[0]))
        end = places[k - 1] + share * (places[k] - places[k - 1])
        if root[1] - root[0] < _NEAR * np.sqrt(limit):
            break
        # A rise that begins late is no parabola: not too near to the side that is known to be within.
        between = places[k - 1] + max(share, 0.3) * (places[k] - places[k - 1])
        hold(found[places[k - 1]][1], float(between))
    return end, False


def profile(
    problem: UpdatingProblem, x: FloatArray, name: str, level: float, points: int
) -> ProfileLikelihood:
    """Profile around the least-squares solution near ``x``; see ``UpdateResult.profile``."""
    fit = fitted(problem, x)
    where = np.flatnonzero(fit.residuals.free == problem.names.index(name))
    if where.size == 0:
        reject("name", repr(name), "a parameter that may move", "Its bounds are equal, or it is exactly 0.")
    j, free = int(where[0]), fit.residuals.free
    # Where an unseen parameter rests means nothing.
    seen = np.linalg.norm((fit.alone or fit).jacobian, axis=0) > UNSEEN

    def value(place: float) -> float:
        return float(fit.residuals.vector(np.where(np.arange(fit.u.size) == j, place, fit.u))[free[j]])

    def resting(u: FloatArray) -> tuple[str, ...]:
        on = seen & ((u <= _ON_BOUND) | (u >= 1.0 - _ON_BOUND)) & (np.arange(u.size) != j)
        return tuple(problem.names[nth] for nth in free[on])

    std = float(np.sqrt(variances(fit)[j]))
    section = Section(j, fit.u, fit.squares(fit.u), std, 1.0, partial(fit.held, j), value, resting)
    return section.profile(name, level, points)


# -- Intervals: draws by either method, and the sides that the profile leaves open


def intervals(
    problem: UpdatingProblem, x: FloatArray, method: Method, level: float, draws: int, seed: int, threads: int
) -> ParameterIntervals:
    """Intervals around the least-squares solution near ``x``; see ``UpdateResult.intervals``."""
    generator = np.random.default_rng(seed)
    fit = fitted(problem, x)
    notes = [*fit.residuals.assumed, *_doubts(fit, x)]
    if method == "laplace":
        u, which = linear_draws(fit, draws, generator)
    else:
        u, which, accepted = ensemble_draws(fit, draws, generator, threads)
        if accepted < 0.1:
            share = f"{100 * accepted:.0f} %"
            notes.append(f"Hardly a move of the ensemble was accepted ({share}): take more draws.")
    step("sides that the data leave open")
    drawn_x, rest = fit.residuals.vector(u), 1.0 - level
    low, high = np.quantile(drawn_x, [rest / 2.0, 1.0 - rest / 2.0], axis=0)
    words = ["fixed"] * len(problem.names)
    sides = open_sides(fit, level, refit=method == "ensemble")
    for j, (below, above, by_others) in zip(fit.residuals.free, sides, strict=True):
        words[j] = words_of(below, above, by_others)
        # An end that the data close is where it is of two: the open side is known from the bounds alone.
        low[j] = problem.bounds[j, 0] if below else low[j]
        high[j] = problem.bounds[j, 1] if above else high[j]
    if outside := [nth for nth in fit.residuals.free if not low[nth] <= x[nth] <= high[nth]]:
        named = ", ".join(problem.names[nth] for nth in outside[:4])
        notes.append(f"Fitted outside its interval: {named}. Least squares lie elsewhere.")
    middle, model_error = np.median(drawn_x, axis=0), float(np.median(fit.errors.tau[which]))
    columns = low, high, middle, np.std(drawn_x, axis=0), tuple(words), drawn_x
    rests = fit.chi_square, model_error, tuple(notes)
    return ParameterIntervals(tuple(problem.names), method, level, *columns, *rests)


def _doubts(fit: Fit, x: FloatArray) -> list[str]:
    learned, fit = fit.errors.learned, fit.alone or fit
    apart = np.abs(fit.jacobian @ (fit.residuals.place(x) - fit.u))
    odd = fit.residuals.hz[np.abs(fit.e) > _ODD * fit.sigma]
    named = ", ".join(f"{hz:.4g} Hz" for hz in odd[:4])
    notes = {
        "As many parameters as values: nothing is left to tell the model's error by.": not learned,
        "Least squares lead far from the solution of the search: some values contradict the others.": (
            np.any(apart > np.maximum(FAR * fit.sigma, SAME))
        ),
        f"Far from the model even so: {named}. Leave them out if they are wrong.": odd.size,
    }
    return [note for note, holds in notes.items() if holds]
