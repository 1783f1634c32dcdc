"""``python -m antires_rs``: the command ``antires``."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
