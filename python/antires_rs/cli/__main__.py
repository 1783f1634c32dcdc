"""``python -m antires_rs.cli``."""

import sys

from . import main

sys.exit(main())
