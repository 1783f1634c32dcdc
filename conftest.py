"""For tests and for the examples in docstrings, which draw into figures of pyplot."""

import sys

import pytest


@pytest.fixture(autouse=True)
def closed_pictures(request):
    """No example leaves a figure behind."""
    yield
    if isinstance(request.node, pytest.DoctestItem) and "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
