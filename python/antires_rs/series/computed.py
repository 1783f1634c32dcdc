"""The sources of a series computed, by whatever workers, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from .ahead import read_ahead
from .one_test import Instructions, Outcome, identified, loaded

__all__ = ["computed"]


def computed(instructions: Instructions, tasks: Iterable[Any], workers: Any) -> Iterator[Outcome]:
    """The outcome of each source; the next one is read while one is computed."""
    for signal in read_ahead(partial(loaded, instructions), tasks):
        yield identified(instructions, signal)
