"""CSV and TSV: rows are samples or frequencies, columns are channels.

Ours begins with comment lines ``# name: JSON``, which hold kind, dofs, rate and the number of rows, so that
a file that was cut between two rows is noticed too. Others are read with or without a line of names.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import AntiresError, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import choice
from ..support.files import write_atomically
from .channels import Channel, Dofs, Reading, in_si, recording_of
from .common import Signal, existing_file, missing_part, signal_given, unsuitable
from .own_format import check_dofs, own_signal
from .text_table import MARK, VERSION, Table, signal_of_table, table_of
from .units import named_unit


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
        Time may be in ms, us, min or h too, in ms, us or ns since 1970, or instants such as
        ``2026-05-04 12:30:00.001``; frequency in kHz. A first column that counts the rows is left out.
        Complex columns are ``1.5-0.2j`` (or i), or pairs ``re(tip)``, ``im(tip)``; ``Real``, ``Imaginary``;
        or, over frequency, ``Magnitude [g/N]`` (``[dB]``), ``Phase [deg]`` (``[rad]``). UTF-8, UTF-16 or
        Latin-1.
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
    file, given = existing_file(path), Reading.of(locals())
    table = table_of(file, delimiter, decimal)
    found, stated = len(table.values), table.header.get("rows")
    if table.problem:
        missing_part(file, table.problem, "a line end after the last row and every row whole", partial, found)
    elif stated is not None and found != stated:
        got, wanted = f"{found} of {stated} rows are there", f"{stated} rows, as its header states"
        missing_part(file, got, wanted, partial, found if found < stated else 0)
    if found < 2:
        unsuitable(
            file,
            f"with {found} rows of numbers",
            "at least two",
            "Export more of the record; a single row is no signal.",
        )
    if "kind" in table.header:
        return own_signal(file, _own(file, table), given)
    return signal_of_table(file, table, given)


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
                channels.append(Channel("force", columns[n + 1], "N", role="force"))
            return recording_of(file, channels, float(head["fs_hz"]), Reading())
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


# -- Signals as CSV or TSV with a header that states everything, the number of rows included


def write_csv(
    path: str | os.PathLike[str], signal: Signal, *, unit: str | None = None, delimiter: str = ","
) -> Path:
    """Write columns of text, whole or not at all; every float comes back bit for bit.

    Parameters
    ----------
    path : path-like
        Replaced if it exists.
    signal : Recording or FrequencyResponse
    unit : str, optional
        Unit of the values, which are in SI and stay as they are: ``'m/s2'`` (default), ``'m/s'``, ``'m'``
        for a recording, ``'m/s2/N'`` and the like for FRFs.
    delimiter : {",", ";", "\\\\t"}

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InvalidInputError
        The folder does not exist, a unit that is not SI, dofs that are neither integers nor strings.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_csv(folder + "/a.csv", ar.Recording([[1.0, 2.5, 4.0]], 8.0, dofs=["tip"]))
    ...     print(file.read_text())
    # antires_rs csv 1
    # kind: "recording"
    # dofs: ["tip"]
    # rows: 3
    # unit: "m/s2"
    # fs_hz: 8.0
    # force: false
    time [s],tip [m/s2]
    0.0,1.0
    0.125,2.5
    0.25,4.0
    <BLANKLINE>
    """
    signal_given(signal)
    choice("delimiter", delimiter, (",", ";", "\t"))
    dofs = check_dofs(signal)
    head: dict[str, object] = {}
    if isinstance(signal, Recording):
        unit = "m/s2" if unit is None else unit
        head = {
            "kind": "recording",
            "dofs": dofs,
            "rows": signal.n_samples,
            "unit": unit,
            "fs_hz": signal.fs_hz,
            "force": signal.force is not None,
        }
        columns = [np.arange(signal.n_samples) / signal.fs_hz, *signal.responses]
        names = ["time [s]", *(f"{dof} [{unit}]" for dof in dofs)]
        if signal.force is not None:
            columns.append(signal.force)
            names.append("force [N]")
    else:
        unit = ("m/s2/N" if signal.kind == "frf" else "1") if unit is None else unit
        more = [name for name in ("coherence", "std") if getattr(signal, name) is not None]
        head = {
            "kind": signal.kind,
            "dofs": dofs,
            "rows": signal.n_freq,
            "unit": unit,
            "reference": signal.reference,
            "n_averages": signal.n_averages,
            "more": more,
        }
        columns = [signal.freq_hz, *(part for row in signal.values for part in (row.real, row.imag))]
        names = ["freq [Hz]", *(f"{part}({dof})" for dof in dofs for part in ("re", "im"))]
        for name in more:
            columns += list(getattr(signal, name))
            names += [f"{name}({dof})" for dof in dofs]
    if named_unit("unit", unit).factor != 1.0:
        reject(
            "unit",
            repr(unit),
            "an SI unit, such as 'm/s2' or 'm/s2/N': signals are in SI",
            "Convert the values to SI first, or leave unit out.",
        )
    lines = [
        f"{MARK} {VERSION}",
        *(f"# {name}: {json.dumps(value)}" for name, value in head.items()),
        delimiter.join(_safe(name, delimiter) for name in names),
    ]
    lines += [delimiter.join(map(repr, row)) for row in np.column_stack(columns).tolist()]
    return write_atomically(path, ("\n".join(lines) + "\n").encode())


def _safe(name: str, delimiter: str) -> str:
    """A column's name for the eye; the header has the dofs in full."""
    return "".join("_" if letter in (delimiter, "\n", "\r", '"') else letter for letter in name)
