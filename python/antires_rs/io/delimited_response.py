"""Columns of text as responses over frequency."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import FloatArray, choice, reject
from ..support.wording import Passed, Wording
from ._common import refuse_real, unsuitable
from .axis import GivenAxis
from .channels import Dofs, in_si, kept, renamed, unit_or_warning
from .column_pairs import PAIRS, joined
from .delimited_text import Table
from .units import is_frequency, named_unit

__all__ = ["response_of", "response_without_axis", "says_frequency"]

_FREQ = ("freq", "f", "hz", "frequency", "freq_hz")


def says_frequency(table: Table, name: str, unit: str) -> bool:
    """Whether name or unit of a column say that it is a frequency."""
    return (bool(table.names) and name.lower() in _FREQ) or is_frequency(unit)


def response_of(
    file: Path,
    lines: FloatArray,
    columns: list[Any],
    labels: list[Any],
    units: list[str],
    dofs: Dofs,
    unit: str | None,
    kind: str,
    reference: Any,
) -> FrequencyResponse:
    """Complex columns over ``lines``, in SI."""
    choice("kind", kind, ("frf", "transmissibility"))
    if not all(np.iscomplexobj(c) for c in columns):
        unsuitable(
            file,
            "with real columns over frequency",
            "complex ones, or pairs such as re(x), im(x) or 'Magnitude [dB]', 'Phase [deg]'",
            Wording(
                "Pass {} or another of its kinds if two columns are one response; magnitudes alone have lost "
                "the phase.",
                Passed("pairs", PAIRS[0]),
            ),
        )
    named = renamed("dofs", labels, dofs)
    chosen = kept(named)
    rows = []
    for i in chosen:
        own = named_unit("unit", unit) if unit is not None else unit_or_warning(file, units[i])
        rows.append(in_si(columns[i], own))
    refuse_real(file, rows)
    return FrequencyResponse(
        lines,
        np.stack(rows),
        [named[i] for i in chosen],
        "frf" if kind == "frf" else "transmissibility",
        reference,
    )


def response_without_axis(
    file: Path,
    table: Table,
    axis: GivenAxis,
    first: str | None,
    pairs: str | None,
    dofs: Dofs,
    unit: str | None,
    kind: str,
    reference: Any,
) -> FrequencyResponse:
    """All columns as responses over a given axis."""
    names, units, columns = table.columns()
    given = "freq_hz" if axis.size is not None else "df_hz"
    if first not in (None, "channel"):
        reject(given, f"it beside first={first!r}", "it where no column is an axis", "Leave one of them out.")
    if says_frequency(table, names[0], units[0]):
        reject(
            given,
            f"it for a file with the column {names[0]!r}",
            "it where no column is an axis",
            "Leave it out.",
        )
    # An empty column in front: every one of the file is a value.
    names, units, columns = joined(
        file, ["", *names], ["", *units], [np.zeros(len(columns[0])), *columns], pairs, True
    )
    if np.iscomplexobj(table.values):
        columns = [columns[0], *(np.asarray(c, dtype=np.complex128) for c in columns[1:])]
    labels = [name if table.names and name else i for i, name in enumerate(names[1:])]
    lines = axis.lines(file, len(columns[0]))
    return response_of(file, lines, columns[1:], labels, units[1:], dofs, unit, kind, reference)
