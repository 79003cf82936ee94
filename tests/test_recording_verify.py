"""Verification: a single bit that differs is found, a hole is called a hole."""

import math
import struct
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.errors import InputError
from vsensor.messages import BIT_ESTIMATE, SENSOR_STATE, SENSOR_TICK, Array, Estimate, State, Tick
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

    def take_up(self, state: State) -> None:
        if len(state.arrays) != 1:
            raise ValueError("not the state of a sum")
        (self.total,) = struct.unpack("<d", state.arrays[0].data)

    def forget(self) -> None:
        self.total = 0.0

    def state(self, number: int) -> State:
        return State(number=number, arrays=[Array(name="total", data=struct.pack("<d", self.total))])


class Stepping(Sum):
    """A machine that steps by another's rule."""

    def __init__(self, rule: Callable[[Tick], Estimate]) -> None:
        super().__init__()
        self._rule = rule

    def step(self, tick: Tick) -> Estimate:
        return self._rule(tick)


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
    verdict = verify(recorded(tmp_path / "a.mcap", ticks(50)), Sum())
    assert verdict == Verdict(ticks=50, compared=50)
    assert verdict.exact


def test_a_single_flipped_bit_is_found(tmp_path: Path) -> None:
    def flip(estimate: Estimate) -> None:
        if estimate.number == 31:
            (bits,) = struct.unpack("<Q", struct.pack("<d", estimate.now_bit_torque_nm))
            (estimate.now_bit_torque_nm,) = struct.unpack("<d", struct.pack("<Q", bits ^ 1))

    verdict = verify(recorded(tmp_path / "a.mcap", ticks(50), damage=flip), Sum())

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
    verdict = verify(recorded(tmp_path / "a.mcap", ticks(3), damage=damage), Sum())
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
    assert verify(session, Stepping(step)).mismatches == 1

    (tmp_path / "a.mcap").unlink()
    session = recorded(tmp_path / "a.mcap", ticks(1), damage=put(comes))
    assert verify(session, Stepping(step)).exact


@given(st.sets(st.integers(0, 19), min_size=1, max_size=19))
def test_a_hole_in_the_ticks_is_a_gap_and_no_mismatch(
    tmp_path_factory: pytest.TempPathFactory, missing: set[int]
) -> None:
    path = tmp_path_factory.mktemp("hole") / "a.mcap"
    kept = [tick for tick in ticks(20) if tick.number not in missing]

    verdict = verify(recorded(path, kept), Sum())

    first = min(missing)
    later = [tick.number for tick in kept if tick.number > first]
    assert verdict.mismatches == 0
    assert verdict.ticks == first
    assert verdict.skipped == len(later)
    if later and first:
        assert verdict.gaps[0] == Gap(first, later[0])
    elif later:
        assert verdict.gaps[0] == Gap(None, later[0])
    assert verdict.exact == (not later)


def parted(
    path: Path, told: Sequence[Tick], states: Collection[int], missing: Collection[int] = ()
) -> Session:
    """A session with the state before each of these ticks, and without some of them."""
    estimator = Sum()
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="none") as writer:
        for tick in told:
            if tick.number in states:
                writer.sync()  # a chunk ends here
                writer.write(SENSOR_STATE, estimator.state(tick.number).SerializeToString(), 0, 0)
            estimate = estimator.step(tick)
            if tick.number not in missing:
                writer.write(SENSOR_TICK, tick.SerializeToString(), 0, 0)
                writer.write(BIT_ESTIMATE, estimate.SerializeToString(), 0, 0)
    return Session(path)


def test_a_part_that_begins_in_the_middle_stands_alone_by_its_state(tmp_path: Path) -> None:
    missing = range(30)
    with_state = parted(tmp_path / "a.mcap", ticks(50), {30}, missing)
    without = parted(tmp_path / "b.mcap", ticks(50), {}, missing)

    assert verify(with_state, Sum()) == Verdict(ticks=20, compared=20)
    assert verify(without, Sum()) == Verdict(skipped=20, gaps=[Gap(None, 30)])


def test_behind_a_loss_the_next_state_is_taken_up(tmp_path: Path) -> None:
    session = parted(tmp_path / "a.mcap", ticks(50), {0, 20, 40}, {25, 26})
    verdict = verify(session, Sum())
    assert verdict == Verdict(ticks=35, compared=35, skipped=13, gaps=[Gap(25, 27)])
    assert not verdict.exact


def test_behind_a_damaged_chunk_of_a_torn_session_the_next_state_is_taken_up(tmp_path: Path) -> None:
    path = parted(tmp_path / "a.mcap", ticks(50), {0, 20, 40}).path
    data = bytearray(path.read_bytes())
    data[data.index(Tick(number=25, time_ns=25_000, motor_torque_nm=0.1 * 25).SerializeToString())] ^= 1
    path.write_bytes(data[:-20])
    verdict = verify(Session(path), Sum())
    assert verdict == Verdict(ticks=30, compared=30, gaps=[Gap(20, 40)])
    assert not verdict.exact


def test_a_state_for_another_tick_does_not_bridge_a_gap(tmp_path: Path) -> None:
    session = parted(tmp_path / "a.mcap", ticks(50), {20}, range(22))
    assert verify(session, Sum()) == Verdict(skipped=28, gaps=[Gap(20, 22)])


def test_a_state_that_does_not_fit_is_told(tmp_path: Path) -> None:
    class Other(Sum):
        def take_up(self, state: State) -> None:
            raise ValueError(f"another string than at {state.number}")

    session = parted(tmp_path / "a.mcap", ticks(50), {30}, range(30))
    verdict = verify(session, Other())
    assert (verdict.misfit, verdict.compared, verdict.exact) == ("another string than at 30", 0, False)
    loose = verify(session, Other(), strict=False)
    assert (loose.misfit, loose.ticks, loose.compared) == ("another string than at 30", 20, 20)


def test_a_tick_that_cannot_be_run_is_named(tmp_path: Path) -> None:
    class Short(Sum):
        def step(self, tick: Tick) -> Estimate:
            if tick.number == 7:
                raise ValueError("the string cannot become 1e+09 m longer")
            return super().step(tick)

    session = recorded(tmp_path / "a.mcap", ticks(10))
    with pytest.raises(InputError, match=r"a\.mcap: tick 7 cannot be run again: the string cannot become"):
        verify(session, Short())


def test_a_restart_behind_a_loss_is_not_known_again(tmp_path: Path) -> None:
    told = [*ticks(10)[:5], *ticks(10)[7:], *ticks(4)]
    verdict = verify(recorded(tmp_path / "a.mcap", told), Sum())
    assert (verdict.ticks, verdict.skipped, verdict.gaps) == (5, 7, [Gap(5, 7)])


def test_a_fresh_start_is_no_gap(tmp_path: Path) -> None:
    told = [*ticks(10), *ticks(7)]
    verdict = verify(recorded(tmp_path / "a.mcap", told), Sum())
    assert (verdict.ticks, verdict.compared, verdict.exact) == (17, 17, True)


def test_ticks_whose_estimate_was_not_recorded_are_run_but_not_compared(tmp_path: Path) -> None:
    session = recorded(tmp_path / "a.mcap", ticks(10), without=lambda estimate: estimate.number in (4, 9))
    verdict = verify(session, Sum())
    assert (verdict.ticks, verdict.compared, verdict.exact) == (10, 8, True)


def test_nothing_compared_is_not_exact(tmp_path: Path) -> None:
    session = recorded(tmp_path / "a.mcap", ticks(10), without=lambda _: True)
    assert not verify(session, Sum()).exact
