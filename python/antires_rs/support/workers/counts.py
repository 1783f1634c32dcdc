"""How many workers a number means, and how many there can be."""

from __future__ import annotations

import os

__all__ = ["MOST_WORKERS", "processors"]

#: More than any machine has; a larger number is a slip.
MOST_WORKERS = 1024


def processors() -> int:
    """Processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
