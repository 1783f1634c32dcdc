"""Measured frequencies beside those of a model, before and after updating."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..support.checks import FloatArray
from ..support.values import Value


def signed(percent: float) -> str:
    """A difference with its sign; what rounds to nothing has none; a dash where there is no partner."""
    if np.isnan(percent):
        return "-"
    said = f"{percent:+.2f}"
    return said[1:] if said in ("+0.00", "-0.00") else said


class _Differences:
    """What both tables say about their frequencies."""

    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray

    @property
    def before_percent(self) -> FloatArray:
        """Difference of the nominal model, ``100 (f_A / f_E - 1)``, (m,)."""
        return 100.0 * (self.before_hz / self.measured_hz - 1.0)

    @property
    def after_percent(self) -> FloatArray:
        """Difference of the updated model, ``100 (f_A / f_E - 1)``, (m,)."""
        return 100.0 * (self.after_hz / self.measured_hz - 1.0)

    @property
    def largest_before_percent(self) -> float:
        """Largest absolute difference before; NaN if nothing has a partner."""
        return _largest(self.before_percent)

    @property
    def largest_after_percent(self) -> float:
        """Largest absolute difference after; NaN if nothing has a partner."""
        return _largest(self.after_percent)

    @property
    def _closing(self) -> str:
        """The largest differences, without numbers where nothing has a partner."""
        if not self.measured_hz.size:
            return "nothing was measured"
        both = {"before": self.largest_before_percent, "after": self.largest_after_percent}
        if np.isnan(list(both.values())).all():
            return "largest difference: none, no value has a partner in the model"
        return "largest difference: " + ", ".join(
            f"no partner {when}" if np.isnan(each) else f"{each:.2f} % {when}" for when, each in both.items()
        )

    def _text(self, head: list[str], labels: Sequence[str], *mac: FloatArray) -> str:
        """The table in print; ``mac`` are columns of both states, where there are some."""
        states = ((self.before_hz, self.before_percent), (self.after_hz, self.after_percent))
        lines = [*head]
        for row, label in enumerate(labels):
            line = f"{label} {self.measured_hz[row]:10.3f}"
            for state, (hz, percent) in enumerate(states):
                line += f"  {_number(hz[row]):>10} {signed(percent[row]):>7}"
                line += f" {_number(mac[state][row]):>6}" if mac else ""
            lines.append(line)
        return "\n".join([*lines, self._closing])


@dataclass(frozen=True, eq=False)
class FrequencyTable(_Differences, Value):
    """Measured antiresonances beside those of the model, before and after.

    Attributes
    ----------
    dof, excitation : ndarray of int, (m,)
        Response and force, zero-based.
    measured_hz, before_hz, after_hz : ndarray, (m,)
        Frequencies; NaN where the model has no partner.
    dof_names : dict of int to str
        Names of the dofs, for models that have some ("mass 3", "node 3 v"), shown in print.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> table = ar.FrequencyTable(np.array([0, 1]), np.array([0, 0]), np.array([10.0, 20.0]),
    ...                           np.array([10.4, 19.0]), np.array([10.1, 20.0]))
    >>> table.before_percent.round(2), round(table.largest_after_percent, 2)
    (array([ 4., -5.]), 1.0)
    """

    dof: FloatArray
    excitation: FloatArray
    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray
    dof_names: dict[int, str] = field(default_factory=dict)

    def __str__(self) -> str:
        pairs = [
            ", ".join(self.dof_names.get(dof, f"{dof:2d}") for dof in pair)
            for pair in zip(self.dof.tolist(), self.excitation.tolist(), strict=True)
        ]
        width = max([7, *map(len, pairs)])
        head = [
            f"{'H_ik':>{width}}   measured      before             after",
            f"{'(i, k)':>{width}}         Hz          Hz       %          Hz       %",
        ]
        return self._text(head, [f"{pair:>{width}}" for pair in pairs])


@dataclass(frozen=True, eq=False)
class ModalTable(_Differences, Value):
    """Measured resonances and shapes beside those of the model, before and after.

    Attributes
    ----------
    mode : ndarray of int, (m,)
        Number of the mode among those measured together, from 0.
    measured_hz, before_hz, after_hz : ndarray, (m,)
        Resonances; NaN where the model has no partner.
    before_mac, after_mac : ndarray, (m,)
        MAC of the measured shape with the partner's; NaN where there is none.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0], [500.0], ground_first_n_per_m=300.0)
    >>> measured = ar.ModalSet([1.6, 6.0], [[0.8, 1.0], [1.0, -0.7]])
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0], bounds=(0.8, 1.4)), measured)
    >>> print(ar.update(problem, rng=0).table)
    mode   measured      before                      after
                 Hz          Hz       %    MAC          Hz       %    MAC
       0      1.600       1.801  +12.53  0.999       1.831  +14.41  1.000
       1      6.000       5.449   -9.19  0.999       6.000    0.00  0.997
    largest difference: 12.53 % before, 14.41 % after
    """

    mode: FloatArray
    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray
    before_mac: FloatArray
    after_mac: FloatArray

    def __str__(self) -> str:
        head = [
            "mode   measured      before                      after",
            "             Hz          Hz       %    MAC          Hz       %    MAC",
        ]
        return self._text(head, [f"{mode:4d}" for mode in self.mode], self.before_mac, self.after_mac)


def _number(value: float) -> str:
    """A number, or a dash where the model has no partner."""
    return "-" if np.isnan(value) else f"{value:.3f}"


def _largest(percent: FloatArray) -> float:
    found = np.abs(percent[~np.isnan(percent)])
    return float(found.max()) if found.size else float("nan")
