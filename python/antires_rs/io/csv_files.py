"""CSV and TSV: rows are samples or frequencies, columns are channels.

Ours begins with comment lines ``# name: JSON``, which hold kind, dofs, rate and the number of rows, so that
a file that was cut between two rows is noticed too. Others are read with or without a line of names.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Unpack

import numpy as np

from ..exceptions import AntiresError
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import choice
from ..support.files import write_atomically
from .channels import Channel, in_si, recording_of
from .common import Signal, missing_part, unsuitable
from .own_format import as_asked, check_dofs
from .reading import OfColumns, PathLike, Reading, opened, reader, writer
from .text_table import MARK, VERSION, Table, signal_of_table, table_of
from .units import named_unit, si_unit


@reader
def read_csv(
    path: PathLike,
    *,
    delimiter: str | None = None,
    decimal: str | None = None,
    partial: bool = False,
    **options: Unpack[OfColumns],
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
    delimiter, decimal : str, optional
        Between columns, and the decimal sign ("." or ","). By default what the numbers show.

    Raises
    ------
    UnsuitableDataError
        A row that is cut or not numeric, fewer rows than the file states, gaps in time.

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
    file, given = opened(read_csv, path, options)
    table = table_of(file, delimiter, decimal)
    found, stated = len(table.values), table.header.get("rows")
    if table.problem:
        missing_part(file, table.problem, "a line end after the last row and every row whole", partial, found)
    elif stated is not None and found != stated:
        got, wanted = f"{found} of {stated} rows are there", f"{stated} rows, as its header states"
        missing_part(file, got, wanted, partial, found if found < stated else 0)
    if found < 2:
        remedy = "Export more of the record; a single row is no signal."
        unsuitable(file, f"with {found} rows of numbers", "at least two", remedy)
    if "kind" in table.header:
        return as_asked(file, _own(file, table), given)
    return signal_of_table(file, table, given)


def _own(file: Path, table: Table) -> Signal:
    """A file of ours: the header tells everything."""
    head, columns = table.header, table.values.real.T
    try:
        dofs, n = list(head["dofs"]), len(head["dofs"])
        if head["kind"] == "recording":
            rows = zip(dofs, columns[1 : n + 1], strict=True)
            channels = [Channel(dof, column, head["unit"]) for dof, column in rows]
            if head["force"]:
                channels.append(Channel("force", columns[n + 1], "N", role="force"))
            return recording_of(file, channels, float(head["fs_hz"]), Reading())
        values = columns[1 : 2 * n + 1 : 2] + 1j * columns[2 : 2 * n + 2 : 2]
        rest = columns[2 * n + 1 :].reshape(-1, n, columns.shape[1])
        return FrequencyResponse(
            columns[0],
            in_si(values, named_unit("unit", head["unit"])),
            dofs,
            head["kind"],
            head["reference"],
            n_averages=head["n_averages"],
            **dict(zip(head["more"], rest, strict=True)),
        )
    except AntiresError:
        raise
    except (KeyError, TypeError, ValueError, IndexError) as exc:
        found, wanted = f"whose header is damaged ({type(exc).__name__}: {exc})", "a file of write_csv"
        unsuitable(file, found, wanted, "Write it again; leave the lines at the top as they are.")


@writer
def write_csv(path: PathLike, signal: Signal, *, unit: str | None = None, delimiter: str = ",") -> Path:
    """Write columns of text, whole or not at all; every float comes back bit for bit.

    Parameters
    ----------
    unit : str, optional
        Unit of the values, which are in SI and stay as they are: ``'m/s2'`` (default), ``'m/s'``, ``'m'``
        for a recording, ``'m/s2/N'`` and the like for FRFs; any other is an InvalidInputError.
    delimiter : {",", ";", "\\\\t"}

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
    dofs = check_dofs(signal)
    choice("delimiter", delimiter, (",", ";", "\t"))
    head: dict[str, object]
    if isinstance(signal, Recording):
        unit = "m/s2" if unit is None else unit
        forces = [] if signal.force is None else [signal.force]
        head = {"kind": "recording", "dofs": dofs, "rows": signal.n_samples, "unit": unit}
        head |= {"fs_hz": signal.fs_hz, "force": bool(forces)}
        columns = [np.arange(signal.n_samples) / signal.fs_hz, *signal.responses, *forces]
        names = ["time [s]", *(f"{dof} [{unit}]" for dof in dofs), *["force [N]"] * len(forces)]
    else:
        unit = ("m/s2/N" if signal.kind == "frf" else "1") if unit is None else unit
        more = [name for name in ("coherence", "std") if getattr(signal, name) is not None]
        head = {"kind": signal.kind, "dofs": dofs, "rows": signal.n_freq, "unit": unit}
        head |= {"reference": signal.reference, "n_averages": signal.n_averages, "more": more}
        columns = [signal.freq_hz, *(part for row in signal.values for part in (row.real, row.imag))]
        names = ["freq [Hz]", *(f"{part}({dof})" for dof in dofs for part in ("re", "im"))]
        for name in more:
            columns += list(getattr(signal, name))
            names += [f"{name}({dof})" for dof in dofs]
    si_unit("unit", unit)
    # The names are for the eye; the header has the dofs in full.
    shown = ("".join("_" if c in (delimiter, "\n", "\r", '"') else c for c in name) for name in names)
    lines = [
        f"{MARK} {VERSION}",
        *(f"# {name}: {json.dumps(value)}" for name, value in head.items()),
        delimiter.join(shown),
        *(delimiter.join(map(repr, row)) for row in np.column_stack(columns).tolist()),
    ]
    return write_atomically(path, ("\n".join(lines) + "\n").encode())
