"""Events: each begins and ends once, at the time on the source's clock at which it was so."""

import math
from collections.abc import Sequence

import pytest

from tests.strings import PIPE, rig
from vsensor.depth import Depths
from vsensor.estimator.figures import STUCK_SPEED
from vsensor.grid import NS
from vsensor.messages import SURFACE_BIT_DEPTH, Estimate, Event, Profile, Sample, Tick
from vsensor.messages.vsensor_pb2 import BAD, GOOD
from vsensor.service.watch import RELIEVED, STANDING_S, STUCK_S, Condition, Watch

MS = 1_000_000
DELAY_S = 0.5
SMALL = rig(PIPE)
Told = tuple[str, bool, int]


def watch(
    speeds: Sequence[tuple[float, float | None]], watching: Watch | None = None, first: int = 0
) -> list[Told]:
    """Events of ticks at 100 Hz, given motor speed at the tick and the bit's half a second earlier."""
    watching = watching or Watch(SMALL)
    told: list[Event] = []
    for number, (surface, bit) in enumerate(speeds):
        time_ns = (first + number) * 10 * MS
        tick = Tick(number=number, time_ns=time_ns, motor_speed_rad_s=surface)
        estimate = Estimate(number=number, time_ns=time_ns)
        if bit is not None:
            estimate.confirmed_time_ns = time_ns - round(DELAY_S * 1e9)
            estimate.confirmed_bit_speed_rad_s = bit
            estimate.top_speed_rad_s = speeds[max(0, number - round(DELAY_S * 100))][0]
        told += watching.tick(tick, estimate)
    return [(event.name, event.begins, event.time_ns) for event in told]


WARMING = [(8.0, None)] * 100


def test_a_condition_is_told_when_it_changes_and_only_then() -> None:
    condition = Condition("wet", "it rains", "it is over")
    seen = [condition.see(holds, time_ns) for time_ns, holds in enumerate([False, True, True, False, False])]
    assert seen == [
        None,
        Event(time_ns=1, name="wet", begins=True, text="it rains"),
        None,
        Event(time_ns=3, name="wet", begins=False, text="it is over"),
        None,
    ]


def test_a_bit_that_stands_while_the_surface_turns_is_stuck_from_when_it_stopped() -> None:
    speeds = [*WARMING, *[(8.0, 8.0)] * 50, *[(8.0, 0.2)] * 100, *[(8.0, 8.0)] * 20]
    begun, over = (1500 - 500) * MS, (2500 - 500) * MS
    assert watch(speeds) == [("stuck", True, begun), ("stuck", False, over)]


@pytest.mark.parametrize("direction", [1, -1])
def test_it_is_stuck_whichever_way_the_surface_turns(direction: int) -> None:
    assert len(watch([(8.0 * direction, 0.1)] * 100)) == 1


def test_a_stop_that_is_shorter_is_a_turning_point() -> None:
    short = round(STUCK_S * 100)
    assert watch([*WARMING, *[(8.0, 0.0)] * short, *[(8.0, 8.0)] * 50]) == []
    assert len(watch([*WARMING, *[(8.0, 0.0)] * (short + 1), *[(8.0, 8.0)] * 50])) == 2


def test_a_string_at_rest_is_not_stuck() -> None:
    assert watch([(0.0, 0.0)] * 500) == []
    assert watch([(2 * STUCK_SPEED - 0.01, 0.0)] * 500) == []


def test_surface_and_bit_are_compared_at_one_time() -> None:
    """When the driller begins to turn, the bit's answers are from before that for half a second more."""
    resting, turning = [(0.0, 0.0)] * 100, [(8.0, 0.0)] * 50
    assert watch([*resting, *turning, *[(8.0, 8.0)] * 100]) == []

    told = watch([*resting, *[(8.0, 0.0)] * 200])
    assert told == [("stuck", True, 1000 * MS)]  # not half a second before the surface moved


def test_where_the_surface_stops_too_the_bit_is_no_longer_stuck() -> None:
    told = watch([*[(8.0, 0.0)] * 200, *[(0.0, 0.0)] * 200])
    assert [begins for _, begins, _ in told] == [True, False]


def test_an_unknown_bit_is_not_stuck_and_the_end_has_the_ticks_own_time() -> None:
    """The grid was laid anew while the bit was stuck: no answer, so that no time of an answer is known."""
    watching = Watch(SMALL)
    assert len(watch([(8.0, 0.0)] * 200, watching)) == 1
    assert watch([(8.0, None)] * 10, watching, first=10_000) == [("stuck", False, 100_000 * MS)]


@pytest.mark.parametrize(("severity", "told"), [(0.99, []), (1.0, ["stick_slip"]), (math.nan, [])])
def test_stick_slip_is_told_by_severity(severity: float, told: list[str]) -> None:
    assert [event.name for event in Watch(SMALL).second(severity, input_lost=False)] == told


def test_lost_input_is_told_with_the_time_of_the_last_tick() -> None:
    watching = Watch(SMALL)
    watch([(8.0, 8.0)] * 201, watching)
    (lost,) = watching.second(0.1, input_lost=True)
    assert (lost.name, lost.begins, lost.time_ns) == ("input_lost", True, 2000 * MS)
    assert watching.second(0.1, input_lost=True) == []
    (back,) = watching.second(0.1, input_lost=False)
    assert (back.name, back.begins) == ("input_lost", False)


def along(margin: float, time_ns: int = 0) -> Profile:
    """A profile with this least margin, in a collar of 30 kN·m."""
    return Profile(
        time_ns=time_ns,
        quality=GOOD,
        weakest_component="collar",
        weakest_depth_m=2700.4,
        weakest_torque_nm=(margin - 1) * 30e3,
        weakest_limit_nm=30e3,
        weakest_limited_by="make-up torque",
        weakest_margin=margin,
    )


def test_over_torque_names_the_component_its_depth_torque_and_limit() -> None:
    """At the confirmed time, whichever way the torque turns."""
    begun = Watch(SMALL).profile(along(-0.1, 7 * MS))
    assert begun == Event(
        time_ns=7 * MS,
        name="over_torque",
        begins=True,
        text="a component bears more torque than it may: collar, 2700 m down, bears 33.0 kN·m of 30.0 kN·m "
        "(make-up torque)",
    )


def test_over_torque_ends_only_when_there_is_some_margin_again() -> None:
    watching = Watch(SMALL)
    margins = [0.2, 0.001, -0.001, 0.001, -0.001, RELIEVED - 0.001, RELIEVED, 0.001, -0.001]
    told = [watching.profile(along(margin)) for margin in margins]
    assert [None if event is None else event.begins for event in told] == [
        *[None, None, True],
        *[None, None, None, False],
        *[None, True],
    ]


def test_a_profile_that_is_bad_or_knows_no_limit_changes_nothing() -> None:
    watching = Watch(SMALL)
    bad = along(-0.5)
    bad.quality = BAD
    assert watching.profile(bad) is None
    assert watching.profile(Profile(quality=GOOD)) is None
    assert watching.profile(along(-0.5)) is not None
    bad.weakest_margin = 0.5
    assert watching.profile(bad) is None


def test_a_string_that_has_turned_and_stands_still_hangs_in_slips_since_it_stopped() -> None:
    watching = Watch(SMALL)
    standing = round(STANDING_S * 100)
    told = watch([*[(8.0, None)] * 100, *[(0.0, None)] * (standing + 50), *[(8.0, None)] * 10], watching)
    stopped, turned = 990 * MS, (100 + standing + 50) * 10 * MS
    assert told == [("connection", True, stopped), ("connection", False, turned)]


def test_the_string_behind_a_gear_stands_still_while_the_motor_creeps() -> None:
    """Behind a gear of 10, a motor at 5 rad/s turns the string at half a radian a second: hardly."""
    geared = rig(PIPE, top_drive={"gear_ratio": 10.0})
    standing = round(STANDING_S * 100) + 50
    creeps = [*[(80.0, None)] * 100, *[(5.0, None)] * standing]
    assert [name for name, _, _ in watch(creeps, Watch(geared))] == ["connection"]
    assert watch(creeps, Watch(SMALL)) == []


def test_a_string_that_never_turned_or_stops_for_short_is_at_no_connection() -> None:
    assert watch([(0.0, None)] * 3000) == []
    brief = round(STANDING_S * 100) - 10
    assert watch([*[(8.0, None)] * 100, *[(0.0, None)] * brief, *[(8.0, None)] * 10]) == []


def test_off_bottom_and_a_string_that_grew_are_told() -> None:
    watching = Watch(SMALL)
    ticks = [
        Tick(number=1, time_ns=1, off_bottom=True),
        Tick(number=2, time_ns=2, off_bottom=True, longer_by_m=28.5),
        Tick(number=3, time_ns=3, longer_by_m=-57.0),
    ]
    told = [event for tick in ticks for event in watching.tick(tick, Estimate(time_ns=tick.time_ns))]
    assert [(event.name, event.begins, event.time_ns) for event in told] == [
        ("off_bottom", True, 1),
        ("string_changed", True, 2),
        ("string_changed", True, 3),
        ("off_bottom", False, 3),
    ]
    assert told[1].text == "the string is 28.5 m longer"
    assert told[2].text == "the string is 57.0 m shorter"


def test_a_stick_foretold_is_told_with_its_time() -> None:
    watching = Watch(SMALL)
    told = [
        event
        for k in range(5)
        for event in watching.tick(
            Tick(number=k + 1), Estimate(time_ns=k, forecast_time_ns=k + NS, stick_in_s=0.8)
        )
    ]
    assert [(event.name, event.text) for event in told] == [
        ("stick_foretold", "the bit is going to stick in 0.8 s")
    ]


def test_each_correction_of_the_configuration_is_told_once_and_by_its_name() -> None:
    watching = Watch(SMALL)
    as_told = 1.0, (0.0, 0.0), 1.0
    assert watching.learned((0.0, 0.0, 0.0, 0.0, 0.0), *as_told) == []
    corrections = -0.0147, 0.022, 0.033, 0.25, 120.0
    (event,) = watching.learned(corrections, *as_told)
    assert (event.name, event.begins) == ("self_tuning", True)
    assert event.text == (
        "the configuration is corrected: delay -1.47%, impedance +2.2%, top-drive inertia +3.3%, "
        "wall friction +25.0%, torque's zero +120 N·m"
    )
    assert watching.learned(corrections, *as_told) == []


@pytest.mark.parametrize(
    ("seen", "told"),
    [
        (((0.0, 0.0), 1.0), "noisier than told: by 3.0 times"),
        (((100.0, 0.0), 1.0), "by 3.0 times, torque is read in steps of 100 N·m"),
        (((0.0, math.pi / 30), 1.0), "by 3.0 times, speed is read in steps of 1 rpm"),
        (((0.0, 0.0), 9.0), "by 3.0 times, speed is read once in 9 ticks"),
    ],
)
def test_channels_that_are_noisier_than_told_are_told_once(
    seen: tuple[tuple[float, float], float], told: str
) -> None:
    watching, nothing = Watch(SMALL), (0.0, 0.0, 0.0, 0.0, 0.0)
    (event,) = watching.learned(nothing, 3.0, *seen)
    assert (event.name, event.begins) == ("noisier", True)
    assert event.text.endswith(told)
    assert watching.learned(nothing, 4.0, *seen) == []
    (event,) = watching.learned(nothing, 1.0, (0.0, 0.0), 1.0)
    assert not event.begins


def test_depths_that_do_not_fit_the_string_are_told() -> None:
    watching, depths = Watch(SMALL), Depths(SMALL)
    for second in range(5):
        depths.take(SURFACE_BIT_DEPTH, Sample(time_ns=second * NS, value=9000.0))
    (event,) = watching.incoming(depths, False, (0, 0))
    assert (event.name, event.begins) == ("depths_at_odds", True)
    assert event.text.endswith("the string is 1500.0 m long")


def test_silent_depths_are_told_and_their_return() -> None:
    watching, depths = Watch(SMALL), Depths(SMALL)
    silences = (False, True, True, False)
    told = [event for silent in silences for event in watching.incoming(depths, silent, (0, 0))]
    assert [(event.name, event.begins) for event in told] == [
        ("depths_silent", True),
        ("depths_silent", False),
    ]


def test_readings_that_are_repeated_are_told_once() -> None:
    watching, depths = Watch(SMALL), Depths(SMALL)
    told = [watching.incoming(depths, False, beats) for beats in ((0, 0), (10, 0), (10, 5), (0, 0))]
    assert [[(event.name, event.begins) for event in events] for events in told] == [
        [],
        [("repeated", True)],
        [],
        [("repeated", False)],
    ]
    assert told[1][0].text.endswith(": torque 10 times")
