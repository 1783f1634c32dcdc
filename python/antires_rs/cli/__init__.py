"""The ``antires`` command. Tables on standard output, progress and errors on standard error.

Exit codes: 0 done, 1 failed, 2 wrong usage (arguments or job file), 130 interrupted. Progress is shown on a
terminal only.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

from ..exceptions import AntiresError, AntiresWarning, InvalidInputError, UnsuitableDataError
from .parser import parser

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process by default.

    Returns
    -------
    int
        0 done, 1 failed, 2 a wrong argument or job file, 130 interrupted. What argparse finds wrong leaves
        through ``SystemExit(2)``.

    Examples
    --------
    >>> from antires_rs.cli import main
    >>> main(["--version"])
    Traceback (most recent call last):
    SystemExit: 0
    """
    args = parser().parse_args(argv)
    with warnings.catch_warnings():
        warnings.simplefilter("always", AntiresWarning)
        warnings.showwarning = _warn
        try:
            code: int = args.run(args)
            sys.stdout.flush()
            return code
        except KeyboardInterrupt:
            print("antires: interrupted", file=sys.stderr)
            return 130
        except BrokenPipeError:
            # The reader (head, less) has gone. Python would complain again when it flushes at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except (AntiresError, OSError) as exc:
            print(f"antires: error: {exc}", file=sys.stderr)
            wrong = isinstance(exc, InvalidInputError) and not isinstance(exc, UnsuitableDataError)
            return 2 if wrong else 1


def _warn(message: Warning | str, category: type[Warning], filename: str, lineno: int, file: Any = None,
          line: str | None = None) -> None:
    """One line for a warning of ours; others as Python has them."""
    if issubclass(category, AntiresWarning):
        print(f"antires: warning: {message}", file=sys.stderr)
    else:
        print(warnings.formatwarning(message, category, filename, lineno, line), end="", file=sys.stderr)


