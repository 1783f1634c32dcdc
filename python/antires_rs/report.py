"""Name of :mod:`antires_rs.figures.report` until 0.2; it leaves with the next release."""

from typing import Any

from .figures import report
from .support.messages import warn_of_change


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    value = getattr(report, name)
    warn_of_change("antires_rs.report is now antires_rs.figures.report")
    return value
