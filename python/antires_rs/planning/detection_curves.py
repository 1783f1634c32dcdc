"""Probabilities of detection: curves by element, and the severities that they are read for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..measured.layout import aligned, number
from ..support.pickling import ReadOnly
from ..support.validation import FloatArray

__all__ = ["DetectionCurves"]


@dataclass(frozen=True, eq=False, repr=False)
class DetectionCurves(ReadOnly):
    """What :func:`detectability` found; print it for a table.

    A damage counts as found where its element is among those declared damaged.

    Attributes
    ----------
    method : str
        ``'predicted'`` or ``'simulated'``.
    severity : dict of int to (n,)
        Stiffness losses of each element, ascending.
    pod : dict of int to (n,)
        Probability of detection there, 0 to 1; of simulated tests the fitted curve.
    a50, a90 : dict of int to float
        Loss that is found in 50 and 90 % of the tests; infinity ("never") where the curve does not reach it.
    a90_95 : dict of int to float
        Upper 95 % confidence bound of a90 from the simulated tests (a90/95); empty for predicted ones.
    false_call_rate : float
        Share of intact tests that declare any damage.
    tests : dict of int to (2, m)
        Simulated tests of each element: their losses, and 1 where found, else 0. Empty for predicted ones.
    n_tests : int
        Damaged and intact tests, or structures of a prediction.
    interrupted : bool
        Whether Ctrl-C ended it before all were there.
    names : dict
        What the elements are called.

    Examples
    --------
    >>> import antires_rs as ar
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0, 0.9], [500.0, 450.0, 550.0])
    >>> curves = ar.detectability(model, [1], excitation=0, std=5e-4, n_tests=2, rng=0)
    >>> curves.a50[1] < curves.a90[1] < 0.05
    True
    """

    method: str
    severity: Mapping[int, FloatArray]
    pod: Mapping[int, FloatArray]
    a50: Mapping[int, float]
    a90: Mapping[int, float]
    a90_95: Mapping[int, float]
    false_call_rate: float
    tests: Mapping[int, FloatArray]
    n_tests: int
    interrupted: bool
    names: Mapping[int, str]

    def __repr__(self) -> str:
        return f"DetectionCurves({self.method}, {len(self.pod)} elements, {self.n_tests} tests)"

    def __str__(self) -> str:
        columns = [self.a50, self.a90, *([self.a90_95] if self.a90_95 else [])]
        head = ["stiffness loss (%)", "a50", "a90", *(["a90/95"] if self.a90_95 else [])]
        rows = [[name, *(_percent(column[e]) for column in columns)] for e, name in self.names.items()]
        kind = "structures" if self.method == "predicted" else "tests"
        last = f"false calls: {100.0 * self.false_call_rate:.2g} % of intact tests"
        stopped = ", stopped before the end" if self.interrupted else ""
        return "\n".join(
            [
                f"probability of detection, {self.method} by {self.n_tests} {kind}{stopped}",
                *aligned(head, rows, left=head[:1]),
                last,
            ]
        )

    def plot(self, ax: Any = None) -> Any:
        """The curves; see :func:`antires_rs.plotting.plot_detectability`."""
        from ..plotting import plot_detectability

        return plot_detectability(self, ax=ax)


def _percent(loss: float) -> str:
    return "never" if loss == float("inf") else number(100.0 * loss, 2)
