"""Name of :mod:`antires_rs.figures` until 0.2; it leaves with the next release."""

from warnings import warn

from .figures import *  # noqa: F403

warn("antires_rs.plotting is now antires_rs.figures", FutureWarning, stacklevel=2)
