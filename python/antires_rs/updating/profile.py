"""Profile likelihood: how the fit falls when one parameter is held and all others are fitted again.

A parameter is open on the side where the sum of squares over the errors' variances, with it held at that
bound and the others fitted within theirs, rises by less than the chi-square quantile (Raue et al.,
Bioinformatics 25 (2009) 1923-1929). A side may be closed only because another parameter runs into a bound of
its own; that is said.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..exceptions import reject
from ..support.checks import FloatArray, finite_scalar, integer
from ..support.progress import one_blas_thread, patient, step
from ..support.values import Value
from .residuals import UNSEEN, Fit, fitted, least_squares

if TYPE_CHECKING:
    from .problem import UpdatingProblem

Kind = Literal["two-sided", "one-sided", "flat", "fixed"]

#: A combination that is seen this little, relative to the best seen, has no covariance of its own.
_RIDGE = 1e-12


def threshold(level: float) -> float:
    """Rise of the sum of squares at the ends of an interval: chi-square with one degree of freedom."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + level / 2.0) ** 2)


def covariance(fit: Fit) -> FloatArray:
    """Covariance of the free parameters as if nothing bounded them, (n, n); huge where nothing is seen."""
    weighted = fit.jacobian / fit.sigma[:, None]
    precision = weighted.T @ weighted
    values, vectors = np.linalg.eigh(precision)
    least = _RIDGE * max(float(values.max(initial=0.0)), 1.0)
    return np.asarray((vectors / np.maximum(values, least)) @ vectors.T)


def open_sides(fit: Fit, level: float, refit: bool) -> list[tuple[bool, bool, bool]]:
    """For every free parameter: open below, open above, and closed only by the bounds of others.

    By the linear residuals, or with ``refit`` by those of the model.
    """
    limit, spread = threshold(level), np.diag(covariance(fit))
    least = squares(fit, fit.u)
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
    weighted = fit.jacobian / fit.sigma[:, None]
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
    return squares(fit, least_squares(fit.residuals, u, fit.sigma, held=[j]))


def squares(fit: Fit, u: FloatArray) -> float:
    """Sum of squares over the errors' variances at u."""
    return float(np.sum((fit.residuals.at(u) / fit.sigma) ** 2))


#: This near to a bound, as a share of the bounds' distance, a parameter is on it.
_ON_BOUND = 1e-6
#: Standard deviations within which most points of a profile lie.
_REACH = 4.0
#: Points that are added on each side, until those around the end differ by this share of the limit's root.
_REFINED, _NEAR = 8, 0.25


@dataclass(frozen=True, eq=False)
class ProfileLikelihood(Value):
    """Likelihood of one parameter, all others fitted again at every value.

    Attributes
    ----------
    name : str
    values : ndarray, (k,)
        Values at which the parameter was held, rising, in its unit.
    rise : ndarray, (k,)
        Rise of the sum of squares over the errors' variances above its least, at least 0.
    threshold : float
        Rise up to which a value is within the interval.
    level : float
    low, high : float
        Interval; a bound where the profile does not close on that side.
    kind : {'two-sided', 'one-sided', 'flat'}
    others_on_bound : tuple of tuple of str, (k,)
        Other parameters that rest on a bound at each value.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.update(ar.cases.chain8().damage_problem(), rng=0)
    >>> held = found.profile(found.problem.names[4], points=5)
    >>> held.kind, bool(held.low < 0.55 < held.high)
    ('two-sided', True)
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
        lines += [
            f"{value:12.6g} {rise:12.4g}{'  ' + ', '.join(names) + ' on a bound' if names else ''}"
            for value, rise, names in zip(self.values, self.rise, self.others_on_bound, strict=True)
        ]
        return "\n".join(lines)


@patient("profile")
@one_blas_thread
def profile(
    problem: UpdatingProblem,
    x: FloatArray,
    name: str,
    *,
    level: float = 0.9,
    points: int = 21,
    progress: bool | None = None,
) -> ProfileLikelihood:
    """Profile around the least-squares solution near ``x``; see ``UpdateResult.profile``."""
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("points", points, low=5, high=1001)
    if name not in problem.names:
        reject("name", repr(name), "a parameter of the problem", f"One of {', '.join(problem.names)}.")
    fit = fitted(problem, x)
    where = np.flatnonzero(fit.residuals.free == problem.names.index(name))
    if where.size == 0:
        remedy = "Its bounds are equal, or it was decided to be 0."
        reject("name", repr(name), "a parameter that may move", remedy)
    j, center = int(where[0]), float(fit.u[where[0]])
    std = np.sqrt(covariance(fit)[j, j])
    found: dict[float, tuple[float, FloatArray]] = {center: (squares(fit, fit.u), fit.u)}
    for bound, count in ((0.0, points // 2), (1.0, points - points // 2)):
        u = fit.u
        for place in _places(center, bound, std, count):
            u = u.copy()
            u[j] = place
            step(f"{name} held at {_value(fit, j, u):.5g}")
            u = least_squares(fit.residuals, u, fit.sigma, held=[j])
            found[float(place)] = (squares(fit, u), u)
    limit = threshold(level)
    (low, low_open), (high, high_open) = (_end(fit, found, j, side, limit) for side in (-1.0, 1.0))
    places = sorted(found)
    rise = np.array([found[place][0] for place in places])
    return ProfileLikelihood(
        name=name,
        values=np.array([_value(fit, j, found[place][1]) for place in places]),
        rise=rise - rise.min(),
        threshold=limit,
        level=level,
        low=_value(fit, j, np.where(np.arange(fit.u.size) == j, low, fit.u)),
        high=_value(fit, j, np.where(np.arange(fit.u.size) == j, high, fit.u)),
        kind=kind_of(low_open, high_open),
        others_on_bound=tuple(_on_bound(fit, found[place][1], j) for place in places),
    )


def _value(fit: Fit, j: int, u: FloatArray) -> float:
    """Free parameter j at u, in its unit."""
    return float(fit.residuals.vector(u)[fit.residuals.free[j]])


def _places(center: float, bound: float, std: float, count: int) -> FloatArray:
    """Values away from the center: most within a few standard deviations, then the bound."""
    reach = min(_REACH * std, abs(bound - center))
    if reach < 1e-9:
        return np.empty(0)
    near = center + np.sign(bound - center) * reach * np.arange(1, count + 1) / count
    return near if abs(near[-1] - bound) < 1e-9 else np.append(near, bound)


def _end(
    fit: Fit, found: dict[float, tuple[float, FloatArray]], j: int, side: float, limit: float
) -> tuple[float, bool]:
    """Where the rise passes the limit on one side, and whether it never does.

    Points are added to ``found`` until one of the two around the passage is near it.
    """
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
        u = found[places[k - 1]][1].copy()
        # A rise that begins late is no parabola: not too near to the side that is known to be within.
        u[j] = places[k - 1] + max(share, 0.3) * (places[k] - places[k - 1])
        u = least_squares(fit.residuals, u, fit.sigma, held=[j])
        found[float(u[j])] = (squares(fit, u), u)
    return end, False


def _on_bound(fit: Fit, u: FloatArray, held: int) -> tuple[str, ...]:
    names = np.array(fit.residuals.problem.names)[fit.residuals.free]
    on = (u <= _ON_BOUND) | (u >= 1.0 - _ON_BOUND)
    on &= np.linalg.norm(fit.jacobian, axis=0) > UNSEEN  # where an unseen parameter rests means nothing
    on[held] = False
    return tuple(names[on].tolist())
