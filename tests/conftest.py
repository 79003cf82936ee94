"""What holds for all tests."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from tests.daemons import free_bus
from vsensor.config import Bus, load
from vsensor.estimator.abreast import WORTHWHILE
from vsensor.estimator.estimator import Estimator
from vsensor.jit import COMPILED

# A loaded machine is no fault of the code: no test is failed for how long it took.
settings.register_profile("vsensor", deadline=None)
# CI tells whether a change broke something: the same examples each time. At a desk new ones are tried, and
# twice as many.
settings.register_profile("ci", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("ci" if os.environ.get("CI") else "vsensor")


def pytest_configure(config: pytest.Config) -> None:
    """Compile once what tests, the processes that run them, and daemons would each compile at once."""
    if COMPILED and not hasattr(config, "workerinput"):
        estimator = Estimator(load(Path(__file__).parents[1] / "config" / "drilling.toml"))
        still = [0.0] * (WORTHWHILE + 2)  # as many ticks as march side by side
        estimator.run(still, still)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what mostly waits: at the end a processor would wait with it."""
    items.sort(key=lambda item: item.get_closest_marker("process") is None)


@pytest.fixture
def bus() -> Bus:
    """A bus of its own for each test."""
    return free_bus()
