"""Files that are whole or not there at all."""

from __future__ import annotations

import os
from pathlib import Path

from ._validation import reject

__all__ = ["write_atomically"]


def write_atomically(path: str | os.PathLike[str], data: bytes) -> Path:
    """Write beside the target, then put it in place in one step; returns the path."""
    target = Path(path)
    if not target.parent.is_dir():
        reject("path", str(target), "a file in a folder that exists",
               f"Make the folder {str(target.parent)!r} first.")
    if target.is_dir():
        reject("path", str(target), "a file, not a folder")
    # Same folder, so that the replacement is one step of the file system.
    beside = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        with open(beside, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, target)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
    return target
