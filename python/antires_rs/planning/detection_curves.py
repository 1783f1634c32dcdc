"""Probabilities of detection: curves by element, and the severities that they are read for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..damage.inference import HIGHEST
from ..measured.antiresonance_set import aligned, number
from ..support.checks import BoolArray, FloatArray
from ..support.values import ReadOnly
from ..views import Viewed


@dataclass(frozen=True, eq=False, repr=False)
class DetectionCurves(ReadOnly, Viewed):
    """What :func:`detectability` found; print it for a table.

    A damage counts as found where its element is among those declared damaged.

    Attributes
    ----------
    method : {'predicted', 'simulated'}
    severity, pod : dict of int to (n,)
        Stiffness losses of each element, ascending, and the probability of detection there, 0 to 1; of
        simulated tests the fitted curve.
    a50, a90, a90_95 : dict of int to float
        Loss that is found in 50 and 90 % of the tests; infinity ("never") where the curve does not reach it;
        and the upper 95 % confidence bound of a90 from simulated tests (a90/95), empty for predicted ones.
    false_call_rate : float
        Share of intact tests that declare any damage.
    tests : dict of int to (2, m)
        Simulated tests of each element: their losses, and 1 where found, else 0. Empty for predicted ones.
    n_tests, interrupted : int and bool
        Damaged and intact tests, or structures of a prediction; and whether Ctrl-C ended it before all.
    names : dict
        What the elements are called.

    Examples
    --------
    >>> import antires_rs as ar
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0, 0.9], [500.0, 450.0, 550.0])
    >>> ar.detectability(model, [1], excitation=0, std=5e-4, n_tests=2, rng=0).a90[1] < 0.05
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
        rows = [[name, *(percent(column[e]) for column in columns)] for e, name in self.names.items()]
        kind = "structures" if self.method == "predicted" else "tests"
        stopped = ", stopped before the end" if self.interrupted else ""
        title = f"probability of detection, {self.method} by {self.n_tests} {kind}{stopped}"
        last = f"false calls: {100.0 * self.false_call_rate:.2g} % of intact tests"
        return "\n".join([title, *aligned(head, rows, left=head[:1]), last])

    def plot(self, ax: Any = None) -> Any:
        """The curves; see :func:`antires_rs.figures.plot_detectability`."""
        return self._view("plot")(self, ax=ax)


def percent(loss: float) -> str:
    """A loss in print; infinity is a damage that no test shows."""
    return "never" if loss == float("inf") else number(100.0 * loss, 2)


# -- Probability of detection against severity: ln(POD / (1 - POD)) = ln 9 + b (ln a - ln a90)
#
# Fitted to found and missed by the largest likelihood. a90/95 is the largest a90 that the likelihood-ratio
# test does not reject at 95 %, one-sided; infinity where the data do not rule out that 90 % are not reached
# at all. Reference: MIL-HDBK-1823A, Nondestructive evaluation system reliability assessment, 2009, appendix
# G.

#: Logit of 0.9, half the 90 % quantile of chi-square with one degree of freedom, and the grid.
_LN9, _DROP = float(np.log(9.0)), 1.3528
_SLOPES, _STEPS = np.geomspace(0.3, 60.0, 80), 1500


class Logit(NamedTuple):
    """A fitted curve: a90, its slope b, and a90/95."""

    a90: float
    slope: float
    bound: float

    def at(self, severity: FloatArray) -> FloatArray:
        """POD."""
        return np.asarray(1.0 / (1.0 + np.exp(-_LN9 - self.slope * (np.log(severity) - np.log(self.a90)))))

    @property
    def a50(self) -> float:
        """Severity found in half of the tests."""
        return float(self.a90 * np.exp(-_LN9 / self.slope))


def fit_logit(severity: FloatArray, found: BoolArray, most: float = HIGHEST) -> Logit:
    """The curve of tests (n,) with these severities, found or not; none is larger than ``most``."""
    log_a, sign = np.log(severity), np.where(found, 1.0, -1.0)
    # Beyond the largest severity a90 is only a way to say that the curve stays below.
    at = np.linspace(log_a.min() - 1.0, np.log(most) + 4.0, _STEPS)
    margin = sign * (log_a - at[:, None])
    table = np.stack([-np.logaddexp(0.0, -sign * _LN9 - b * margin).sum(axis=1) for b in _SLOPES], axis=1)
    profile = table.max(axis=1)
    # A gap between found and missed leaves a range of equally likely a90: its middle.
    top = np.flatnonzero(profile >= profile.max() - 1e-6)
    best, last = int(top[top.size // 2]), int(np.flatnonzero(profile >= profile.max() - _DROP)[-1])
    bound = reached(float(np.exp(at[last])), most) if last < at.size - 1 else np.inf
    return Logit(float(np.exp(at[best])), float(_SLOPES[int(table[best].argmax())]), bound)


def reached(a: float, most: float = HIGHEST) -> float:
    """Infinity for what lies beyond every severity."""
    return a if a <= most else np.inf


def rising(share: FloatArray) -> FloatArray:
    """The nearest curve that nowhere falls (least squares): detection does not become less with damage."""
    from scipy.optimize import isotonic_regression

    return np.asarray(isotonic_regression(share).x)


def crossing(severity: FloatArray, share: FloatArray, level: float) -> float:
    """Severity from which on a rising curve is at the level or above; infinity where it ends below."""
    reached_at = np.flatnonzero(share >= level)
    if not reached_at.size:
        return np.inf
    first = int(reached_at[0])
    if first == 0:
        return float(severity[0])
    (low, high), (a, b) = share[first - 1 : first + 1], np.log(severity[first - 1 : first + 1])
    return float(np.exp(a + (b - a) * (level - low) / (high - low)))
