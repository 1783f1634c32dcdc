"""Frequency responses and transmissibilities, as immutable values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..exceptions import reject
from ..support.checks import (
    ComplexArray,
    FloatArray,
    choice,
    complex_rows,
    dof_labels,
    finite_scalar,
    frequency_band,
    in_range,
    real_array,
)
from ..support.values import ReadOnly, frozen
from ..views import Viewed
from .recording import Recording
from .spectra import std_of_coherence

ResponseKind = Literal["frf", "transmissibility"]


@dataclass(frozen=True, eq=False, init=False, repr=False)
class FrequencyResponse(ReadOnly, Viewed):
    """Frequency responses, or transmissibilities, of several dofs to one excitation.

    Parameters
    ----------
    freq_hz : array_like, (n_freq,)
        Strictly ascending, not negative.
    values : array_like, (n_outputs, n_freq)
        Complex. A vector is taken as one output.
    dofs : iterable of int or str, optional
        Name of each output. Default ``0, 1, ...``.
    kind : {"frf", "transmissibility"}
        FRFs ``H_pk`` to the one force at k, or transmissibilities ``T_pj = X_p / X_j``.
    reference : int or str, optional
        For a transmissibility the dof j, which must be among ``dofs`` (its row is ones).
    coherence : array_like, (n_outputs, n_freq), optional
        Ordinary coherence of each value, 0 to 1.
    n_averages : float, optional
        Independent averages behind each value, e.g.
        :func:`~antires_rs.signals.spectra.effective_averages` of overlapping segments.
    std : array_like, (n_outputs, n_freq), optional
        Standard deviation of the real part of each value, which is that of the imaginary part and, while it
        is small, of the magnitude. Default: from coherence and ``n_averages``, if both are known.

    Attributes
    ----------
    n_outputs, n_freq : int
        Beside the parameters: as given, arrays read-only, None where not known.

    Raises
    ------
    InvalidInputError
        Wrong shapes, NaN, frequencies that do not ascend, or a reference that does not fit the kind.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> freq = np.linspace(1.0, 10.0, 19)
    >>> ar.FrequencyResponse(freq, [1 / (25 - freq**2 + 1j), 1 / (36 - freq**2 + 1j)], dofs=[3, 7])
    FrequencyResponse(frf, 2 outputs, 19 lines 1-10 Hz, dofs=(3, 7))
    """

    freq_hz: FloatArray
    values: ComplexArray
    dofs: tuple[Any, ...]
    kind: ResponseKind
    reference: Any | None
    coherence: FloatArray | None
    n_averages: float | None
    std: FloatArray | None

    def __init__(
        self,
        freq_hz: Any,
        values: Any,
        dofs: Iterable[Any] | None = None,
        kind: ResponseKind = "frf",
        reference: Any | None = None,
        coherence: Any | None = None,
        n_averages: float | None = None,
        std: Any | None = None,
    ) -> None:
        freq = check_freq("freq_hz", freq_hz)
        wanted = f"a complex array (n_outputs, {freq.size}), one row an output, one column a frequency"
        array = complex_rows("values", values, freq.size, wanted=wanted)
        in_range("values", array)
        labels = dof_labels("dofs", dofs, array.shape[0])
        choice("kind", kind, ("frf", "transmissibility"))
        if kind == "transmissibility":
            if reference not in labels:
                wanted = f"the reference dof j of the transmissibilities, one of {labels}"
                reject("reference", reference, wanted, "Include the row of ones of the reference itself.")
            row = labels.index(reference)
            if np.abs(array[row] - 1.0).max() > 1e-6:
                got = f"a row of the reference {reference!r} that is not one everywhere"
                reject("values", got, f"T_jj = 1 in row {row}", "Divide all rows by the reference's row.")
        elif reference is not None:
            reject("reference", reference, "None for kind='frf'", "Only transmissibilities have a reference.")
        if coherence is not None:
            wanted = f"a real array of the shape of values, {array.shape}, from 0 to 1"
            coherence = _beside("coherence", coherence, array.shape, wanted)
            # Rounding may push an exact coherence a few ulps over one.
            if coherence.min() < 0.0 or coherence.max() > 1.0 + 1e-9:
                remedy = "Coherence lies between 0 and 1; check that it was not exported in per cent."
                reject("coherence", f"values from {coherence.min():g} to {coherence.max():g}", wanted, remedy)
            coherence = frozen(np.minimum(coherence, 1.0))
        if n_averages is not None:
            n_averages = finite_scalar("n_averages", n_averages, low=1.0)
        if std is not None:
            wanted = f"a real array of the shape of values, {array.shape}, not negative"
            std = frozen(_beside("std", std, array.shape, wanted))
            if std.min() < 0.0:
                reject("std", f"values from {std.min():g}", wanted, "Leave std out where it is not known.")
        elif coherence is not None and n_averages is not None and n_averages > 1.0:
            std = frozen(std_of_coherence(array, coherence, n_averages))
        self._fill(
            freq_hz=frozen(freq),
            values=frozen(array),
            dofs=labels,
            kind=kind,
            reference=reference,
            coherence=coherence,
            n_averages=n_averages,
            std=std,
        )

    @property
    def n_outputs(self) -> int:
        """Number of outputs (rows of ``values``)."""
        return int(self.values.shape[0])

    @property
    def n_freq(self) -> int:
        """Number of frequency lines."""
        return int(self.freq_hz.size)

    def to_dataframe(self) -> Any:
        """The complex values, a column for each dof, over ``freq_hz``; needs pandas."""
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """``values``, ``coherence`` and ``std`` over ``dof`` and ``freq_hz``; needs xarray."""
        return self._view("to_xarray")(self)

    def __repr__(self) -> str:
        to = "" if self.reference is None else f", reference={self.reference!r}"
        return (
            f"FrequencyResponse({self.kind}, {self.n_outputs} outputs, {self.n_freq} lines "
            f"{self.freq_hz[0]:g}-{self.freq_hz[-1]:g} Hz, dofs={self.dofs}{to})"
        )


def _beside(name: str, value: Any, shape: tuple[int, ...], wanted: str) -> FloatArray:
    """Real companion of ``values``, of its shape; a vector stands for one output."""
    array = real_array(name, value, ndim=None, wanted=wanted)
    array = array[None, :] if array.ndim == 1 else array
    if array.shape != shape:
        got = f"an array of shape {array.shape}"
        reject(name, got, wanted, "Check its axes: a row for each dof, a column for each line.")
    return array


def check_freq(name: str, value: Any) -> FloatArray:
    """Frequency axis: at least two lines, strictly ascending, not negative."""
    wanted = "a real array (n_freq,) in Hz, at least two lines, strictly ascending, not negative"
    freq = real_array(name, value, ndim=1, wanted=wanted)
    if freq.size < 2:
        reject(name, f"{freq.size} line", wanted, "Keep more of the lines.")
    if freq[0] < 0.0:
        reject(name, f"{freq[0]:g} Hz as the first line", wanted, "Drop the lines below zero.")
    falls = np.flatnonzero(np.diff(freq) <= 0.0)
    if falls.size:
        i = int(falls[0])
        got = f"{freq[i]:g} Hz followed by {freq[i + 1]:g} Hz at index {i}"
        reject(name, got, wanted, "Sort the lines and drop repeated ones.")
    return freq


# -- The band that data cover, and the band that is asked of them


def covered_hz(source: Any) -> tuple[float, float]:
    """Frequencies that a source of either kind can tell of; anything else is refused."""
    if isinstance(source, Recording):
        return 0.0, source.fs_hz / 2
    if isinstance(source, FrequencyResponse):
        return float(source.freq_hz[0]), float(source.freq_hz[-1])
    remedy = "Make one of the arrays first: Recording(responses, fs_hz)."
    reject("source", type(source).__name__, "a Recording or a FrequencyResponse", remedy)


def band_of(source: Any, band_hz: Any) -> tuple[float, float]:
    """A band inside what the source covers."""
    low, high = covered_hz(source)
    return frequency_band("band_hz", band_hz, low_hz=low, high_hz=high)
