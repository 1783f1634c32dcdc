"""Several records of one test as one: what is averaged together, and never across a joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..exceptions import Argument
from ..support.validation import reject
from .recording import Recording

__all__ = ["PooledRecording", "parts_of", "pooled", "shortest", "without_force"]


class PooledRecording(Recording):
    """Records of one test end to end, with their limits; every average is taken inside ``parts``.

    Attributes
    ----------
    parts : tuple of Recording
        In the order given, all with the dofs of the first in its order.
    """

    parts: tuple[Recording, ...]

    def __init__(self, parts: Sequence[Recording]) -> None:
        forces = [part.force for part in parts if part.force is not None]
        super().__init__(
            np.concatenate([part.responses for part in parts], axis=1),
            parts[0].fs_hz,
            parts[0].dofs,
            np.concatenate(forces) if len(forces) == len(parts) else None,
        )
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
    bare = [Recording(part.responses, part.fs_hz, part.dofs) for part in parts_of(rec)]
    return PooledRecording(bare) if len(bare) > 1 else bare[0]


def pooled(records: Sequence[Recording], name: str = "source") -> Recording:
    """Records of one test as one; the force is kept where all have it.

    Parameters
    ----------
    records : sequence of Recording
        Of the same dofs, in any order, and of one sampling rate.
    name : str
        What errors call the argument.

    Raises
    ------
    InvalidInputError
        Records of other dofs or of another sampling rate than the first.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals.pooled import pooled
    >>> from antires_rs.signals.recording import Recording
    >>> one = Recording(np.eye(2, 100), 10.0, dofs=["a", "b"])
    >>> pooled([one, Recording(np.eye(2, 50), 10.0, dofs=["b", "a"])]).parts[1].dofs
    ('a', 'b')
    """
    first = records[0]
    same = [_as_first(first, rec, Argument(name).item(i)) for i, rec in enumerate(records)]
    return PooledRecording(same) if len(same) > 1 else first


def _as_first(first: Recording, rec: Recording, name: Argument) -> Recording:
    """A record with its rows in the order of the first record's."""
    if rec.fs_hz != first.fs_hz:
        reject(
            name,
            f"a sampling rate of {rec.fs_hz:g} Hz",
            f"that of the first record, {first.fs_hz:g} Hz",
            "Resample one of them, or identify them apart.",
        )
    if set(rec.dofs) != set(first.dofs):
        reject(
            name,
            f"a record of dofs {rec.dofs}",
            f"the dofs of the first record, {first.dofs}",
            "Identify setups with sensors at other places apart, and join the sets by merge_setups.",
        )
    if rec.dofs == first.dofs:
        return rec
    rows = [rec.dofs.index(dof) for dof in first.dofs]
    return Recording(rec.responses[rows], rec.fs_hz, first.dofs, rec.force)
