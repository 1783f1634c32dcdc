r"""Spectra of many segments, kept in half the digits beside their exact average.

Sums over segments are made in double precision while the segments are transformed, some at a time. What is
kept of each is asked for standard deviations only, so seven digits do: of a record whose band reaches up to
the Nyquist frequency, segments that overlap by half take as much memory as the record.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..support.validation import ComplexArray, FloatArray

__all__ = ["Segments", "add_products", "pieces"]

#: Numbers that are worked on at a time: a few times this is what a step needs beside its input.
AT_A_TIME = 1 << 17


def pieces(count: int, size: int, at_a_time: int = AT_A_TIME) -> Iterator[slice]:
    """Slices of ``count`` things of ``size`` numbers each, at least one thing in each slice.

    Examples
    --------
    >>> from antires_rs.signals.segments import pieces
    >>> list(pieces(5, 60_000))
    [slice(0, 2, None), slice(2, 4, None), slice(4, 5, None)]
    """
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
