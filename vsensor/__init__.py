"""A virtual torque sensor for the bit of a drill string."""

from importlib.metadata import version

__version__ = version("vsensor")
