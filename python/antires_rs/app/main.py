"""The ``antires`` command: tables go to standard output, errors and progress to standard error."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    came: list[int] = []
    try:  # Ctrl-C may come while modules are loaded, so all but this file is loaded in here
        with _noticed(came):
            from .command import run

            return run(argv)
    except KeyboardInterrupt:
        pass
    except ImportError:  # what C code of other packages, interrupted as it is loaded, makes of it
        if not came:
            raise
    print("antires: interrupted", file=sys.stderr)
    return 130


@contextmanager
def _noticed(came: list[int]) -> Iterator[None]:
    """Keep in mind that Ctrl-C came, where it raises KeyboardInterrupt as usual."""
    import signal
    from threading import current_thread, main_thread

    def interrupt(number: int, frame: Any) -> None:
        came.append(number)
        signal.default_int_handler(number, frame)

    usual = signal.getsignal(signal.SIGINT)
    if usual is not signal.default_int_handler or current_thread() is not main_thread():
        yield
        return
    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
