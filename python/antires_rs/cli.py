"""The ``antires`` command. Tables on standard output, progress and errors on standard error.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ._core import __version__
from .exceptions import AntiresError

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
        0 done, 1 failed, 130 interrupted. Wrong usage leaves through ``SystemExit(2)``, as argparse does.

    Examples
    --------
    >>> from antires_rs.cli import main
    >>> main(["--version"])
    Traceback (most recent call last):
    SystemExit: 0
    """
    args = _parser().parse_args(argv)
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
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="antires",
        description="Antiresonances from measured responses, model updating, damage location.")
    parser.add_argument("--version", action="version", version=f"antires {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    demo = commands.add_parser(
        "demo", help="a whole study in a few seconds: record, identify, update, find the damage",
        description="Virtual test of an eight-mass chain: antiresonances from records alone, an updated "
                    "model, and the damaged spring. Writes pictures and reports.")
    demo.add_argument("--out", type=Path, default=Path("demo_output"), metavar="DIR",
                      help="folder for pictures, reports and summary.json (default: %(default)s)")
    demo.add_argument("--seed", type=_number(int, 0), default=0, metavar="N",
                      help="another structure, another record, another search (default: %(default)s)")
    demo.add_argument("--noise", type=_number(float, 0.0, 1.0), default=0.01, metavar="FRACTION",
                      help="sensor noise as a fraction of each channel's rms (default: %(default)s)")
    demo.add_argument("--workers", type=_number(int, 1), default=None, metavar="N",
                      help="threads of the search (default: all processors); the numbers do not depend on it")
    demo.add_argument("--json", action="store_true", help="print summary.json instead of the tables")
    demo.set_defaults(run=_demo)
    return parser


def _demo(args: argparse.Namespace) -> int:
    from . import demo  # pulls in the whole chain: not for --help
    return demo.command(args.out, seed=args.seed, noise=args.noise, workers=args.workers, as_json=args.json)


def _number(kind: Callable[[str], Any], low: float, high: float = float("inf")) -> Callable[[str], Any]:
    """Argument type: a number within limits, or a usage error that says which."""
    what = "an integer" if kind is int else "a number"
    limits = f"of at least {low:g}" if high == float("inf") else f"from {low:g} to {high:g}"

    def parse(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high:
            raise argparse.ArgumentTypeError(f"got {text!r}; wanted {what} {limits}")
        return value
    return parse


if __name__ == "__main__":
    sys.exit(main())
