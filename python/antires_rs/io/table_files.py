"""Tables: rows are samples or frequencies, columns are channels. CSV and TSV, Excel, Parquet.

A CSV file of ours begins with comment lines ``# name: JSON``, which hold kind, dofs, rate and the number of
rows, so that a file that was cut between two rows is noticed too; ``crc32`` is of the header and the numbers.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Unpack
from zlib import crc32

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import choice
from ..support.files import cell, write_atomically
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, recording_of
from .child_process import Limits, channels_of_child
from .common import Signal, missing_part, parts_of, require, unsuitable
from .options import OfColumns, PathLike, Reading, opened, reader, writer
from .own_format import as_asked, check_dofs
from .text_table import MARK, VERSION, Table, named, signal_of_table, table_of
from .units import Unit

__all__ = ["read_csv", "read_excel", "read_parquet", "write_csv"]


@reader(".csv .tsv .txt")
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
        Time may be in ms, us, min or h, in ms, us or ns since 1970, or instants such as ``2026-05-04
        12:30:00.001``; frequency in kHz. A first column that counts the rows is left out. Complex columns are
        ``1.5-0.2j`` (or i), or pairs ``re(tip)``, ``im(tip)``; ``Real``, ``Imaginary``; or, over frequency,
        ``Magnitude [g/N]`` (``[dB]``), ``Phase [deg]`` (``[rad]``). UTF-8, UTF-16 or Latin-1.
    delimiter, decimal : str, optional
        Between columns, and the decimal sign ("." or ","). By default what the numbers show.

    Notes
    -----
    A last line without an end is warned of, as its last number may be cut. A file of another program that was
    cut exactly between two rows shows no sign of it.

    Examples
    --------
    >>> import pathlib, tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "run.csv")
    ...     _ = file.write_text("time [s];tip [g];hammer [N]\\n0;1,0;5\\n0,5;-0,5;0\\n1;0,25;0\\n")
    ...     ar.read_csv(file)
    Recording(1 channels, 1.5 s at 2 Hz, dofs=('tip',), with force)
    """
    file, given = opened(read_csv, path, options)
    table = table_of(file, delimiter, decimal)
    found, stated = len(table.values), table.header.get("rows")
    problem = table.problem or (f"{found} of {stated} rows are there" if stated not in (None, found) else "")
    if problem:
        kept = 0 if stated is not None and found > stated else found
        missing_part(file, problem, "a line end after the last row and every row whole", partial, kept)
    if found < 2:
        unsuitable(file, f"with {found} rows of numbers", "at least two")
    if table.header:
        return as_asked(file, _own(file, table), given)
    return signal_of_table(file, table, given)


def _own(file: Path, table: Table) -> Signal:
    """A file of ours: the header tells everything."""
    head, columns = table.header, table.values.real.T
    stated = head.pop("crc32", None)  # files of versions before have none
    if stated is not None and head["rows"] == len(table.values) and stated != _checksum(head, columns.T):
        remedy = "Copy it again; of one that you changed yourself, remove the line '# crc32'."
        unsuitable(file, "which does not have its checksum", "a file as write_csv wrote it", remedy)
    with parts_of(file, "a whole file of write_csv"):
        dofs, n = list(head["dofs"]), len(head["dofs"])
        if head["kind"] == "recording":
            rows = zip(dofs, columns[1 : n + 1], strict=True)
            channels = [Channel(dof, column, head["unit"]) for dof, column in rows]
            if head["force"]:
                channels.append(Channel("force", columns[n + 1], "N", role="force"))
            return recording_of(file, channels, float(head["fs_hz"]), Reading())
        values = columns[1 : 2 * n + 1 : 2] + 1j * columns[2 : 2 * n + 2 : 2]
        rest = columns[2 * n + 1 :].reshape(-1, n, columns.shape[1])
        values = Unit.named(head["unit"]).in_si(values)
        more = {"n_averages": head["n_averages"], **dict(zip(head["more"], rest, strict=True))}
        return FrequencyResponse(columns[0], values, dofs, head["kind"], head["reference"], **more)


def _checksum(head: dict[str, Any], values: Any) -> int:
    numbers = np.ascontiguousarray(np.where(np.isnan(values), 0.0, values), dtype="<f8")
    return crc32(numbers.view(np.uint8).reshape(-1), crc32(json.dumps(head).encode()))  # type: ignore[arg-type]


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
    ...     file.read_text().splitlines()[-3:]
    ['0.0,1.0', '0.125,2.5', '0.25,4.0']
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
        names = ["time [s]", *(f"{cell(dof)} [{unit}]" for dof in dofs), *["force [N]"] * len(forces)]
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
    Unit.written(unit)
    values = np.column_stack(columns)
    head["crc32"] = _checksum(json.loads(json.dumps(head)), values)
    # The names are for the eye; the header has the dofs in full.
    shown = ("".join("_" if c in (delimiter, "\n", "\r", '"') else c for c in name) for name in names)
    lines = [
        f"{MARK} {VERSION}",
        *(f"# {name}: {json.dumps(value)}" for name, value in head.items()),
        delimiter.join(shown),
        *(delimiter.join(map(repr, row)) for row in values.tolist()),
    ]
    return write_atomically(path, ("\n".join(lines) + "\n").encode())


@reader(".xlsx .xlsm")
def read_excel(
    path: PathLike,
    *,
    sheet: str | None = None,
    time_limit_s: float = 120.0,
    memory_limit_gb: float = 8.0,
    **options: Unpack[OfColumns],
) -> Signal:
    """Read a sheet of an Excel workbook (.xlsx), one row a sample or a frequency.

    Days and times, or those of a clock, in the first column are the time.

    Parameters
    ----------
    path : path-like
        Lines of text above the numbers: the last names the columns, ``tip [g]``; a line of units may follow.
    sheet : str, optional
        By default the first.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> from openpyxl import Workbook
    >>> book = Workbook()
    >>> for row in (["time [ms]", "tip [g]"], [0, 1.0], [10, -0.5], [20, 0.25]):
    ...     book.active.append(row)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     book.save(folder + "/a.xlsx")
    ...     ar.read_excel(folder + "/a.xlsx")
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_excel, path, options)
    require("read_excel", "openpyxl", "excel")
    wanted, limits = "an Excel workbook (.xlsx) with rows of numbers", Limits(time_limit_s, memory_limit_gb)
    entries, texts = channels_of_child(columns_of_excel, file, wanted, limits, sheet=sheet)
    head = [row for row in json.loads(texts["head"]) if len(row) == len(entries)]
    return signal_of_table(file, _table(file, entries, head), given)


@reader(".parquet .pq")
def read_parquet(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[OfColumns]
) -> Signal:
    """Read a Parquet table, as pandas writes it, one row a sample or a frequency.

    The index of pandas comes first; a column of timestamps is the time.

    Parameters
    ----------
    path : path-like
        Columns are named ``tip [g]``, or have their unit in the field's metadata, ``unit``.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> import pyarrow as pa, pyarrow.parquet as pq
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     table = pa.table({"time": [0.0, 0.5, 1.0], "tip [g]": [1.0, -0.5, 0.25]})
    ...     pq.write_table(table, folder + "/a.parquet")
    ...     ar.read_parquet(folder + "/a.parquet")
    Recording(1 channels, 1.5 s at 2 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_parquet, path, options)
    require("read_parquet", "pyarrow", "series")
    wanted, limits = "a whole Parquet file with columns of numbers", Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(columns_of_parquet, file, wanted, limits)
    # pandas puts an index of instants last, under a name of its own.
    entries.sort(key=lambda entry: not (entry["name"].startswith("__index_level_") or "instants" in entry))
    for entry in entries:
        if entry["name"].startswith("__index_level_"):
            entry["name"] = "time" if "instants" in entry else ""
    return signal_of_table(file, _table(file, entries, [[entry["name"] for entry in entries]]), given)


def _table(file: Path, entries: list[dict[str, Any]], head: list[list[str]]) -> Table:
    """The columns as those of a text."""
    if not entries or entries[0]["values"].size < 2:
        found = f"with {len(entries)} columns of {entries[0]['values'].size if entries else 0} rows"
        unsuitable(file, found, "columns of two rows or more")
    table = Table(values=np.column_stack([entry["values"] for entry in entries]))
    if not np.isfinite(table.values).all():
        unsuitable(file, "with values that are not finite", "finite numbers")
    named(table, head)
    units = table.units or [""] * len(entries)
    table.units = [entry["unit"] or unit for entry, unit in zip(entries, units, strict=True)]
    if "instants" in entries[0] and table.names:
        table.names[0] = "time"
    return table


# -- In the child process

#: More columns or rows than these, and a sheet is no record of a test.
MOST_CHANNELS, MOST_CELLS = 10_000, 100_000_000


def table_of_parquet(path: str, request: dict[str, Any]) -> Answer:
    """All columns as a text, in the child process."""
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    room(table.num_rows * table.num_columns, request)
    return answer([], table=table.to_pydict())


def tried_parquet(path: str, request: dict[str, Any]) -> Answer:
    """All row groups read in turn: a table that ends or fills this process does not reach the parent."""
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            for group in range(file.num_row_groups):
                about = file.metadata.row_group(group)
                room(about.num_rows * about.num_columns, request)
                file.read_row_group(group)
    except MemoryError:
        raise
    except Exception:  # which the parent meets and tells where that part is asked for
        return answer([])
    return answer([])


def columns_of_parquet(path: str, request: dict[str, Any]) -> Answer:
    """Columns of a Parquet table."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        names = [name for name in file.schema_arrow.names if asked((name,), name, request)]
        room(file.metadata.num_rows * len(names), request)
        if len(names) > MOST_CHANNELS:
            raise Unfit(f"{len(names)} columns")
        table = file.read(columns=names)
    index = [n for n in (table.schema.pandas_metadata or {}).get("index_columns", ()) if isinstance(n, str)]
    made = []
    for each in sorted(table.schema, key=lambda each: each.name not in index):  # pandas writes it last
        data = table.column(each.name)
        if data.null_count:
            raise Unfit(f"the column {each.name!r} has {data.null_count} empty cells")
        metadata = (each.metadata or {}).items()
        said = {key.decode(errors="replace"): text.decode(errors="replace") for key, text in metadata}
        unit = said.get("unit") or said.get("units") or ""
        made.append(column(each.name, data.to_numpy(), unit))
    instants = [each["name"] for each in made if "instants" in each]
    if len(instants) > 1:
        raise Unfit(f"{called(instants)} all hold instants: keep the one that is the time")
    return answer(made)


def columns_of_excel(path: str, request: dict[str, Any]) -> Answer:
    """Rows of a sheet of an Excel workbook: a few lines of text, then numbers."""
    import datetime

    from openpyxl import load_workbook

    book = load_workbook(path, read_only=True, data_only=True)
    names = book.sheetnames
    chosen = request["sheet"] or names[0]
    if chosen not in names:
        raise Unfit(f"no sheet is named {chosen!r} (the sheets are {called(names)})")
    sheet = book[chosen]
    head: list[list[str]] = []
    rows: list[list[Any]] = []
    cells = before = 0
    for row in sheet.iter_rows(values_only=True):
        values = list(row)
        while values and values[-1] is None:
            values.pop()
        if not values:
            continue
        if not rows:  # a table may begin some columns to the right
            before = next(i for i, v in enumerate(values) if v is not None)
        values = values[before:]
        cells += len(values)
        if cells > MOST_CELLS or 64 * cells > request["most_bytes"]:
            raise MemoryError(f"more than {cells} cells")
        plain = all(isinstance(v, int | float | complex | datetime.datetime | datetime.time) for v in values)
        if not rows and not plain and not complex_row(values):
            head.append(["" if v is None else str(v) for v in values])
            continue
        if rows and len(values) != len(rows[0]):
            raise Unfit(f"row {len(rows) + 1} of numbers has {len(values)} columns, not {len(rows[0])}")
        rows.append(values)
    if not rows:
        raise Unfit(f"the sheet {sheet.title!r} has no row of numbers (the sheets are {called(names)})")
    made = []
    for i, each in enumerate(zip(*rows, strict=True), start=1):
        own: Any = np.array(each, dtype=object)
        if all(isinstance(v, datetime.datetime) for v in each):
            own = own.astype("datetime64[ns]")
        elif all(isinstance(v, datetime.time) for v in each):
            day = datetime.date(1970, 1, 1)
            clock = [datetime.datetime.combine(day, at.replace(tzinfo=None)) for at in each]
            own = np.array(clock, dtype="datetime64[ns]")
        made.append(column(f"column {i}", own))
    return answer(made, head=head[-3:])


def complex_row(values: list[Any]) -> bool:
    """Whether a row has complex numbers as texts, which is how a sheet holds them."""
    try:
        for value in values:
            number("", value)
    except ValueError:
        return False
    return any(not isinstance(value, str) for value in values)


def column(name: str, values: Any, unit: str = "") -> dict[str, Any]:
    """A column of a table as numbers: instants become seconds from the first, texts complex numbers."""
    if values.dtype.kind in "Mm":
        whole = values.astype("datetime64[ns]" if values.dtype.kind == "M" else "timedelta64[ns]")
        if np.isnat(whole).any():
            raise Unfit(f"the column {name!r} has instants that are missing")
        seconds = (whole - whole[0]) / np.timedelta64(1, "s")
        return {"name": name, "values": seconds, "unit": "s", "instants": 1}
    if values.dtype.kind == "O":
        values = np.array([number(name, each) for each in values])
        values = values if np.iscomplexobj(values) else values.astype(np.float64)
    if values.dtype.kind not in "biufc":
        raise Unfit(f"the column {name!r} has {values.dtype}, no numbers")
    return {"name": name, "values": values, "unit": unit}


def number(name: str, value: Any) -> Any:
    """A number of a cell; empty ones are refused."""
    if isinstance(value, str):
        text = value.strip().replace("i", "j").replace(" ", "")
        try:
            return complex(text) if "j" in text else float(text)
        except ValueError:
            raise Unfit(f"the column {name!r} has {value[:40]!r}, which is no number") from None
    if value is None:
        raise Unfit(f"the column {name!r} has empty cells")
    if not isinstance(value, int | float | complex):
        raise Unfit(f"the column {name!r} has {str(value)[:40]!r} among its numbers")
    return complex(value) if isinstance(value, complex) else float(value)
