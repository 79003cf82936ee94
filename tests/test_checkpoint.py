"""What the sensor remembers, taken up at any tick, goes on to the same bits."""

from collections.abc import Iterator

import pytest

from tests.rigs import BEGUN_NS, NS, SHORT, Surface, samples, simulated
from tests.strings import PIPE
from vsensor import checkpoint
from vsensor.commands import COMMAND
from vsensor.intake import FORECAST_SHED
from vsensor.messages import (
    SENSOR_EVENT,
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    SURFACE_SPEED,
    Estimate,
    Event,
    Sample,
    State,
    Tick,
)
from vsensor.service.engine import Engine

Fed = list[tuple[str, Sample | Event]]


def troubled() -> Fed:
    """Eight seconds of drilling with all that the intake must remember: holes, jumps, depths, commands."""
    feed: Fed = list(samples(simulated(8)))
    missing = set(range(300, 308)) | {411}
    fed = [item for at, item in enumerate(feed) if at not in missing]
    told = Event(time_ns=BEGUN_NS, name=COMMAND, begins=True, text="longer 28.5 m")
    fed.insert(350, (SENSOR_EVENT, told))
    fed.insert(360, (SENSOR_EVENT, Event(time_ns=BEGUN_NS, name=FORECAST_SHED, begins=True)))
    fed.insert(500, (SURFACE_SPEED, Sample(time_ns=BEGUN_NS + 90 * NS, value=9.0, sequence=7)))
    fed.insert(
        448, (SURFACE_SPEED, Sample(time_ns=fed[447][1].time_ns + 3 * NS // 2, value=30.0, sequence=7))
    )
    fed.insert(150, (SURFACE_BIT_DEPTH, Sample(time_ns=BEGUN_NS, value=1190.0)))
    fed.insert(151, (SURFACE_HOLE_DEPTH, Sample(time_ns=BEGUN_NS, value=1190.2)))
    return fed


FED = troubled()


def ran(engine: Engine, fed: Fed) -> Iterator[tuple[bytes, bytes]]:
    for topic, sample in fed:
        for tick, estimate in engine.take(topic, sample):
            yield tick.SerializeToString(), estimate.SerializeToString()


def saved(engine: Engine) -> State:
    """As it comes back from a file."""
    state = checkpoint.whole(*checkpoint.remembered(engine.intake, engine.estimator))
    return State.FromString(state.SerializeToString())


CUTS = (0, 1, 153, 305, 351, 353, 400, 451, 504, len(FED) - 1)
"""Before anything came, within holes, between a command and the tick that it is for, behind a sample
that waits for another to bear it out, behind a jump."""


def test_taken_up_between_two_samples_all_that_follows_is_the_same() -> None:
    engine, other = Engine(SHORT), Engine(SHORT)
    states: list[tuple[int, State]] = []
    given: list[list[tuple[bytes, bytes]]] = []
    for at, item in enumerate(FED):
        if at in CUTS:
            states.append((at, saved(engine)))
        given.append(list(ran(engine, [item])))
    for cut, state in states:
        other.take_up(state)
        assert list(ran(other, FED[cut:])) == [answer for answers in given[cut:] for answer in answers], cut


def test_it_names_the_next_tick_and_the_time_of_the_last() -> None:
    engine = Engine(SHORT)
    assert (saved(engine).number, saved(engine).HasField("time_ns")) == (0, False)
    ticks = [tick for topic, sample in FED[:200] for tick, _ in engine.take(topic, sample)]
    assert saved(engine).number == ticks[-1].number + 1
    assert saved(engine).time_ns == ticks[-1].time_ns


def test_a_state_of_another_string_is_refused_and_changes_nothing() -> None:
    two_parts = SHORT.model_copy(update={"string": (PIPE, *SHORT.string)})
    engine, untouched = Engine(two_parts), Engine(two_parts)
    with pytest.raises(ValueError, match="the configuration asks for"):
        engine.take_up(saved(Engine(SHORT)))
    feed: Surface = samples(simulated(2))
    assert list(ran(engine, list(feed))) == list(ran(untouched, list(feed)))


def damaged(field: str, value: object) -> State:
    state = saved(Engine(SHORT))
    setattr(state.arrays[3] if field != "intake" else state, field, value)
    return state


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("dtype", "|O"),
        ("dtype", "nonsense"),
        ("data", b"123"),
        ("name", "another"),
        ("intake", "{"),
        ("intake", "{}"),
        ("intake", "[]"),
    ],
)
def test_a_state_that_cannot_be_read_is_refused_with_a_reason(field: str, value: object) -> None:
    with pytest.raises(ValueError, match="state"):
        Engine(SHORT).take_up(damaged(field, value))


def test_the_length_of_a_string_that_grew_is_taken_up_exactly() -> None:
    engine, other = Engine(SHORT), Engine(SHORT)
    for metres in (0.1, 28.5):
        engine.intake.depths.lengthen(metres)
        longer_by = engine.intake.depths.longer_by()
        engine.step(Tick(number=1, motor_torque_nm=1e3, motor_speed_rad_s=9.0, longer_by_m=longer_by))
    other.take_up(saved(engine))
    assert [part.length for part in other.estimator.string] == [p.length for p in engine.estimator.string]
    assert engine.estimator.string[0].length > SHORT.string[0].length + 28
    assert isinstance(other.step(Tick(number=2)), Estimate)
