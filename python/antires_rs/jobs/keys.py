"""Every section of a job file: what it holds, and the sentences that explain it.

The same sentences are the comments of ``antires init`` and the remedies of the messages.
"""

from __future__ import annotations

from .keys_data import DATA, IDENTIFICATION
from .keys_model import MODEL, PARAMETERS
from .keys_search import DAMAGE, OUTPUT, SEARCH, UPDATING
from .keys_series import SERIES

__all__ = ["SECTIONS"]

#: In the order of a job file.
SECTIONS = {
    section.name: section
    for section in (DATA, SERIES, IDENTIFICATION, MODEL, PARAMETERS, UPDATING, DAMAGE, SEARCH, OUTPUT)
}
