"""What a test could measure: the antiresonances of all candidate sensors for one force, with their slopes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..damage.measured_states import LEAST_STD, roots_at
from ..support.checks import FloatArray, finite_scalar
from ..updating.targets import antiresonance_objective

if TYPE_CHECKING:
    from ..models.parameters import Parameter
    from ..models.structural_model import StructuralModel


# -- How well a test tells an antiresonance: the Cramer-Rao bound for one response under random excitation
#
# With a white force and white noise of the sensor, both over the band B, the spectral lines of a record of
# the length T tell of the logarithms of the zeros of H
#
# .. math:: I_{mn} = 2 T \int_B \frac{\mathrm{Re}(g_m^* g_n)}{\nu^2 \overline{|H|^2}} \, df, \qquad
#           g_m = \frac{\partial H}{\partial \ln f_m}
#               = H \, \frac{2 \omega_m^2 + 2 j \zeta \omega \omega_m}
#                          {\omega_m^2 - \omega^2 + 2 j \zeta \omega \omega_m},
#
# nu being the noise as a fraction of the channel's rms, the bar a mean over the band. The complex gain of H
# is unknown too. The standard deviations are the roots of the diagonal of the inverse (L. Ljung, System
# Identification, 2nd ed. 1999, section 7.4).

#: The band is looked at from this share of its upper end on, with so many lines in a half-power bandwidth.
_LOWEST, _LINES = 1e-3, 4.0
_FEWEST_LINES, _MOST_LINES = 2000, 20_000


@dataclass(frozen=True)
class ExpectedErrors:
    """Noise, length and damping of a test; or the relative standard deviation of every value."""

    noise: float
    duration_s: float
    damping_ratio: float
    std: float | None

    def __post_init__(self) -> None:
        finite_scalar("noise", self.noise, low=0.0, high=10.0)
        finite_scalar("duration_s", self.duration_s, low=0.0, low_open=True, unit="s")
        finite_scalar("damping_ratio", self.damping_ratio, low=1e-4, high=0.5)
        if self.std is not None:
            finite_scalar("std", self.std, low=0.0, high=0.5, low_open=True)

    def __str__(self) -> str:
        if self.std is not None:
            return "std as given"
        return (
            f"the Cramer-Rao bound for {100.0 * self.noise:g} % noise, {self.duration_s:g} s and "
            f"{100.0 * self.damping_ratio:g} % damping; tests repeat less well, say so by std="
        )

    def of(
        self,
        model: StructuralModel,
        sensors: list[int],
        force: int,
        roots_hz: list[FloatArray],
        high_hz: float,
    ) -> list[FloatArray]:
        """Relative standard deviations of the roots of each sensor's response."""
        if self.std is not None:
            return [np.full(own.size, max(self.std, LEAST_STD)) for own in roots_hz]
        count = int(np.clip(-np.log(_LOWEST) * _LINES / self.damping_ratio, _FEWEST_LINES, _MOST_LINES))
        freq = np.geomspace(_LOWEST * high_hz, high_hz, count)
        width = np.gradient(freq)
        found = []
        for sensor, own in zip(sensors, roots_hz, strict=True):
            if not own.size:
                found.append(np.empty(0))
                continue
            curve = model.frf(sensor, force, freq, damping_ratio=self.damping_ratio)
            power = float(width @ np.abs(curve) ** 2) / float(width.sum())
            damping = 2j * self.damping_ratio * freq * own[:, None]
            along = curve * (2.0 * own[:, None] ** 2 + damping) / (own[:, None] ** 2 - freq**2 + damping)
            rows = np.vstack([along, curve, 1j * curve]) * np.sqrt(2.0 * self.duration_s * width / power)
            parts = np.hstack([rows.real, rows.imag])
            # The inverse of parts parts', by its triangle: near roots make it nearly singular.
            size = np.linalg.norm(parts, axis=1)
            triangle = np.linalg.qr((parts / size[:, None]).T, mode="r")
            inverse = np.linalg.pinv(triangle)
            std = self.noise * np.linalg.norm(inverse, axis=1)[: own.size] / size[: own.size]
            found.append(np.maximum(std, LEAST_STD))
        return found


#: Relative distance up to which roots of two responses are one, and from which on transmissibilities show
#: both in full; as in the core (update/objective.rs).
ONE, APART = 1e-6, 1e-3
#: What shows less of a root does not show it; as in ``damage.measured_states``.
SEEN = 0.5
#: A change of 1 % that moves a root by more than 3 % does so for a moment only: two roots are about to merge.
_STEEPEST = 3.0
#: The core looks so far beyond the highest measured value.
_MARGIN = 1.5


@dataclass(frozen=True)
class VirtualRoots:
    """Roots in the band for one force.

    Number of the candidate (n,), d ln f / dp (n, p), relative standard deviation of a value (n,), and of
    roots that some candidates share whether each of them shows it, {root: (c,) of 0 or 1}.
    """

    sensor: NDArray[np.intp]
    slopes: FloatArray
    std: FloatArray
    common: dict[int, FloatArray]


def objective(
    model: StructuralModel,
    parameters: tuple[Parameter, ...],
    sensors: list[int],
    force: int,
    high_hz: float,
    sees: str | None,
) -> _core.Objective:
    """The core's objective of these responses, for its roots up to ``high_hz`` (and none of its values)."""
    parts = [(dof, force, np.array([high_hz / _MARGIN]), sees, 0) for dof in sensors]
    core = model.description.core_parameters(parameters)
    return antiresonance_objective(model, core, parts, "squared", None, 0.0, None)


def virtual_roots(
    model: StructuralModel,
    parameters: tuple[Parameter, ...],
    nominal: FloatArray,
    sensors: list[int],
    force: int,
    band_hz: tuple[float, float],
    sees: str,
    errors: ExpectedErrors,
    threads: int,
) -> VirtualRoots:
    """The roots of every candidate in the band, less those that are about to merge or vanish."""
    shown = "frf" if sees == "frf" else None
    core = objective(model, parameters, sensors, force, band_hz[1], shown)
    found = roots_at(core, nominal[None], slopes=True, threads=threads)[0]
    inside = (found.log_f >= np.log(max(band_hz[0], 1e-300))) & (found.log_f <= np.log(band_hz[1]))
    relative = found.slopes * np.where(nominal == 0.0, 1.0, nominal)
    inside &= np.abs(relative).max(axis=1, initial=0.0) < _STEEPEST
    sensor, log_f = found.response[inside], found.log_f[inside]
    own = [np.exp(log_f[sensor == nth]) for nth in range(len(sensors))]
    std = errors.of(model, sensors, force, own, band_hz[1])
    common = {} if sees == "frf" else _common([np.log(each) for each in own])
    return VirtualRoots(sensor, found.slopes[inside], np.concatenate([np.empty(0), *std]), common)


def _common(log_f: list[FloatArray]) -> dict[int, FloatArray]:
    """Whether each candidate shows the roots that not all others show in full."""
    starts = np.concatenate([[0], np.cumsum([own.size for own in log_f])])
    found: dict[int, FloatArray] = {}
    for nth, own in enumerate(log_f):
        for other, theirs in enumerate(log_f):
            if other == nth or not own.size or not theirs.size:
                continue
            apart = np.abs(own[:, None] - theirs)
            if apart.min() >= APART:
                continue
            # Each root has one counterpart at most.
            partner = _core.align(apart, np.full(own.size, 0.5 * APART), np.full(theirs.size, 0.5 * APART))
            for root in np.flatnonzero(partner >= 0):
                share = (apart[root, partner[root]] - ONE) / (APART - ONE) >= SEEN
                row = found.setdefault(int(starts[nth] + root), np.ones(len(log_f)))
                row[other] = float(share)
    return found
