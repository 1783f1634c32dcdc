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
    denominator, (order + 1,), or both for each root, with its number in front; ``s`` are roots of the latter
    in units of 2 pi f_max.
    """
    order = below[1].shape[-1] - 1
    step = 1e-6 * np.abs(s)  # central difference: error 1e-12 of a derivative that needs two digits
    points = np.stack([s + step, s - step, s, 1j * s.imag], axis=1)
    phi = below[0].at(points.ravel(), order).reshape(*points.shape, order + 1)
    denominator = (phi @ below[1][..., None])[..., 0]
    if above[0] is not below[0]:
        phi = above[0].at(points.ravel(), order).reshape(phi.shape)
    numerator = np.linalg.norm(phi[:, 2:] @ above[1].swapaxes(-1, -2), axis=2)
    slope = np.abs(denominator[:, 0] - denominator[:, 1]) / (2 * step)
    residue = numerator[:, 0] / np.maximum(slope, 1e-300)
    curve = numerator[:, 1] / np.maximum(np.abs(denominator[:, 3]), 1e-300)
    return share_of_curve(residue, s.real, curve)


def share_of_curve(residue: FloatArray, distance: FloatArray, curve: FloatArray) -> FloatArray:
    """Peak of a pole at its ``distance`` from the lines, over the curve there."""
    return np.asarray(residue / np.maximum(np.abs(distance) * curve, 1e-300))
