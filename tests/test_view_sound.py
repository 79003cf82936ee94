"""Whatever comes over the bus, the view goes on; what makes no sense is not drawn."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.view_rig import BEGUN_NS, description, estimate, messages, profile, status, tick
from vsensor.messages import Description, Estimate, Message, Profile, Status, Tick
from vsensor.view.sound import sound
from vsensor.view.stream import Stream

NUMBERS = st.floats() | st.sampled_from([0.0, -1.0, 1e308, math.inf, math.nan])
TIMES = st.integers(-(1 << 63), (1 << 63) - 1) | st.integers(BEGUN_NS, BEGUN_NS + 10_000_000_000)
KINDS: list[Callable[[], Message]] = [Tick, Estimate, Profile, Description, Status]


def any_message(data: st.DataObject) -> Message:
    """Of any kind, with any fields set to any numbers, and sometimes otherwise sound."""
    makers: list[Callable[[], Message]] = [
        *KINDS,
        lambda: tick(1),
        lambda: estimate(1),
        lambda: profile(1),
        description,
        status,
    ]
    message = data.draw(st.sampled_from(makers))()
    fields = [f for f in message.DESCRIPTOR.fields if f.type in (f.TYPE_DOUBLE, f.TYPE_SFIXED64)]
    for field in data.draw(st.lists(st.sampled_from(fields), max_size=4, unique_by=lambda f: f.name)):
        if field.is_repeated:
            getattr(message, field.name)[:] = data.draw(st.lists(NUMBERS, max_size=13))
        else:
            value = data.draw(NUMBERS if field.type == field.TYPE_DOUBLE else TIMES)
            setattr(message, field.name, value)
    return message


@given(st.data())
def test_any_numbers_are_survived_between_sound_messages(data: st.DataObject) -> None:
    stream = Stream()
    heard = [message for _, message in messages(data.draw(st.sampled_from([0, 30])))]
    for message in [*heard, any_message(data), any_message(data), status(), tick(2000), estimate(2000)]:
        if not stream.falls_back(message):
            stream.take(message)
    list(stream.batches())


@pytest.mark.parametrize("message", [m for _, m in messages(2)], ids=lambda m: type(m).__name__)
def test_what_a_daemon_sends_is_sound(message: Message) -> None:
    assert sound(message)


def test_a_limit_that_is_not_known_is_no_fault() -> None:
    told = profile(0)
    told.torque_limit_nm[:] = told.margin[:] = [math.nan] * 11
    assert sound(told)


def _without_gear() -> Message:
    told = description()
    told.gear_ratio = 0.0
    return told


def _upside_down() -> Message:
    told = profile(0)
    told.depth_m[:] = told.depth_m[::-1]
    return told


def _too_short() -> Message:
    told = profile(0)
    told.torque_nm.pop()
    return told


@pytest.mark.parametrize(
    "message",
    [
        Tick(motor_torque_nm=math.nan),
        Estimate(now_bit_speed_rad_s=math.inf),
        Status(severity=1e300),
        Profile(),
        Description(),
        _without_gear(),
        _upside_down(),
        _too_short(),
    ],
)
def test_what_makes_no_sense_is_told_from_what_does(message: Message) -> None:
    assert not sound(message)
