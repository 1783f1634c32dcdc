r"""Spectra of many segments, kept in half the digits beside their exact average.

Sums over segments are made in double precision while the segments are transformed, some at a time. What is
kept of each is asked for standard deviations only, so seven digits do: of a record whose band reaches up to
the Nyquist frequency, segments that overlap by half take as much memory as the record.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..exceptions import Argument, reject
from ..support.checks import ComplexArray, FloatArray
from .recording import Recording

#: Numbers that are worked on at a time: a few times this is what a step needs beside its input.
AT_A_TIME = 1 << 17


def pieces(count: int, size: int, at_a_time: int = AT_A_TIME) -> Iterator[slice]:
    """Slices of ``count`` things of ``size`` numbers each, at least one thing in each slice."""
    step = max(1, at_a_time // max(1, size))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def add_products(total: ComplexArray, spectra: ComplexArray) -> None:
    """Add the sums of conj(A) B over the segments, (n_freq, n_rows, n_segments), to ``total`` in place."""
    _, n, count = spectra.shape
    for some in pieces(len(spectra), n * (n + count)):
        part = spectra[some]
        total[some] += part.conj() @ part.transpose(0, 2, 1)


@dataclass(frozen=True, eq=False)
class Segments:
    """Scaled spectra of what was averaged.

    Attributes
    ----------
    values : (n_freq, n_rows, n_segments) complex
        Of long records in single precision.
    matrix : (n_freq, n_rows, n_rows) complex
        Mean over the segments of conj(A) B, in double precision.
    unit : (n_freq, n_rows)
        What ``values`` are to be multiplied by for that mean.
    scale : (n_freq, n_rows)
        What both are to be multiplied by, ``matrix`` in rows and in columns.
    """

    values: NDArray[np.complexfloating[Any, Any]]
    matrix: ComplexArray
    unit: FloatArray
    scale: FloatArray

    @classmethod
    def of(cls, values: ComplexArray) -> Self:
        """Of spectra as they are."""
        matrix = values.conj() @ values.transpose(0, 2, 1) / values.shape[2]
        return cls(values, matrix, np.ones(values.shape[:2]), np.ones(values.shape[:2]))

    @property
    def count(self) -> int:
        """Number of segments."""
        return int(self.values.shape[2])

    def covariance(self, lines: slice = slice(None)) -> ComplexArray:
        """Mean over the segments of A conj(B) at some lines, scaled, (n_lines, n_rows, n_rows)."""
        scaled, scale = self.matrix[lines].conj(), self.scale[lines]
        scaled *= scale[:, :, None]
        scaled *= scale[:, None, :]
        return scaled

    def at(self, lines: slice) -> ComplexArray:
        """Those of some lines, scaled, in double precision."""
        factor = self.unit[lines] * self.scale[lines]
        return np.asarray(self.values[lines] * factor[:, :, None], dtype=np.complex128)

    def times(self, scale: FloatArray) -> Self:
        """Scaled once more, by rows (n_rows,) or by lines and rows, (n_freq, n_rows) or (n_freq, 1)."""
        return replace(self, scale=self.scale * scale)

    def part(self, lines: slice) -> Self:
        """The same for some of the lines."""
        values, matrix, unit, scale = self.values, self.matrix, self.unit, self.scale
        return replace(self, values=values[lines], matrix=matrix[lines], unit=unit[lines], scale=scale[lines])

    def projected(self, directions: FloatArray) -> Segments:
        """The same in the basis ``directions``, (n_rows, n_directions)."""
        return Segments.of(np.asarray(directions.T @ self.at(slice(None))))


# -- Several records of one test as one: what is averaged together, and never across a joint


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
    """Records of one test as one; the force is kept where all have it."""
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
