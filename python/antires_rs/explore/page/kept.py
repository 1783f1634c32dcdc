"""The file of a session: nothing of others is replaced unasked, and what was not saved finds a place."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from pathlib import Path

from ...exceptions import AntiresError, InvalidInputError
from ...support.files import write_atomically
from ...support.validation import reject

__all__ = ["TAKEN", "SessionFile"]

#: What the error is about where there is a file that this session has not written, or has changed since.
TAKEN = "file"


class SessionFile:
    """Where a session is saved.

    Attributes
    ----------
    path : pathlib.Path or None
        None where the set can only be downloaded, or taken from Python.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._own: tuple[int, int, int] | None = None

    def opened(self) -> None:
        """Say that what stands in the file now is known to the session, which may replace it."""
        self._own = None if self.path is None else _mark(self.path)

    def write(self, text: str, *, replace_file: bool = False) -> str:
        """Write the text; the name of the file.

        Raises
        ------
        InvalidInputError
            There is no name, or the file cannot be written; or what stands there is not this session's, and
            ``replace_file`` is False: then the error is about :data:`TAKEN`.
        """
        if self.path is None:
            reject("path", None, "a file to write", "Download the set instead.")
        found = _mark(self.path)
        if found is not None and found != self._own and not replace_file:
            how = "is there already" if self._own is None else "something else has changed meanwhile"
            reject(
                TAKEN,
                f"{self.path}, which {how}",
                "a file that is not there yet, or as this page left it",
                "Replace it, or download the set.",
            )
        _write(self.path, text)
        self.opened()
        return self.path.name

    def write_beside(self, text: str) -> Path | None:
        """Write to a new file beside, or where that cannot be in the folder for temporary files; its path."""
        if self.path is None:
            return None
        for folder in (self.path.parent, Path(tempfile.gettempdir())):
            with suppress(AntiresError):
                free = next(path for path in _names(folder, self.path.stem) if not path.exists())
                _write(free, text)
                return free
        reject(
            "path",
            f"{self.path.parent} and {tempfile.gettempdir()}, in neither of which a file can be written",
            "a folder for edits that were not saved",
            "Make room there.",
        )


def _names(folder: Path, stem: str) -> Iterator[Path]:
    """Names for what was not saved, so that an earlier one is not replaced."""
    yield folder / f"{stem}_unsaved.json"
    yield from (folder / f"{stem}_unsaved_{i}.json" for i in count(2))


def _write(path: Path, text: str) -> None:
    try:
        write_atomically(path, text.encode())
    except OSError as exc:
        raise InvalidInputError(
            "path",
            f"{path}, which cannot be written ({exc.strerror or exc})",
            "a file in a folder in which you may write, on a disk with room",
            "Download the set to another place.",
        ) from exc


def _mark(path: Path) -> tuple[int, int, int] | None:
    """Tells a version of a file from another; None for no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
