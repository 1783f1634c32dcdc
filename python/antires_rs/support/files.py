"""Files that are whole or not there at all, also after a kill or a power cut."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..exceptions import reject

_BESIDE = re.compile(r"\.(.+)\.(\d+)\.tmp")  # a file that is being written: its name to be, and the process


_FORMULA = re.compile(r"[=@+\t\r-]")
_PLAIN = re.compile(r"[+-]\w*")


def cell(value: object) -> object:
    """A value for a table of text; what a spreadsheet would carry out, ``=cmd``, is text to it too."""
    formula = isinstance(value, str) and _FORMULA.match(value) and not _PLAIN.fullmatch(value)
    return f"'{value}" if formula else value


def marked_json(text: str, name: str, form: str, version: int, wanted: str, remedy: str) -> dict[str, Any]:
    """The object of a JSON text that says it is of this format and version; ``name`` stands in messages."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as exc:
        reject("path", f"{name!r}, which is not JSON ({exc})", wanted, remedy)
    if not isinstance(data, dict) or data.get("format") != form:
        reject("path", f"{name!r} without the mark {form!r}", wanted, remedy)
    if not isinstance(data.get("version"), int) or data["version"] > version:
        reject("path", f"{name!r} of version {data.get('version')!r}", wanted, "Update antires_rs.")
    return data


def write_atomically(path: str | os.PathLike[str], data: bytes) -> Path:
    """Write beside the target, then put it in place in one step; returns the path."""
    with written_beside(path) as beside, open(beside, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    return Path(path)


@contextmanager
def written_beside(path: str | os.PathLike[str]) -> Iterator[Path]:
    """The path of a file to be written inside; then it takes the place of the target, which else stays."""
    if not isinstance(path, str | os.PathLike):
        reject("path", path, "the path of a file", "As in 'page.html'.")
    target = Path(path)
    if not target.parent.is_dir():
        remedy = f"Make the folder {str(target.parent)!r} first."
        reject("path", str(target), "a file in a folder that exists", remedy)
    if target.is_dir():
        reject("path", str(target), "a file, not a folder", "Name a file in it.")
    if target.exists() and not target.is_file():  # its name would be taken by a plain file
        reject("path", str(target), "a plain file, not a device or pipe", "Write it to a file first.")
    # Same folder, so that the replacement is one step of the file system.
    beside = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        yield beside
        put_in_place(beside, target)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
    _forget_half_written(target)


def put_in_place(beside: Path, target: Path) -> None:
    """Let a file that was flushed to the disk take its name, for good: the folder is flushed too."""
    os.replace(beside, target)
    if os.name == "posix":  # elsewhere a folder cannot be opened
        with suppress(OSError):  # nor flushed on some file systems, which then have a way of their own
            folder = os.open(target.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)


def _forget_half_written(target: Path) -> None:
    """Remove what processes that are no more were writing to the same target."""
    if os.name != "posix":  # os.kill would end the process instead of asking for it
        return
    with suppress(OSError):  # the target is in place, which is what was asked for
        for name in os.listdir(target.parent):
            found = _BESIDE.fullmatch(name)
            if found and found[1] == target.name and not alive(int(found[2])):
                target.with_name(name).unlink(missing_ok=True)


def alive(process: int) -> bool:
    """Whether a process of this number is there."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # someone else's
        return True
    return True
