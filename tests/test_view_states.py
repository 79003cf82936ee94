"""Bars of states: each question's answer, from its time on."""

import pytest

from tests.view_rig import BEGUN_NS, DELAY_NS, estimate, profile, status, stuck
from vsensor.messages import Estimate, Event, Message, Profile, Status
from vsensor.messages.states import STATES
from vsensor.messages.vsensor_pb2 import BAD, UNCERTAIN
from vsensor.quality import Reason
from vsensor.view.batches import Lane, LaneLook
from vsensor.view.states import States
from vsensor.view.verdicts import Grade, Verdict, bit_state, roughness, strength, trust


def lanes(*given: Message) -> dict[str, list[tuple[int, str]]]:
    """Each lane's states and times; every state of a lane must have its colour."""
    states = States()
    for message in given:
        states.hear(message, BEGUN_NS)
    found: dict[str, list[tuple[int, str]]] = {}
    colours: dict[str, set[str]] = {}
    for batch in states.batches():
        if isinstance(batch, LaneLook):
            colours[batch.entity] = {*batch.colours}
        elif isinstance(batch, Lane):
            assert not batch.state or batch.state in colours[batch.entity]
            found.setdefault(batch.entity, []).append((batch.time_ns, batch.state))
    return found


def bit_at(speed: float, top: float = 10.0, number: int = 0) -> Estimate:
    told = estimate(number)
    told.confirmed_bit_speed_rad_s, told.top_speed_rad_s = speed, top
    return told


@pytest.mark.parametrize(
    ("speed", "top", "word", "grade"),
    [
        (12.0, 10.0, "turns", Grade.WELL),
        (0.2, 10.0, "stands", Grade.ALARM),
        (0.2, 0.1, "rests", Grade.UNKNOWN),
        (-3.0, 10.0, "turns back", Grade.ALARM),
        (-12.0, -10.0, "turns", Grade.WELL),
    ],
)
def test_whether_the_bit_turns_is_asked_of_bit_and_top(
    speed: float, top: float, word: str, grade: Grade
) -> None:
    assert bit_state(bit_at(speed, top), "confirmed") == Verdict(word, grade)


def test_the_bits_state_stands_at_its_confirmed_time_and_only_where_it_changes() -> None:
    told = lanes(*(bit_at(speed, number=number) for number, speed in enumerate((5.0, 5.0, 0.0, 0.0, 5.0))))
    at = [BEGUN_NS - DELAY_NS + number * 10_000_000 for number in (0, 2, 4)]
    assert told["/bit"] == list(zip(at, ("turns", "stands", "turns"), strict=True))


def test_a_stick_that_is_foretold_again_and_again_is_drawn_until_it_is_so_no_more() -> None:
    sticking = [estimate(number) for number in range(14)]
    for told in sticking[3:7]:
        told.stick_in_s = 0.5
    sticking[9].stick_in_s = 0.5  # one alone says nothing
    seen = lanes(*sticking)["/stick-foretold"]
    assert [state for _, state in seen] == ["soon", ""]
    assert seen[0][0] > sticking[3].time_ns


@pytest.mark.parametrize(
    ("severity", "word"),
    [(0.0, "smooth"), (0.49, "smooth"), (0.5, "uneven"), (0.99, "uneven"), (1.0, "stick-slip")],
)
def test_the_severity_is_told_in_a_word(severity: float, word: str) -> None:
    assert roughness(Status(severity=severity)).word == word
    assert lanes(Status(severity=severity))["/stick-slip"] == [(BEGUN_NS, word)]


def test_an_unknown_severity_is_no_smooth_one() -> None:
    assert roughness(Status()).grade is Grade.UNKNOWN


@pytest.mark.parametrize(
    ("margin", "word"), [(0.5, "within limits"), (0.05, "near a limit"), (-0.01, "over a limit")]
)
def test_how_near_a_limit_is_told_with_the_component(margin: float, word: str) -> None:
    near = profile(0)
    near.weakest_margin = margin
    assert strength(near).word == word
    assert strength(near).why == "collars, make-up torque"
    assert lanes(near)["/strength"] == [(near.time_ns, word)]


def test_without_strengths_nothing_is_within_limits() -> None:
    assert strength(Profile()).grade is Grade.UNKNOWN


def test_quality_is_drawn_for_the_driller_in_a_word_and_for_service_with_its_reasons() -> None:
    good, worse, bad = (estimate(number) for number in range(3))
    worse.quality, worse.reasons = UNCERTAIN, int(Reason.STALE_TORQUE)
    bad.quality, bad.reasons = BAD, int(Reason.STALE_TORQUE | Reason.STALE_SPEED)
    seen = lanes(good, worse, bad)
    assert [state for _, state in seen["/trust"]] == ["good", "uncertain", "bad"]
    assert [state for _, state in seen["/sensor/quality"]] == [
        "good",
        "uncertain: stale torque",
        "bad: stale torque, stale speed",
    ]


def test_a_verdict_of_a_newer_daemon_is_not_trusted() -> None:
    strange = estimate(100)
    strange.MergeFromString(bytes([0x88, 0x01, 9]))  # field 17, quality = 9
    assert trust(strange).grade is Grade.UNKNOWN


def test_a_change_of_the_sensors_state_is_drawn_once() -> None:
    seen = lanes(status("warming up"), status("warming up"), status("running"), status("input lost"))
    assert [state for _, state in seen["/sensor/state"]] == ["warming up", "running", "input lost"]


def test_each_state_of_the_sensor_has_its_colour() -> None:
    seen = lanes(*map(status, STATES))  # lanes() looks for the colours
    assert [state for _, state in seen["/sensor/state"]] == list(STATES)


def test_an_event_is_drawn_from_its_begin_to_its_end() -> None:
    seen = lanes(stuck(0, True), stuck(150, False))
    assert seen["/sensor/stuck"] == [(BEGUN_NS, "stuck"), (BEGUN_NS + 1_500_000_000, "")]


@pytest.mark.parametrize("name", ["stick_foretold", "string_changed", "self_tuning", "command", "new"])
def test_an_event_that_never_ends_is_no_state(name: str) -> None:
    assert lanes(Event(time_ns=BEGUN_NS, name=name, begins=True, text="x")) == {}
