"""What holds for all tests."""

import pytest
from hypothesis import settings

from tests.daemons import free_bus
from vsensor.config import Bus

# A loaded machine is no fault of the code: no test is failed for how long it took.
settings.register_profile("vsensor", deadline=None)
settings.load_profile("vsensor")


@pytest.fixture
def bus() -> Bus:
    """A bus of its own for each test."""
    return free_bus()
