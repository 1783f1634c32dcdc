"""What pictures are drawn of, made once a process."""

import pytest

from tests.support import four_masses


@pytest.fixture(scope="session")
def record():
    return four_masses.record()


@pytest.fixture(scope="session")
def identified():
    return four_masses.identified()
