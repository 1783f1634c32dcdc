"""Columns of a table by their names: a record over time, or responses over frequency."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..support.validation import finite_scalar
from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import Signal, rate_of, unsuitable
from .channels import Channel, Dofs, recording_of
from .column_pairs import joined
from .delimited_response import response_of, says_frequency
from .delimited_text import Table
from .units import abscissa_factor, is_abscissa, parse_unit

__all__ = ["signal_of_columns"]

_TIME = ("time", "t", "time_s", "s", "seconds", "timestamp", "datetime", "date", "date/time", "x_value")
#: What programs call the number of a row.
_INDEX = ("", "index", "unnamed: 0", "sample", "samples", "no", "no.", "nr", "nr.", "#", "row", "point")
#: First instants from which on they are in ns, us or ms since 1970.
_SINCE_1970 = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
# Instants with few digits may differ so much from the rate that they were sampled at.
_SAME_RATE = 1e-3


def signal_of_columns(
    file: Path,
    table: Table,
    first: str | None,
    pairs: str | None,
    fs_hz: float | None,
    dofs: Dofs,
    force: Any,
    unit: str | None,
    kind: str,
    reference: Any,
) -> Signal:
    """The signal that the columns of a table are; options as those of ``read_csv``."""
    names, units, columns = table.columns()
    digits = table.digits[0]
    if first is None and _counts(columns[0]) and (names[0].lower() in _INDEX or not table.names):
        timed = len(names) > 1 and (names[1].lower() in _TIME or says_frequency(table, names[1], units[1]))
        if timed or fs_hz is not None:
            names, units, columns = names[1:], units[1:], columns[1:]
            digits = table.digits[1]
            first = None if timed else "channel"
        else:
            unsuitable(
                file,
                f"whose first column, {names[0]!r}, counts the rows, and no column is a time or a frequency",
                "a sampling rate or a column of time",
                Wording("Pass {}, or {} if it is the time in s.", Passed("fs_hz"), Passed("first", "time")),
            )
    hertz = first == "freq" or pairs is not None or says_frequency(table, names[0], units[0])
    names, units, columns = joined(file, names, units, columns, pairs, hertz)
    if first is None:
        seconds = not hertz and is_abscissa(units[0])
        first = (
            "time"
            if (bool(table.names) and names[0].lower() in _TIME) or seconds
            else "freq"
            if hertz or any(np.iscomplexobj(c) for c in columns)
            else "channel"
            if table.names and fs_hz is not None
            else None
        )
    if first is None:
        unsuitable(
            file,
            f"whose first column, {names[0]!r}, is neither called time nor frequency",
            "to know what it is",
            Wording(
                "Pass {}, {} or, with {}, {}.",
                Passed("first", "time"),
                Passed("first", "freq"),
                Passed("fs_hz"),
                Passed("first", "channel"),
            ),
        )
    skip = 0 if first == "channel" else 1
    if len(columns) <= skip:
        unsuitable(
            file,
            "with no column of values",
            "at least one beside the first",
            "Export the channels beside the first column.",
        )
    labels = [name if table.names and name else i - skip for i, name in enumerate(names)]
    if first == "freq":
        lines = columns[0].real * _into_si(file, names[0], units[0])
        return response_of(file, lines, columns[1:], labels[1:], units[1:], dofs, unit, kind, reference)
    if any(np.iscomplexobj(c) for c in columns):
        unsuitable(
            file, "with complex columns over time", "real ones", Wording("Pass {}.", Passed("first", "freq"))
        )
    instants = columns[0] * _into_si(file, names[0], units[0], columns[0]) if first == "time" else None
    if instants is not None and fs_hz is None:
        rate = rate_of(file, instants, digits=digits)
    else:
        rate = finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
        if instants is not None:
            _warn_other_rate(file, instants, rate, digits)
    channels = [
        Channel(name, values, its, "force" if str(name).lower() == "force" else "")
        for name, values, its in zip(labels[skip:], columns[skip:], units[skip:], strict=True)
    ]
    return recording_of(file, channels, rate, dofs=dofs, force=force, unit=unit)


def _into_si(file: Path, name: str, unit: str, instants: Any = None) -> float:
    """Factor of the first column into s or Hz; a unit that is not known would move every frequency."""
    text = unit.strip()
    if is_abscissa(text):
        return abscissa_factor(text)
    known = parse_unit(text)
    if known is None or known.quantity:
        unsuitable(
            file,
            f"whose first column, {name!r}, is in {text!r}",
            "a unit of time or frequency: s, ms, us, min, h, Hz, kHz, rad/s",
            "Correct the unit in the header.",
        )
    # Seconds since 1970 stay below 1e11 for 3,000 years, so that larger ones are in a smaller unit.
    largest = 0.0 if instants is None else float(np.abs(instants[0]))
    return next((factor for least, factor in _SINCE_1970 if largest >= least), 1.0)


def _counts(values: Any) -> bool:
    """Whether a column is 0, 1, 2, ... or 1, 2, 3, ..."""
    if np.iscomplexobj(values) or values.size < 3 or values[0] not in (0.0, 1.0):
        return False
    return bool(np.array_equal(values, values[0] + np.arange(values.size)))


def _warn_other_rate(file: Path, times: Any, rate: float, digits: float) -> None:
    """A rate that the caller gives and the column of time denies moves every frequency."""
    with suppress(UnsuitableDataError):  # instants that say nothing are why a rate was given
        own = rate_of(file, times, digits=digits)
        if abs(own - rate) > _SAME_RATE * rate:
            warn(
                "other_rate",
                f"path: {str(file)!r} has instants at {own:.6g} Hz; read at {rate:.6g} Hz, as fs_hz= says. "
                "Leave fs_hz= out if the file is right.",
            )
