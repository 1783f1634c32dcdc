"""Universal files: dataset 58, functions at nodal dofs, in text or binary form.

The format is documented by the Structural Dynamics Research Laboratory, University of Cincinnati, after SDRC.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..exceptions import AntiresError, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.spectra import std_of_coherence
from ..support.checks import FloatArray, choice
from ..support.directions import DIRECTIONS, point_of
from ..support.files import write_atomically
from ..support.messages import warn
from .channels import Channel, one_quantity, recording_of, unit_or_warning
from .common import (
    Signal,
    choose_run,
    existing_file,
    missing_part,
    rate_of,
    refuse_real,
    simplest_rate,
    unsuitable,
)
from .options import PathLike, Reading, reader, writer
from .own_format import check_dofs
from .units import Unit, abscissa_factor

__all__ = ["list_uff", "read_uff", "write_uff"]

# -- Where the datasets of a universal file begin and end, found without trusting any of them
#
# A dataset lies between two lines ``    -1``. The file does not say how many there are, nor that one is
# short; so each dataset 58 is measured against the number of points in its own header.

#: A line of its own: ``-1`` in the first six columns and nothing else.
_MARKER = re.compile(rb"(?:\A|(?<=[\r\n])) {4}-1[ ]*(?=[\r\n]|\Z)")
_LINE_END = re.compile(rb"\r?\n|\r")
_HEADER_LINES = 11
#: By ordinate type: numbers per point, width in text, bytes in binary form.
_FORMS = {2: (1, 13, 4), 4: (1, 20, 8), 5: (2, 13, 4), 6: (2, 20, 8)}
_FORTRAN = re.compile(rb"(?<=[0-9.])[Dd](?=[+-]?[0-9])")  # the exponent of a Fortran double, 1.5D+03


@dataclass(frozen=True)
class Dataset:
    """One dataset, and what is wrong with it; the rest is of a 58 alone."""

    number: int  # its type, 0 if that cannot be read
    start: int  # with the markers
    stop: int
    problem: str = ""
    points: int = 0  # as its header states
    lines: tuple[str, ...] = ()  # of the header, with that of the type
    at: int = 0  # where its numbers begin
    item: int = 0  # bytes of each in binary form


_INK = re.compile(rb"[^ \r\n\t\x1a\x00]")


def scan(data: bytes) -> list[Dataset]:
    """Every dataset of a file, in order; the last may have a problem."""
    found: list[Dataset] = []
    position = 0
    while _INK.search(data, position):
        begin = _MARKER.search(data, position)
        stray = data[position : begin.start() if begin else len(data)]
        if stray.strip(b" \r\n\t\x1a\x00"):
            problem = f"{len(stray)} bytes at byte {position} belong to no dataset"
            found.append(Dataset(0, position, position + len(stray), problem))
        if begin is None:
            break
        dataset = _dataset(data, begin.start(), begin.end())
        found.append(dataset)
        position = dataset.stop
    if data[position:].lstrip(b"\r\n"):
        # Blanks without a line end are the beginning of a marker.
        tail = data[position:].rpartition(b"\n")[2]
        if tail.strip(b"\r\x1a\x00"):
            found.append(Dataset(0, position, len(data), "it is cut in its first line"))
    return found


def _dataset(data: bytes, start: int, after: int) -> Dataset:
    while data[after : after + 1] == b" ":
        after += 1
    at, _ = _line(data, after)
    at, identity = _line(data, at)
    try:
        number, binary = int(identity[:6]), identity[6:7].lower() == b"b"
    except ValueError:
        number, binary = 0, False
    problem = "" if number else "its type cannot be read"
    lines: list[str] = [identity.decode("utf-8", "replace")]
    if number == 58:
        for _ in range(_HEADER_LINES):
            at, line = _line(data, at)
            lines.append(line.decode("utf-8", "replace"))
        try:
            kind, points, even = (int(lines[7][i : i + 10]) for i in (0, 10, 20))
            per_point, width, size = _FORMS[kind]
        except (ValueError, KeyError):
            problem = "its header is cut or damaged"
    end = _MARKER.search(data, at)
    if number != 58 or problem:
        stop, problem = (end.end(), problem) if end else (len(data), problem or "it has no end")
        return Dataset(number, start, stop, problem)
    made = Dataset(58, start, len(data), "", points, tuple(lines), at)
    numbers = per_point + (0 if even else 1)
    if binary:
        return _binary(data, made, numbers, size)
    rows = data[at : end.start() if end else len(data)].splitlines()
    # Fields are 13 or 20 wide; an abscissa, where there is one, has 13.
    there = sum(len(line.rstrip()) for line in rows) // (width * per_point + (0 if even else 13))
    if there != points and _to_the_left(rows, width if even or width == 13 else 0):
        there = sum(len(line.split()) for line in rows) // numbers
    return _judged(made, end, there)


def _to_the_left(rows: Iterable[bytes], width: int) -> bool:
    """Whether numbers, or a blank for their sign, begin their fields: blanks behind belong to them."""
    places = (each.start() % width for row in rows for each in re.finditer(rb"\S+", row)) if width else ()
    return max(places, default=2) < 2


def _binary(data: bytes, made: Dataset, numbers: int, size: int) -> Dataset:
    """The end is where the number of points says; the number of bytes beside it is often wrong."""
    for each in dict.fromkeys((size, 8)):  # Some programs write single precision as double.
        at = made.at + made.points * numbers * each
        end = re.compile(rb"[\r\n]{0,2} {4}-1[ ]*(?=[\r\n]|\Z)").match(data, at) if at >= made.at else None
        if end:
            return replace(made, stop=end.end(), item=each)
    marker = re.compile(rb" {4}-1[ ]*(?=[\r\n]|\Z)").search(data, made.at)
    there = ((marker.start() if marker else len(data)) - made.at) // (numbers * size)
    return _judged(made, marker, min(there, made.points), short=True)


def _judged(made: Dataset, end: re.Match[bytes] | None, there: int, short: bool = False) -> Dataset:
    if end is None:
        return replace(made, problem=f"it has no end and {min(there, made.points)} of {made.points} points")
    problem = f"it has {there} points, not the {made.points} that its header states"
    return replace(made, stop=end.end(), problem=problem if short or there != made.points else "")


def _line(data: bytes, at: int) -> tuple[int, bytes]:
    """Where the next line begins, and this one without its end."""
    end = _LINE_END.search(data, at)
    return (end.end(), data[at : end.start()]) if end else (len(data), data[at:])


def numbers_of(data: bytes, dataset: Dataset) -> NDArray[np.float64]:
    """The numbers of a 58 without a problem, abscissae among them; ValueError for other text."""
    kind, even = (int(dataset.lines[7][i : i + 10]) for i in (0, 20))
    per_point, width, _ = _FORMS[kind]
    count = dataset.points * (per_point + (0 if even else 1))
    if dataset.item:
        order = "<" if dataset.lines[0][7:13].strip() == "1" else ">"
        return np.frombuffer(data, f"{order}f{dataset.item}", count, dataset.at).astype(np.float64)
    rows = _FORTRAN.sub(b"E", data[dataset.at : dataset.stop]).splitlines()[:-1]
    words = b" ".join(rows).split()
    if len(words) != count:  # numbers may touch
        widths = [width] if even or width == 13 else [13] + per_point * [width]
        ends = np.cumsum([0, *(widths * (max(map(len, rows)) // sum(widths) + 1))]).tolist()
        fields = [row[a:b] for row in rows for a, b in zip(ends, ends[1:], strict=False)]
        words = [field for field in fields if field.strip()]
    if len(words) != count:
        raise ValueError(f"{len(words)} numbers of {count}")
    return np.array(words, dtype=np.float64)


# -- Names of the universal file's points: node and direction, ``12+Z``, and back

Point = tuple[int, int]  # node and direction code


def label_of(point: Point) -> str:
    """``'12+Z'`` of (12, 3)."""
    return f"{point[0]}{DIRECTIONS.get(point[1], f'?{point[1]}')}"


def as_point(argument: str, value: Any) -> Point:
    """(12, 3) of ``(12, '+Z')``, ``(12, 'Z')``, ``(12, 3)`` or ``'12+Z'``."""
    if isinstance(value, tuple) and len(value) == 2:
        node, way = value
        value = f"{node}:{DIRECTIONS.get(way, way) if isinstance(way, int) else way}"
    point = point_of(value) if isinstance(value, str) else None
    if point is None:
        wanted = "a node and a direction, such as (12, '+Z'), (12, 3) or '12+Z'"
        reject(argument, repr(value), wanted, "Directions are +X to -Z, or 1 to 6 with a sign.")
    return point


def dof_of(dofs: Any, own: Mapping[Point, Any]) -> Callable[[Point], tuple[Any, float]]:
    """Function from a point to its dof and sign: a mapping with ``12+Z`` alone takes ``-Z`` turned round.

    ``own`` are the dofs that files of ours state: "node 2 u" is the name of one before it is a point.
    """
    if dofs is None:
        return lambda point: (own.get(point, label_of(point)), 1.0)
    if callable(dofs):
        return lambda point: (dofs(point[0], DIRECTIONS.get(point[1], "?")), 1.0)
    if not isinstance(dofs, Mapping):
        wanted = "a mapping {(node, direction): dof} or a function of the two"
        reject("dofs", type(dofs).__name__, wanted, "List the points with antires_rs.io.list_uff.")
    named = list(own.values())
    table = {as_point("dofs", key): dof for key, dof in dofs.items() if key not in named}

    def look_up(point: Point) -> tuple[Any, float]:
        if isinstance(own.get(point), str) and own[point] in dofs:
            return dofs[own[point]], 1.0
        for at, sign in ((point, 1.0), ((point[0], -point[1]), -1.0)):
            if at in table:
                return table[at], sign
        remedy = "Map a point to None to leave it out; antires_rs.io.list_uff shows all points."
        reject("dofs", f"no dof for {label_of(point)}", "a dof for every response of the file", remedy)

    return look_up


def points_of(dofs: tuple[Any, ...], given: Any) -> dict[Any, Point]:
    """Node and direction of each dof, for writing: given, read from the label, or numbered."""
    if not (given is None or callable(given) or isinstance(given, Mapping)):
        wanted = "a mapping {dof: (node, direction)} or a function of the dof"
        reject("dofs", given, wanted, "Leave it out where dofs are numbers or labels like '3+Z'.")
    points: dict[Any, Point] = {}
    for dof in dofs:
        if isinstance(given, Mapping) and dof not in given:
            reject("dofs", f"no node and direction for {dof!r}", f"one for each of {dofs}", "Add it to dofs.")
        own = point_of(dof) if isinstance(dof, str) else None
        if given is not None:
            points[dof] = as_point("dofs", given[dof] if isinstance(given, Mapping) else given(dof))
        elif own is not None and label_of(own) == dof:
            points[dof] = own
        elif isinstance(dof, int) and 0 <= dof < 999_999_999:
            points[dof] = dof + 1, 0
    free = max((node for node, _ in points.values()), default=0) + 1
    points |= {dof: (free + i, 0) for i, dof in enumerate([dof for dof in dofs if dof not in points])}
    twice = next((point for point, n in Counter(points.values()).items() if n > 1), None)
    if twice is not None:
        got = f"{label_of(twice)} for two dofs"
        reject("dofs", got, "a point of its own for each", "Give one of them another node or direction.")
    return points


# -- The functions of a universal file

#: Function types of record 6 that are read.
FUNCTIONS = {1: "time", 2: "auto spectrum", 3: "cross spectrum", 4: "frf", 5: "transmissibility"}
FUNCTIONS |= {6: "coherence", 9: "auto spectrum"}
FORCES, _OVER_TIME = (9, 13), 17  # specific data types of a force, and of an abscissa of time
#: What a function without labels is in, by its specific data type, after dataset 164 was heeded.
_SI = {8: "m", 11: "m/s", 12: "m/s2", 9: "N", 13: "N"}
#: ID line 2 of our files, with the place of the set among all that were written together.
MARK = re.compile(r"^antires_rs uff (\d+) set (\d+) of (\d+)$")
VERSION = 1
WANTED = "a whole universal file with datasets 58"


@dataclass(frozen=True)
class Function:
    """One dataset 58, ``what`` being one of ``FUNCTIONS`` or "function type n"."""

    what: str
    response: Point
    reference: Point
    x: NDArray[np.float64]
    values: NDArray[Any]
    unit: str  #: Of the ordinate and its denominator.
    reference_unit: str = ""
    role: str = ""
    even: bool = False
    step: float = 0.0
    scale: float = 1.0  # into SI by the units of dataset 164, for functions without a unit of their own
    x_unit: float = 1.0  # unit of the abscissa in the file, in s or Hz
    #: What our writer adds: dof, exact rate or abscissa, averages.
    own: dict[str, Any] = field(default_factory=dict)

    @property
    def at(self) -> str:
        """``'12+Z'``, the point of the response."""
        return label_of(self.response)

    @property
    def place(self) -> str:
        """``'12+Z / 1+X'``, response and reference; of a record the point alone."""
        return self.at + ("" if self.what == "time" else f" / {label_of(self.reference)}")

    def __str__(self) -> str:
        unit = self.unit + (f" / {self.reference_unit}" if self.reference_unit else "") or "no unit"
        return f"{self.what:<16} {self.place}, {self.values.size} points, {unit}"


def functions_of(file: Path, partial: bool) -> list[Function]:
    """Every dataset 58 of a file, none lost in silence."""
    data = file.read_bytes()
    datasets = scan(data)
    if not datasets or all(d.number == 0 for d in datasets):
        unsuitable(file, "without a dataset between lines '    -1'", WANTED)
    functions: list[Function] = []
    factors: dict[int, float] = {}
    for i, dataset in enumerate(datasets, start=1):
        if dataset.problem or dataset.number not in (58, 164):
            continue
        try:
            if dataset.number == 58:
                functions.append(_function(file, i, dataset, numbers_of(data, dataset), factors))
            else:  # what SI is to be multiplied by
                text = _FORTRAN.sub(b"E", data[dataset.start : dataset.stop]).split(b"\n", 3)[3]
                factors = _factors(file, *map(float, text.split()[:2]))
        except AntiresError:
            raise
        except (ValueError, LookupError, TypeError) as exc:
            unsuitable(file, f"whose dataset {i} cannot be read ({exc})", WANTED)
    kept = len(functions)
    bad = [(i, d) for i, d in enumerate(datasets) if d.problem]
    if bad:
        i, first = bad[0]
        of = next((f" of {f.own['of']}" for f in functions if "of" in f.own), "")
        problem = f"dataset {i + 1} ({first.number or 'unknown'}) is damaged: {first.problem}"
        missing_part(file, f"{problem}; {kept}{of} functions are whole", WANTED, partial, kept)
    else:
        _check_marks(file, functions, partial)
    if not functions:
        unsuitable(file, f"with {len(datasets)} datasets and no 58 among them", WANTED)
    return functions


def nodes_of(path: PathLike) -> dict[int, tuple[float, ...]]:
    """Coordinates in m of the nodes of a universal file, datasets 15, 781 and 2411, by their numbers."""
    file = existing_file(path)
    data, per_m, nodes = file.read_bytes(), 1.0, dict[int, tuple[float, ...]]()
    try:
        for each in scan(data):
            rows = _FORTRAN.sub(b"E", data[each.start : each.stop]).decode("latin-1").splitlines()[2:-1]
            if each.number == 164:
                per_m = float(rows[1].split()[0])
            elif each.number == 15:
                cells = (row.split() for row in rows)
                nodes |= {int(c[0]): tuple(map(float, c[4:7])) for c in cells}
            elif each.number in (781, 2411):
                heads = zip(rows[::2], rows[1::2], strict=True)
                nodes |= {int(head.split()[0]): tuple(map(float, row.split()[:3])) for head, row in heads}
    except (ValueError, IndexError) as exc:
        unsuitable(file, f"whose nodes cannot be read ({exc})", "nodes in datasets 15, 781 or 2411")
    if not (per_m > 0.0 and all(len(xyz) == 3 and np.isfinite(xyz).all() for xyz in nodes.values())):
        unsuitable(file, "with nodes that are no three numbers", "nodes in datasets 15, 781 or 2411")
    return {node: tuple(x / per_m for x in xyz) for node, xyz in nodes.items()}


def _factors(file: Path, length: float, force: float) -> dict[int, float]:
    """Into SI by dataset 164, for specific data types of motions and of forces."""
    if not (np.isfinite([length, force]).all() and length > 0.0 and force > 0.0):
        unsuitable(file, f"whose units (dataset 164) have the factors {length:g} and {force:g}", WANTED)
    return dict.fromkeys((8, 11, 12), 1.0 / length) | dict.fromkeys(FORCES, 1.0 / force)


def _function(
    file: Path, i: int, dataset: Dataset, numbers: NDArray[np.float64], factors: dict[int, float]
) -> Function:
    """A set as its header says: points in record 6, abscissa in 7, data and units of the axes in 8 to 10."""
    lines = dataset.lines
    kind, *points = (_whole(lines[6][a:b]) for a, b in ((0, 5), (41, 51), (51, 55), (66, 76), (76, 80)))
    form, even = int(lines[7][:10]), int(lines[7][20:30]) == 1
    first, step = (float(_FORTRAN.sub(b"E", lines[7][a : a + 13].encode())) for a in (30, 43))
    step = step if even else 0.0
    over, above, below = (_whole(line[:10]) for line in lines[8:11])
    axis, unit, per = (line[46:67].strip() for line in lines[8:11])
    what = FUNCTIONS.get(kind, f"function type {kind}")
    if kind == 0 and over == _OVER_TIME:
        what = "time"
    columns = numbers.reshape(dataset.points, -1).T
    x: Any = first + np.arange(dataset.points) * step if even else columns[0]
    values = columns[-2] + 1j * columns[-1] if form in (5, 6) else columns[-1].copy()
    if not (np.isfinite(values).all() and np.isfinite(x).all()):
        unsuitable(file, f"whose dataset {i} has values that are not finite", WANTED)
    own = _own(lines, first, step)
    into_si = abscissa_factor(axis)  # The format has s and Hz; some programs label what they wrote in ms.
    if even and not into_si * step > 0.0:
        unsuitable(file, f"whose dataset {i} has a step of {into_si * step:g}", "a positive step")
    x, step = into_si * x, into_si * step
    if "start" in own:
        x = own["start"] + own["step"] * np.arange(values.size)
    unit, per = ("" if text.upper() == "NONE" else text for text in (unit, per))
    scale = 1.0
    if not (unit or per):
        scale = factors.get(above, 1.0) / factors.get(below, 1.0)
        unit, per = _SI.get(above, ""), _SI.get(below, "")
    response, reference = (points[0], points[1]), (points[2], points[3])
    role = "force" if above in FORCES else ""
    return Function(what, response, reference, x, values, unit, per, role, even, step, scale, into_si, own)


def _whole(text: str) -> int:
    """A whole number of the header; 0 where the field is empty."""
    return int(text) if text.strip() else 0


def _own(lines: Sequence[str], first: float, step: float) -> dict[str, Any]:
    """What our writer adds, as far as it agrees with the header."""
    match = MARK.match(lines[2].strip())
    if match is None or int(match[1]) > VERSION:
        return {}
    own: dict[str, Any] = {"set": int(match[2]), "of": int(match[3])}
    for line in lines[4:6]:
        try:
            own |= json.loads(line[:80])
        except (ValueError, TypeError):
            break
    numbers = [own.get(name, 0.0) for name in ("start", "step", "rate_hz", "n_averages")]
    pairs = [(own.get(name, stated), stated) for name, stated in (("start", first), ("step", step))]
    agree = all(isinstance(n, int | float) for n in numbers)
    agree = agree and all(f"{exact:.5e}" == f"{stated:.5e}" for exact, stated in pairs)
    if agree and ("start" in own) == ("step" in own) == (step > 0.0):
        return own
    return {name: value for name, value in own.items() if name in ("set", "of", "dof")}


def _check_marks(file: Path, functions: list[Function], partial: bool) -> None:
    """Files of ours state how many sets were written together."""
    expected, kept = 1, len(functions)
    marks = [(f.own["set"], f.own["of"]) for f in functions if "set" in f.own]
    for number, count in marks:
        if number != expected:
            missing_part(file, f"set {expected} of {count} is missing", WANTED, partial, kept)
        expected = 1 if number == count else number + 1
    if expected != 1:
        number, count = marks[-1]
        missing_part(file, f"{number} of {count} sets are there", WANTED, partial, kept)


# -- FRFs, transmissibilities and spectra of a universal file as a FrequencyResponse


def response_of(
    file: Path, functions: list[Function], kind: str, named: Any, reference: Any, unit: str | None
) -> FrequencyResponse:
    """The response of all points to one reference; its kind, coherence and averages."""
    names = ("auto spectrum", "cross spectrum") if kind == "spectra" else (kind,)
    wanted = [f for f in functions if f.what in names]
    if kind == "spectra" and all(f.what == "auto spectrum" for f in wanted):
        found = f"with {len(wanted)} auto spectra, the first of {wanted[0].at}, and no cross spectrum"
        instead = "time records, FRFs, or cross spectra with the auto spectrum of their reference"
        unsuitable(file, found, instead, "Power spectra have lost the phase: export one of these instead.")
    point = _reference(file, [f for f in wanted if kind != "spectra" or f.response != f.reference], reference)
    if kind == "spectra":
        wanted, is_force = _over_auto(file, wanted, point, unit)
        kind = "frf" if is_force else "transmissibility"
    else:
        wanted = [f for f in wanted if f.reference == point]
    beside = [f for f in functions if f.what == "coherence" and f.reference == point]
    lines = frequencies(wanted[0])
    for f in (*wanted, *beside):
        if f.x.size != lines.size or np.abs(frequencies(f) - lines).max() > 1e-6 * lines[-1]:
            unsuitable(file, f"with other frequencies at {f.at} than at {wanted[0].at}", "one axis for all")
    refuse_real(file, [(f"{f.what} of {f.at}", f.values) for f in wanted])
    if unit is None:  # receptances beside accelerances: their quotients are no transmissibilities
        kept_ones = [f for f in wanted if named(f.response)[0] is not None]
        kinds = [(f.at, Unit.of(f.unit).quantity) for f in kept_ones]
        one_quantity(file, [(label, each, each or "in no known unit") for label, each in kinds])
    rows = {f.response: _values(file, f, unit) for f in wanted}
    coherence = _coherence(file, functions, point, rows)
    if kind == "transmissibility" and point not in rows:
        rows[point] = np.ones(lines.size, dtype=np.complex128)
        if coherence is not None:
            coherence[point] = np.ones(lines.size)
    labels = {p: named(p) for p in rows}
    kept = [p for p, (dof, _) in labels.items() if dof is not None]
    is_frf = kind == "frf"
    # The reference of transmissibilities may itself point the other way.
    turn = 1.0 if is_frf or point not in kept else labels[point][1]
    values = np.stack([rows[p] * (labels[p][1] * turn) for p in kept])
    seen = None if coherence is None else np.stack([coherence[p] for p in kept])
    averages = next((f.own["n_averages"] for f in wanted if "n_averages" in f.own), None)
    dofs, reference = [labels[p][0] for p in kept], None if is_frf else named(point)[0]
    made_of: Any = "frf" if is_frf else "transmissibility"
    return FrequencyResponse(lines, values, dofs, made_of, reference, seen, averages)


def frequencies(f: Function) -> FloatArray:
    """Frequencies without the rounding of first line and step to six digits, as far as it can be undone."""
    if not f.even or "start" in f.own or f.x.size < 2:
        return f.x
    half = half_digit(f.step, f.x_unit)
    step = 1.0 / simplest_rate(1.0 / (f.step + half), 1.0 / (f.step - half))  # 0.333333 is 1/3
    first = step * round(float(f.x[0]) / step)
    start = first if abs(first - f.x[0]) <= half_digit(float(f.x[0]), f.x_unit) else float(f.x[0])
    return np.asarray(start + step * np.arange(f.x.size), dtype=np.float64)


def half_digit(value: float, unit: float = 1.0) -> float:
    """Half of the sixth digit, as E13.5 rounds a value in ``unit``, and a little more."""
    if value == 0.0:
        return 0.0
    digit: float = 10.0 ** (float(np.floor(np.log10(abs(value / unit)))) - 5.0)
    return unit * 0.50001 * digit


def _reference(file: Path, functions: list[Function], given: Any) -> Point:
    points = list(dict.fromkeys(f.reference for f in functions))
    chosen = points if given is None else [p for p in points if p == as_point("reference", given)]
    if len(chosen) == 1:
        return chosen[0]
    responses = {f.at for f in functions}
    remedy = "Choose it by reference=."
    if given is None and len(responses) == 1:
        stayed = f"roving={responses.pop()!r}"
        remedy = f"If the hammer roved and this sensor stayed, pass {stayed}; else choose one by reference=."
    found = f"with the references {', '.join(map(label_of, points)) or 'none'}"
    unsuitable(file, found, "one" if given is None else f"reference={given!r}", remedy)


def _values(file: Path, f: Function, unit: str | None) -> NDArray[Any]:
    """Values in SI."""
    if unit is not None:
        factor = Unit.named(unit).factor
    else:
        above, below = (unit_or_warning(file, text) for text in (f.unit, f.reference_unit))
        # Some programs write the whole quotient into the numerator's label.
        factor = f.scale * above.factor / (1.0 if above.per else below.factor)
    values: NDArray[Any] = f.values.astype(np.complex128)
    return values if factor == 1.0 else values * factor


def _coherence(
    file: Path, functions: list[Function], point: Point, rows: dict[Point, Any]
) -> dict[Point, FloatArray] | None:
    """Coherences of these rows with the reference; those of no function, or of some rows, are told of."""
    coherences = [f for f in functions if f.what == "coherence"]
    pairs = {(f.response, f.reference) for f in functions if f.what != "coherence"} | {(point, point)}
    odd = [f.place for f in coherences if (f.response, f.reference) not in pairs]
    found = {f.response: f.values.real for f in coherences if f.reference == point and f.response in rows}
    lost = [label_of(p) for p in rows if p not in found] if found else []
    said = f"of other points than its functions, {', '.join(odd)}" if odd else ""
    said = f"of {len(found)} of {len(rows)} responses, not of {', '.join(lost)}" if lost else said
    if said:
        wanted = f"Wanted are those of the functions' directions with the reference {label_of(point)}"
        warn("coherence_left_out", f"path: {str(file)!r} has coherences {said}; they are left out. {wanted}.")
    return found if found and not lost else None


def _over_auto(
    file: Path, spectra: list[Function], point: Point, unit: str | None
) -> tuple[list[Function], bool]:
    """Cross spectra over the auto spectrum of their reference, and whether that is a force."""
    autos = [f for f in spectra if f.what == "auto spectrum" and f.response == point]
    autos = [f for f in autos if f.reference in (point, (0, 0))]
    crosses = [f for f in spectra if f.what == "cross spectrum" and f.reference == point != f.response]
    if len(autos) != 1 or not crosses:
        found = f"with {len(crosses)} cross spectra and {len(autos)} auto spectra of {label_of(point)}"
        unsuitable(file, found, "cross spectra, and one auto spectrum of their reference")
    power = autos[0].values.real
    if power.min() <= 0.0:
        found = f"with an auto spectrum of {label_of(point)} that is not positive everywhere"
        unsuitable(file, found, "a reference that was never dead")
    single = autos[0].unit or crosses[0].reference_unit
    is_force = autos[0].role == "force" or Unit.of(single).quantity == "force"
    if is_force and unit is None and any(f.scale != 1.0 for f in (*autos, *crosses)):
        found = "with spectra without units where dataset 164 names others than SI"
        unsuitable(file, found, "the unit of their quotient", "Pass unit=, such as 'mm/s2/N'.")
    odd = next((f for f in crosses if f.values.shape != power.shape), None)
    if odd is not None:
        found = f"with {odd.values.size} lines at {odd.at} and {power.size} of the reference"
        unsuitable(file, found, "one frequency axis")
    return [replace(f, values=f.values / power, reference_unit=single, scale=1.0) for f in crosses], is_force


# -- FRFs of a hammer that roved while a sensor stayed, as those of a force at the sensor
#
# By reciprocity H_sk = H_ks: the response at the sensor s to a force at k is the response at k to a force
# at s.


def roved(file: Path, functions: list[Function], sensor: Any) -> list[Function]:
    """FRFs and coherences of the sensor, response and reference exchanged."""
    point = as_point("roving", sensor)
    curves = [f for f in functions if f.what in ("frf", "coherence")]
    chosen = [f for f in curves if f.response == point]
    if not any(f.what == "frf" for f in chosen):
        there = ", ".join(dict.fromkeys(f.at for f in curves if f.what == "frf")) or "none"
        found, wanted = f"with FRFs at the responses {there}", f"FRFs of roving={label_of(point)!r}"
        unsuitable(file, found, wanted, "Name the sensor that stayed while the hammer roved.")
    kept = [{name: value for name, value in f.own.items() if name != "dof"} for f in chosen]
    pairs = zip(chosen, kept, strict=True)
    return [replace(f, response=f.reference, reference=f.response, own=own) for f, own in pairs]


# -- Universal files in which points were recorded several times


def _runs_of(functions: list[Function]) -> list[tuple[Function, int]]:
    """The functions with their run: 1 where a point comes first, 2 where it comes again, ..."""
    seen: Counter[Any] = Counter()
    runs = []
    for f in functions:
        key = f.what, f.place, f.role
        seen[key] += 1
        runs.append((f, seen[key]))
    return runs


def one_run(file: Path, functions: list[Function], run: int | None) -> list[Function]:
    """The functions of one run, never chosen unasked; points without that run are left out with a warning."""
    runs = _runs_of(functions)
    again = [(f, n) for f, n in runs if n > 1 and f.what != "coherence"]
    most = max((n for _, n in again), default=1)
    if run is None and again:
        found = f"with several functions ({again[0][0].what}) of {again[0][0].place}: {most} runs"
        unsuitable(file, found, "one for each point", choose_run(most))
    if run is not None and not (type(run) is int and 1 <= run <= most):
        reject("run", run, f"1 to {most}, the runs of {str(file)!r}", "Number the runs from 1.")
    if not again:
        return functions
    chosen = [f for f, n in runs if n == run]
    there = {(f.what, f.place, f.role) for f in chosen}
    lost = dict.fromkeys(f.at for f in functions if (f.what, f.place, f.role) not in there)
    if lost:
        said = f"has no run {run} of {', '.join(lost)}, which is left out."
        warn("points_without_run", f"path: {str(file)!r} {said}")
    return chosen


#: Kinds by what a function is, where they differ.
_KIND_OF = {"auto spectrum": "spectra", "cross spectrum": "spectra"}


@reader(".uff .unv .uf .u58")
def read_uff(
    path: PathLike,
    *,
    kind: Literal["time", "frf", "transmissibility", "spectra"] | None = None,
    dofs: Any = None,
    reference: Any = None,
    force: Any = "auto",
    unit: str | None = None,
    run: int | None = None,
    roving: Any = None,
    partial: bool = False,
) -> Signal:
    """Read dataset 58 of a universal file, in text or binary form.

    Parameters
    ----------
    kind : {"time", "frf", "transmissibility", "spectra"}, optional
        What to read, where a file holds several. Cross spectra S_jp (mean of X_p times the conjugate of X_j)
        over the auto spectrum of their reference become FRFs where that is a force, and transmissibilities
        otherwise (H1). Coherences go with the values they belong to.
    dofs : mapping or callable, optional
        ``{(node, direction): dof}`` or a function of both, direction being ``'+Z'``, ``'-RX'`` or ``'S'``;
        None leaves a channel out. A mapping with ``(12, '+Z')`` takes a channel in ``-Z`` with its sign
        changed. Default: labels such as ``'12+Z'``; in files of ours, the dofs that were written.
    reference, force : str or (int, str), optional
        Reference point, where a file has several: ``'1+X'`` or ``(1, '+X')``; and force channel of a record:
        "auto" is the only one in N or of that ordinate type, None leaves it out.
    unit : str, optional
        Unit of the responses, in place of the file's labels. Without labels the units of dataset 164 hold,
        where there is one, and SI otherwise.
    run : int, optional
        Which run to read, from 1, where points were recorded several times; identify from all of them:
        ``identify_antiresonances([run 1, run 2], ...)``.
    roving : str or (int, str), optional
        The sensor that stayed while the hammer roved, ``'5+Z'``: its FRFs to all references become, by
        reciprocity, those of the references to a force at that sensor. Name it as the excitation then.

    Notes
    -----
    One of another program that was cut between two sets lacks the rest without a trace; ours are numbered.
    Steps have six digits in the format: the simplest that fits is taken (1.95313E-03 s is 512 Hz).

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     record = ar.Recording([[1.0, 2.0, 4.0, 3.0]], 512.0, dofs=["12+Z"])
    ...     file = ar.write_uff(folder + "/a.uff", record)
    ...     ar.read_uff(file, dofs={(12, "+Z"): 4})
    Recording(1 channels, 0.0078125 s at 512 Hz, dofs=(4,), no force)
    """
    file = existing_file(path)
    if kind is not None:
        choice("kind", kind, ("time", "frf", "transmissibility", "spectra"))
    functions = functions_of(file, partial)
    if roving is not None:
        functions = roved(file, functions, roving)
    kinds = (_KIND_OF.get(f.what, f.what) for f in functions)
    there = [k for k in dict.fromkeys(kinds) if k != "coherence" and not k.startswith("function type")]
    chosen = there[0] if kind is None and len(there) == 1 else kind
    if chosen not in there:
        found = f"with {', '.join(there) or 'no function that can be read'}"
        held = "; ".join(map(str, functions[:10]))
        remedy = f"Pass kind={' or '.join(map(repr, there))}." if there else f"It holds {held}."
        unsuitable(file, found, "one kind of function" if kind is None else f"kind={kind!r}", remedy)
    wanted = [f for f in functions if _KIND_OF.get(f.what, f.what) in (chosen, "coherence")]
    functions = one_run(file, wanted, run)
    own = {f.response: f.own["dof"] for f in functions if f.own.get("dof") is not None}
    named = dof_of(dofs, own)
    if chosen == "time":
        return _recording(file, [f for f in functions if f.what == "time"], named, force, unit)
    return response_of(file, functions, str(chosen), named, reference, unit)


def list_uff(path: PathLike, *, partial: bool = False) -> list[str]:
    """One line for each function of a universal file: what it is, where, how long, in which unit, which run.

    Parameters
    ----------
    path, partial
        As in :func:`~antires_rs.read_uff`, and so are the errors.

    Returns
    -------
    list of str

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_uff(folder + "/a.uff", ar.Recording([[1.0, 2.0, 4.0]], 512.0, dofs=["12+Z"]))
    ...     print(*ar.io.list_uff(file))
    time             12+Z, 3 points, m/s2
    """
    runs = _runs_of(functions_of(existing_file(path), partial))
    several = max((run for _, run in runs), default=1) > 1
    return [f"{f}, run {run}" if several else str(f) for f, run in runs]


def _recording(file: Path, functions: list[Function], named: Any, force: Any, unit: str | None) -> Recording:
    rates = {_rate(file, f) for f in functions}
    starts = {round(float(f.x[0]), 9) for f in functions}
    if len(rates) > 1 or len(starts) > 1:
        found = f"with records of rates {sorted(rates)} Hz that begin at {sorted(starts)} s"
        unsuitable(file, found, "channels recorded together", "Read them one by one.")
    channels = []
    for f in functions:
        if np.iscomplexobj(f.values):
            unsuitable(file, f"with a complex time record of {f.at}", "real ones")
        scale = 1.0 if unit is not None and f.role != "force" else f.scale
        channels.append(Channel(f.response, f.values * scale, f.unit, role=f.role))
    if force not in ("auto", None):
        force = as_point("force", force)
    signs: dict[Any, float] = {}

    def dof(point: Point) -> Any:
        label, sign = named(point)
        signs[label] = sign
        return label

    made = recording_of(file, channels, rates.pop(), Reading(dofs=dof, force=force, unit=unit))
    return Recording(made.responses * [[signs[d]] for d in made.dofs], made.fs_hz, made.dofs, made.force)


def _rate(file: Path, f: Function) -> float:
    if "rate_hz" in f.own:
        return float(f.own["rate_hz"])
    if not f.even:
        return rate_of(file, f.x, digits=5e-6)
    half = half_digit(f.step, f.x_unit)
    return simplest_rate(1.0 / (f.step + half), 1.0 / (f.step - half))


def force_of(path: PathLike) -> str | None:
    """Point of the force, ``'12+Z'``, by references or channels; None where the file does not tell one."""
    functions = functions_of(existing_file(path), True)
    points = {f.reference for f in functions if f.what == "frf"}
    points |= {f.response for f in functions if f.what == "time" and f.role == "force"}
    known = {point for point in points if point[0] > 0 and point[1] != 0}
    return label_of(known.pop()) if len(points) == 1 and known else None


# -- Signals as datasets 58

#: Function types of record 6 that are written, and their titles in ID line 1.
_WRITTEN = {"time": (1, "Time Response"), "frf": (4, "Frequency Response Function")}
_WRITTEN |= {"transmissibility": (5, "Transmissibility"), "coherence": (6, "Coherence")}
#: Specific data types of records 8 to 10.
_DATA = {"": 0, "displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}


@writer
def write_uff(
    path: PathLike,
    signal: Signal,
    *,
    binary: bool = True,
    unit: str | None = None,
    dofs: Mapping[Any, Any] | Callable[[Any], Any] | None = None,
    excitation: Any = None,
) -> Path:
    """Write dataset 58 for every channel, whole or not at all.

    Parameters
    ----------
    binary : bool
        Double precision in binary form (58b), bit for bit; otherwise text of 12 digits.
    unit : str, optional
        SI unit of the values: ``'m/s2'`` by default, for FRFs ``'m/s2/N'``.
    dofs : mapping or callable, optional
        ``{dof: (node, direction)}``, such as ``(12, '+Z')``. Default: read from labels such as ``'12+Z'``;
        other dofs become scalars of nodes of their own. The dofs themselves are kept in the ID lines.
    excitation : int or str or (int, str), optional
        Point of the force: one of the dofs, or a node and direction. Not known by default.

    Raises
    ------
    InvalidInputError
        The folder does not exist, a unit that is not SI, two dofs at one point, labels that do not fit.

    Notes
    -----
    The header has six digits; ID lines 2, 4 and 5 have the place among all sets, rate and frequencies in full
    and the dof. Standard deviations that coherence and averages do not tell are lost, with a warning.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> record = ar.Recording([[1.0, 2.0, 4.0]], 512.0, dofs=["12+Z"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_uff(folder + "/a.uff", record, binary=False)
    ...     print(file.read_text().splitlines()[-2].split())
    ['1.00000000000e+00', '2.00000000000e+00', '4.00000000000e+00']
    """
    check_dofs(signal)
    points = points_of(signal.dofs, dofs)
    force = None
    if excitation is not None:
        known = isinstance(excitation, int | str) and excitation in points
        force = points[excitation] if known else as_point("excitation", excitation)
    make = _of_recording if isinstance(signal, Recording) else _of_response
    functions = make(signal, points, force, unit)  # type: ignore[arg-type]
    blocks = (_block(f, f"{i} of {len(functions)}", binary) for i, f in enumerate(functions, start=1))
    return write_atomically(path, b"".join(blocks))


def _of_recording(
    rec: Recording, points: dict[Any, Point], force: Point | None, unit: str | None
) -> list[Function]:
    unit = "m/s2" if unit is None else unit
    Unit.written(unit)
    step, x = 1.0 / rec.fs_hz, np.arange(rec.n_samples) / rec.fs_hz
    line4 = {"start": 0.0, "step": step, "rate_hz": rec.fs_hz}
    more: dict[str, Any] = {"even": True, "step": step}
    made = [
        Function("time", points[d], (0, 0), x, row, unit, own=line4 | {"dof": d}, **more)
        for d, row in zip(rec.dofs, rec.responses, strict=True)
    ]
    if rec.force is not None:
        at = force or (max(node for node, _ in points.values()) + 1, 0)
        made.append(Function("time", at, (0, 0), x, rec.force, "N", own=line4, **more))
    return made


def _of_response(
    resp: FrequencyResponse, points: dict[Any, Point], force: Point | None, unit: str | None
) -> list[Function]:
    is_frf = resp.kind == "frf"
    unit = ("m/s2/N" if is_frf else "1") if unit is None else unit
    above, _, below = unit.rpartition("/") if Unit.written(unit).per else (unit.removeprefix("1"), "", "")
    start, step = float(resp.freq_hz[0]), float((resp.freq_hz[-1] - resp.freq_hz[0]) / (resp.n_freq - 1))
    gap = np.abs(start + step * np.arange(resp.n_freq) - resp.freq_hz).max()
    even = bool(gap <= 1e-12 * resp.freq_hz[-1])
    derived = None  # what a reader makes of coherence and averages
    if resp.coherence is not None and resp.n_averages is not None and resp.n_averages > 1.0:
        derived = std_of_coherence(resp.values, resp.coherence, resp.n_averages)
    if resp.std is not None and (derived is None or not np.array_equal(resp.std, derived)):
        said = "its standard deviations are not those of coherence and averages"
        why = "and a universal file has no place for them; they are left out"
        warn("errors_not_written", f"signal: {said}, {why}.")
    line4: dict[str, Any] = {} if resp.n_averages is None else {"n_averages": resp.n_averages}
    line4 |= {"start": start, "step": step} if even else {}
    at, reference = [points[dof] for dof in resp.dofs], (0, 0) if force is None else force
    reference = reference if is_frf else points[resp.reference]
    tables: list[tuple[str, Any, str, str]] = [(resp.kind, resp.values, above, below)]
    tables += [] if resp.coherence is None else [("coherence", resp.coherence, "", "")]
    return [
        Function(what, p, reference, resp.freq_hz, row, up, down, "", even, step, own=line4 | {"dof": dof})
        for what, rows, up, down in tables
        for dof, p, row in zip(resp.dofs, at, rows, strict=True)
    ]


def _block(f: Function, place: str, binary: bool) -> bytes:
    """One dataset, from marker to marker."""
    values, is_complex = f.values, np.iscomplexobj(f.values)
    numbers = values.astype(np.complex128).view(np.float64) if is_complex else values.astype(np.float64)
    if not f.even:  # abscissa before each value
        numbers = np.column_stack([f.x, numbers.reshape(values.size, -1)]).ravel()
    identity = f"{58:6d}"
    if binary:  # little endian, IEEE 754, 11 lines of header
        body = numbers.astype("<f8").tobytes()
        identity += f"b{1:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
        body += b"\n"  # the marker is on a line of its own
    else:
        body = _text(numbers, not f.even, is_complex)
    kind, title = _WRITTEN[f.what]
    own = {name: value for name, value in f.own.items() if name == "dof"}
    line4, line5 = json.dumps({n: v for n, v in f.own.items() if n not in own}), json.dumps(own)
    if len(line5) > 80:
        wanted = "labels of at most 70 letters in a universal file"
        reject("dofs", repr(own["dof"]), wanted, "Shorten the label.")
    over = f" / {label_of(f.reference)}" if f.reference != (0, 0) else ""
    points = "".join(f" {'NONE':<10}{node:10d}{way:4d}" for node, way in (f.response, f.reference))
    start, step = (float(f.x[0]), f.step) if f.even else (0.0, 0.0)
    axes = [(_OVER_TIME, "s") if f.what == "time" else (_OVER_TIME + 1, "Hz")]
    for unit in (f.unit, f.reference_unit, ""):
        axes.append((_DATA[Unit.of(unit).quantity], unit))
    lines = [
        f"{-1:6d}",
        identity,
        f"{title} {label_of(f.response)}{over}",
        f"antires_rs uff {VERSION} set {place}",
        "NONE",
        line4,
        line5,
        f"{kind:5d}{0:10d}{0:5d}{0:10d}{points}",
        f"{6 if is_complex else 4:10d}{values.size:10d}{int(f.even):10d}{start:13.5e}{step:13.5e}{0.0:13.5e}",
        *(f"{data:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit or 'NONE':<20}" for data, unit in axes),
    ]
    return "".join(f"{line:<80}\n" for line in lines).encode("ascii") + body + f"{-1:6d}\n".encode()


def _text(numbers: NDArray[Any], uneven: bool, is_complex: bool) -> bytes:
    """4E20.12, or with abscissae 2(E13.5,E20.12) and E13.5,2E20.12."""
    if not uneven:
        forms = ["%20.11e"] * 4
    else:
        forms = ["%13.5e", "%20.11e", "%20.11e"] if is_complex else ["%13.5e", "%20.11e"] * 2
    rows = [numbers[i : i + len(forms)].tolist() for i in range(0, numbers.size, len(forms))]
    lines = ("".join(form % v for form, v in zip(forms, row, strict=False)) for row in rows)
    return "".join(f"{line}\n" for line in lines).encode()
