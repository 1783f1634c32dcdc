"""Parts of long studies: what every run of the suite has, and what waits for ``make campaign``."""

from __future__ import annotations

import os

import pytest

campaign = pytest.mark.campaign  #: For a whole test that repeats at length what others show in small.


def some_of(cases, kept=1):
    """Values for ``parametrize``: the first ``kept``, or those listed, always; the rest in the campaign."""
    cases = list(cases)
    always = cases[:kept] if isinstance(kept, int) else kept
    return [case if case in always else _later(case) for case in cases]


def examples(n):
    """Examples of a property test: ``n``, or a multiple of it in the campaign."""
    return n * int(os.environ.get("ANTIRES_EXAMPLES", "1"))


def _later(case):
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=campaign)
