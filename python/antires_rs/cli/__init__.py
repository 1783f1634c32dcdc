"""The ``antires`` command. Tables on standard output, progress and errors on standard error.

Exit codes: 0 done, 1 failed, 2 wrong usage (arguments or job file), 130 interrupted. Progress is shown on a
terminal only.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

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
    try:  # Ctrl-C may come while modules are loaded, so all but this file is loaded in here
        from .command import run
        return run(argv)
    except KeyboardInterrupt:
        print("antires: interrupted", file=sys.stderr)
        return 130
