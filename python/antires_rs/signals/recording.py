"""Time records, alone or several of one test, as immutable values.

Arrays are channels first, ``(n_channels, n_samples)``. A dof is named by an integer or a string. What is
given is copied, and the copy read-only, so that no result can change after it was computed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exceptions import reject
from ..support.checks import FloatArray, dof_labels, finite_scalar, in_range, real_array
from ..support.messages import warn
from ..support.values import ReadOnly, frozen
from ..views import Viewed

_YEAR_S = 365.0 * 86400.0


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
    time_s : array_like, (n_samples,), optional
        Instant of each sample in s, ascending, on a clock that other records share: what :func:`align` joins
        sensors by. A record with gaps in it is refused by all else.

    Attributes
    ----------
    n_channels, n_samples : int
        Beside the parameters, which are as given, arrays read-only.
    duration_s : float

    Raises
    ------
    InvalidInputError
        Wrong shapes, NaN, fewer than two samples, a rate that is not positive, or labels that do not fit.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> ar.Recording(np.zeros((2, 1024)) + 1.0, 512.0, dofs=["tip", "root"])
    Recording(2 channels, 2 s at 512 Hz, dofs=('tip', 'root'), no force)
    """

    responses: FloatArray
    fs_hz: float
    dofs: tuple[Any, ...]
    force: FloatArray | None
    time_s: FloatArray | None = None  # also of those that an older version pickled

    def __init__(
        self,
        responses: Any,
        fs_hz: float,
        dofs: Iterable[Any] | None = None,
        force: Any | None = None,
        time_s: Any | None = None,
    ) -> None:
        wanted = "a real array (n_channels, n_samples), one row a channel"
        array = real_array("responses", responses, ndim=2, wanted=wanted)
        got = f"an array of shape {array.shape}"
        if array.shape[1] < 2:
            remedy = "Transpose it if channels are in the columns."
            reject("responses", got, f"{wanted} with at least two samples", remedy)
        if array.shape[0] > array.shape[1]:
            remedy = "Transpose it: channels come first."
            reject("responses", got, f"{wanted} with more samples than channels", remedy)
        in_range("responses", array)
        rate = finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
        years = array.shape[1] / rate / _YEAR_S
        if rate < 1.0 and years > 1.0:
            said = f"fs_hz: at {rate:.4g} Hz the record lasts {years:.2g} years."
            warn("slow_record", f"{said} If that is the time step in s, the rate is {1.0 / rate:.6g} Hz.")
        labels = dof_labels("dofs", dofs, array.shape[0])
        if force is not None:
            wanted = f"a real array ({array.shape[1]},), one value for each sample of responses"
            force = real_array("force", force, ndim=1, wanted=wanted)
            if force.size != array.shape[1]:
                remedy = "Cut force and responses to the same samples."
                reject("force", f"{force.size} samples", wanted, remedy)
            in_range("force", force)
            force = frozen(force)
        if time_s is not None:
            time_s = frozen(_instants(time_s, array.shape[1]), time_s)
        self._fill(responses=frozen(array, responses), fs_hz=rate, dofs=labels, force=force, time_s=time_s)

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
        """A column for each dof, and ``force``, over ``time_s``; needs pandas."""
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """``responses`` and ``force`` over ``dof`` and ``time_s``, the rate an attribute; needs xarray."""
        return self._view("to_xarray")(self)

    def __repr__(self) -> str:
        force = "no force" if self.force is None else "with force"
        return (
            f"Recording({self.n_channels} channels, {self.duration_s:g} s at {self.fs_hz:g} Hz, "
            f"dofs={self.dofs}, {force})"
        )


def _instants(time_s: Any, n_samples: int) -> FloatArray:
    """The instants of a record, checked."""
    wanted = f"a real array ({n_samples},) that ascends, one instant in s for each sample"
    instants = real_array("time_s", time_s, ndim=1, wanted=wanted)
    if instants.size != n_samples:
        remedy = "Leave it out, or cut both to the same samples."
        reject("time_s", f"{instants.size} instants", wanted, remedy)
    falls = np.flatnonzero(np.diff(instants) <= 0.0)
    if falls.size:
        at = int(falls[0])
        got = f"{instants[at]:.9g} s followed by {instants[at + 1]:.9g} s"
        reject("time_s", got, wanted, "Add the range of the counter where it began again at zero.")
    return instants


# -- Several records of one test as one: what is averaged together, and never across a joint


class PooledRecording(Recording):
    """Records of one test end to end, with their limits; every average is taken inside ``parts``."""

    parts: tuple[Recording, ...]  #: In the order given, all with the dofs of the first in its order.

    def __init__(self, parts: Sequence[Recording]) -> None:
        forces = [part.force for part in parts if part.force is not None]
        force = np.concatenate(forces) if len(forces) == len(parts) else None
        responses = np.concatenate([part.responses for part in parts], axis=1)
        super().__init__(responses, parts[0].fs_hz, parts[0].dofs, force)
        object.__setattr__(self, "parts", tuple(parts))

    def __repr__(self) -> str:
        return f"{len(self.parts)} x {self.parts[0]!r}"


def parts_of(rec: Recording) -> tuple[Recording, ...]:
    """The records that a pool holds; a record alone is its own only part."""
    return rec.parts if isinstance(rec, PooledRecording) else (rec,)


def shortest(rec: Recording) -> int:
    """Samples of the shortest part, in which every segment must fit."""
    return min(part.n_samples for part in parts_of(rec))


def without_force(rec: Recording) -> Recording:
    """The same record as if the force had not been measured."""
    if rec.force is None:
        return rec
    bare = [Recording(part.responses, part.fs_hz, part.dofs, None, part.time_s) for part in parts_of(rec)]
    return PooledRecording(bare) if len(bare) > 1 else bare[0]


def check_recording(rec: object) -> None:
    """Refuse what is not a Recording, or one whose samples are not even, which only ``align`` can use."""
    if not isinstance(rec, Recording):
        got = type(rec).__name__
        reject("rec", got, "a Recording", "Make one of the arrays first: Recording(responses, fs_hz).")
    for part in parts_of(rec):
        steps = np.diff(part.time_s) if part.time_s is not None else ()
        odd = np.flatnonzero(np.abs(np.asarray(steps) * part.fs_hz - 1.0) > 0.5)
        if odd.size:
            got = f"a record with {odd.size} gaps in its time, the first at {part.time_s[odd[0]]:.9g} s"  # type: ignore[index]
            reject("rec", got, "evenly sampled responses", "Resample it: ar.align([record]).")


def force_of(rec: Recording) -> FloatArray:
    """The measured force, which this estimate needs."""
    if rec.force is None:
        got = "a Recording without force"
        reject("rec", got, "one with the force recorded", "Use transmissibilities: they need no force.")
    return rec.force


def rows_of(rec: Recording, include_force: bool) -> list[FloatArray]:
    """The responses, and after them the force where it is wanted."""
    return [*rec.responses, force_of(rec)] if include_force else [*rec.responses]
