"""Samples in the order of arrival, and ticks, by columns."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.intake.given import Input
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Event, Sample
from vsensor.messages.vsensor_pb2 import Quality as QualityMessage

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


class Arrivals(NamedTuple):
    """n samples of the two channels as they came."""

    is_speed: NDArray[np.bool_]
    """Speed; else torque."""
    time_ns: Integers
    value: Floats
    quality: Integers
    """0 where the source says nothing of it."""
    sequence: NDArray[np.uint64]
    numbered: NDArray[np.bool_]
    """Whether it has a sequence number."""

    @staticmethod
    def none() -> "Arrivals":
        """No samples at all."""
        kinds = (np.bool_, np.int64, np.float64, np.int64, np.uint64, np.bool_)
        return Arrivals._make(np.empty(0, kind) for kind in kinds)

    @staticmethod
    def in_turn(time_ns: Integers, torque: Floats, speed: Floats, first: tuple[int, int]) -> "Arrivals":
        """n rows of a table as a rig would send them: torque, then speed, each numbered from its `first`.

        Where a channel is NaN it has no sample.
        """
        value = np.column_stack((torque, speed))
        known = ~np.isnan(value)
        number = (np.array(first, np.int64) + np.cumsum(known, axis=0) - 1).astype(np.uint64)
        count = int(known.sum())
        return Arrivals(
            is_speed=np.broadcast_to([False, True], value.shape)[known],
            time_ns=np.repeat(time_ns, 2).reshape(-1, 2)[known],
            value=value[known],
            quality=np.zeros(count, np.int64),
            sequence=number[known],
            numbered=np.ones(count, np.bool_),
        )

    def part(self, start: int, end: int) -> "Arrivals":
        """Those from `start` on, before `end`."""
        return Arrivals._make(column[start:end] for column in self)

    def samples(self) -> Iterator[tuple[str, Sample]]:
        """Yield them one by one."""
        for is_speed, time_ns, value, quality, sequence, numbered in zip(
            *(column.tolist() for column in self), strict=True
        ):
            sample = Sample(time_ns=time_ns, value=value)
            if quality:
                sample.quality = QualityMessage.ValueType(quality)
            if numbered:
                sample.sequence = sequence
            yield SURFACE_SPEED if is_speed else SURFACE_TORQUE, sample


class Inputs(NamedTuple):
    """What the estimator is given at n ticks: the fields of `intake.Input` by columns."""

    number: Integers
    time_ns: Integers
    motor_torque: Floats
    motor_speed: Floats
    reasons: NDArray[np.uint32]
    off_bottom: NDArray[np.bool_]
    longer_by: Floats
    forecast_shed: NDArray[np.bool_]

    def part(self, start: int, end: int) -> "Inputs":
        """Those from tick `start` on, before `end`."""
        return Inputs._make(column[start:end] for column in self)


_TYPES = (np.int64, np.int64, np.float64, np.float64, np.uint32, np.bool_, np.float64, np.bool_)
Feed = Iterable[Arrivals | tuple[str, Sample | Event]]
"""Samples by columns and, between them, single samples and what the sensor was told."""


def by_columns(ticks: Iterable[Input]) -> Inputs:
    """Ticks that came one by one."""
    columns = list(zip(*ticks, strict=True)) or [()] * len(_TYPES)
    return Inputs._make(np.array(column, kind) for column, kind in zip(columns, _TYPES, strict=True))
