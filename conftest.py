"""For tests and for the examples in docstrings, which draw into figures of pyplot."""

import sys

import pytest


@pytest.fixture(autouse=True)
def closed_pictures():
    """No test and no example leaves a figure behind."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
