"""What is measured: time records and frequency responses, as immutable values.

Arrays are channels first, ``(n_channels, n_samples)`` and ``(n_outputs, n_freq)``; frequencies are in
Hz. A dof is named by an integer or a string. Both classes copy what they are given and make the copy
read-only, so that no result can change after it was computed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..exceptions import reject
from ..support.checks import FloatArray, dof_labels, finite_scalar, in_range, real_array
from ..support.values import ReadOnly, frozen
from ..views import Viewed


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Recording(ReadOnly, Viewed):
    """Responses recorded together on one clock.

    Parameters
    ----------
    responses : array_like, (n_channels, n_samples)
        One row a channel. Accelerations, velocities or displacements; all of one kind.
    fs_hz : float
        Sampling rate in Hz.
    dofs : iterable of int or str, optional
        Name of each channel's degree of freedom. Default ``0, 1, ...``.
    force : array_like, (n_samples,), optional
        The exciting force, if it was measured. Antiresonances do not need it.

    Attributes
    ----------
    responses, fs_hz, dofs, force
        As given, arrays read-only.
    n_channels, n_samples : int
    duration_s : float

    Raises
    ------
    InvalidInputError
        Wrong shapes, NaN, fewer than two samples, a rate that is not positive, or labels that do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals.recording import Recording
    >>> Recording(np.zeros((2, 1024)) + 1.0, 512.0, dofs=["tip", "root"])
    Recording(2 channels, 2 s at 512 Hz, dofs=('tip', 'root'), no force)
    """

    responses: FloatArray
    fs_hz: float
    dofs: tuple[Any, ...]
    force: FloatArray | None

    def __init__(
        self, responses: Any, fs_hz: float, dofs: Iterable[Any] | None = None, force: Any | None = None
    ) -> None:
        wanted = "a real array (n_channels, n_samples), one row a channel"
        array = real_array("responses", responses, ndim=2, wanted=wanted)
        if array.shape[1] < 2:
            reject(
                "responses",
                f"an array of shape {array.shape}",
                wanted + " with at least two samples",
                "Transpose it if channels are in the columns.",
            )
        if array.shape[0] > array.shape[1]:
            reject(
                "responses",
                f"an array of shape {array.shape}",
                wanted + " with more samples than channels",
                "Transpose it: channels come first.",
            )
        in_range("responses", array)
        put = object.__setattr__  # the one place where a frozen value is filled
        put(self, "responses", frozen(array, responses))
        put(self, "fs_hz", finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz"))
        put(self, "dofs", dof_labels("dofs", dofs, array.shape[0]))
        if force is not None:
            wanted = f"a real array ({array.shape[1]},), one value for each sample of responses"
            force = real_array("force", force, ndim=1, wanted=wanted)
            if force.size != array.shape[1]:
                reject(
                    "force", f"{force.size} samples", wanted, "Cut force and responses to the same samples."
                )
            in_range("force", force)
            force = frozen(force)
        put(self, "force", force)

    @property
    def n_channels(self) -> int:
        """Number of response channels."""
        return int(self.responses.shape[0])

    @property
    def n_samples(self) -> int:
        """Samples per channel."""
        return int(self.responses.shape[1])

    @property
    def duration_s(self) -> float:
        """Length of the record in seconds, ``n_samples / fs_hz``."""
        return self.n_samples / self.fs_hz

    def to_dataframe(self) -> Any:
        """A column for each dof, and ``force``, over ``time_s``.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """``responses`` and ``force`` over ``dof`` and ``time_s``; the rate is an attribute.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        MissingDependencyError
            xarray is not installed.
        """
        return self._view("to_xarray")(self)

    def __repr__(self) -> str:
        force = "no force" if self.force is None else "with force"
        return (
            f"Recording({self.n_channels} channels, {self.duration_s:g} s at {self.fs_hz:g} Hz, "
            f"dofs={self.dofs}, {force})"
        )
