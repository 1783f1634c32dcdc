"""Residuals over the unit box of the free parameters, what is known of their errors, and the best fit."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..support.checks import BoolArray, FloatArray, IntArray
from ..support.progress import step
from .problem import UpdatingProblem
from .targets import MODEL_ERROR

STEP_OF_SLOPES = 1e-5  # of the range: the residuals carry rounding of 1e-13, so this leaves 1e-8 of error


class BoxResiduals:
    """Residuals (m,) as a function of u (n,) in the unit box."""

    def __init__(self, problem: UpdatingProblem, x: FloatArray) -> None:
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
        paired = np.isfinite(problem._core.pairs(x)[0])
        self.kept = (paired & (weights > 0.0))[value]
        self.hz = problem.measured_hz[value][self.kept]  # measured frequency that each residual belongs to
        #: 0 for frequencies, 1 for entries of shapes.
        self.kind, std, weights = kind[self.kept], std[self.kept], weights[value][self.kept]
        known, noun = np.isfinite(std), f"{problem.noun}s"
        stated, alone = bool(known.any()), len(paired) - int(paired.sum())
        #: Standard deviations that the measurement states, and relative size of the error that it does not.
        self.stated = np.where(known, std, np.median(std[known])) if stated else None
        self.size = np.ones(std.size) if stated else 1.0 / weights
        assumed = {
            f"{alone} measured {noun} without a partner in the model are left out.": alone,
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
        """Residuals at one point, (m,)."""
        problem = self.problem
        return np.asarray(problem._targets.errors(problem._core, self.vector(u))[self.kept])

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

FLOOR = 1e-5  # no test and no model agrees better than this in omega squared: no interval has the width 0
_MOST, _STEP_ERROR_MODEL = 0.3, 0.05  # largest error of the model, in omega squared, and the step of ln(tau)
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
    def around(cls, stated: FloatArray | None, size: FloatArray, guess: float, spare: int) -> ErrorModel:
        """Grid around the error that the residuals suggest; the parameters leave ``spare`` of them over."""
        s = np.zeros(size.size) if stated is None else np.maximum(stated, FLOOR)
        if spare <= 0:  # as many parameters as values: nothing is left to learn from
            tau = np.array([0.0 if stated is not None else MODEL_ERROR])
            return cls(tau, np.zeros(1), s**2 + (tau[:, None] * size) ** 2, False)
        usual = FLOOR if stated is None else float(np.median(s))
        low = min(max(FLOOR, _LEAST * usual), 0.1 * _MOST)
        first = min(max(low, guess / _BELOW), 0.5 * _MOST)
        last = min(_MOST, max(guess, usual, 2.0 * first) * _ABOVE * _TAIL ** (1.0 / spare))
        tau = np.exp(np.arange(np.log(first), np.log(last), _STEP_ERROR_MODEL))
        log_prior = np.full(tau.size, np.log(_STEP_ERROR_MODEL / np.log(_MOST / low)))
        if stated is not None:
            tau = np.append(0.0, tau)
            log_prior = np.append(0.0, log_prior)  # half and half: the factor cancels
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
_DAMPED = 1e-6  # share of the steepest column that a step costs: what no value sees stays where it is


@dataclass(frozen=True, eq=False)
class Fit:
    """Solution u (n,), residuals e (m,) and Jacobian (m, n) there, and the errors that they suggest."""

    residuals: BoxResiduals
    u: FloatArray
    e: FloatArray
    jacobian: FloatArray
    rank: int
    errors: ErrorModel
    chances: FloatArray  # probabilities of the errors of the model on the grid, (G,)

    @property
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

    @property
    def chi_square(self) -> float:
        """Reduced chi-square by the stated errors; NaN where none are stated or nothing is left over."""
        stated, spare = self.residuals.stated, self.e.size - self.rank
        if stated is None or spare <= 0:
            return float("nan")
        return float(np.sum((self.e / np.maximum(stated, FLOOR)) ** 2) / spare)


def fitted(problem: UpdatingProblem, x: FloatArray) -> Fit:
    """Least squares within the bounds from ``x``, with the errors that its residuals suggest."""
    residuals = BoxResiduals(problem, x)
    u = residuals.place(x)
    stated, size = residuals.stated, residuals.size
    sigma = size * max(_rms(residuals.at(u) / size), FLOOR) if stated is None else np.maximum(stated, FLOOR)
    for _ in range(_ROUNDS):
        step("least squares")
        before, u = residuals.at(u), least_squares(residuals, u, sigma)
        if np.any(np.abs(residuals.at(u) - before) > np.maximum(FAR * sigma, SAME)):  # it has led far
            starts = (residuals.place(problem.nominal), np.full(u.size, 0.5))
            found = [u, *(least_squares(residuals, start, sigma) for start in starts)]
            u = min(found, key=lambda u: float(np.sum((residuals.at(u) / sigma) ** 2)))
        e, jacobian = residuals.at(u), residuals.jacobian(u)
        rank = int(np.count_nonzero(np.linalg.svd(jacobian, compute_uv=False) > UNSEEN)) if u.size else 0
        size = residuals.size
        shape = residuals.kind == 1
        if stated is None and shape.any():  # errors of shapes have a unit of their own
            ratio = max(_rms((e / size)[shape]), FLOOR) / max(_rms((e / size)[~shape]), FLOOR)
            size = size * np.where(shape, ratio, 1.0)
        guess = _rms(e / size) * np.sqrt(e.size / max(e.size - rank, 1))
        errors = ErrorModel.around(stated, size, float(guess), e.size - rank)
        fit = Fit(residuals, u, e, jacobian, rank, errors, errors.marginal(e, jacobian))
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
