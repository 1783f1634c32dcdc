"""From arguments to an exit code: the command is run, its errors and warnings are one line each."""

from __future__ import annotations

import errno
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from ..exceptions import AntiresError, AntiresWarning, InvalidInputError, UnsuitableDataError
from .parser import parser
from .usage import complain

__all__ = ["run"]


def run(argv: Sequence[str] | None) -> int:
    """Carry out a command; everything but Ctrl-C becomes an exit code here."""
    args = parser().parse_args(argv)
    with warnings.catch_warnings():
        warnings.simplefilter("always", AntiresWarning)
        warnings.showwarning = _warn
        try:
            code: int = args.run(args)
            sys.stdout.flush()
            return code
        except BrokenPipeError:
            # The reader (head, less) has gone. Python would complain again when it flushes at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except (AntiresError, OSError) as exc:
            complain(_refused(exc) if isinstance(exc, OSError) else exc)
            wrong = isinstance(exc, InvalidInputError) and not isinstance(exc, UnsuitableDataError)
            return 2 if wrong else 1


def _refused(exc: OSError) -> object:
    """What the system refuses, by the name that the user gave: files are written under another one first."""
    if not isinstance(exc.filename, str) or exc.errno not in (errno.EACCES, errno.EPERM, errno.EROFS):
        return exc
    from ..support.files import final_path

    return UnsuitableDataError(
        repr(str(final_path(exc.filename))),
        f"'{exc.strerror}' from the system",
        "a place that this user may read and write",
        "Choose another folder, or change its permissions.",
    )


def _warn(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: Any = None,
    line: str | None = None,
) -> None:
    """One line for each thing that a warning of ours says; others as Python has them."""
    if issubclass(category, AntiresWarning):
        for said in str(message).splitlines():
            print(f"antires: warning: {said}", file=sys.stderr)
    else:
        print(warnings.formatwarning(message, category, filename, lineno, line), end="", file=sys.stderr)
