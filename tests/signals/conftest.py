"""A record without a fault, made once a process."""

import pytest

from tests.support.checked_records import data


@pytest.fixture(scope="session")
def good():
    return data()
