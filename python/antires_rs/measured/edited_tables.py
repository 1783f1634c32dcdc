"""A set of antiresonances with a memory of what a person changed in it."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any, Self

from ..order_sweep.table import ResponseTable
from ..support.pickling import FrozenDict
from .edits import Edit, added, dropped
from .response_tables import ResponseTables

__all__ = ["EditedTables"]


class EditedTables(ResponseTables):
    """Tables by dof from which rows can be dropped, and to which some can be added, on record.

    Nothing is changed: each edit gives another set, which remembers the one before the first.
    """

    _edits: tuple[Edit, ...]
    _original: Self | None

    def __init__(self, excitation: Any, tables: Mapping[Any, ResponseTable]) -> None:
        super().__init__(excitation, tables)
        self._fill(_edits=(), _original=None)

    @property
    def edits(self) -> tuple[Edit, ...]:
        """What was dropped and added by hand, in order."""
        return self._edits

    def drop(self, dof: Any, freq_hz: Any, *, reason: str = "", tol_hz: float | None = None) -> Self:
        """A new set without some values; this one stays as it is.

        Parameters
        ----------
        dof : int or str
        freq_hz : float or array_like
            Each drops the value nearest to it.
        reason : str
            Kept with the record of what was done, ``edits``.
        tol_hz : float, optional
            How far the nearest value may be; default 1 % of ``freq_hz``.

        Returns
        -------
        AntiresonanceSet
            ``original()`` gives back the set before all edits.

        Raises
        ------
        InvalidInputError
            No such dof, no value that near, or two frequencies that mean the same value.

        Examples
        --------
        >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
        >>> table = AntiresonanceSet(0, {0: [8.7, 12.2], 1: 14.4})
        >>> fewer = table.drop(0, 12.2, reason="mains hum of the shaker")
        >>> table[0].tolist(), fewer[0].tolist()
        ([8.7, 12.2], [8.7])
        >>> print(fewer.edits[0])
        dropped 12.20 Hz at dof 0 (mains hum of the shaker)
        """
        dof = self._dof(dof)
        return self._edited(dof, *dropped(dof, self.tables[dof], freq_hz, reason, tol_hz))

    def add(
        self, dof: Any, freq_hz: Any, *, damping_ratio: Any = None, std_hz: Any = None, reason: str = ""
    ) -> Self:
        """A new set with more values; this one stays as it is.

        Parameters
        ----------
        dof : int or str
            One of the set's.
        freq_hz : float or array_like, (n,)
        damping_ratio, std_hz : float or array_like, (n,), optional
            One for all, or one each. Not known by default.
        reason : str
            Kept with the record of what was done, ``edits``.

        Returns
        -------
        AntiresonanceSet
            ``original()`` gives back the set before all edits. In tables the values' source is "by hand".

        Raises
        ------
        InvalidInputError
            No such dof, a frequency that is not positive, or a value that is there already.

        Examples
        --------
        >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
        >>> more = AntiresonanceSet(0, {0: [8.7], 1: 14.4}).add(0, 12.2, reason="clear in the phase")
        >>> print(more)
        antiresonances, force at 0
        dof  freq_hz  doubts
          0    8.700
              12.200  added by hand
          1   14.400
        edited by hand: added 12.20 Hz at dof 0 (clear in the phase)
        """
        dof = self._dof(dof)
        return self._edited(dof, *added(dof, self.tables[dof], freq_hz, damping_ratio, std_hz, reason))

    def original(self) -> Self:
        """The set before the first edit by hand; itself if there was none."""
        return self if self._original is None else self._original

    def _edited(self, dof: Any, table: ResponseTable, records: Sequence[Edit]) -> Self:
        return self._with(
            _tables=FrozenDict({**self._tables, dof: table}),
            _edits=(*self._edits, *records),
            _original=self.original(),
        )

    def _with(self, **parts: Any) -> Self:
        """A copy with other parts; whatever else the set carries stays with it."""
        new = copy.copy(self)
        new._fill(**parts)
        return new
