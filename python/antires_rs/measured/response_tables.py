"""A read-only mapping of response dofs to antiresonances, and its columns by dof."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..order_sweep.table import ResponseTable
from ..support.pickling import FrozenDict, ReadOnly
from ..support.validation import FloatArray, reject
from .tables import label

__all__ = ["ResponseTables"]


class ResponseTables(ReadOnly, Mapping[Any, FloatArray]):
    """One :class:`~antires_rs.order_sweep.table.ResponseTable` for each response to one force.

    As a mapping it gives the frequencies: ``{dof: freq_hz}``. What else it has is derived from the tables.
    """

    _excitation: Any
    _tables: FrozenDict[Any, ResponseTable]

    def __init__(self, excitation: Any, tables: Mapping[Any, ResponseTable]) -> None:
        self._fill(_excitation=excitation, _tables=FrozenDict(tables))

    @property
    def excitation(self) -> Any:
        """The dof of the force, int or str."""
        return self._excitation

    @property
    def tables(self) -> Mapping[Any, ResponseTable]:
        """By dof: all that is known of its antiresonances, a row each."""
        return self._tables

    @property
    def damping_ratio(self) -> Mapping[Any, FloatArray]:
        """By dof, in the order of the frequencies: NaN where not known, without the dofs with none known."""
        return self._known(lambda table: table.damping_ratio)

    @property
    def std_hz(self) -> Mapping[Any, FloatArray]:
        """Standard deviations by dof: NaN where not known, without the dofs with none known."""
        return self._known(lambda table: table.std_hz)

    @property
    def scores(self) -> Mapping[Any, Mapping[str, NDArray[Any]]]:
        """By dof: what speaks for each, arrays by name, see :mod:`antires_rs.order_sweep.scores`."""
        return FrozenDict({dof: table.scores for dof, table in self._tables.items() if table.scores})

    def columns(self, dof: Any) -> dict[str, FloatArray]:
        """Frequency, damping ratio and standard deviation of a dof, (n,) each; NaN where not known."""
        table = self._tables[dof]
        return {"freq_hz": table.freq_hz, "damping_ratio": table.damping_ratio, "std_hz": table.std_hz}

    def by_hand(self) -> set[tuple[Any, float]]:
        """(dof, frequency in Hz) of what is there because it was added by hand."""
        return {
            (dof, freq)
            for dof, table in self._tables.items()
            for freq in table.freq_hz[table.by_hand].tolist()
        }

    def __getitem__(self, dof: Any) -> FloatArray:
        return self._tables[dof].freq_hz

    def __iter__(self) -> Iterator[Any]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)

    def __eq__(self, other: object) -> bool:
        """Same excitation, dofs and values, bit for bit; diagrams, scores and edits do not count."""
        if not isinstance(other, ResponseTables):
            return NotImplemented
        return (
            self._excitation == other._excitation
            and self._tables.keys() == other._tables.keys()
            and all(table.same_as(other._tables[dof]) for dof, table in self._tables.items())
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        counts = ", ".join(f"{dof!r}: {len(table)}" for dof, table in self._tables.items())
        return f"{type(self).__name__}(excitation={self._excitation!r}, values by dof {{{counts}}})"

    def _known(self, column: Callable[[ResponseTable], FloatArray]) -> FrozenDict[Any, FloatArray]:
        """A column by dof, without the dofs that have antiresonances and nothing known of any."""
        columns = {dof: column(table) for dof, table in self._tables.items()}
        return FrozenDict(
            {dof: values for dof, values in columns.items() if not values.size or not np.isnan(values).all()}
        )

    def _dof(self, dof: Any) -> Any:
        """One of the set's dofs."""
        dof = label("dof", dof)
        if dof not in self._tables:
            reject("dof", dof, f"one of {tuple(self._tables)}", "Name a dof of the set; those are its keys.")
        return dof
