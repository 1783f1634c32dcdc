"""What all readers share: files and packages named in errors, and rates of instants."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn
from zlib import error as ZlibError

import numpy as np

from ..exceptions import AntiresError, MissingDependencyError, UnsuitableDataError, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.messages import warn

#: Parts of a record whose mean steps are compared, and by how much they may differ relatively.
_PARTS, _DRIFT = 32, 1e-3
_EVEN = "instants in s, evenly spaced and ascending"
_INSTANTS = "Resample it, cut out an even part, or leave the instants out and pass the rate."
TO_ALIGN = "Read it with align=True and resample it by align, or cut out an even part."

#: What wrong values of the right form may raise where they are used.
DAMAGE = (LookupError, TypeError, AttributeError, ArithmeticError, ValueError, RecursionError, ZlibError)
BYTES_OF_DOF = 512  # of a model, whatever its matrices hold: 300 are taken, and some microseconds

Signal = Recording | FrequencyResponse


def existing_file(path: str | os.PathLike[str]) -> Path:
    """The path of a file that is there and not empty."""
    if not isinstance(path, str | os.PathLike):
        reject("path", path, "the path of a file", "Pass a text or a pathlib.Path.")
    file = Path(path)
    if file.is_dir():
        reject("path", str(file), "a file, not a folder", "Name one of the files in it.")
    if file.stat().st_size == 0:
        unsuitable(file, "which is empty", "a file with data")
    return file


def unsuitable(
    path: Path, found: str, wanted: str, remedy: str = "Copy or export it again, correct it, or name another."
) -> NoReturn:
    """Raise for a file that is damaged or of another kind."""
    raise UnsuitableDataError("path", f"{str(path)!r}, {found}", wanted, remedy)


def most_bytes(path: Path) -> int:
    """What a file may allocate in this process: its own size, or ANTIRES_MAX_BYTES, 1 GB by default."""
    stated = os.environ.get("ANTIRES_MAX_BYTES", "1e9")
    try:
        return max(path.stat().st_size, int(float(stated)))
    except (ValueError, OverflowError):
        remedy = "Correct or remove this environment variable."
        reject("ANTIRES_MAX_BYTES", repr(stated), "a number of bytes, as 2e9", remedy)


def bounded(path: Path, size: int, found: str) -> None:
    """Refuse a file whose numbers ask for more bytes than it may allocate."""
    most = most_bytes(path)
    if size > most:
        remedy = "If it is not damaged, allow more by the environment variable ANTIRES_MAX_BYTES."
        unsuitable(path, f"{found}, {size:.3g} bytes in memory", f"at most {most:.3g} bytes", remedy)


def brief(exc: BaseException) -> str:
    """The first line of an error of another package, at most so long that it can be read."""
    said = (str(exc).splitlines() or [""])[0]
    return said[:120] if said and said.isprintable() else type(exc).__name__


def missing_part(path: Path, found: str, wanted: str, partial: bool, kept: int) -> None:
    """A file of which a part is missing: an error, or with ``partial`` a warning that counts it."""
    if partial and kept:
        warn("incomplete_file", f"path: {str(path)!r} is incomplete: {found}; what is whole was read.")
        return
    unsuitable(path, found, wanted, "Copy or export it again" + ", or pass partial=True" * bool(kept) + ".")


@contextmanager
def parts_of(path: Path, wanted: str) -> Iterator[None]:
    """Where a signal or a result is made of the parts of a file; one that is missing or odd is told."""
    try:
        yield
    except AntiresError:
        raise
    except DAMAGE as exc:
        unsuitable(path, f"which is damaged ({type(exc).__name__}: {exc})", wanted)


def choose_run(count: int) -> str:
    """What to do with a file of several runs."""
    return f"Choose one by run=1 to run={count}, and give them together as repeats of one test."


def refuse_real(path: Path, rows: Sequence[tuple[Any, Any]]) -> None:
    """Refuse names and responses if one is real, or all imaginary parts vanish; ones are references."""
    real = next((name for name, row in rows if not np.iscomplexobj(row)), None)
    vary = any((row != row[:1]).any() for _, row in rows)
    if real is not None or (vary and not any(np.any(row.imag) for _, row in rows)):
        found = "whose responses have no imaginary part" if real is None else f"whose {real} is real"
        remedy = "Magnitudes alone have lost the phase: export it with them, or real and imaginary part."
        unsuitable(path, found, "complex FRFs or transmissibilities", remedy)


def require(what: str, module: str, extra: str, package: str = "") -> None:
    """Raise where a package is not installed, without importing it; the error names the extra to install."""
    try:
        there = find_spec(module) is not None
    except ModuleNotFoundError:  # of a package above it
        there = False
    if not there:
        package = package or module
        how = f'pip install "antires-rs[{extra}]", or: pip install {package}'
        raise MissingDependencyError(f"{what} needs {package}; install it with: {how}")


def simplest_rate(low: float, high: float) -> float:
    """The rate in [low, high] that is the simplest number, or whose step is; both positive."""

    def simplest(low: float, high: float) -> float:
        numbers = (float(f"{0.5 * (low + high):.{digits}e}") for digits in range(16))
        return next((number for number in numbers if low <= number <= high), 0.5 * (low + high))

    def key(number: float, rate: float) -> tuple[int, float, float]:
        # Of equally simple ones, the nearer to the middle.
        digits = f"{number:.15e}".partition("e")[0].rstrip("0")
        return len(digits), abs(rate - 0.5 * (low + high)), rate

    rate, step = simplest(low, high), simplest(1.0 / high, 1.0 / low)
    return min(key(rate, rate), key(step, 1.0 / step))[2]


def usual_rate(path: Path, times: Any) -> float:
    """Sampling rate of instants in s with gaps: that of the usual step."""
    steps = np.diff(times)
    if not steps.size or not np.isfinite(times).all() or steps.min() <= 0.0:
        unsuitable(path, "whose time does not ascend", "instants that ascend", _INSTANTS)
    usual = float(np.median(steps))
    rate = 1.0 / float(np.mean(steps[steps < 1.5 * usual]))
    return simplest_rate((1.0 - 1e-9) * rate, (1.0 + 1e-9) * rate)


TOO_FEW_DIGITS = "Where instants are only written with too few digits, give the rate by fs_hz=."


def rate_of(path: Path, times: Any, *, digits: float = 1e-9, remedy: str = _INSTANTS) -> float:
    """Sampling rate of even instants in s, the simplest their rounding allows; gaps are refused."""
    if times.size < 2 or not np.isfinite(times).all():
        unsuitable(path, f"whose {times.size} instants are too few or not finite", _EVEN, remedy)
    span, rounding = float(times[-1] - times[0]), digits * float(np.abs(times).max())
    step = span / (times.size - 1)
    if span <= 0.0:
        unsuitable(path, "whose time does not ascend", _EVEN, remedy)
    if 2.0 * rounding > 1.5 * step:  # neighbours are written alike, and a lost sample is not seen
        found = f"whose instants are written to {2.0 * rounding:.1g} s, in steps of {step:.3g} s"
        unsuitable(path, found, _EVEN, TOO_FEW_DIGITS)
    # A lost sample moves its neighbour by a whole step; a tenth is jitter no writer makes by rounding.
    late = np.flatnonzero(np.abs(np.diff(times) - step) > max(0.1 * step, 2.0 * rounding))
    if late.size:
        i = int(late[0])
        found = f"with {times[i]:.9g} s followed by {times[i + 1]:.9g} s after steps of {step:.6g} s"
        if late.size > times.size // 10:
            remedy = TOO_FEW_DIGITS
        unsuitable(path, f"{found} ({late.size} such gaps)", _EVEN, remedy)
    # Steps may also change in the course of the record, each by less than counts as a gap. Jitter of single
    # instants averages out over a part; its two ends have at most a tenth of a step each.
    width = max(times.size // _PARTS, 16)
    edges = np.arange(0, times.size - 1, width)
    steps = np.diff(times[edges]) / width
    odd = np.abs(steps - step)
    if edges.size > 2 and odd.max() > _DRIFT * step + (2.0 * rounding + 0.2 * step) / width:
        i = int(np.argmax(odd))
        where = f"from {times[edges[i]]:.9g} to {times[edges[i + 1]]:.9g} s"
        found = f"whose rate drifts: steps are {steps[i]:.6g} s on average {where}, and {step:.6g} s in all"
        unsuitable(path, found, _EVEN, remedy)
    count = times.size - 1
    return simplest_rate(count / (span + 2.0 * rounding), count / max(span - 2.0 * rounding, 0.5 * span))
