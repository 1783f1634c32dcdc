"""What commands share: where they speak, and how they name their arguments."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..exceptions import Argument, InvalidInputError
from ..support.validation import reject

__all__ = ["arguments", "existing", "new_file", "print_json", "say"]


def say(text: str) -> None:
    """A line of progress; on a terminal only."""
    if sys.stderr.isatty():
        sys.stderr.write(f"{text}\n")  # in one piece, whenever Ctrl-C comes
        sys.stderr.flush()


def print_json(data: Any) -> None:
    """Numbers for machines, on standard output."""
    print(json.dumps(data, indent=1, allow_nan=False))


def new_file(option: str, file: Path | None, *endings: str) -> None:
    """Refuse a file that could not be written, before anything is computed for it."""
    if file is None:
        return
    if file.suffix not in endings:
        reject(option, repr(str(file)), f"a file that ends in {endings[0]}", "Choose another name.")
    if not file.parent.is_dir():
        wanted = "a file in a folder that exists"
        reject(option, repr(str(file)), wanted, f"Make {str(file.parent)!r} first.")


def existing(argument: str, path: Path, remedy: str) -> Path:
    """A file that is there."""
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "does not exist"
        reject(argument, f"{str(path)!r}, which {what}", "a file that exists", remedy)
    return path


@contextmanager
def arguments(names: Mapping[str, str]) -> Iterator[None]:
    """Errors about an argument of a function become errors about that of the command."""
    try:
        yield
    except InvalidInputError as exc:
        name = names.get(exc.path[0])
        if name is None:
            raise
        raise type(exc)(Argument(name, (name, *exc.path[1:])), exc.got, exc.wanted, exc.remedy) from exc
