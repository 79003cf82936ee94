"""What holds for all tests."""

from hypothesis import settings

# A loaded machine is no fault of the code: no test is failed for how long it took.
settings.register_profile("vsensor", deadline=None)
settings.load_profile("vsensor")
