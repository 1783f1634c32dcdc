"""Fixtures that tests of several packages ask for."""

import signal

import pytest

from tests.support.pictures import drawn_quickly

# In the background, as many runners start them, SIGINT is ignored; programs that tests start inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def quick_pictures():
    """Where it matters that pictures are drawn and where they go, not how they look."""
    with drawn_quickly():
        yield
