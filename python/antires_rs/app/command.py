"""From arguments to an exit code: the command is run, its errors and warnings are one line each."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from pathlib import Path
from typing import Any

from ..exceptions import AntiresError, AntiresWarning, Argument, InvalidInputError, UnsuitableDataError
from .parser import complain, parser, printable


def run(argv: Sequence[str] | None) -> int:
    """Carry out a command; everything but Ctrl-C becomes an exit code here."""
    args = parser().parse_args(argv)
    _of_job.set(hasattr(args, "job"))
    with warnings.catch_warnings():
        warnings.simplefilter("always", AntiresWarning)
        warnings.showwarning = _warn  # type: ignore[assignment]
        try:
            module, name = args.does.split(".")
            code: int = getattr(import_module(f"{__package__}.{module}"), name)(args)
            sys.stdout.flush()
            return code
        except BrokenPipeError:
            # The reader (head, less) has gone. Python would complain again when it flushes at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except (AntiresError, OSError, MemoryError) as exc:
            complain(shell_words(str(exc) or "there is not enough memory."))
            return 2 if isinstance(exc, InvalidInputError) and not isinstance(exc, UnsuitableDataError) else 1


def _warn(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: Any) -> None:
    """One line for each thing that a warning of ours says; others as Python has them."""
    if issubclass(category, AntiresWarning):
        for said in shell_words(str(message)).splitlines():
            print(printable(f"antires: warning: {said}"), file=sys.stderr)
    else:
        print(warnings.formatwarning(message, category, filename, lineno), end="", file=sys.stderr)


# -- What commands share: where they speak, and how they name their arguments

_of_job: ContextVar[bool] = ContextVar("_of_job", default=False)


def shell_words(text: str) -> str:
    """A text of the library without the words of Python: arguments as the job, or the command, has them."""
    if "=" not in text and " see ." not in text:
        return text
    reading = import_module(f"{__package__}.reading")  # which stands on this module, as commands do
    spell = reading.Job.spelled if _of_job.get() else reading.Call.spelled
    words: str = reading.spelled(text, spell)
    return words


def say(text: str) -> None:
    """A line of progress; on a terminal only."""
    if sys.stderr.isatty():
        sys.stderr.write(f"{printable(text)}\n")  # in one piece, whenever Ctrl-C comes
        sys.stderr.flush()


def hint(text: str) -> None:
    """A line on standard error that is no error."""
    print(printable(f"antires: {text}"), file=sys.stderr)


def show(as_json: bool, data: Any, text: object) -> None:
    """What a command found, on standard output: numbers for machines, or the text."""
    print(json.dumps(data, indent=1, allow_nan=False) if as_json else printable(shell_words(str(text))))


_HEAD = 100_000  # bytes of a file, the styles of a report among them, in which it says whose it is


def new_file(option: str, file: Path | None, *endings: str) -> None:
    """Refuse a file that could not be written, before anything is computed for it."""
    if file is None:
        return
    wanted, remedy = f"a file that ends in {endings[0]}", "Choose another name."
    if file.suffix in endings:
        wanted, remedy = "a file in a folder that exists", f"Make {str(file.parent)!r} first."
    if file.suffix not in endings or not file.parent.is_dir():
        raise InvalidInputError(option, repr(str(file)), wanted, remedy)
    if option == "--out" and file.exists() and not _is_ours(file):
        got = f"{str(file)!r}, which exists and is not of antires_rs"
        wanted = "a new file, or one that antires_rs wrote"
        raise InvalidInputError(option, got, wanted, "Choose another name, or move that file away.")


def _is_ours(file: Path) -> bool:
    """Whether a file was written by antires_rs: sets and reports name it in their first lines."""
    if not file.is_file():
        return False
    with open(file, "rb") as opened:
        return b"antires_rs" in opened.read(_HEAD)


def existing(
    argument: str, path: Path, remedy: str, wanted: str = "a file that exists", name: str | None = None
) -> Path:
    """A file that is there; ``name`` is what the user calls it."""
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "does not exist"
        raise InvalidInputError(argument, f"{name or str(path)!r}, which {what}", wanted, remedy)
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
