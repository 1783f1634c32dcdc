"""Jobs: what to read, to model and to look for, in one TOML file.

``antires init`` writes a job with every key explained; ``antires update`` and ``antires damage`` carry it
out.
"""

from .job import Job, read_job
from .template import template

__all__ = ["Job", "read_job", "template"]
