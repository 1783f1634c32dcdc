"""CSV and TSV: rows are samples or frequencies, columns are channels.

Ours begins with comment lines ``# name: JSON``, which hold kind, dofs, rate and the number of rows, so that
a file that was cut between two rows is noticed too. Others are read with or without a line of names.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import AntiresError, UnsuitableDataError
from ..signals.frequency_response import FrequencyResponse
from ..support.validation import choice, finite_scalar
from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import Signal, existing_file, missing_part, rate_of, unsuitable
from .axis import given_axis
from .channels import Channel, Dofs, in_si, recording_of
from .column_pairs import joined
from .delimited_response import response_of, response_without_axis, says_frequency
from .delimited_text import Table, table_of
from .own import own_signal
from .units import abscissa_factor, named_unit

__all__ = ["read_csv"]

_TIME = ("time", "t", "s", "time_s", "seconds")
# Instants with few digits may differ so much from the rate that they were sampled at.
_SAME_RATE = 1e-3


def read_csv(
    path: str | os.PathLike[str],
    *,
    first: str | None = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    kind: str | None = None,
    reference: Any = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    pairs: str | None = None,
    freq_hz: Any = None,
    df_hz: float | None = None,
    partial: bool = False,
) -> Signal:
    """Read columns of text: one of our files as it was, any other by the names of its columns.

    Options for a file of ours: as in :func:`read_npz`.

    Parameters
    ----------
    path : path-like
        Separated by commas, semicolons, tabs or spaces; lines beginning with # or % are comments. The last of
        a few lines of text before the numbers names the columns, ``tip [g]``; a line of units may follow it.
        Time may be in ms, us or min too, frequency in kHz. Complex columns are ``1.5-0.2j`` (or i), or pairs
        ``re(tip)``, ``im(tip)``; ``Real``, ``Imaginary``; or, over frequency, ``Magnitude [g/N]`` (``[dB]``),
        ``Phase [deg]`` (``[rad]``).
    first : {"time", "freq", "channel"}, optional
        What the first column is. By default its name tells, and complex columns lie over frequency.
    fs_hz : float, optional
        Sampling rate, where there is no column of time; in place of the column's where there is one.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by the column's name, or a function of it; None leaves one out.
        Default: the names, or 0, 1, ... without names.
    force : str or None
        Column of the force; "auto" takes the one in N or called force, None leaves it out.
    unit : str, optional
        Unit of the responses, in place of the file's: ``'m/s2'``, ``'g'``, ``'g/N'`` and the like.
    kind, reference
        Of complex columns: as in :class:`FrequencyResponse`; "frf" by default.
    delimiter, decimal : str, optional
        Between columns, and the decimal sign ("." or ","). By default what the numbers show.
    pairs : {"real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad"}, optional
        What two neighbouring columns after the first are, where their names do not tell.
    freq_hz : (n_freq,), optional
        Frequencies of the rows, where no column holds them.
    df_hz : float, optional
        Their spacing from 0 Hz on, in place of ``freq_hz``.
    partial : bool
        Read the whole rows of a file that was cut, with a warning that counts what is missing.

    Returns
    -------
    Recording or FrequencyResponse
        In SI.

    Raises
    ------
    UnsuitableDataError
        A row that is cut or not numeric, fewer rows than the file states, gaps in time.
    InvalidInputError
        Options that do not fit the file.
    FileNotFoundError
        There is none.

    Warns
    -----
    AntiresWarning
        The last line has no end, so that its last number may be cut; a unit that is not known; a
        column of time that says another rate than ``fs_hz``.

    Notes
    -----
    A file of another program that was cut exactly between two rows shows no sign of it.

    Examples
    --------
    >>> import pathlib, tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "run.csv")
    ...     _ = file.write_text("time [s];tip [g];hammer [N]\\n0;1,0;5\\n0,5;-0,5;0\\n1;0,25;0\\n")
    ...     record = ar.read_csv(file)
    >>> record, record.responses[0].tolist()
    (Recording(1 channels, 1.5 s at 2 Hz, dofs=('tip',), with force), [9.80665, -4.903325, 2.4516625])
    """
    file = existing_file(path)
    if first is not None:
        choice("first", first, ("time", "freq", "channel"))
    table = table_of(file, delimiter, decimal)
    if table.problem:
        missing_part(
            file,
            table.problem,
            "a line end after the last row and every row whole",
            partial,
            len(table.values),
        )
    if "rows" in table.header and len(table.values) != table.header["rows"]:
        stated = table.header["rows"]
        if not table.problem:
            kept = len(table.values) if len(table.values) < stated else 0
            missing_part(
                file,
                f"{len(table.values)} of {stated} rows are there",
                f"{stated} rows, as its header states",
                partial,
                kept,
            )
    if len(table.values) < 2:
        unsuitable(
            file,
            f"with {len(table.values)} rows of numbers",
            "at least two",
            "Export more of the record; a single row is no signal.",
        )
    if "kind" in table.header:
        return own_signal(
            file,
            _own(file, table),
            first=first,
            fs_hz=fs_hz,
            dofs=dofs,
            force=force,
            unit=unit,
            kind=kind,
            reference=reference,
            pairs=pairs,
            df_hz=df_hz,
            freq_hz=None if freq_hz is None else "an axis",
        )
    axis = given_axis(freq_hz, df_hz)
    kind = "frf" if kind is None else kind
    if axis is not None:
        return response_without_axis(file, table, axis, first, pairs, dofs, unit, kind, reference)
    return _foreign(file, table, first, pairs, fs_hz, dofs, force, unit, kind, reference)


def _own(file: Path, table: Table) -> Signal:
    """A file of ours: the header tells everything."""
    head, columns = table.header, table.values.real.T
    try:
        dofs, n = list(head["dofs"]), len(head["dofs"])
        if head["kind"] == "recording":
            channels = [
                Channel(dof, column, head["unit"])
                for dof, column in zip(dofs, columns[1 : n + 1], strict=True)
            ]
            if head["force"]:
                channels.append(Channel("force", columns[n + 1], "N", "force"))
            return recording_of(file, channels, float(head["fs_hz"]))
        values = columns[1 : 2 * n + 1 : 2] + 1j * columns[2 : 2 * n + 2 : 2]
        rest = columns[2 * n + 1 :].reshape(-1, n, columns.shape[1])
        more = dict(zip(head["more"], rest, strict=True))
        return FrequencyResponse(
            columns[0],
            in_si(values, named_unit("unit", head["unit"])),
            dofs,
            head["kind"],
            head["reference"],
            more.get("coherence"),
            head["n_averages"],
            more.get("std"),
        )
    except AntiresError:
        raise
    except (KeyError, TypeError, ValueError, IndexError) as exc:
        unsuitable(
            file,
            f"whose header is damaged ({type(exc).__name__}: {exc})",
            "a file of write_csv",
            "Write it again; leave the lines at the top as they are.",
        )


def _foreign(
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
    names, units, columns = table.columns()
    hertz = first == "freq" or pairs is not None or says_frequency(table, names[0], units[0])
    names, units, columns = joined(file, names, units, columns, pairs, hertz)
    if first is None:
        seconds = not hertz and (units[0].lower() == "s" or abscissa_factor(units[0]) != 1.0)
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
        lines = columns[0].real * abscissa_factor(units[0])
        return response_of(file, lines, columns[1:], labels[1:], units[1:], dofs, unit, kind, reference)
    if any(np.iscomplexobj(c) for c in columns):
        unsuitable(
            file, "with complex columns over time", "real ones", Wording("Pass {}.", Passed("first", "freq"))
        )
    instants = columns[0] * abscissa_factor(units[0]) if first == "time" else None
    if instants is not None and fs_hz is None:
        rate = rate_of(file, instants, digits=table.digits)
    else:
        rate = finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
        if instants is not None:
            _warn_other_rate(file, instants, rate, table.digits)
    channels = [
        Channel(name, values, its, "force" if str(name).lower() == "force" else "")
        for name, values, its in zip(labels[skip:], columns[skip:], units[skip:], strict=True)
    ]
    return recording_of(file, channels, rate, dofs=dofs, force=force, unit=unit)


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
