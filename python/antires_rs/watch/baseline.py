"""What the baseline says of a test: the values expected at its conditions, and how they scatter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import lgamma

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray

# -- Straight lines through values with gaps and wild points: least squares with Huber's weights
#
# Reference: P. J. Huber, Robust Statistics, 1981, chapter 7.

HUBER = 1.345  # residuals beyond so many standard deviations count less, with 95 % efficiency for normal ones
ROUNDS = 12
_MAD = 0.6745  # the median of the absolute values of a standard normal variable
_RIDGE = 1e-9  # ridge relative to the mean diagonal: where the rows do not tell a coefficient, it is 0


@dataclass(frozen=True)
class Regression:
    """Coefficients (q, m) of the columns of a basis, and (X'X)^-1 of its rows, (q, q)."""

    coefficients: FloatArray
    inverse: FloatArray

    def at(self, x: FloatArray) -> FloatArray:
        """Values (n, m) at rows (n, q)."""
        return np.asarray(x @ self.coefficients)


def fitted(y: FloatArray, x: FloatArray) -> Regression:
    """Each column of y (n, m), NaN where there is no value, on the rows of x (n, q)."""
    there = ~np.isnan(y)
    weight = there.astype(np.float64)
    middle = _median(y)  # About its median: logarithms of hertz are of one size, their changes 1e-3 of it.
    filled = np.where(there, y - middle, 0.0)
    size = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-300)
    scaled = x / size
    eye = np.eye(x.shape[1])
    products = (scaled[:, :, None] * scaled[:, None, :]).reshape(len(x), -1)
    for _ in range(ROUNDS):
        gram = (weight.T @ products).reshape(-1, *eye.shape)
        gram += _RIDGE * np.maximum(np.trace(gram, axis1=1, axis2=2), 1e-300)[:, None, None] * eye
        right = (weight * filled).T @ scaled
        coefficients = np.linalg.solve(gram, right[..., None])[..., 0].T
        if x.shape[0] < 4:
            break
        rest = np.abs(np.where(there, filled - scaled @ coefficients, np.nan))
        with np.errstate(invalid="ignore", divide="ignore"):
            wild = rest / (HUBER * np.maximum(_median(rest) / _MAD, 1e-300))
            weight = np.where(there, 1.0 / np.maximum(wild, 1.0), 0.0)
    coefficients = coefficients / size[:, None]
    coefficients[0] += middle  # the first column of every basis is 1
    inverse = np.linalg.inv(scaled.T @ scaled + _RIDGE * len(x) * eye) / np.outer(size, size)
    return Regression(coefficients, inverse)


def _median(values: FloatArray) -> FloatArray:
    """Of each column, 0 where it is empty; sorting puts NaN last, ten times as fast as nanmedian."""
    ranked = np.sort(values, axis=0)
    count = np.sum(~np.isnan(values), axis=0)
    at = np.arange(values.shape[1])
    low, high = np.maximum((count - 1) // 2, 0), np.minimum(count // 2, len(values) - 1)
    return np.asarray(np.where(count > 0, 0.5 * (ranked[low, at] + ranked[high, at]), 0.0))


# -- What the antiresonances depend on: each condition as a straight line, or one with a bend, or not at all
#
# A condition is kept where tests that are left out are predicted better with it, and bends where that
# predicts them better again by more than its standard error. Beyond the baseline's range the line goes on,
# with what is not known of it as a standard deviation.

FOLDS = 20  # parts in which the baseline is left out in turn, at most
BENDS = (0.25, 0.5, 0.75)  # where a line may bend: these shares of the baseline are below
_SIDE = 10  # tests on either side of a bend, at least
_STILL = 1e-9  # a condition that varies less than this share of its own size does not vary


@dataclass(frozen=True)
class Column:
    """One condition: where its line bends (None: nowhere), and its middle, low and high in the baseline."""

    name: str
    bend: float | None
    middle: float
    std: float
    low: float
    high: float

    def of(self, conditions: Mapping[str, FloatArray]) -> FloatArray:
        """The condition (n,) of some tests, at its middle where it is not known."""
        value = conditions[self.name]
        return np.where(np.isnan(value), self.middle, value)

    def away(self, conditions: Mapping[str, FloatArray]) -> FloatArray:
        """How far it is outside the baseline's range, (n,)."""
        value = self.of(conditions)
        return np.maximum(np.maximum(self.low - value, value - self.high), 0.0)


@dataclass(frozen=True)
class Basis:
    """The constant, and one function of each condition that is used, two where its line bends."""

    columns: tuple[Column, ...]

    @property
    def size(self) -> int:
        """Number of functions."""
        return 1 + sum(1 if one.bend is None else 2 for one in self.columns)

    def rows(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """The functions at some tests, (n, size)."""
        made = [np.ones(n)]
        for one in self.columns:
            value = one.of(conditions) - one.middle
            made.append(value / one.std)
            if one.bend is not None:
                made.append(np.maximum(value - (one.bend - one.middle), 0.0) / one.std)
        return np.stack(made, axis=1)

    def slopes(self, coefficients: FloatArray, column: Column, above: bool) -> FloatArray:
        """Change of each value with one condition, (m,), at its high or its low end."""
        place = Basis(self.columns[: self.columns.index(column)]).size
        slope = coefficients[place] / column.std
        if column.bend is not None and above:
            slope = slope + coefficients[place + 1] / column.std
        return np.asarray(slope)


def folds_of(n: int) -> NDArray[np.intp]:
    """Part to which each baseline test belongs, (n,): every k-th test, so that all parts span all times."""
    return np.arange(n) % min(n, FOLDS)


def basis_of(y: FloatArray, conditions: Mapping[str, FloatArray]) -> Basis:
    """The basis that values (n, m) with NaN support at the conditions (n,) of the baseline."""
    basis = Basis(())
    error = _left_out(y, basis, conditions) if conditions else np.empty(0)
    for name, values in conditions.items():
        known = values[~np.isnan(values)]
        if known.size < _SIDE or np.std(known) <= _STILL * max(np.abs(known).max(), 1e-300):
            continue
        line = Column(name, None, *map(float, (known.mean(), known.std(), known.min(), known.max())))
        best = Basis((*basis.columns, line))
        best_error = _left_out(y, best, conditions)
        if np.nanmean(best_error) >= np.nanmean(error):
            continue
        for share in BENDS:
            at = float(np.quantile(known, share))
            if min(np.sum(known < at), np.sum(known > at)) < _SIDE:
                continue
            bent = Basis((*basis.columns, replace(line, bend=at)))
            bent_error = _left_out(y, bent, conditions)
            gain = best_error - bent_error
            if np.nanmean(gain) > 2.0 * np.nanstd(gain) / np.sqrt(np.sum(~np.isnan(gain))):
                best, best_error = bent, bent_error
        basis, error = best, best_error
    return basis


def _left_out(y: FloatArray, basis: Basis, conditions: Mapping[str, FloatArray]) -> FloatArray:
    """Squared errors of tests left out in turn, by test, each value in units of its own spread."""
    x = basis.rows(conditions, len(y))
    folds, rest = folds_of(len(y)), np.full(y.shape, np.nan)
    for fold in range(int(folds.max()) + 1):
        out = folds == fold
        rest[out] = y[out] - fitted(y[~out], x[~out]).at(x[out])
    size = np.nanmedian(np.abs(y - np.nanmedian(y, axis=0)), axis=0)
    # Wild values would decide; they tell nothing of conditions.
    bounded = np.minimum((rest / np.maximum(size, 1e-12)) ** 2, 9.0)
    count = np.sum(~np.isnan(bounded), axis=1)
    return np.asarray(np.where(count > 0, np.nansum(bounded, axis=1) / np.maximum(count, 1), np.nan))


# -- Scatter of single values: their variances, and how heavy the tails are
#
# Residuals over their standard deviation follow Student's t with nu degrees of freedom, one nu for all
# values, so that a wild value counts for as much as it is rare: it is replaced by the normal deviate of its
# probability. Scales are the likeliest under that t.
#
# Reference: K. L. Lange, R. J. A. Little, J. M. G. Taylor, J. Am. Stat. Assoc. 84 (1989) 881-896.

#: Degrees of freedom that are tried, from heavy tails to the normal law.
DEGREES = (2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, np.inf)
STATED = 5.0  # what is told by a stated standard deviation counts as so many tests
ROUNDS_NORMAL = 30
_LARGEST = 30.0


def variances(rest: FloatArray, stated: FloatArray, degrees: float, lost: float) -> FloatArray:
    """Variance of residuals (n, m), ``lost`` parameters fitted; ``stated`` std (m,) count as more tests."""
    count = np.sum(~np.isnan(rest), axis=0)
    free = np.maximum(count - lost, 1.0)
    squares = np.nan_to_num(rest) ** 2
    variance = np.maximum(squares.sum(axis=0) / np.maximum(count, 1), 1e-300)
    for _ in range(ROUNDS_NORMAL if np.isfinite(degrees) else 1):
        weight = 1.0 if np.isinf(degrees) else (degrees + 1.0) / (degrees + squares / variance)
        variance = np.maximum(np.sum(weight * squares, axis=0) / free, 1e-300)
    share = np.where(np.isnan(stated), 0.0, STATED)
    mixed = (free * variance + share * np.nan_to_num(stated) ** 2) / (free + share)
    return np.asarray(np.maximum(mixed, 1e-18))


def degrees_of(rest: FloatArray) -> float:
    """Likeliest degrees of freedom of residuals (n, m), each column with a scale of its own."""
    enough = np.sum(~np.isnan(rest), axis=0) >= 8
    if not enough.any():
        return float("inf")
    rest = rest[:, enough]
    none = np.full(rest.shape[1], np.nan)
    best = (-np.inf, np.inf)
    for degrees in DEGREES:
        scale = np.sqrt(variances(rest, none, degrees, 0.0))
        x = rest / scale
        # The logarithm of the density, less what is the same for all degrees of freedom.
        if np.isinf(degrees):
            law = -0.5 * x**2 - 0.5 * np.log(2.0)
        else:
            half = lgamma((degrees + 1.0) / 2.0) - lgamma(degrees / 2.0) - 0.5 * np.log(degrees)
            law = half - 0.5 * (degrees + 1.0) * np.log1p(x**2 / degrees)
        best = max(best, (float(np.nansum(law - np.log(scale))), degrees))
    return best[1]


def scores(scaled: FloatArray, degrees: float) -> FloatArray:
    """Normal deviates of residuals over their standard deviation."""
    if np.isinf(degrees):
        return np.clip(scaled, -_LARGEST, _LARGEST)
    from scipy.special import ndtri, stdtr

    tail = np.maximum(stdtr(degrees, -np.abs(scaled)), 1e-200)
    return np.asarray(np.clip(-np.sign(scaled) * ndtri(tail), -_LARGEST, _LARGEST))


# -- Correlations of many values from few tests
#
# Factors that all values share (eigenvalues above what noise of this size makes, Marchenko and Pastur) are
# kept as they are; what is left of the correlations is shrunk towards none by
#
# .. math:: \lambda = \sum_{i \ne j} \mathrm{Var}(r_{ij}) / \sum_{i \ne j} r_{ij}^2.
#
# References: V. A. Marchenko, L. A. Pastur, Math. USSR-Sbornik 1 (1967) 457-483; J. Schaefer, K. Strimmer,
# Stat. Appl. Genet. Mol. Biol. 4 (2005) 32.

_ABOVE, _MOST = 1.3, 4  # eigenvalues this much above the edge of noise are factors; at most so many of them
_LEAST = 0.05


def correlations(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Correlation matrix (m, m) of normal scores (n, m) with NaN, and loadings (m, k) of its factors."""
    there = (~np.isnan(z)).astype(float)
    filled = np.nan_to_num(z)
    count = there.T @ there
    sums = filled.T @ filled
    size = np.sqrt(np.maximum(np.diag(sums), 1e-300) / np.maximum(np.diag(count), 1.0))
    r = sums / np.maximum(count, 1.0) / np.outer(size, size)
    # Pairs that are hardly ever seen together tell nothing.
    r = np.where(count >= 4, np.clip(r, -0.98, 0.98), 0.0)
    np.fill_diagonal(r, 1.0)
    m, n = len(r), max(4.0, float(np.median(count)))
    loadings = np.empty((m, 0))
    if m >= 4:
        values, vectors = np.linalg.eigh(r)
        kept = np.flatnonzero(values > _ABOVE * (1.0 + np.sqrt(m / n)) ** 2)[::-1][: min(_MOST, m // 4)]
        # What noise adds to an eigenvalue is taken off it.
        loadings = vectors[:, kept] * np.sqrt(np.maximum(values[kept] - 1.0 - m / n, 0.0))
    common = loadings @ loadings.T
    rest = r - common
    pairs = ~np.eye(m, dtype=bool)
    noise = ((1.0 - r**2) ** 2 / np.maximum(count - 1.0, 1.0))[pairs]
    share = float(np.clip(noise.sum() / max(np.sum(rest[pairs] ** 2), 1e-300), 0.0, 1.0)) if m > 1 else 1.0
    rest = (1.0 - share) * rest
    np.fill_diagonal(rest, np.maximum(1.0 - np.diag(common), _LEAST))
    values, vectors = np.linalg.eigh(0.5 * (rest + rest.T))  # No eigenvalue near or below 0.
    return (vectors * np.maximum(values, _LEAST)) @ vectors.T + common, loadings


# -- What is learned, and what may move values without damage: conditions not known, or out of range

_POOR = 1.5  # a stated deviation above the usual by this factor is that of a poor test: the excess is added
_CURVED = 0.01  # beyond the baseline's range the slope of each value may differ from its line's by this share
_SLOPE = 0.3  # beyond it the slope of all values together is known to so large a share
#: Standard deviation of a condition that is not known, and of a shared factor, in units of the baseline's.
_UNKNOWN, _FACTOR = 2.0, 5.0


@dataclass(frozen=True)
class Learned:
    """The baseline of m values: ``variance`` of the logarithm of each, ``usual`` stated standard deviation.

    ``factors`` (m, k) are in the ``correlation`` of normal scores; ``attenuation``: the share of a slope that
    errors of the condition hide.
    """

    basis: Basis
    regression: Regression
    variance: FloatArray
    usual: FloatArray
    degrees: float
    correlation: FloatArray
    factors: FloatArray
    attenuation: Mapping[str, float]

    def expected(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """Logarithms of the values at the conditions of n tests, (n, m)."""
        return self.regression.at(self.basis.rows(conditions, n))

    def deviation(self, std: FloatArray, conditions: Mapping[str, FloatArray]) -> FloatArray:
        """Standard deviations of tests about that, with what is not known of it, (n, m)."""
        n = len(std)
        excess = np.nan_to_num(np.maximum(std**2 - (_POOR * self.usual) ** 2, 0.0))
        x = self.basis.rows(conditions, n)
        unsure = 1.0 + np.einsum("ij,jk,ik->i", x, self.regression.inverse, x)  # of the line, and of one test
        return np.asarray(np.sqrt(self.variance * unsure[:, None] + excess + self.beyond(conditions, n) ** 2))

    def beyond(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """Standard deviation, (n, m), of what each value does by itself outside the baseline's range."""
        variance = np.zeros((n, self.variance.size))
        for one in self.basis.columns:
            away = one.away(conditions)
            if away.any():
                steepest = np.maximum(*(np.abs(self._slopes(one, above)) for above in (True, False)))
                variance += (_CURVED * away[:, None] * steepest) ** 2
        return np.sqrt(variance)

    def outside(self, conditions: Mapping[str, FloatArray], n: int) -> NDArray[np.bool_]:
        """Tests at a condition that the baseline does not have, (n,)."""
        away = [one.away(conditions) for one in self.basis.columns]
        return np.asarray(np.any([np.zeros(n), *away], axis=0))

    def directions(self, conditions: Mapping[str, FloatArray], test: int, *, free: bool) -> FloatArray:
        """Changes of all values without damage, of one standard deviation each, (m, k), in the logarithm."""
        columns = []
        for one in self.basis.columns:
            value = float(conditions[one.name][test])
            if np.isnan(value):
                columns.append(self._slopes(one, True) * _UNKNOWN * one.std)
            elif (away := max(one.low - value, value - one.high)) > 0.0:
                unsure = _SLOPE * away + self.attenuation[one.name] * abs(value - one.middle)
                columns.append(self._slopes(one, value > one.high) * unsure)
        if free:
            columns += list((_FACTOR * self.factors * np.sqrt(self.variance)[:, None]).T)
        return np.stack(columns, axis=1) if columns else np.empty((self.variance.size, 0))

    def _slopes(self, column: Column, above: bool) -> FloatArray:
        return self.basis.slopes(self.regression.coefficients, column, above)


def learned(
    y: FloatArray, std: FloatArray, conditions: Mapping[str, FloatArray], basis: Basis, degrees: float
) -> Learned:
    """Learn from tests (n, m); ``degrees`` of freedom of the tails as :func:`degrees_of` has it."""
    x = basis.rows(conditions, len(y))
    regression = fitted(y, x)
    rest = y - regression.at(x)
    known = np.any(~np.isnan(std), axis=0)
    usual = np.where(known, np.nanmedian(np.where(known, std, 0.0), axis=0), np.nan)
    variance = variances(rest, usual, degrees, float(basis.size))
    correlation, factors = correlations(scores(rest / np.sqrt(variance), degrees))
    attenuation = {
        one.name: _attenuation(rest, variance, basis.slopes(regression.coefficients, one, True), one.std)
        for one in basis.columns
    }
    return Learned(basis, regression, variance, usual, degrees, correlation, factors, attenuation)


def _attenuation(rest: FloatArray, variance: FloatArray, slope: FloatArray, std: float) -> float:
    """Share of a slope that errors of the condition hide.

    Along the slope residuals vary by (1 - r) / r of the condition's variance, r being its reliability.
    """
    weight = np.where(np.isnan(rest), 0.0, slope / variance)
    power = weight @ slope
    enough = power > 0.0
    if enough.sum() < 3:
        return 0.0
    away = np.sum(weight * np.nan_to_num(rest), axis=1)[enough] / power[enough]
    share = max(0.0, float(np.mean(away**2) - np.mean(1.0 / power[enough]))) / std**2
    return share / (1.0 + share)
