"""Name of :mod:`antires_rs.app.main` until 0.2; it leaves with the next release."""

from typing import Any

from .app import main
from .support.messages import warn_of_change


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    value = getattr(main, name)
    warn_of_change("antires_rs.cli is now antires_rs.app.main")
    return value


if __name__ == "__main__":
    warn_of_change("antires_rs.cli is now antires_rs.app.main")
    raise SystemExit(main.main())
