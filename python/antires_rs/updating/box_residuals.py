"""Residuals over the unit box of the free parameters, with what is known of their errors."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .error_rows import error_rows, errors

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["BoxResiduals"]

#: Step of the central differences, relative to the range of a parameter; see ``identifiability``.
_STEP = 1e-5
#: Candidates that a thread evaluates at a time.
_PIECE = 64


class BoxResiduals:
    """Residuals as a function of u in the unit box.

    Where the lower bound is above 0, u runs with the logarithm of the parameter: antiresonances hang on
    ratios of stiffness to mass, and a common scale of all is then a straight line along which nothing
    changes.

    Attributes
    ----------
    free : ndarray of int, (n,)
        Parameters that u holds: not those with equal bounds, nor damage that was decided to be exactly 0.
    tilt : ndarray, (n,)
        Slope of the logarithm of the prior's density in u, which is uniform in the parameters themselves.
    stated : ndarray, (m,), or None
        Standard deviations that the measurement states; the median of the others where one does not.
    size : ndarray, (m,)
        Relative size of the error that is not stated.
    kind : ndarray of int, (m,)
        0 for frequencies, 1 for entries of shapes.
    assumed : tuple of str
        What was assumed, in sentences.
    """

    def __init__(self, problem: UpdatingProblem, x: FloatArray) -> None:
        self.problem, self.x = problem, x
        low, high = problem.bounds.T
        self.free = np.flatnonzero((high > low) & ~_resting(problem, x))
        self.low, self.high = low[self.free], high[self.free]
        self.log = self.low > 0.0
        self.tilt = np.zeros(self.free.size)
        self.tilt[self.log] = np.log(self.high[self.log] / self.low[self.log])
        value, kind, std = error_rows(problem._targets)
        weights = np.ones(len(problem.measured_hz)) if problem.weights is None else problem.weights
        paired = np.isfinite(problem._core.pairs(x)[0])
        self.kept = (paired & (weights > 0.0))[value]
        self.kind, std, weights = kind[self.kept], std[self.kept], weights[value][self.kept]
        known, noun = np.isfinite(std), f"{problem.noun}s"
        self.stated: FloatArray | None = None
        self.size = np.ones(std.size)
        assumed = []
        alone = len(paired) - int(paired.sum())
        if alone:
            assumed.append(f"{alone} measured {noun} without a partner in the model are left out.")
        if not known.any():
            self.size = 1.0 / weights
            assumed.append(
                f"No errors of the measured {noun} are stated: theirs are learned from the residuals."
            )
        else:
            self.stated = np.where(known, std, np.median(std[known]))
            if not known.all():
                assumed.append("Values without a standard deviation are given the median of the others.")
        self.assumed = tuple(assumed)

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
        return np.asarray(errors(problem._targets, problem._core, self.vector(u))[self.kept])

    def many(self, u: FloatArray, workers: int) -> FloatArray:
        """Residuals at every row, (k, m): the same bits for any number of workers."""
        pieces = [u[first : first + _PIECE] for first in range(0, len(u), _PIECE)]

        def rows(piece: FloatArray) -> FloatArray:
            return np.stack([self.at(row) for row in piece])

        if workers == 1 or len(pieces) == 1:
            return np.concatenate([rows(piece) for piece in pieces])
        pool = ThreadPoolExecutor(workers)
        try:
            return np.concatenate(list(pool.map(rows, pieces)))
        finally:  # after Ctrl-C what has not begun is not begun
            pool.shutdown(wait=False, cancel_futures=True)

    def jacobian(self, u: FloatArray) -> FloatArray:
        """Change of the residuals over the bounds' distances, (m, n), by central differences."""
        steps = _STEP * np.eye(u.size)
        columns = [(self.at(u + h) - self.at(u - h)) / (2.0 * _STEP) for h in steps]
        return np.stack(columns, axis=1) if columns else np.empty((self.size.size, 0))


def _resting(problem: UpdatingProblem, x: FloatArray) -> NDArray[np.bool_]:
    """Damage at exactly 0: with penalties it is decided, not estimated."""
    reductions = np.array([p.quantity == "stiffness_reduction" for p in problem.parameters])
    return np.asarray(reductions & (x == 0.0) & (problem.penalty is not None))
