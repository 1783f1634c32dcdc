"""Records and tables that packages with C code read, in the child process of ``_child.py``.

Each function gives arrays by key, texts (``channels``: what each array is, in JSON) and what was listed.
"""

from __future__ import annotations

import json
from typing import Any

#: More columns or rows than these, and a sheet is no record of a test.
MOST_CHANNELS, MOST_CELLS = 10_000, 100_000_000


class Unfit(ValueError):
    """A file that is whole and does not hold what is wanted; the parent says it as it is."""


Answer = tuple[dict[str, Any], dict[str, str], list[Any]]


def answer(channels: list[dict[str, Any]]) -> Answer:
    """Values of the channels as arrays, the rest of them as one text."""
    arrays = {f"c{i}": channel.pop("values") for i, channel in enumerate(channels)}
    listed = [[channel["name"], list(arrays[f"c{i}"].shape), True] for i, channel in enumerate(channels)]
    return arrays, {"channels": json.dumps(channels, default=str)}, listed


def asked(names: tuple[str, ...], request: dict[str, Any]) -> bool:
    """Whether a channel is one of those asked for, by name or pattern; time and force always are."""
    from fnmatch import fnmatchcase

    if request["only"] is None or names[-1].lower() in request["roles"]:
        return True
    return any(
        name == pattern or fnmatchcase(name, pattern.replace("[", "[[]"))
        for name in names
        for pattern in request["only"]
    )


def room(count: int, request: dict[str, Any]) -> None:
    """Refuse more numbers than may be handed over."""
    if 16 * count > request["most_bytes"]:
        raise MemoryError(f"{count} numbers")


def tdms(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a TDMS file, scaled, with rate, unit and start where their properties have them."""
    import numpy as np
    from nptdms import TdmsFile

    made: list[dict[str, Any]] = []
    with TdmsFile.open(path) as file:
        several = sum(bool(group.channels()) for group in file.groups()) > 1
        chosen = [
            (f"{group.name}/{channel.name}" if several else channel.name, channel)
            for group in file.groups()
            for channel in group.channels()
            if len(channel) and asked((f"{group.name}/{channel.name}", channel.name), request)
        ]
        if not chosen and request["only"] is not None:
            raise Unfit("the channels are " + called(c.name for g in file.groups() for c in g.channels()))
        room(sum(len(channel) for _, channel in chosen), request)
        for name, channel in chosen:
            values = np.asarray(channel[:])
            if values.dtype.kind == "M":
                values = (values - values[0]) / np.timedelta64(1, "s")
            if values.dtype.kind not in "biufc":
                continue
            own = channel.properties
            axis = f"{own.get('wf_xname', '')} {own.get('wf_xunit_string', '')}".lower()
            if "frequency" in axis or axis.endswith("hz"):
                raise Unfit(f"the channel {name!r} lies over frequency, not time")
            step = own.get("wf_increment")
            unit = own.get("unit_string") or own.get("NI_UnitDescription") or own.get("Unit") or ""
            made.append(
                {
                    "name": name,
                    "values": values,
                    "unit": str(unit),
                    "step_s": None if step is None else float(step),
                    "start": str(own.get("wf_start_time", "")),
                    "offset_s": float(own.get("wf_start_offset", 0.0) or 0.0),
                }
            )
    return answer(made)


def wav(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a WAV file; whole numbers become shares of full scale."""
    import numpy as np
    from scipy.io import wavfile

    rate, values = wavfile.read(path)
    values = values[:, None] if values.ndim == 1 else values
    room(values.size, request)
    if values.dtype == np.uint8:
        values = (values.astype(np.float64) - 128.0) / 128.0
    elif values.dtype.kind == "i":
        values = values / 2.0 ** (8 * values.dtype.itemsize - 1)
    return answer(
        [
            {"name": f"channel {i + 1}", "values": np.float64(column), "unit": "", "step_s": 1.0 / rate}
            for i, column in enumerate(values.T)
        ]
    )


def mseed(path: str, request: dict[str, Any]) -> Answer:
    """Traces of a miniSEED file, those that follow each other joined."""
    import numpy as np
    from obspy import read

    room(int(sum(trace.stats.npts for trace in read(path, format="MSEED", headonly=True))), request)
    stream = read(path, format="MSEED")
    stream.merge(method=-1)
    made = []
    for trace in stream:
        if asked((trace.id, trace.stats.channel), request) and trace.data.dtype.kind in "biuf":
            made.append(
                {
                    "name": trace.id,
                    "values": np.float64(trace.data),
                    "unit": "counts",
                    "step_s": float(trace.stats.delta),
                    "start": str(trace.stats.starttime),
                    "offset_s": 0.0,
                    "until": str(trace.stats.endtime),
                }
            )
    if not made and request["only"] is not None:
        raise Unfit("the traces are " + called(trace.id for trace in stream))
    return answer(made)


def called(names: Any) -> str:
    """Names in a sentence."""
    return ", ".join(repr(name) for name in list(names)[:20]) or "none"


def column(name: str, values: Any, unit: str = "") -> dict[str, Any]:
    """A column of a table as numbers: instants become seconds from the first, texts complex numbers."""
    import numpy as np

    if values.dtype.kind in "Mm":
        whole = values.astype("datetime64[ns]" if values.dtype.kind == "M" else "timedelta64[ns]")
        if np.isnat(whole).any():
            raise Unfit(f"the column {name!r} has instants that are missing")
        return {
            "name": name,
            "values": (whole - whole[0]) / np.timedelta64(1, "s"),
            "unit": "s",
            "instants": 1,
        }
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


def parquet(path: str, request: dict[str, Any]) -> Answer:
    """Columns of a Parquet table."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        names = [name for name in file.schema_arrow.names if asked((name,), request)]
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
        said = {key.decode(): text.decode() for key, text in (each.metadata or {}).items()}
        unit = said.get("unit") or said.get("units") or ""
        made.append(column(each.name, data.to_numpy(), unit))
    instants = [each["name"] for each in made if "instants" in each]
    if len(instants) > 1:
        raise Unfit(f"{called(instants)} all hold instants: keep the one that is the time")
    return answer(made)


def excel(path: str, request: dict[str, Any]) -> Answer:
    """Rows of a sheet of an Excel workbook: a few lines of text, then numbers."""
    import datetime

    import numpy as np
    from openpyxl import load_workbook

    book = load_workbook(path, read_only=True, data_only=True)
    names = book.sheetnames
    sheet = book[request.get("sheet") or names[0]] if (request.get("sheet") or names[0]) in names else None
    if sheet is None:
        raise Unfit(f"the sheets are {called(names)}")
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
    for i in range(len(rows[0])):
        each = [row[i] for row in rows]
        name = f"column {i + 1}"
        if all(isinstance(v, datetime.datetime) for v in each):
            made.append(column(name, np.array(each, dtype="datetime64[ns]")))
        elif all(isinstance(v, datetime.time) for v in each):
            made.append(column(name, np.array([of_day(v) for v in each], dtype="timedelta64[us]")))
        else:
            made.append(column(name, np.array(each, dtype=object)))
    arrays, texts, listed = answer(made)
    return arrays, {**texts, "head": json.dumps(head[-3:]), "sheets": json.dumps(names)}, listed


def of_day(at: Any) -> int:
    """Microseconds of a clock since midnight."""
    return int(((at.hour * 60 + at.minute) * 60 + at.second) * 1_000_000 + at.microsecond)


def complex_row(values: list[Any]) -> bool:
    """Whether a row has complex numbers as texts, which is how a sheet holds them."""
    try:
        for value in values:
            number("", value)
    except ValueError:
        return False
    return any(not isinstance(value, str) for value in values)


def full(path: str, request: dict[str, Any]) -> Answer:
    """Stiffness and mass of ANSYS as entries, with node and direction of each row."""
    import numpy as np
    from ansys.mapdl.reader import read_binary

    points, *matrices = read_binary(path).load_km(as_sparse=True, sort=False)
    arrays = {"points": np.asarray(points, dtype=np.int64).reshape(-1, 2)}
    for name, matrix in zip("KM", matrices, strict=True):
        entries = matrix.tocoo()
        arrays |= {f"{name}.row": entries.row, f"{name}.col": entries.col, f"{name}.data": entries.data}
    room(sum(array.size for array in arrays.values()), request)
    return arrays, {}, []


READERS = {"full": full, "tdms": tdms, "wav": wav, "mseed": mseed, "parquet": parquet, "excel": excel}
