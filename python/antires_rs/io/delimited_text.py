"""The text of a CSV or TSV file as names, units and numbers."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import unsuitable
from .column_pairs import is_part_unit, part_of
from .instants import without_count, without_instants
from .units import is_abscissa, parse_unit

__all__ = ["MARK", "Table", "named", "table_of"]

#: First line of our files.
MARK, VERSION = "# antires_rs csv", 1
_COMMENT = ("#", "%", "//")
_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]$")


#: The sign of an imaginary part between blanks, 1 + 2i, or its unit after one.
_SPACED = re.compile(r"[ \t]*([+-])[ \t]*([0-9.,]+(?:[eE][+-]?\d+)?[ij])\b")


@dataclass
class Table:
    """Numbers of a file, one row a line.

    Attributes
    ----------
    header : dict
        The JSON values of ``# name: value`` lines; empty for files of other programs.
    names, units : list of str
        By column; ``names`` is empty where the file has none.
    values : (n_rows, n_columns)
        Real or complex.
    problem : str
        What is cut; empty for a whole file.
    digits : (float, float)
        Relative rounding of the first two columns, by their digits.
    """

    header: dict[str, Any] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)
    values: NDArray[Any] = field(default_factory=lambda: np.empty((0, 0)))
    problem: str = ""
    digits: tuple[float, float] = (1e-9, 1e-9)

    def columns(self) -> tuple[list[str], list[str], list[Any]]:
        """Names, units and values of the columns as they stand."""
        n = self.values.shape[1]
        columns = [c if np.any(c.imag) else c.real for c in self.values.T]
        if np.iscomplexobj(self.values):
            # A column of complex text is complex even where its imaginary part vanishes; the first is not.
            columns = [columns[0], *self.values.T[1:]]
        return self.names or [f"column {i + 1}" for i in range(n)], self.units or [""] * n, columns


def table_of(file: Path, delimiter: str | None, decimal: str | None) -> Table:
    """Comments, names and numbers; a last row that is cut is left out and told of."""
    text = _decoded(file)
    if "\x00" in text:
        unsuitable(
            file, "with bytes that are no text", "a text file", "Export it as text: numbers in columns."
        )
    table, ended = Table(), text.endswith(("\n", "\r"))
    lines = text.splitlines()
    if text.startswith(MARK):
        _header(file, lines, table)
    body = [line for line in lines if line.strip() and not line.lstrip().startswith(_COMMENT)]
    trailing = (
        delimiter is None and len(body) > 1 and all(map(_trails, body[len(body) // 2 : -1] or body[:1]))
    )
    if trailing:  # some programs end every row with a delimiter, and with it the names or not
        whole = _trails(body[-1])
        body = [line.rstrip()[:-1] if _trails(line) else line for line in body]
        ended, trailing = ended and whole, not whole
    between = delimiter if delimiter is not None else _delimiter(body)
    body, instants = without_instants(file, without_count(body, between), between)
    point = decimal if decimal is not None else "," if _decimal_commas(body, between) else "."
    start = next((i for i, line in enumerate(body) if _numeric(line, between, point)), len(body))
    if start == len(body):
        unsuitable(
            file,
            f"without a row of numbers{_first_odd(body, between, point)}",
            "columns of numbers",
            Wording("Name the {} and {}.", Passed("delimiter"), Passed("decimal")),
        )
    rows = body[start:]
    width = len(_split(rows[0], between))
    for line in body[:start]:
        parts = _split(line, between)
        if len(parts) == width > 1 and _numeric(parts[0], None, point):  # a row, not names
            unsuitable(
                file,
                f"whose row {line.strip()[:60]!r} is not numeric throughout",
                "numbers in every column",
                "Mend or remove that row.",
            )
    _names(table, body[:start] or _commented_names(lines, between, width), between)
    if not ended:
        # A number that lost its last digits still is one, so that only a line end proves the row whole.
        cut = len(_split(rows[-1], between)) != width or "rows" in table.header or trailing
        stated = f" of {table.header['rows']}" if "rows" in table.header else ""
        if cut:
            rows.pop()
            table.problem = f"row {len(rows) + 1}{stated} is cut, {len(rows)} are whole"
        else:
            _warn_end(file)
    _fill(file, table, rows, between, point, width)
    if instants:
        table.names[:1] = ["time"] if table.names else []
        table.units = [instants, *(table.units[1:] or [""] * (width - 1))]
    return table


def _fill(file: Path, table: Table, rows: list[str], between: str | None, point: str, width: int) -> None:
    if table.names and len(table.names) != width:
        unsuitable(
            file,
            f"with {len(table.names)} names over {width} columns",
            "a name for each column",
            "Put names that hold the delimiter in double quotes.",
        )
    for i, row in enumerate(rows):
        got = len(_split(row, between))
        if got != width:
            missing = ", ".join(map(repr, table.names[got : got + 5]))
            unsuitable(
                file,
                f"whose row {i + 1} of numbers, {row.strip()[:60]!r}, has {got} columns",
                f"{width}, as the first row" + (f", with {missing}" if missing else ""),
                "It was cut or damaged: complete or remove that row.",
            )
    if not rows:
        table.values = np.empty((0, width))
        return
    plain = "\n".join(between.join(_split(row, between)) if between and '"' in row else row for row in rows)
    if point == ",":
        plain = plain.replace(",", ".")
    is_complex = bool(re.search(r"[0-9.] ?\*?[ij]\b", plain[:2000]))
    if is_complex:
        if between is not None:
            plain = _SPACED.sub(r"\1\2", plain)
        plain = re.sub(r"(?<=[0-9.])i\b", "j", plain)
    try:
        values = np.loadtxt(
            plain.splitlines(),
            delimiter=between,
            ndmin=2,
            comments=None,
            dtype=np.complex128 if is_complex else np.float64,
        )
    except ValueError as exc:
        unsuitable(
            file,
            f"with a value that is no number ({exc})",
            "numbers in every column",
            "Correct or remove that value.",
        )
    table.values = values
    digits = [_rounding(rows, c, table.values[:, c], between, point) for c in range(min(width, 2))]
    table.digits = (digits[0], digits[-1])


def _rounding(rows: list[str], c: int, values: NDArray[Any], between: str | None, point: str) -> float:
    """Half a unit in the last decimal place that a column ever shows, relative to its largest number."""
    places = max(_places(_split(row, between)[c], point) for row in rows[:1000])
    largest = float(np.abs(values).max()) or 1.0
    return max(0.5 * 10.0**-places / largest, 1e-15)


def _places(number: str, point: str) -> int:
    """Decimal places of a number; of the real part of a complex one."""
    match = re.match(r"\(?[-+]?([\d.,]*)(?:[eE]([-+]?\d+))?", number.strip())
    mantissa, exponent = (match[1], match[2]) if match else ("", None)
    return len(mantissa.partition(point)[2]) - int(exponent or 0)


def _header(file: Path, lines: list[str], table: Table) -> None:
    """Our own ``# name: JSON`` lines."""
    version = lines[0][len(MARK) :].strip()
    if version != str(VERSION):
        unsuitable(file, f"of version {version!r}", f"version {VERSION} or older", "Update antires_rs.")
    for line in lines[1:]:
        if not line.startswith("# "):
            break
        name, _, value = line[2:].partition(": ")
        try:
            table.header[name] = json.loads(value)
        except ValueError:
            unsuitable(
                file,
                f"whose header is damaged at {name!r}",
                "a whole file of write_csv",
                "Write it again; leave the lines at the top as they are.",
            )
    if not isinstance(table.header.get("rows"), int):
        unsuitable(file, "whose header does not state its rows", "a whole file of write_csv", "It was cut.")


def _delimiter(body: list[str]) -> str | None:
    """The sign that splits most lines in the middle of the file; None for spaces."""
    middle = len(body) // 2
    sample = body[max(middle - 2, 0) : middle + 3]  # one of them may be damaged
    often = (sign for sign in ("\t", ";", ",") if 2 * sum(sign in line for line in sample) > len(sample))
    return next(often, None)


def _decoded(file: Path) -> str:
    """The text: UTF-8, UTF-16 by its mark (Excel's "Unicode text"), or else Latin-1."""
    raw = file.read_bytes()
    names = ("utf-16",) if raw.startswith((b"\xff\xfe", b"\xfe\xff")) else ("utf-8-sig",)
    for name in (*names, "latin-1"):
        try:
            return raw.decode(name).replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeDecodeError:
            continue
    raise AssertionError("Latin-1 has every byte")


def _trails(line: str) -> bool:
    return line.rstrip()[-1] in ",;"


def _first_odd(body: list[str], between: str | None, point: str) -> str:
    """The field that is no number in the middle of the file, for an error."""
    line = body[len(body) // 2] if body else ""
    odd = next((part for part in _split(line, between) if not _numeric(part, None, point)), "")
    return f": {odd.strip()[:40]!r} in {line.strip()[:60]!r} is none" if odd.strip() else ""


def _decimal_commas(body: list[str], between: str | None) -> bool:
    """Whether the numbers have commas and no points; every row is asked, as some programs print 1 for 1,0."""

    def any_with(sign: str) -> bool:
        return any(sign in line and _numeric(line, between, ",") for line in body)

    return between != "," and any_with(",") and not any_with(".")


def _split(line: str, between: str | None) -> list[str]:
    if between is None:
        return line.split()
    return next(csv.reader([line], delimiter=between)) if '"' in line else line.split(between)


def _numeric(line: str, between: str | None, point: str) -> bool:
    parts = [p.strip().replace("i", "j") for p in _split(line, between)]
    if between is not None and "j" in line.replace("i", "j"):
        parts = [_SPACED.sub(r"\1\2", p) for p in parts]
    try:
        for part in parts:
            complex(part.replace(",", ".") if point == "," else part)
    except ValueError:
        return False
    return bool(parts)


def _names(table: Table, head: list[str], between: str | None) -> None:
    """Names and units of the lines of text above the numbers."""
    if between is None:  # "Frequency [Hz]" is one name
        head = [re.sub(r"(?<=\w)\s+([\[(])", r"\1", line) for line in head]
    rows = [[part.strip().strip('"') for part in _split(line, between)] for line in head]
    named(table, rows)


def named(table: Table, rows: list[list[str]]) -> None:
    """Put names and units, as the lines above the numbers have them, into the table."""
    if not rows:
        return
    names = rows[-1]
    second = rows[-2] if len(rows) > 1 else []
    bracketed = [_UNIT.match(part) for part in names]
    # A line of units under the names: every part is one, in brackets or not.
    if (
        second
        and len(second) == len(names)
        and (
            is_abscissa(names[0])  # the others may be in V or in units that are not known
            or all(parse_unit(part) is not None or is_abscissa(part) for part in names)
        )
    ):
        table.names, table.units = second, [_bare(part) for part in names]
        return
    # "re(tip)" is a part of tip; "Phase (deg)" and "Real [g/N]" have a unit.
    has_unit = [
        bool(m and m[1]) and (part_of(part) is None or "[" in part or _is_unit(m[2] if m else ""))
        for m, part in zip(bracketed, names, strict=True)
    ]
    table.names = [
        m[1] if m and has else part for m, has, part in zip(bracketed, has_unit, names, strict=True)
    ]
    table.units = [m[2] if m and has else "" for m, has in zip(bracketed, has_unit, strict=True)]


def _is_unit(text: str) -> bool:
    known = parse_unit(text)
    return is_part_unit(text) or (known is not None and bool(known.quantity))


def _commented_names(lines: list[str], between: str | None, width: int) -> list[str]:
    """Names in the last comment above the numbers, as numpy.savetxt writes them; only if they fit."""
    first = next(i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENT))
    above = lines[first - 1].lstrip().lstrip("#%/").strip() if first else ""
    fits = len(_split(above, between)) == width and width > 1
    return [above] if fits and not any(_numeric(part, None, ".") for part in _split(above, between)) else []


def _bare(part: str) -> str:
    return part.strip("[]() ")


def _warn_end(file: Path) -> None:
    warn(
        "cut_line",
        f"path: {str(file)!r} has no line end after its last row, whose last number may be cut. "
        "If it is whole, add one.",
    )
