"""The configuration: a TOML file with units, as frozen, validated values in SI."""

from vsensor.config.differences import differences
from vsensor.config.estimation import DepthSettings, EstimatorSettings, Tuning
from vsensor.config.hardware import Bit, Component, Measurement, TopDrive
from vsensor.config.rig import Rig, effective_toml, load, loads
from vsensor.config.service import Bus, KeptState, Loop, Metrics, Recording, SpeedUnit, TorqueUnit, View

__all__ = [
    "Bit",
    "Bus",
    "Component",
    "DepthSettings",
    "EstimatorSettings",
    "KeptState",
    "Loop",
    "Measurement",
    "Metrics",
    "Recording",
    "Rig",
    "SpeedUnit",
    "TopDrive",
    "TorqueUnit",
    "Tuning",
    "View",
    "differences",
    "effective_toml",
    "load",
    "loads",
]
