"""Name of :mod:`antires_rs.figures.report` until 0.2; it leaves with the next release."""

from warnings import warn

warn("antires_rs.report is now antires_rs.figures.report", FutureWarning, stacklevel=2)
