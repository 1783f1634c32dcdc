"""Name of :mod:`antires_rs.figures.report` until 0.2; it leaves with the next release."""

from warnings import warn

from .figures.report import write_report as write_report

warn("antires_rs.report is now antires_rs.figures.report", FutureWarning, stacklevel=2)
