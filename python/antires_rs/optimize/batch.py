"""The user's function as the core calls it: all candidates of a generation at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..exceptions import ObjectiveError
from ..support.validation import FloatArray, integer, reject
from ..support.workers.counts import MOST_WORKERS

__all__ = ["Batch"]

_RETURN = "Return a float for each candidate: an array (m,) of them with vectorized=True."


class Batch:
    """A function of (m, n) candidates made of the user's function, with its pool if it needs one."""

    def __init__(self, fun: Callable[..., Any], vectorized: bool, workers: Any) -> None:
        if not callable(fun):
            reject("fun", fun, "a callable", "Pass the function itself, without calling it.")
        self.fun, self.vectorized, self.pool = fun, vectorized, None
        self.seen_finite = False
        self.map: Callable[..., Any] = map
        if callable(workers):
            self.map = workers
        elif workers is not None and integer("workers", workers, low=1, high=MOST_WORKERS) > 1:
            import multiprocessing

            self.pool = multiprocessing.get_context("spawn").Pool(workers)
            self.map = self.pool.map

    def __enter__(self) -> Callable[[FloatArray], FloatArray]:
        return self._evaluate

    def __exit__(self, *exc: object) -> None:
        if self.pool is not None:
            self.pool.terminate()

    def _evaluate(self, candidates: FloatArray) -> FloatArray:
        answer = self.fun(candidates) if self.vectorized else list(self.map(self.fun, candidates))
        wanted = f"{len(candidates)} real costs, one for each candidate"
        try:
            costs = np.asarray(answer)
            if np.iscomplexobj(costs):
                raise TypeError("complex costs")
            costs = costs.astype(np.float64)
        except (TypeError, ValueError) as exc:
            raise ObjectiveError(
                "fun", f"{type(answer).__name__} that is not numeric ({exc})", wanted, _RETURN
            ) from exc
        if costs.shape != (len(candidates),):
            raise ObjectiveError("fun", f"an array of shape {costs.shape}", wanted, _RETURN)
        # A cost that is not finite is the worst there is; a whole first generation of them is a mistake.
        self.seen_finite = self.seen_finite or bool(np.isfinite(costs).any())
        if not self.seen_finite:
            raise ObjectiveError(
                "fun",
                f"no finite cost for any of {len(candidates)} candidates",
                wanted,
                "Call the function at a point inside the bounds to see why.",
            )
        return costs
