"""``python -m antires_rs``: the command ``antires``."""

import sys

from .app.main import main

if __name__ == "__main__":
    sys.exit(main())
