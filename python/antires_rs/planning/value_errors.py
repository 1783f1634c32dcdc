r"""How well a test tells an antiresonance: the Cramer-Rao bound for one response under random excitation.

With a white force and white noise of the sensor, both over the band B, the spectral lines of a record of the
length T tell of the logarithms of the zeros of H

.. math:: I_{mn} = 2 T \int_B \frac{\mathrm{Re}(g_m^* g_n)}{\nu^2 \overline{|H|^2}} \, df, \qquad
          g_m = \frac{\partial H}{\partial \ln f_m}
              = H \, \frac{2 \omega_m^2 + 2 j \zeta \omega \omega_m}
                         {\omega_m^2 - \omega^2 + 2 j \zeta \omega \omega_m},

nu being the noise as a fraction of the channel's rms, the bar a mean over the band. The complex gain of H is
unknown too. The standard deviations are the roots of the diagonal of the inverse. No estimate without bias is
better; what identification reaches of it is told in the guide.

Reference: L. Ljung, System Identification, 2nd ed. 1999, section 7.4 (the bound in the frequency domain).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..damage.measured_states import LEAST_STD
from ..support.validation import FloatArray, finite_scalar

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["ExpectedErrors"]

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
