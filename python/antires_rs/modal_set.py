"""Resonances and mode shapes, measured or computed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ._validation import dof_labels, real_array, reject

__all__ = ["ModalSet"]


class ModalSet:
    """Resonant frequencies with their mode shapes.

    Parameters
    ----------
    freq_hz : array_like, (n_modes,)
        Resonant frequencies in Hz, ascending.
    shapes : array_like, (n_modes, n_dofs)
        One mode a row, real or complex.
    dofs : iterable of int or str, optional
        Name of each column.
    damping_ratio : array_like, (n_modes,), optional
        Modal damping ratios.

    Raises
    ------
    InvalidInputError
        Shapes and frequencies that do not fit, or frequencies not ascending.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.ModalSet([1.0, 2.0], [[1.0, 1.0], [1.0, -1.0]])
    ModalSet(2 modes x 2 dofs, 1 to 2 Hz)
    """

    def __init__(self, freq_hz: Any, shapes: Any, dofs: Iterable[Any] | None = None,
                 damping_ratio: Any = None) -> None:
        self.freq_hz = real_array("freq_hz", freq_hz, ndim=1, wanted="an array (n_modes,) in Hz")
        if np.any(np.diff(self.freq_hz) < 0):
            reject("freq_hz", "frequencies out of order", "ascending frequencies")
        self.shapes = np.asarray(shapes)
        if self.shapes.ndim != 2 or self.shapes.shape[0] != self.freq_hz.size:
            reject("shapes", f"an array of shape {self.shapes.shape}",
                   f"({self.freq_hz.size}, n_dofs), one mode a row")
        if not np.all(np.isfinite(self.shapes)):
            reject("shapes", "NaN or infinite values", "finite shapes")
        self.dofs = dof_labels("dofs", dofs, self.shapes.shape[1])
        self.damping_ratio = None if damping_ratio is None else real_array(
            "damping_ratio", damping_ratio, ndim=1, wanted="an array (n_modes,)")
        if self.damping_ratio is not None and self.damping_ratio.shape != self.freq_hz.shape:
            reject("damping_ratio", f"{self.damping_ratio.size} values", f"{self.freq_hz.size}, one a mode")

    def __len__(self) -> int:
        return int(self.freq_hz.size)

    def __repr__(self) -> str:
        low, high = self.freq_hz[0], self.freq_hz[-1]
        return f"ModalSet({len(self)} modes x {len(self.dofs)} dofs, {low:.4g} to {high:.4g} Hz)"
