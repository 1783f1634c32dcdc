"""A measured structure with one storey softened exactly: rank-one change of its measured receptances.

    R' = R - R u u' R / (1 / dk + u' R u),     R = -A / omega**2

where A is the measured matrix of accelerances and u the storey (e_1, or e_i - e_(i - 1)).
Reference: H. N. Ozguven, Mech. Syst. Signal Process. 1 (1987) 53-72.
"""

from __future__ import annotations

import numpy as np

__all__ = ["softened"]


def softened(freq_hz, accelerance, storey, loss_n_per_m):
    """Accelerances (n_freq, n, n) a storey (0 the lowest) softer by ``loss_n_per_m``."""
    omega = 2.0 * np.pi * np.asarray(freq_hz)[:, None, None]
    receptance = -np.asarray(accelerance) / omega**2
    u = np.zeros(receptance.shape[-1])
    u[storey] = 1.0
    if storey:
        u[storey - 1] = -1.0
    if loss_n_per_m == 0.0:
        return np.array(accelerance)
    column, row = receptance @ u, u @ receptance
    scale = -1.0 / loss_n_per_m + np.einsum("i,fi->f", u, column)
    changed = receptance - column[:, :, None] * row[:, None, :] / scale[:, None, None]
    return -changed * omega**2
