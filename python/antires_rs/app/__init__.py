"""Jobs: what to read, to model and to look for, in one TOML file.

``antires init`` writes a job with every key explained; ``antires update`` and ``antires damage`` carry it
out. Uses the public calls of all packages below, and ``io`` and ``report``: a job says nothing that a call
could not say. To add a key: ``keys``, then the file that makes an argument of it (``reading``, ``measured``,
``model`` or ``unknowns``).
"""

from .job import Job, read_job
from .keys import template

__all__ = ["Job", "read_job", "template"]
