"""Name of :mod:`antires_rs.figures` until 0.2; it leaves with the next release."""

from typing import Any

from . import figures
from .support.messages import warn_of_change


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    value = getattr(figures, name)
    warn_of_change("antires_rs.plotting is now antires_rs.figures")
    return value
