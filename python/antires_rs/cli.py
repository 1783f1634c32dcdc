"""Old name of :mod:`antires_rs.app.main` until 0.2; it leaves with the next release."""

from .support.messages import moved

__getattr__ = moved("antires_rs.cli", "antires_rs.app.main")

if __name__ == "__main__":
    raise SystemExit(__getattr__("main")())
