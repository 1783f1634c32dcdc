"""How much of a rational curve one of its poles owns."""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .forsythe import Basis


def dominance(
    above: tuple[Basis, FloatArray], below: tuple[Basis, FloatArray], s: ComplexArray
) -> FloatArray:
    """Norm of residues / abs(Re s), over the norm of above/below at i Im s.

    ``above`` holds the coefficients of one or more numerators, (n_outputs, order + 1), ``below`` those of the
    denominator, (order + 1,); ``s`` are roots of the latter in units of 2 pi f_max.
    """
    order, n = below[1].size - 1, s.size
    step = 1e-6 * np.abs(s)  # central difference: error 1e-12 of a derivative that needs two digits
    points = np.concatenate([s + step, s - step, s, 1j * s.imag])
    denominator = below[0].at(points, order) @ below[1]
    numerator = np.linalg.norm(above[0].at(points[2 * n :], order) @ above[1].T, axis=1)
    slope = np.abs(denominator[:n] - denominator[n : 2 * n]) / (2 * step)
    residue = numerator[:n] / np.maximum(slope, 1e-300)
    curve = numerator[n:] / np.maximum(np.abs(denominator[3 * n :]), 1e-300)
    return share_of_curve(residue, s.real, curve)


def share_of_curve(residue: FloatArray, distance: FloatArray, curve: FloatArray) -> FloatArray:
    """Peak of a pole at its ``distance`` from the lines, over the curve there."""
    return np.asarray(residue / np.maximum(np.abs(distance) * curve, 1e-300))
