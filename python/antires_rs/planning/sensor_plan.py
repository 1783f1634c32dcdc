"""A planned test: its sensors and force, and what it would show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..measured.layout import aligned, number
from ..support.pickling import FrozenDict, ReadOnly
from ..support.validation import FloatArray
from .placement import Round

__all__ = ["SensorPlan"]

#: Positions of the force that are printed.
_FORCES = 5


@dataclass(frozen=True, eq=False, repr=False)
class SensorPlan(ReadOnly):
    """What :func:`plan_test` found; print it for a table.

    Attributes
    ----------
    sensors : tuple of int
        Dofs of the model, in the order of their rounds.
    excitation : int
        Dof of the force.
    criterion : str
        ``'determinant'`` or ``'worst'``.
    value : float
        Of the criterion: information in nats that the test is expected to give; or the largest of
        ``detectable`` (of parameters, of ``std`` over the spread before the test).
    value_of_all : float
        The same, with a sensor on every candidate.
    n_values : int
        Antiresonances in the band that the test would show.
    detectable : dict of int to float
        Stiffness loss of each element that nine of ten tests would show, in [0, 0.99], infinity where none
        would: the linear estimate for small losses. Empty for parameters.
    detectable_by_all : dict of int to float
        The same, with a sensor on every candidate.
    std : dict of str to float
        Standard deviation of each unknown after the test, in its unit, the others unknown too.
    std_before : dict of str to float
        The same before it: uniform within its bounds.
    excitations : dict of int to float
        ``value`` by position of the force, the best first, each with its own best sensors.
    rounds : tuple of Round
        How the sensors were found, from the first one on.
    names, labels : dict
        What elements and dofs are called.
    value_std : dict of int to (n,)
        Relative standard deviation of each antiresonance of each sensor on which all this rests.
    errors : str
        Where these come from: given, or the Cramer-Rao bound for noise, duration and damping.

    Examples
    --------
    >>> import antires_rs as ar
    >>> plan = ar.plan_test(ar.cases.chain8().model, n_sensors=3, excitations=0, std=5e-4)
    >>> plan.sensors, plan.excitation, plan.n_values
    ((0, 3, 1), 0, 17)
    """

    sensors: tuple[int, ...]
    excitation: int
    criterion: str
    value: float
    value_of_all: float
    n_values: int
    detectable: Mapping[int, float]
    detectable_by_all: Mapping[int, float]
    std: Mapping[str, float]
    std_before: Mapping[str, float]
    excitations: Mapping[int, float]
    rounds: tuple[Round, ...]
    band_hz: tuple[float, float]
    names: Mapping[int, str]
    labels: Mapping[int, str]
    value_std: Mapping[int, FloatArray] = field(default_factory=FrozenDict)
    errors: str = ""

    def __repr__(self) -> str:
        return f"SensorPlan(sensors={self.sensors}, excitation={self.excitation}, {self._value(self.value)})"

    def __str__(self) -> str:
        low, high = self.band_hz
        lines = [
            f"{len(self.sensors)} sensors: " + ", ".join(self.labels[dof] for dof in self.sensors),
            f"force at {self.labels[self.excitation]}",
            f"{self.n_values} antiresonances from {low:g} to {high:g} Hz; {self._value(self.value)}"
            f" (a sensor on every candidate: {self._value(self.value_of_all)})",
        ]
        if self.errors:
            lines.append(f"values known to {self._known()}: {self.errors}")
        if len(self.excitations) > 1:
            best = list(self.excitations.items())[:_FORCES]
            lines.append(
                "forces: " + ", ".join(f"{self.labels[dof]} {self._value(value)}" for dof, value in best)
            )
        if self.detectable:
            rows = [
                [self.names[e], _percent(self.detectable[e]), _percent(self.detectable_by_all[e])]
                for e in self.detectable
            ]
            head = ["stiffness loss seen in 9 of 10 tests (%)", "these sensors", "all candidates"]
            lines += ["", *aligned(head, rows, left=head[:1])]
        else:
            rows = [[name, f"{std:.3g}"] for name, std in self.std.items()]
            lines += ["", *aligned(["parameter", "std"], rows, left=["parameter"])]
        return "\n".join(lines)

    def _known(self) -> str:
        """The least and the largest error of a value."""
        std = np.concatenate([np.empty(0), *self.value_std.values()])
        ends = [f"{100.0 * end:.2g}" for end in (std.min(initial=np.inf), std.max(initial=0.0))]
        return " to ".join(dict.fromkeys(ends)) + " %"

    def _value(self, value: float) -> str:
        if self.criterion == "determinant":
            return f"{value:.1f} nats"
        return f"worst {100.0 * value:.2g} %" if value != float("inf") else "worst: never"

    def plot(self, ax: Any = None) -> Any:
        """Smallest detectable losses by element; see :func:`antires_rs.plotting.plot_plan`."""
        from ..plotting import plot_plan

        return plot_plan(self, ax=ax)


def _percent(loss: float) -> str:
    return "never" if loss == float("inf") else number(100.0 * loss, 2)
