"""Verification: a single bit that differs is found, a hole is called a hole."""

import math
import struct
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.messages import BIT_ESTIMATE, SENSOR_TICK, Estimate, Tick
from vsensor.recording.reader import Session
from vsensor.recording.verify import Gap, Verdict, verify
from vsensor.recording.writer import SessionWriter

NAN = math.nan


class Sum:
    """An estimator with a memory: any tick left out changes all that follow."""

    def __init__(self) -> None:
        self.total = 0.0

    def step(self, tick: Tick) -> Estimate:
        self.total = 0.0 if tick.number == 0 else self.total
        self.total += tick.motor_torque_nm
        return Estimate(number=tick.number, time_ns=tick.time_ns, now_bit_torque_nm=self.total)


def ticks(count: int) -> list[Tick]:
    return [Tick(number=n, time_ns=n * 1000, motor_torque_nm=0.1 * n) for n in range(count)]


def recorded(
    path: Path,
    told: Iterable[Tick],
    *,
    damage: Callable[[Estimate], None] = lambda _: None,
    without: Callable[[Estimate], bool] = lambda _: False,
) -> Session:
    """A session whose estimates were made by Sum, then damaged or left out."""
    estimator = Sum()
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for tick in told:
            estimate = estimator.step(tick)
            damage(estimate)
            writer.write(SENSOR_TICK, tick.SerializeToString(), 0, 0)
            if not without(estimate):
                writer.write(BIT_ESTIMATE, estimate.SerializeToString(), 0, 0)
    return Session(path)


def test_the_same_estimator_gives_the_same_bits(tmp_path: Path) -> None:
    verdict = verify(recorded(tmp_path / "a.mcap", ticks(50)), Sum().step)
    assert verdict == Verdict(ticks=50, compared=50, mismatches=0, first=None, gap=None)
    assert verdict.exact


def test_a_single_flipped_bit_is_found(tmp_path: Path) -> None:
    def flip(estimate: Estimate) -> None:
        if estimate.number == 31:
            (bits,) = struct.unpack("<Q", struct.pack("<d", estimate.now_bit_torque_nm))
            (estimate.now_bit_torque_nm,) = struct.unpack("<d", struct.pack("<Q", bits ^ 1))

    verdict = verify(recorded(tmp_path / "a.mcap", ticks(50), damage=flip), Sum().step)

    assert (verdict.compared, verdict.mismatches, verdict.exact) == (50, 1, False)
    assert verdict.first is not None
    assert (verdict.first.number, verdict.first.field) == (31, "now_bit_torque_nm")
    assert verdict.first.recorded != verdict.first.recomputed


def set_zero(estimate: Estimate) -> None:
    estimate.now_bit_speed_rad_s = 0.0


def set_quality(estimate: Estimate) -> None:
    estimate.quality = 2  # type: ignore[assignment]


def clear_torque(estimate: Estimate) -> None:
    estimate.ClearField("now_bit_torque_nm")


@pytest.mark.parametrize(
    ("damage", "field", "recorded_value"),
    [
        (set_zero, "now_bit_speed_rad_s", 0.0),
        (set_quality, "quality", 2),
        (clear_torque, "now_bit_torque_nm", None),
    ],
)
def test_a_field_that_is_set_and_one_that_is_not_differ(
    tmp_path: Path, damage: Callable[[Estimate], None], field: str, recorded_value: object
) -> None:
    verdict = verify(recorded(tmp_path / "a.mcap", ticks(3), damage=damage), Sum().step)
    assert verdict.mismatches == 3
    assert verdict.first is not None
    assert (verdict.first.number, verdict.first.field, verdict.first.recorded) == (0, field, recorded_value)


@pytest.mark.parametrize(("was", "comes"), [(0.0, -0.0), (1.0, NAN), (NAN, 1.0)])
def test_values_are_compared_by_their_bits(tmp_path: Path, was: float, comes: float) -> None:
    def put(value: float) -> Callable[[Estimate], None]:
        def into(estimate: Estimate) -> None:
            estimate.forecast_bit_torque_nm = value

        return into

    def step(tick: Tick) -> Estimate:
        estimate = Estimate(number=tick.number, time_ns=tick.time_ns, now_bit_torque_nm=tick.motor_torque_nm)
        put(comes)(estimate)
        return estimate

    session = recorded(tmp_path / "a.mcap", ticks(1), damage=put(was))
    assert verify(session, step).mismatches == 1

    (tmp_path / "a.mcap").unlink()
    session = recorded(tmp_path / "a.mcap", ticks(1), damage=put(comes))
    assert verify(session, step).exact


@given(st.sets(st.integers(0, 19), min_size=1, max_size=19))
def test_a_hole_in_the_ticks_is_a_gap_and_no_mismatch(
    tmp_path_factory: pytest.TempPathFactory, missing: set[int]
) -> None:
    path = tmp_path_factory.mktemp("hole") / "a.mcap"
    kept = [tick for tick in ticks(20) if tick.number not in missing]

    verdict = verify(recorded(path, kept), Sum().step)

    first = min(missing)
    later = [tick.number for tick in kept if tick.number > first]
    assert verdict.mismatches == 0
    assert verdict.gap == (Gap(first, later[0]) if later else None)
    assert verdict.ticks == first


def test_a_fresh_start_is_no_gap(tmp_path: Path) -> None:
    told = [*ticks(10), *ticks(7)]
    verdict = verify(recorded(tmp_path / "a.mcap", told), Sum().step)
    assert (verdict.ticks, verdict.compared, verdict.exact) == (17, 17, True)


def test_ticks_whose_estimate_was_not_recorded_are_run_but_not_compared(tmp_path: Path) -> None:
    session = recorded(tmp_path / "a.mcap", ticks(10), without=lambda estimate: estimate.number in (4, 9))
    verdict = verify(session, Sum().step)
    assert (verdict.ticks, verdict.compared, verdict.exact) == (10, 8, True)


def test_nothing_compared_is_not_exact(tmp_path: Path) -> None:
    session = recorded(tmp_path / "a.mcap", ticks(10), without=lambda _: True)
    assert not verify(session, Sum().step).exact
