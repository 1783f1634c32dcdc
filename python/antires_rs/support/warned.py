"""One way to warn: what is said, and the name under which more is said of it."""

from __future__ import annotations

import sys
import warnings

from ..exceptions import AntiresWarning

__all__ = ["warn"]


def warn(about: str | tuple[str, ...], text: str) -> None:
    """Warn at the line of the user's call, however deep in this package.

    ``about`` names entries of ``troubleshooting.md`` beside this file, see :func:`~antires_rs.explain`.
    """
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).startswith("antires_rs."):
        level, frame = level + 1, frame.f_back
    warnings.warn(AntiresWarning(text, (about,) if isinstance(about, str) else about), stacklevel=level)
