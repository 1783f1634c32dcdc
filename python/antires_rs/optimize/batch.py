"""The user's function as the core calls it: all candidates of a generation, or as many as time allows."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..exceptions import ObjectiveError
from ..support.validation import FloatArray, reject
from ..support.workers.door import Failed, Workers

__all__ = ["Batch"]

_RETURN = "Return a float for each candidate: an array (m,) of them with vectorized=True."
#: Candidates go to workers in chunks of about so long: an interrupted chunk is lost.
_CHUNK_S = 0.25


class _Late(Exception):
    """The time is over."""


class Batch:
    """A function of (m, n) candidates made of the user's function, with its workers if it needs some.

    It returns the costs, NaN for those that were not evaluated, and why there are such: ``'interrupted'``,
    ``'time'``, or ``'error'``, which is then in :attr:`error`.
    """

    def __init__(
        self, fun: Callable[..., Any], vectorized: bool, workers: Any, max_seconds: float | None
    ) -> None:
        if not callable(fun):
            reject("fun", fun, "a callable", "Pass the function itself, without calling it.")
        self._fun, self._vectorized = fun, vectorized
        self._end = np.inf if max_seconds is None else time.monotonic() + max_seconds
        self._workers = None if workers is None else Workers(fun, workers, seconds_a_chunk=_CHUNK_S)
        self._seen_finite = False
        #: What the function raised, or what is wrong with its answer.
        self.error: BaseException | None = None

    def __enter__(self) -> Batch:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._workers is not None:
            self._workers.close(at_once=kind is not None)

    def __call__(self, candidates: FloatArray) -> tuple[FloatArray, str | None]:
        """Costs of a generation."""
        if self._vectorized:
            return self._all_at_once(candidates)
        found: dict[int, Any] = {}
        why = self._evaluate(candidates, found)
        costs = np.full(len(candidates), np.nan)
        done = sorted(found)
        try:
            costs[done] = self._numbers([found[nth] for nth in done], len(done), whole=why is None)
        except ObjectiveError as error:
            self.error, why = error, "error"
        return costs, why

    def _evaluate(self, candidates: FloatArray, found: dict[int, Any]) -> str | None:
        """Fill ``found`` by number of the candidate; returns why it is not full."""
        try:
            if self._workers is None:
                for nth, x in enumerate(candidates):
                    try:
                        found[nth] = self._fun(x)
                    except Exception as error:
                        return self._failed(error, x)
                    self._in_time()
            else:
                for nth, value in self._workers.as_done(candidates, poll=self._in_time):
                    if isinstance(value, Failed):
                        return self._failed(value.error, candidates[nth])
                    found[nth] = value
        except KeyboardInterrupt:
            return "interrupted"
        except _Late:
            return "time"
        except Exception as error:  # of the workers
            self.error = error
            return "error"
        return None

    def _failed(self, error: BaseException, x: FloatArray) -> str:
        error.add_note(f"fun was at x = {np.array2string(x, precision=6, threshold=20)}")
        self.error = error
        return "error"

    def _in_time(self) -> None:
        if time.monotonic() > self._end:
            raise _Late

    def _all_at_once(self, candidates: FloatArray) -> tuple[FloatArray, str | None]:
        count = len(candidates)
        try:
            return self._numbers(self._fun(candidates), count, whole=True), None
        except Exception as error:
            self.error = error
            return np.full(count, np.nan), "error"

    def _numbers(self, answer: Any, count: int, whole: bool) -> FloatArray:
        """The answer as costs; one that is not finite is the worst there is."""
        wanted = f"{count} real costs, one for each candidate"
        try:
            costs = np.asarray(answer)
            if np.iscomplexobj(costs):
                raise TypeError("complex costs")
            costs = costs.astype(np.float64)
        except (TypeError, ValueError) as exc:
            raise ObjectiveError(
                "fun", f"{type(answer).__name__} that is not numeric ({exc})", wanted, _RETURN
            ) from exc
        if costs.shape != (count,):
            raise ObjectiveError("fun", f"an array of shape {costs.shape}", wanted, _RETURN)
        # A whole first generation that is not finite is a mistake.
        self._seen_finite = self._seen_finite or bool(np.isfinite(costs).any())
        if whole and not self._seen_finite:
            raise ObjectiveError(
                "fun",
                f"no finite cost for any of {count} candidates",
                wanted,
                "Call the function at a point inside the bounds to see why.",
            )
        return np.where(np.isfinite(costs), costs, np.inf)
