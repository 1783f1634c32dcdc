"""Lines of single curves: measured FRFs and transmissibilities, and the responses to one impact.

Nothing was averaged, so the noise comes with the curves (``std``, or coherence and averages) or is taken from
them: what is rough from line to line is noise, or an error of another kind that the fit should not follow
either (a joint that slips, a mode that drifts).
"""

from __future__ import annotations

import numpy as np

from ..signals.directions import ROUNDING, aligned, direction_noise, noise_shares
from ..signals.roughness import local_noise
from ..support.validation import ComplexArray, FloatArray
from .lines import Lines, unit

__all__ = ["curve_lines"]


def curve_lines(
    freq_hz: FloatArray,
    values: ComplexArray,
    force: ComplexArray | None = None,
    *,
    std: FloatArray | None = None,
    runs: ComplexArray | None = None,
    size_known: bool,
    added_decay_per_s: float = 0.0,
) -> Lines:
    """Vectors of equal noise, and what each line is worth.

    Parameters
    ----------
    freq_hz : (n_freq,)
    values : (n_rows, n_freq) complex
        Known at least up to a factor at each line.
    force : (n_freq,) complex, optional
        One more row with the same factors. It is scaled to weigh as much as all responses together at the
        median line.
    std : (n_rows, n_freq), optional
        Standard deviation of the real parts of ``values``, where it is known.
    runs : (R, n_rows, n_freq) complex, optional
        What each of several tests gave, where ``values`` are their average.
    size_known : bool
        Whether the size of ``values`` from line to line is a property of the structure.
    added_decay_per_s : float
        Of an exponential window.
    """
    rows = values if force is None else np.vstack([values, _weighty(force, values)])
    power = np.sum(np.abs(rows) ** 2, axis=0)
    directions = aligned(rows)
    if std is not None:
        row, line = noise_shares(np.maximum(2.0 * std**2 / np.where(power > 0.0, power, 1.0), ROUNDING))
    elif force is None:
        row, line = noise_shares(direction_noise(directions))
    else:
        # Of FRFs the noise is nearly the same at all lines, that of their directions is not.
        row, line = noise_shares(local_noise(values))
        line = np.maximum(line / np.where(power > 0.0, power, 1.0), 1e-300)
    scaled = values / np.sqrt(row)[:, None]
    size = np.linalg.norm(scaled, axis=0)
    # Of all rows but the force, whose noise is not that of a response.
    snr = np.sum(np.abs(directions[: len(values)]) ** 2 / row[:, None], axis=0) / line
    if force is not None:
        scaled = np.vstack([scaled, _weighty(force, scaled)])
        responses, size = size, np.linalg.norm(scaled, axis=0)
        if std is None:
            # What roughness tells is a start, careful by the number of responses; residuals replace it.
            snr = snr / len(values)
        else:
            # Noise that is known counts as it is, over a vector that the force, without noise, makes longer.
            snr = snr * (size / np.where(responses > 0.0, responses, 1.0)) ** 2
    return Lines(
        freq_hz,
        unit(scaled),
        snr,
        added_decay_per_s=added_decay_per_s,
        size=size if size_known else None,
        noise_given=std is not None,
        runs=None if runs is None else _units(runs / np.sqrt(row)[:, None], scaled[len(values) :]),
    )


def _units(runs: ComplexArray, force: ComplexArray) -> ComplexArray:
    """Unit vectors of every test, the force (no row or one) the same in all: (n_freq, n_rows, R)."""
    rows = [unit(np.vstack([run, force])) for run in runs]
    return np.stack(rows, axis=2).transpose(1, 0, 2)


def _weighty(force: ComplexArray, responses: ComplexArray) -> ComplexArray:
    """The force as a row that weighs as much as all responses together at the median line."""
    ratio = np.linalg.norm(responses, axis=0) / np.maximum(np.abs(force), 1e-300)
    return np.asarray(float(np.median(ratio)) * force[None, :])
