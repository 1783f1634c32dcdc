"""The text of a CSV or TSV file as names, units and numbers."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import compress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import UnsuitableDataError, reject
from ..signals.frequency_response import FrequencyResponse
from ..support.checks import FloatArray, choice, finite_scalar
from ..support.messages import warn
from .channels import Channel, chosen, recording_of, response_of, warn_other_rate
from .common import TO_ALIGN, Signal, rate_of, unsuitable, usual_rate
from .options import Reading
from .raw_arrays import given_lines, lines_of_axis
from .units import Unit, abscissa_factor, is_abscissa, is_frequency

# -- Columns of text that are one complex response together: two parts of it, or magnitude and phase

#: What two neighbouring columns may be.
PAIRS = ("real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad")
_WORDS = {
    "re": ("re", "real"),
    "im": ("im", "imag", "imaginary"),
    "mag": ("mag", "magnitude", "amp", "ampl", "amplitude", "abs", "modulus"),
    "phase": ("phase", "angle", "arg"),
}
_PART = {word: part for part, words in _WORDS.items() for word in words}
_ANY = "|".join(sorted(_PART, key=len, reverse=True))
_NAME = re.compile(
    rf"^(?:(?P<w1>{_ANY})(?: part)?(?:[ _.(]+(?P<b1>.+?)\)?)?|(?P<b2>.+?)[ _.]+(?P<w2>{_ANY})(?: part)?)$",
    re.IGNORECASE,
)
_ANGLES = dict.fromkeys(("deg", "degree", "degrees", "°"), "deg")
_ANGLES |= dict.fromkeys(("rad", "radian", "radians"), "rad")
_LINEAR = ("lin", "linear", "abs")
_DEGREES = 60.0  # radians of a phase do not reach it within a band
_PER_TURN = {"deg": np.pi / 180.0, "rad": 1.0}


class Part(NamedTuple):
    """One column: which part it is ('' for none), of which response, in which unit."""

    part: str
    base: str
    unit: str

    @property
    def is_plain(self) -> bool:
        """Whether the unit says how the part is written, not what it measures."""
        return is_part_unit(self.unit) or self.unit.strip().lower() in _LINEAR


def is_part_unit(text: str) -> bool:
    """Whether the text is a unit that only magnitudes and phases have."""
    return text.strip().lower() in _ANGLES or _is_level(text)


def part_of(name: str, unit: str = "") -> Part:
    """What the name of a column says."""
    match = _NAME.match(name.strip())
    if match is None:
        return Part("", name, unit)
    base = (match["b1"] or match["b2"] or "").strip()
    if base and not unit and is_part_unit(base):
        base, unit = "", base
    return Part(_PART[(match["w1"] or match["w2"]).lower()], base, unit)


def joined(file: Path, columns: list[Channel], pairs: str | None, over_freq: bool) -> list[Channel]:
    """The columns with every pair, told by ``pairs`` or by names, made one; '' where it has no name."""
    if pairs is not None:
        choice("pairs", pairs, PAIRS)
        if len(columns) % 2 == 0:
            found = f"with {len(columns) - 1} columns beside the first"
            unsuitable(file, found, f"two for each response, as {pairs=} says")
    out: list[Channel] = []
    rest = list(columns)
    while rest:
        column = rest.pop(0)
        here, after = (part_of(c.name, c.unit) for c in (column, rest[0] if rest else Channel("", ())))
        kinds, kind = (here.part, after.part) if here.base == after.base else ("", ""), ""
        if pairs is not None and out:
            kind = pairs
        elif kinds == ("re", "im"):
            kind = "real_imag"
        elif kinds == ("mag", "phase") and over_freq:
            kind = _pair_of(file, column, here, after, rest[0].values)
        if kind:
            unit = "" if kind.startswith("db") or here.is_plain else column.unit
            name = here.base if all(kinds) or not here.part else ""
            column = Channel(name, _complex(kind, column.values, rest.pop(0).values), unit)
        out.append(column)
    return out


def _pair_of(file: Path, level_of: Channel, level: Part, angle: Part, phases: Any) -> str:
    """Which of ``PAIRS`` a magnitude and a phase are, by their units, else by numbers that leave no doubt."""
    turn, linear = _ANGLES.get(angle.unit.strip().lower()), level.is_plain or Unit.of(level.unit).quantity
    size = "db" if _is_level(level.unit) else "magnitude" if linear else ""
    name, guessed = level_of.name, []
    if not size and np.any(np.asarray(level_of.values) < 0.0):  # as no magnitude is
        size, guessed = "db", ["magnitudes in dB, as some are negative"]
    if not turn and not angle.unit and _DEGREES < np.abs(phases).max() <= 720.0:
        turn, guessed = "deg", [*guessed, "phases in degrees, by their size"]
    if not turn or not size:
        lacks = ["the unit of the phase"] * (not turn) + ["whether it is in dB"] * (not size)
        found = f"which does not tell of {name!r} {' nor '.join(lacks)}"
        wanted = "headers such as 'Magnitude [g/N]' or 'Magnitude [dB]' and 'Phase [deg]' or 'Phase [rad]'"
        unsuitable(file, found, wanted, f"Pass pairs= as one of {', '.join(PAIRS[1:])}.")
    if guessed:
        said = f"path: {str(file)!r} is read with {' and '.join(guessed)}. Say it by pairs='{size}_{turn}'."
        warn("no_unit", said)
    return f"{size}_{turn}"


def _complex(kind: str, first: Any, second: Any) -> Any:
    if kind == "real_imag":
        return first + 1j * second
    size, turn = kind.split("_")
    magnitude = 10.0 ** (first / 20.0) if size == "db" else first
    return magnitude * np.exp(1j * _PER_TURN[turn] * second)


def _is_level(text: str) -> bool:
    return text.strip().lower().startswith("db")


# -- Instants in the first column, or in the second behind the number of the row

_HEAD = 200  # rows in which the first instant is looked for

_INSTANT = re.compile(  #: An instant, as ISO 8601 has it, or with slashes.
    r"(\d{4})[-/](\d\d)[-/](\d\d)(?:[T ](\d\d:\d\d)(?::(\d\d)(?:[.,](\d{1,9}))?)?)?(Z|[+-]\d\d:?\d\d)?\Z"
)


def _instants_as_time(file: Path, rows: list[list[str]]) -> tuple[int | None, str, float]:
    """Put the time since the first instant in its place, as fine as written; its column, unit and start."""
    there = (c for row in rows[:_HEAD] for c, text in enumerate(row[:2]) if _INSTANT.match(text))
    column = next(there, None)
    middle = rows[len(rows) // 2 :][:3]  # the date of a test in the header is no column
    if column is None or not any(len(row) > column and _INSTANT.match(row[column]) for row in middle):
        return None, "", 0.0
    told = ((i, _INSTANT.match(row[column])) for i, row in enumerate(rows) if len(row) > column)
    found = {i: match for i, match in told if match}
    start = min(found)
    odd = next((i for i in range(start, len(rows) - 1) if i not in found), None)
    if odd is not None:
        got = f"whose row {odd - start + 1}, {' '.join(rows[odd])[:40]!r}, has no instant as others have"
        unsuitable(file, got, "an instant in every row")
    digits = max(len(match[6] or "") for match in found.values())
    unit, per_s = next((u, n) for u, n in (("s", 0), ("ms", 3), ("us", 6), ("ns", 9)) if digits <= n)
    try:
        at = {i: _instant(match) for i, match in found.items()}
    except ValueError as exc:
        unsuitable(file, f"with an instant that is none ({exc})", "days and times that exist")
    for i, each in at.items():
        rows[i][column] = str(int((each - at[start]) / np.timedelta64(1, "ns")) // 10 ** (9 - per_s))
    return column, unit, float((at[start] - np.datetime64(0, "ns")) / np.timedelta64(1, "s"))


def _instant(match: re.Match[str]) -> np.datetime64:
    year, month, day, clock, second, part, zone = match.groups()
    time = f"{clock or '00:00'}:{second or '00'}.{(part or '').ljust(9, '0')}"
    at = np.datetime64(f"{year}-{month}-{day}T{time}", "ns")
    if zone in (None, "Z"):
        return at
    shift = np.timedelta64(int(zone[1:3]) * 60 + int(zone[-2:]), "m")
    return at - shift if zone[0] == "+" else at + shift


# -- Layouts of loggers and analysers
#
# Columns under rows that are called by what they hold: CH No., Range, ..., Unit (KYOWA PCD).

_UNITS = ("unit", "units", "einheit")
_NAMES = re.compile(r"(ch|channel|signal|sensor|kanal)\b|name\b", re.IGNORECASE)
_RATE = re.compile(r"sampl\w*[ _]?(rate|freq)\w*", re.IGNORECASE)


def labelled_rows(rows: Sequence[Sequence[str]], width: int) -> tuple[list[str], list[str]] | None:
    """Names and units of the columns where each row above them says first what it holds; None for others."""
    own = next((row for row in reversed(rows) if len(row) == width and row[0].lower() in _UNITS), None)
    if own is None:
        return None
    named = (row for row in reversed(rows) if len(row) == width and _NAMES.match(row[0]) and all(row[1:]))
    names = next(named, ["", *(f"channel {i}" for i in range(1, width))])
    return ["", *names[1:]], ["", *own[1:]]


def stated_rate_hz(rows: Sequence[Sequence[str]]) -> float | None:
    """What a row such as ``Sampling Rate(Hz),50`` says; None without one."""
    stated = (row for row in rows if len(row) > 1 and _RATE.match(row[0]) and "khz" not in row[0].lower())
    number = next((row[1] for row in stated if re.fullmatch(r"[\d.]+", row[1])), "0")
    return float(number) or None


# -- One response a file (PULSE): "Header Size:", "X-Axis unit:", "Signal:", tags; number, x, real, imaginary


def pulse_columns(head: Sequence[str], width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns."""
    pairs = (line.partition(":") for line in head)
    said = {key.strip().lower(): value.strip() for key, _, value in pairs}
    x = next((said[key] for key in ("x-axis unit", "x-axis units", "x-axisunit") if key in said), "")
    unit, base = said.get("amplitudeunit", ""), said.get("signal", "").strip("()") or "response"
    values = [base] if width < 4 else [f"re({base})", f"im({base})"]
    names = ["", "Time" if x.lower() in ("s", "ms") else "Frequency", *values]
    return names[-width:], ["", x, *[unit] * len(values)][-width:]


# -- Sensors with a counter of packets and a clock of 32 bits in microseconds (Movella, Xsens DOT)

_MOVELLA = {"acc": "m/s2", "freeacc": "m/s2", "gyr": "deg/s", "euler": "deg", "mag": "a.u.", "quat": "1"}
_CLOCK = "SampleTimeFine"


def unwrapped(ticks: FloatArray) -> FloatArray:
    """The readings of a counter of 16, 24 or 32 bits that began again at zero, as if it had more."""
    steps = np.diff(ticks)
    down = steps < 0.0
    if not down.any() or np.any(ticks != np.rint(ticks)):
        return ticks
    usual = float(np.median(steps))
    for bits in (16, 24, 32):
        fixed = steps[down] + 2.0**bits
        even = fixed.min() > 0.0 and fixed.max() <= 1000.0 * usual < 2.0 ** (bits - 1)
        if even and ticks.max() < 2.0**bits:
            return np.concatenate([ticks[:1], ticks[0] + np.cumsum(steps + 2.0**bits * down)])
    return ticks


# -- A text as a table

MARK, VERSION = "# antires_rs csv", 1  # first line of our files
_MOST_HEAD = 12  # lines of their header at most
_COMMENT, _NUMBERS = ("#", "%", "//"), "numbers in every column"
_MANTISSA = re.compile(r"\(?[-+]?([\d.,]*)(?:[eE]([-+]?\d+))?")
_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]$")
#: The sign of an imaginary part between blanks, 1 + 2i, or its unit after one.
_SPACED = re.compile(r"[ \t]*([+-])[ \t]*([0-9.,]+(?:[eE][+-]?\d+)?[ij])\b")


@dataclass
class Table:
    """Numbers of a file, one row a line, real or complex; what is not stated is empty."""

    header: dict[str, Any] = field(default_factory=dict)  # of our ``# name: JSON`` lines
    names: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)
    values: NDArray[Any] = field(default_factory=lambda: np.empty((0, 0)))
    problem: str = ""  # what is cut
    digits: tuple[float, float] = (1e-9, 1e-9)  # relative rounding of the first two columns
    instants: int | None = None  # the column that had instants
    began_s: float = 0.0  # the first of them, since 1970
    rate_hz: float | None = None  # which its header states

    def columns(self) -> list[Channel]:
        """The columns as they stand; those of complex text are complex even if real, but for the first."""
        first, *rest = self.values.T
        values = [first if np.any(first.imag) else first.real, *rest]
        names = self.names or [f"column {i + 1}" for i in range(len(values))]
        return list(map(Channel, names, values, self.units or [""] * len(values)))


def table_of(file: Path, delimiter: str | None, decimal: str | None) -> Table:
    """Comments, names and numbers; a last row that is cut is left out and told of."""
    text = decoded(file)
    if "\x00" in text:
        unsuitable(file, "with bytes that are no text", "a text file")
    table, ended, lines = Table(), text.endswith("\n"), text.splitlines()
    if text.startswith(MARK) or any(line.startswith("# crc32: ") for line in lines[:_MOST_HEAD]):
        _header(file, lines, table)
    body = [line.rstrip() for line in lines if line.strip() and not line.lstrip().startswith(_COMMENT)]
    middle = body[len(body) // 2 : -1] or body[:1]
    trailing = delimiter is None and len(body) > 1 and all(map(_trails, middle))
    if trailing:  # some programs end every row with a delimiter, and with it the names or not
        trailing = not _trails(body[-1])
        body, ended = [line.rstrip()[:-1] if _trails(line) else line for line in body], ended and not trailing
    between = delimiter or _delimiter(body)
    split = [_split(line, between) for line in body]
    table.instants, unit, table.began_s = _instants_as_time(file, split)
    point = decimal if decimal is not None else "," if _decimal_commas(split, between) else "."
    start = next((i for i, row in enumerate(split) if _numeric(row, point)), len(split))
    if start == len(split):
        middle = split[len(split) // 2] if split else []
        odd = next((f": {part[:40]!r} is none" for part in middle if not _numeric([part], point)), "")
        unsuitable(file, f"without a row of numbers{odd}", _NUMBERS, "Name the delimiter= and decimal=.")
    before = split[start - 1] if start else []
    if len(before) == len(split[start]) + 1 and _numeric(before[:-1], point):
        before.pop()  # a comment behind the first row
        start -= 1
    rows = split[start:]
    width = len(rows[0])
    for row in split[:start]:
        if len(row) == width > 1 and _numeric(row[:1], point):  # a row, not names
            unsuitable(file, f"whose row {' '.join(row)[:60]!r} is not numeric throughout", _NUMBERS)
    _headed(table, body[:start] or _commented_names(lines, between, width), between, width)
    if between == "," and len(table.names) != width and _cut_at_decimals(rows, len(table.names)):
        found = "whose decimal commas cannot be told from the commas between its columns"
        unsuitable(
            file, found, "decimal points, or semicolons between columns", "Export it again with either."
        )
    if not ended:
        # A number that lost its last digits still is one, so that only a line end proves the row whole.
        if len(rows[-1]) != width or "rows" in table.header or trailing:
            rows.pop()
            stated = f" of {table.header['rows']}" if "rows" in table.header else ""
            table.problem = f"row {len(rows) + 1}{stated} is cut, {len(rows)} are whole"
        else:
            said = "has no line end after its last row, whose last number may be cut"
            warn("cut_line", f"path: {str(file)!r} {said}. If it is whole, add one.")
    _fill(file, table, rows, point, width)
    _as_movella(table)
    if table.instants is not None:
        table.units = table.units or [""] * width
        table.units[table.instants] = unit
        if table.names:
            table.names[table.instants] = "time"
    return table


def _headed(table: Table, head: list[str], between: str | None, width: int) -> None:
    """Names, units and a rate of the lines above the numbers."""
    if between is None:  # "Frequency [Hz]" is one name
        head = [re.sub(r"(?<=\w)\s+([\[(])", r"\1", line) for line in head]
    above = [[part.strip('"') for part in _split(line, between)] for line in head]
    table.rate_hz = stated_rate_hz(above)
    pulse = bool(head) and head[0].startswith("Header Size:")
    told = pulse_columns(head, width) if pulse else labelled_rows(above, width)
    if told is None:
        named(table, above)
    else:
        table.names, table.units = told


def _as_movella(table: Table) -> None:
    """A sensor's own clock first; the row of zeros that it begins with is no sample."""
    if _CLOCK in table.names and len(table.values) > 2:
        others = [i for i, name in enumerate(table.names) if name not in ("PacketCounter", _CLOCK)]
        table.values = table.values[:, [table.names.index(_CLOCK), *others]]
        table.names, table.digits = ["time", *(table.names[i] for i in others)], (1e-12, 1e-12)
        kinds = (name.partition("_")[0].lower() for name in table.names[1:])
        table.units = ["us", *(_MOVELLA.get(kind, "") for kind in kinds)]
        moving = [i for i, name in enumerate(table.names) if name.startswith("Acc_")]
        table.values = table.values[1 if moving and not table.values[0, moving].any() else 0 :]


def _fill(file: Path, table: Table, rows: list[list[str]], point: str, width: int) -> None:
    """The numbers of the rows, and how they are rounded."""
    if table.names and len(table.names) != width:
        found, wanted = f"with {len(table.names)} names over {width} columns", "a name for each column"
        unsuitable(file, found, wanted, "Put names that hold the delimiter in double quotes.")
    short = next((i for i, row in enumerate(rows) if len(row) != width), None)
    if short is not None:
        row, n = " ".join(rows[short])[:60], len(rows[short])
        missing = ", ".join(map(repr, table.names[n : n + 5]))
        found = f"whose row {short + 1} of numbers, {row!r}, has {n} columns"
        unsuitable(file, found, f"{width}, as the first row" + f", with {missing}" * bool(missing))
    table.values = np.empty((0, width))
    if not rows:
        return
    is_complex = any(re.search(r"[0-9.] ?\*?[ij]\b", part) for row in rows[:20] for part in row)
    kind = np.complex128 if is_complex else np.float64
    plain: Iterable[str] = map(";".join, rows)
    if is_complex or point == ",":
        plain = (";".join(_plain(part, point) for part in row) for row in rows)
    try:
        table.values = np.loadtxt(plain, kind, comments=None, delimiter=";", ndmin=2)
    except ValueError as exc:
        unsuitable(file, f"with a value that is no number ({exc})", _NUMBERS)
    last = [[row[c] for row in rows[-1000:]] for c in range(min(width, 2))]
    digits = [_rounding(texts, table.values[:, c], point) for c, texts in enumerate(last)]
    table.digits = (digits[0], digits[-1])


_FEW = 10  # of fewer numbers all may end in a zero that is not written


def _rounding(column: list[str], values: NDArray[Any], point: str) -> float:
    """Half a unit in the last decimal place that a column shows, relative to its largest number.

    It is asked of the last rows, and there of the largest numbers unless these are few: where all have as
    many digits, late instants have the fewest places.
    """
    most = float(np.abs(values).max()) or 1.0
    large = np.abs(values[-len(column) :]) >= 10.0 ** np.floor(np.log10(most))
    places = []
    for text in compress(column, large) if large.sum() >= _FEW else column:
        match = _MANTISSA.match(text)  # of the real part of a complex one
        mantissa, exponent = match.groups() if match else ("", None)
        places.append(len(mantissa.partition(point)[2]) - float(exponent or 0))
    unit: float = 0.5 * 10.0 ** min(-max(places), 300.0)
    return max(unit / most, 1e-15)


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
            unsuitable(file, f"whose header is damaged at {name!r}", "a whole file of write_csv")
    if not isinstance(table.header.get("rows"), int):
        unsuitable(file, "whose header does not state its rows", "a whole file of write_csv")


def decoded(file: Path) -> str:
    """The text: UTF-8, UTF-16 by its mark (Excel's "Unicode text"), or else Latin-1."""
    raw = file.read_bytes()
    marked = raw.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = raw.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _trails(line: str) -> bool:
    return line.rstrip()[-1] in ",;"


def _delimiter(body: list[str]) -> str | None:
    """The sign that splits most lines in the middle, one of which may be damaged; None for spaces."""
    sample = body[max(len(body) // 2 - 2, 0) : len(body) // 2 + 3]
    often = (sign for sign in ("\t", ";", ",") if 2 * sum(sign in row for row in sample) > len(sample))
    return next(often, None)


def _decimal_commas(rows: list[list[str]], between: str | None) -> bool:
    """Whether the numbers have commas and no points; every row is asked, as some programs print 1 for 1,0."""

    def any_with(sign: str) -> bool:
        return any(any(sign in part for part in row) and _numeric(row, ",") for row in rows)

    return between != "," and any_with(",") and not any_with(".")


def _cut_at_decimals(rows: list[list[str]], n_names: int) -> bool:
    """Whether all parts are digits, twice as many as names, or with zeros in front as only decimals have."""
    some = rows[:_HEAD]
    digits = all(re.fullmatch(r"[-+]?\d+([eE][-+]?\d+)?", part) for row in some for part in row)
    twice = n_names > 0 and all(len(row) == 2 * n_names for row in some)
    return digits and (twice or any(re.match(r"[-+]?0\d|-0$", part) for row in some for part in row))


def _split(line: str, between: str | None) -> list[str]:
    if between is None:
        return line.split()
    parts = next(csv.reader([line], delimiter=between)) if '"' in line else line.split(between)
    return [part.strip() for part in parts]


def _plain(part: str, point: str) -> str:
    """A number as Python writes it."""
    if part[-1:] in ("i", "j", ")"):
        part = _SPACED.sub(r"\1\2", part).replace("i", "j")
    return part.replace(",", ".") if point == "," else part


def _numeric(parts: list[str], point: str) -> bool:
    try:
        for part in parts:
            complex(_plain(part, point))
    except ValueError:
        return False
    return bool(parts)


def named(table: Table, rows: list[list[str]]) -> None:
    """Put names and units, as the lines above the numbers have them, into the table."""
    if not rows:
        return
    names = rows[-1]
    second = rows[-2] if len(rows) > 1 else []
    # A line of units under the names: every part is one, in brackets or not; those beside a time or frequency
    # may be in V or in units that are not known.
    known = [Unit.of(part).known or is_abscissa(part) for part in names]
    if second and len(second) == len(names) and (is_abscissa(names[0]) or all(known)):
        table.names, table.units = second, [part.strip("[]() ") for part in names]
        return
    table.names, table.units = [], []
    for part in names:
        match = _UNIT.match(part)
        # "re(tip)" is a part of tip; "Phase (deg)" and "Real [g/N]" have a unit.
        is_unit = match and (is_part_unit(match[2]) or Unit.of(match[2]).quantity)
        has_unit = match and match[1] and (not part_of(part).part or "[" in part or is_unit)
        table.names.append(match[1] if match and has_unit else part)
        table.units.append(match[2] if match and has_unit else "")


def _commented_names(lines: list[str], between: str | None, width: int) -> list[str]:
    """Names in the last comment above the numbers, as numpy.savetxt writes them; only if they fit."""
    first = next(i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENT))
    above = lines[first - 1].lstrip().lstrip("#%/").strip() if first else ""
    parts = _split(above, between)
    return [above] if len(parts) == width > 1 and not any(_numeric([part], ".") for part in parts) else []


# -- Columns of a table by their names: a record over time, or responses over frequency

_FREQ = ("freq", "f", "hz", "frequency", "freq_hz")
_TIME = ("time", "t", "time_s", "s", "seconds", "timestamp", "datetime", "date", "date/time", "x_value")
#: What programs call the number of a row.
_INDEX = ("", "index", "unnamed: 0", "sample", "samples", "no", "no.", "nr", "nr.", "#", "row", "point")
#: First instants from which on they are in ns, us or ms since 1970.
_SINCE_1970 = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))


def signal_of_table(file: Path, table: Table, given: Reading) -> Signal:
    """The signal that the columns of a table are."""
    if given.first is not None:
        choice("first", given.first, ("time", "freq", "channel"))
    if given.freq_hz is not None or given.df_hz is not None:
        return _response_without_axis(file, table, given)
    columns, named = table.columns(), bool(table.names)
    digits, first = table.digits[0], given.first
    name = columns[0].name
    behind = table.instants == 1
    if first is None and table.rate_hz is not None and not name and not is_abscissa(columns[0].unit):
        span = float(columns[0].values[-1] - columns[0].values[0])
        steps = span * table.rate_hz / (columns[0].values.size - 1)
        first = "time" if abs(steps - 1.0) < 1e-3 else None  # as the rate in the header tells
    counts = first is None and given.pairs is None and _counts(columns[0].values, behind)
    if counts and (name.lower() in _INDEX or not named):
        after = columns[1] if len(columns) > 1 else None
        timed = after and (after.name.lower() in _TIME or _says_frequency(after, named) or behind)
        if not timed and given.fs_hz is None:
            found = f"whose first column, {name!r}, counts the rows, and no column is a time or a frequency"
            remedy = "Pass fs_hz=, or first='time' if it is the time in s."
            if len(columns) % 2:  # two for each response
                remedy += " If it is the frequency in Hz, pass pairs='real_imag' or another of its kinds."
            unsuitable(file, found, "a sampling rate or a column of time", remedy)
        columns = columns[1:]
        digits, first = table.digits[1], None if timed else "channel"
    hertz = first == "freq" or given.pairs is not None or _says_frequency(columns[0], named)
    columns = joined(file, columns, given.pairs, hertz)
    if first is None:
        first = _what_first(file, columns, hertz, given.fs_hz is not None)
    lead, rest = columns[0], columns if first == "channel" else columns[1:]
    if not rest:
        unsuitable(file, "with no column of values", "at least one beside the first")
    channels = chosen(file, _called(rest, named), given)
    if first == "freq":
        return _response(file, lead.values.real * _into_si(file, lead), channels, given)
    if any(np.iscomplexobj(c.values) for c in columns):
        unsuitable(file, "with complex columns over time", "real ones", "Pass first='freq'.")
    if first == "channel":
        rate = finite_scalar("fs_hz", given.fs_hz, low=0.0, low_open=True, unit="Hz")
        return recording_of(file, channels, rate, given)
    return _over_time(file, table, lead, channels, digits, given)


def _over_time(
    file: Path, table: Table, lead: Channel, channels: list[Channel], digits: float, given: Reading
) -> Signal:
    """A record over its column of instants."""
    rate = given.rate_hz
    instants = unwrapped(lead.values) * _into_si(file, lead, lead.values)
    clock = instants + table.began_s
    if given.align:
        return recording_of(file, channels, rate or usual_rate(file, instants), given, clock)
    if rate is None:
        rate = rate_of(file, instants, digits=digits, remedy=TO_ALIGN)
        return recording_of(file, channels, rate, given, clock)
    with suppress(UnsuitableDataError):  # instants that say nothing are why a rate was given
        warn_other_rate(file, "has instants at", rate_of(file, instants, digits=digits), rate)
    return recording_of(file, channels, rate, given)


def _what_first(file: Path, columns: list[Channel], hertz: bool, rated: bool) -> str:
    """What the first column is."""
    lead = columns[0]
    if lead.name.lower() in _TIME or (not hertz and is_abscissa(lead.unit)):
        return "time"
    if hertz or any(np.iscomplexobj(c.values) for c in columns):
        return "freq"
    if lead.values[0] < lead.values[-1] and np.all(np.diff(lead.values) >= 0.0):  # as a time
        found = f"whose first column, {lead.name!r}, ascends but is neither called time nor frequency"
        unsuitable(file, found, "to know what it is", "Pass first='time', first='freq' or first='channel'.")
    if not rated:
        found = "without a column of time or frequency"
        unsuitable(file, found, "a sampling rate", "Pass fs_hz=, in samples a second.")
    return "channel"


def _says_frequency(column: Channel, named: bool) -> bool:
    """Whether name or unit of a column say that it is a frequency."""
    return (named and column.name.lower() in _FREQ) or is_frequency(column.unit)


def _response(file: Path, lines: Any, columns: list[Channel], given: Reading) -> FrequencyResponse:
    if not all(np.iscomplexobj(c.values) for c in columns):
        wanted = "complex ones, or pairs such as re(x), im(x) or 'Magnitude [dB]', 'Phase [deg]'"
        how = f"Pass pairs={PAIRS[0]!r} or another of its kinds if two columns are one response."
        unsuitable(file, "with real columns over frequency", wanted, how)
    return response_of(file, lines, columns, given)


def _response_without_axis(file: Path, table: Table, given: Reading) -> FrequencyResponse:
    """All columns as responses over a given axis."""
    columns, named = table.columns(), bool(table.names)
    wanted = "it where no column is an axis"
    option = "df_hz" if given.freq_hz is None else "freq_hz"
    lines = given_lines(file, given, columns[0].values.size)
    if given.first not in (None, "channel"):
        reject(option, f"it beside first={given.first!r}", wanted, "Leave one of them out.")
    if _says_frequency(columns[0], named):
        reject(option, f"it for a file with the column {columns[0].name!r}", wanted, "Leave it out.")
    if len(columns) > 1 and given.pairs is None and lines_of_axis(columns[0].values) is not None:
        got = "it for a file whose first column ascends in even steps as a frequency does"
        reject(option, got, wanted, "Leave it out, and pass first='freq'.")
    # An empty column in front: every one of the file is a value, also where the first is real.
    columns = chosen(file, columns, given)
    joint = joined(file, [Channel("", np.zeros(lines.size)), *columns], given.pairs, True)[1:]
    if np.iscomplexobj(table.values):
        joint = [replace(c, values=np.asarray(c.values, dtype=np.complex128)) for c in joint]
    return _response(file, lines, _called(joint, named), given)


def _called(columns: list[Channel], named: bool) -> list[Channel]:
    """The columns by their names, or their numbers; one that is called force is the force of a record."""
    names = [c.name if named and c.name else i for i, c in enumerate(columns)]
    roles = ["force" if c.name.lower() == "force" else "" for c in columns]
    return [replace(c, name=name, role=role) for c, name, role in zip(columns, names, roles, strict=True)]


def _into_si(file: Path, lead: Channel, instants: Any = None) -> float:
    """Factor of the first column into s or Hz; a unit that is not known would move every frequency."""
    text = lead.unit.strip()
    if is_abscissa(text):
        return abscissa_factor(text)
    if not Unit.of(text).known or Unit.of(text).quantity:
        found = f"whose first column, {lead.name!r}, is in {text!r}"
        unsuitable(file, found, "a unit of time or frequency: s, ms, us, min, h, Hz, kHz, rad/s")
    # Seconds since 1970 stay below 1e11 for 3,000 years, so that larger ones are in a smaller unit.
    largest = 0.0 if instants is None else float(np.abs(instants[0]))
    return next((factor for least, factor in _SINCE_1970 if largest >= least), 1.0)


def _counts(values: Any, anywhere: bool) -> bool:
    """Whether a column is 0, 1, 2, ... or 1, 2, 3, ..., or counts from ``anywhere``."""
    if np.iscomplexobj(values) or values.size < 3 or not (anywhere or values[0] in (0.0, 1.0)):
        return False
    return bool(np.array_equal(values, values[0] + np.arange(values.size)))
