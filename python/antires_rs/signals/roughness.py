"""What is rough from line to line is noise: second differences of curves that are smooth without it."""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray

__all__ = ["local_noise", "roughness", "second_differences", "typical_noise"]

# Lines over which the noise of measured curves is taken to be constant.
NOISE_LINES = 31
# With fewer lines nothing tells noise from curve.
LEAST_LINES = 12
# No curve is taken to have less noise than this share of its power.
LEAST_NOISE = 1e-12
# Second differences of white noise over the noise itself, in power.
GAIN = 6.0
# The median of abs()**2 of complex Gaussian noise over its mean.
MEDIAN = np.log(2.0)


def second_differences(values: ComplexArray) -> FloatArray:
    """Squared second differences along the last axis: ``GAIN`` times the power of white noise."""
    return np.abs(values[..., 2:] - 2.0 * values[..., 1:-1] + values[..., :-2]) ** 2


def typical_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve (n_outputs, n_freq) at its median line, (n_outputs,)."""
    noise = np.median(second_differences(values), axis=1) / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE * np.mean(np.abs(values) ** 2, axis=1)))


def local_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve around every line, (n_outputs, n_freq).

    At a sharp resonance the curve itself bends within a line; there the noise comes out too high, which only
    keeps the few lines of the peak from ruling the fit.
    """
    from scipy.ndimage import median_filter  # slow to import

    power = np.mean(np.abs(values) ** 2, axis=1)[:, None]
    if values.shape[1] < LEAST_LINES:
        return np.repeat(power, values.shape[1], axis=1)
    second = second_differences(values)
    second = np.concatenate([second[:, :1], second, second[:, -1:]], axis=1)
    noise = median_filter(second, size=(1, NOISE_LINES), mode="nearest") / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE * power))


def roughness(curve: ComplexArray) -> float:
    """Noise over power of one curve, by medians: the few lines of a sharp resonance are rough too."""
    power = float(np.median(np.abs(curve) ** 2))
    return float(np.median(second_differences(curve))) / GAIN / power if power > 0.0 else 0.0
