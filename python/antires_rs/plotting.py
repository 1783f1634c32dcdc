"""Old name of :mod:`antires_rs.figures` until 0.2; it leaves with the next release."""

from .support.messages import moved

__getattr__ = moved(__name__, "antires_rs.figures")
