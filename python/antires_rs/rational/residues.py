r"""Shapes from curves whose poles are known: least squares in the frequency domain (LSFD).

    Y_o(f) = sum_r [ A_ro / (s - s_r) + conj(A_ro) / (s - conj(s_r)) ] + sum_m C_om s^m,      s = 2 pi i f

The powers m = -2 ... 2 with real coefficients stand for what lies outside the band (lower and upper
residuals) and for the quantity measured: s^2 / (s - s_r) of an accelerance is s + s_r plus the fraction of a
receptance times s_r^2, so the shape is the same for receptance, mobility and accelerance, up to one factor
for each mode.

Reference: W. Heylen, S. Lammens, P. Sas, Modal Analysis Theory and Testing, KU Leuven, 1997 (LSFD).
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray

__all__ = ["dominant_shapes", "residues"]

RESIDUAL_POWERS = (-2, -1, 0, 1, 2)


def residues(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, poles: ComplexArray
) -> ComplexArray:
    """Residues A of every pole in every curve.

    Parameters
    ----------
    freq_hz : (n_freq,)
    values : (n_outputs, n_freq) complex
    weights : (n_freq,)
        Of squared residuals.
    poles : (n_poles,) complex
        rad/s, one of each pair.

    Returns
    -------
    (n_poles, n_outputs) complex

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.rational.residues import residues
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> s, pole = 2j * np.pi * f, -1.0 + 60.0j
    >>> y = (2 - 1j) / (s - pole) + (2 + 1j) / (s - pole.conjugate()) + 3.0 - 0.2 * s
    >>> residues(f, y[None], np.ones(200), np.array([pole])).round(9).tolist()
    [[(2-1j)]]
    """
    s = 2j * np.pi * freq_hz
    top = np.abs(s).max()
    near, far = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    columns = np.concatenate(
        [near + far, 1j * (near - far), np.stack([(s / top) ** m for m in RESIDUAL_POWERS], axis=1)], axis=1
    )
    root_w = np.sqrt(weights / weights.max())[:, None]
    columns, right = columns * root_w, values.T * root_w
    # Columns of very different size (far residuals, light damping) would spoil the rank decision.
    size = np.linalg.norm(columns, axis=0)
    stacked = np.concatenate([(columns / size).real, (columns / size).imag])
    solution = np.linalg.lstsq(stacked, np.concatenate([right.real, right.imag]), rcond=None)[0]
    solution /= size[:, None]
    n = poles.size
    return np.asarray(solution[:n] + 1j * solution[n : 2 * n], dtype=np.complex128)


def dominant_shapes(residue: ComplexArray) -> ComplexArray:
    """Shapes (n_modes, n_dofs) from residues (n_modes, n_references, n_dofs), of unit norm.

    The residues of one mode to several references have rank one; with one reference they are the shape.
    """
    if not residue.size:
        return np.empty((residue.shape[0], residue.shape[2]), dtype=np.complex128)
    return np.asarray(np.linalg.svd(residue, full_matrices=False)[2][:, 0], dtype=np.complex128)
