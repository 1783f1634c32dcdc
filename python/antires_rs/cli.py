"""Name of :mod:`antires_rs.app.main` until 0.2; it leaves with the next release."""

from warnings import warn

from .app.main import main

warn("antires_rs.cli is now antires_rs.app.main", FutureWarning, stacklevel=2)

if __name__ == "__main__":
    raise SystemExit(main())
