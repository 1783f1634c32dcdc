"""Fixtures that tests of several packages ask for."""

import pytest

from tests.support.pictures import drawn_quickly


@pytest.fixture
def quick_pictures():
    """Where it matters that pictures are drawn and where they go, not how they look."""
    with drawn_quickly():
        yield
