"""Each value with the nearest root: which severities are worth a closer look, in microseconds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..damage.evidence import FURTHEST, HIGHEST
from ..damage.measured_states import Values
from ..support.validation import FloatArray
from .interpolated import Interpolated, Places
from .tables import LEVELS

__all__ = ["Rough", "Scan"]

#: Further from every root than this (ln f) a value counts as unexplained.
_FAR = 0.2
#: Severities of each score of a scan that are looked at.
_BEST = 2
#: Precision of u where nothing sees it; longest step of u.
_BLIND, _LONGEST = 1e-2, 0.7
#: Degrees of freedom of the errors in the search, and the weight of a value that has no root.
_FREEDOM, _LEAST_WEIGHT = 4.0, 0.14
#: Price of such a value, and of the root that it leaves without one.
_LOST = 9.0

#: Sets with one element more, and the severities u where they explain most.
Scan = dict[tuple[int, ...], FloatArray]


@dataclass
class Rough:
    """A test of now against the tables; ``outside`` is the share of a change that counts as its error."""

    tables: Interpolated
    now: Values
    alike: float
    outside: float

    def __post_init__(self) -> None:
        t = self.tables.tables
        self._same = self.now.response[:, None] == t.response
        start = self.tables.start
        errors = t.errors[0, 0, self._near(start)].astype(np.float64)
        self._spread = errors @ errors.T + self.alike**2 + np.diag(self.now.std**2)
        self._variance = np.sum(errors**2, axis=1) + self.alike**2 + self.now.std**2
        self._start = start.place

    def _near(self, at: Places) -> NDArray[np.intp]:
        """The nearest root of each value."""
        apart = np.abs(self.now.log_f[:, None] - np.where(at.there, at.place, np.inf))
        return np.asarray(np.argmin(np.where(self._same, apart, np.inf), axis=1))

    def _seen(self, at: Places) -> tuple[NDArray[np.intp], FloatArray, FloatArray, FloatArray]:
        """Nearest roots, residuals, their variances, and weights that a false value hardly has."""
        near = self._near(at)
        residual = self.now.log_f - at.place[near]
        residual = np.clip(np.nan_to_num(residual, posinf=_FAR, neginf=-_FAR), -_FAR, _FAR)
        moved = np.nan_to_num(at.place[near] - self._start[near], posinf=_FAR, neginf=-_FAR)
        variance = self._variance + (self.outside * np.clip(moved, -_FAR, _FAR)) ** 2
        return near, residual, variance, 1.0 / (1.0 + residual**2 / (_FREEDOM * variance))

    def refined(self, elements: tuple[int, ...], u: FloatArray, steps: int = 2) -> tuple[FloatArray, float]:
        """Most probable severities from a point on, and their log evidence."""
        for _ in range(steps):
            at = self.tables.places(elements, u)
            near, residual, variance, weight = self._seen(at)
            slopes = self.tables.columns(at, near)
            by = (weight / variance)[:, None] * slopes
            precision = by.T @ slopes + _BLIND * np.eye(len(elements))
            step = np.linalg.solve(precision, by.T @ residual - 1.0)
            u = np.clip(u + np.clip(step, -_LONGEST, _LONGEST), 0.0, FURTHEST)
        evidence, precision = self._gaussian(self.tables.places(elements, u))
        size = len(elements)
        volume = 0.5 * (size * np.log(2.0 * np.pi) - np.linalg.slogdet(precision)[1]) - size * np.log(HIGHEST)
        return u, evidence - float(u.sum()) + float(volume)

    def _gaussian(self, at: Places) -> tuple[float, FloatArray]:
        """Log-likelihood of the values that are near a root, their errors correlated, less the price of the
        others; and the precision of the severities."""
        near, residual, variance, weight = self._seen(at)
        kept = np.flatnonzero(weight > _LEAST_WEIGHT)
        covariance = self._spread[np.ix_(kept, kept)]
        covariance[np.diag_indices(kept.size)] += (variance - self._variance)[kept]
        factor = np.linalg.cholesky(covariance)
        white = np.linalg.solve(
            factor, np.column_stack([residual[kept], self.tables.columns(at, near[kept])])
        )
        own, by = white[:, 0], white[:, 1:]
        log_likelihood = -0.5 * float(own @ own) - float(np.log(np.diag(factor)).sum())
        log_likelihood -= 0.5 * kept.size * np.log(2.0 * np.pi) + _LOST * (near.size - kept.size)
        return log_likelihood, by.T @ by + _BLIND * np.eye(by.shape[1])

    def scan(self, elements: tuple[int, ...], u: FloatArray, further: NDArray[np.intp]) -> Scan:
        """Sets with one of ``further`` more that explain most, all its severities tried."""
        t = self.tables.tables
        at = self.tables.places(elements, u)
        moved = np.where(t.old, np.where(at.there, at.place - self._start, np.inf), 0.0).astype(np.float32)
        residual = np.full((self.now.size, further.size, LEVELS.size), _FAR, dtype=np.float32)
        for response, place in self.tables.by_response.items():
            values = np.flatnonzero(self.now.response == response)
            roots = self.tables.of_response[response]
            own = place[:, further] + moved[roots, None, None]
            for value, log_f in zip(values.tolist(), self.now.log_f[values].astype(np.float32), strict=True):
                np.minimum(np.abs(own - log_f).min(axis=0), _FAR, out=residual[value])
        unexplained = residual.sum(axis=0)
        weight = (1.0 / (_FREEDOM * self._seen(at)[2])).astype(np.float32)
        misfit = np.log1p(residual**2 * weight[:, None, None]).sum(axis=0)
        chosen: Scan = {}
        for score in (unexplained, misfit):
            level = np.argmin(score[:, 1:], axis=1) + 1
            least = score[np.arange(further.size), level]
            for nth in np.argsort(least, kind="stable")[:_BEST].tolist():
                joined = sorted(
                    [*zip(elements, u.tolist(), strict=True), (int(further[nth]), LEVELS[level[nth]])]
                )
                key = tuple(e for e, _ in joined)
                chosen.setdefault(key, np.array([x for _, x in joined]))
        return chosen
