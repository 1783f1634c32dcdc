"""The likeliest numerators of one window.

The channels are brought to equal noise, and to the few directions that hold their signal: numerators of order
m span at most m + 1 of them, however many channels there are. Where nothing tells the noise, the residual
of a first fit does, by channel and by line; a second fit is weighted by it, so that lines and channels at
which the structure is not what the fit can be (a joint that slips, tests at which a mode had moved) lose
their say. Noise that came with the curves keeps its weights, and errors are never less than it makes them.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...signals.directions import ROUNDING, aligned, noise_shares
from ...support.validation import ComplexArray, FloatArray
from ..likelihood import Likeliest, likeliest
from ..lines import SNR_CAP, Lines, unit
from ..uncertainty import Influence

#: Highest order of a window, and lines that each order needs.
HIGHEST_ORDER, LINES_PER_ORDER = 16, 5
#: Directions kept of the channels: those in which there is more signal than noise, within these numbers.
LEAST_DIRECTIONS, MOST_DIRECTIONS = 3, 14
#: Iterations of weights and order in each of the fits, the second with the noise from the first's residual.
ITERATIONS = (3, 3)
#: Lines over which a residual is averaged, and the least share of its median that one may have.
RESIDUAL_LINES, LEAST_RESIDUAL = 15, 0.05


class LocalFit:
    """Numerators of all rows of ``lines`` at the likeliest order and its neighbours."""

    def __init__(self, lines: Lines, max_order: int) -> None:
        self.freq_hz = lines.freq_hz
        most = max(2, min(max_order, HIGHEST_ORDER, lines.freq_hz.size // LINES_PER_ORDER))
        self._highest = most
        directions = aligned(lines.vectors)
        row, line = np.ones(len(directions)), 1.0 / lines.snr
        #: Standard deviation of the rows of the directions, (n_rows, n_freq).
        self.noise = np.sqrt(row[:, None] * line)
        if lines.segments is not None:
            self._more = 1.0
            self._fit(lines, row, most, sum(ITERATIONS))
            return
        start = None
        self._more = 1.0
        for iterations in ITERATIONS:
            if start is not None:
                given = self.noise
                row, line = self._residual_noise(directions)
                self.noise = np.sqrt(row[:, None] * line)
                if lines.noise_given:
                    # The residual of a fit that follows the noise is less than the noise that is known.
                    self._more = max(1.0, float(np.median(given / self.noise)))
                    row, line = np.ones(len(directions)), 1.0 / lines.snr
            scaled = directions / np.sqrt(row)[:, None]
            power = np.sum(np.abs(scaled) ** 2, axis=0)
            weighed = Lines(self.freq_hz, unit(scaled), power / line, runs=_rescaled(lines.runs, row))
            self._fit(weighed, row, most, iterations, start)
            start = (
                self.best.order,
                np.sum(np.abs(self.best.fit.values(self.best.coefficients)) ** 2, axis=1),
            )

    def _fit(
        self,
        lines: Lines,
        row_noise: FloatArray,
        max_order: int,
        iterations: int,
        start: tuple[int, FloatArray] | None = None,
    ) -> None:
        """Fit lines of equal noise; ``row_noise`` is what their rows were divided by, in power."""
        v = lines.vectors
        power, held = np.linalg.eigh(np.real((v * lines.snr) @ v.conj().T))
        # Noise alone has the power of one in each direction and line.
        signal = int(np.sum(power > 2.0 * lines.freq_hz.size))
        held = held[:, -min(max(signal, LEAST_DIRECTIONS), MOST_DIRECTIONS) :]
        self._mix = np.sqrt(row_noise)[:, None] * held
        self._lines = lines.projected(held)
        self.best: Likeliest = likeliest(
            self.freq_hz,
            self._lines.covariance,
            SNR_CAP,
            lines.independent,
            max_order,
            iterations=iterations,
            start=start,
        )

    def _residual_noise(self, directions: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Noise power of rows and lines that the residual tells."""
        from scipy.ndimage import uniform_filter1d  # slow to import

        fitted = self.numerators(self.best.order)
        size = np.maximum(np.sum(np.abs(fitted) ** 2, axis=0), 1e-300)
        along = np.sum(fitted.conj() * directions, axis=0) / size
        left = np.abs(directions - fitted * along) ** 2
        row, line = noise_shares(uniform_filter1d(left, RESIDUAL_LINES, axis=1, mode="nearest"))
        line = np.maximum(line, LEAST_RESIDUAL * float(np.median(line)))
        return row, np.maximum(line, ROUNDING)

    def orders(self, around: tuple[int, ...], lowest: int) -> list[int]:
        """Orders this far from the likeliest one, those that there are."""
        some = {min(max(self.best.order + k, lowest), self._highest) for k in around} | {self.best.order}
        return sorted(some)

    def coefficients(self, order: int) -> FloatArray:
        """Coefficients of all rows, (order + 1, n_rows)."""
        return np.asarray(self._own(order) @ self._mix.T)

    def numerators(self, order: int) -> ComplexArray:
        """All rows at the lines, (n_rows, n_freq)."""
        return np.asarray(self._mix @ self.best.fit.values(self._own(order)).T)

    def zeros(self, order: int) -> list[ComplexArray]:
        """Roots of every row in rad/s."""
        c = self.coefficients(order)
        return [self.best.fit.zeros(own) for own in c.T]

    def standard_deviations(self, row: int, s: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Of zeros of the likeliest order in Hz: by noise, and by the scatter between tests (0 for one)."""
        within, between = self._influence.variances(self._mix[row], s)
        # Where there are several tests, the noise is what they differ by.
        more = self._more if self._lines.runs is None else 1.0
        return more * np.sqrt(within), np.sqrt(between)

    def _own(self, order: int) -> FloatArray:
        """Coefficients of the directions that are held."""
        return self.best.coefficients if order == self.best.order else self.best.fit.likeliest(order)[0]

    @cached_property
    def _influence(self) -> Influence:
        lines = self._lines.by_test()
        return Influence(self.best.fit, self.best.coefficients, self.best.misfit, lines)


def _rescaled(runs: ComplexArray | None, row_noise: FloatArray) -> ComplexArray | None:
    """Unit vectors of every test with their rows brought to equal noise."""
    if runs is None:
        return None
    scaled = runs / np.sqrt(row_noise)[:, None]
    return np.asarray(scaled / np.maximum(np.linalg.norm(scaled, axis=1, keepdims=True), 1e-300))
