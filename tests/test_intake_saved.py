"""What the intake remembers, as a file tells it: taken up, or refused by name with what would be right."""

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from tests.rigs import BEGUN_NS, NS, RATE, SHORT, samples, simulated
from tests.test_intake import BEGUN, MS, SMALL, S, T
from vsensor import checkpoint
from vsensor.cli.main import app
from vsensor.config import effective_toml
from vsensor.intake import Intake
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_STATE,
    SENSOR_TICK,
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    Sample,
    State,
)
from vsensor.recording.writer import SessionWriter
from vsensor.service.engine import Engine

DECADES = 50 * 365 * 86_400 * NS
Place = tuple[str | int, ...]


def fed(intake: Intake) -> Intake:
    """Something of every kind is remembered: a loss, a jump, a point that waits, depths, a doubt."""
    for number in range(40):
        if number not in (31, 32):
            for topic in (T, S):
                at = Sample(time_ns=BEGUN + number * 10 * MS, value=1.0 + number, sequence=number)
                intake.take(topic, at)
    for topic, metres in ((SURFACE_BIT_DEPTH, 999.0), (SURFACE_HOLE_DEPTH, 1000.0)):
        for second in range(4):
            intake.take(topic, Sample(time_ns=BEGUN + (second - 4) * NS, value=metres))
    intake.take(SURFACE_BIT_DEPTH, Sample(time_ns=BEGUN, value=500.0))
    intake.depths.command(off_bottom=True)
    intake.take(T, Sample(time_ns=BEGUN + DECADES, value=1.0))
    intake.take(S, Sample(time_ns=BEGUN + 1500 * MS, value=1.0))
    return intake


def remembered() -> Any:
    """The same as it stands in a file."""
    return json.loads(json.dumps(fed(Intake(SMALL)).save()))


def changed(held: Any, place: Place, value: object) -> Any:
    *way, last = place
    part = held
    for key in way:
        part = part[key]
    part[last] = value
    return held


def places(held: Any, place: Place = ()) -> Iterator[Place]:
    """Where anything stands in it, lists and tables as well as what they hold."""
    inner = held.items() if isinstance(held, dict) else enumerate(held) if isinstance(held, list) else ()
    for key, value in inner:
        yield (*place, key)
        yield from places(value, (*place, key))


def found(held: Any, place: Place) -> Any:
    for key in place:
        held = held[key]
    return held


ANY = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(), inner, max_size=4)),
)
TIMES = st.one_of(
    st.integers(-3 * NS, 3 * NS).map(lambda ns: BEGUN + ns),
    st.sampled_from([BEGUN + DECADES, 1 << 62, -1 << 62, 1 << 63, -1 << 63, 1 << 64, 10**400, -(10**400)]),
)


@given(place=st.sampled_from(list(places(remembered()))), data=st.data())
def test_with_any_other_value_in_it_it_is_refused_by_name_or_can_be_gone_on_with(
    place: Place, data: st.DataObject
) -> None:
    held = remembered()
    was = found(held, place)
    near = [st.integers(-2, 2).map(lambda by: was + by)] if type(was) in (int, float) else []
    longer = [st.integers(0, 3).map(lambda count: was[:count] + was)] if isinstance(was, list) else []
    held = changed(held, place, data.draw(st.one_of(ANY, TIMES, *near, *longer)))
    intake = Intake(SMALL)
    try:
        intake.restore(json.loads(json.dumps(held)))
    except ValueError as error:
        if not str(error).startswith("saved state: intake"):
            raise
        return
    ticks = [
        tick
        for number in range(40, 60)
        for topic in (T, S)
        for tick in intake.take(topic, Sample(time_ns=BEGUN + number * 10 * MS, value=1.0, sequence=number))
    ]
    assert len(ticks) <= 100 * 5
    assert all(math.isfinite(tick.motor_torque + tick.motor_speed) for tick in ticks)
    assert json.dumps(intake.save())


def test_unchanged_it_is_taken_up_whole() -> None:
    intake = Intake(SMALL)
    intake.restore(remembered())
    assert json.loads(json.dumps(intake.save())) == remembered()


POINTS: Place = ("channels", T, "points")


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (
            ("anchor_ns",),
            "now",
            r"intake.anchor_ns holds 'now' where a whole number from -\d+ to \d+ is right",
        ),
        (("anchor_ns",), None, "intake.number holds 40 where 0 without an anchor"),
        (("number",), [1], r"intake.number holds \[1\] where a whole number"),
        (("number",), True, "intake.number holds True where a whole number"),
        (
            ("number",),
            39,
            "intake.consumed_ns holds .* where .*, as anchor, number and rate have it, is right",
        ),
        (("number",), 10**40, "intake.number holds 1000+.* where"),
        (
            ("jump_ns",),
            {"surface/troque": 1},
            "intake.jump_ns holds .* no keys but surface/torque, surface/speed",
        ),
        (("forecast_shed",), 0, "intake.forecast_shed holds 0 where true or false is right"),
        (("channels",), {}, "intake.channels.surface/torque is not there"),
        ((*POINTS, 0), [BEGUN, 1.0], r"points\[0\] holds .* where a list of 3 is right"),
        (
            (*POINTS, 0, 1),
            math.nan,
            r"points\[0\]\[1\] holds nan where a number from -200000 to 200000 is right",
        ),
        (
            (*POINTS, 0, 2),
            1 << 40,
            r"points\[0\]\[2\] holds 1099511627776 where a whole number from 0 to 1023",
        ),
        (POINTS, [], "surface/torque.points holds .* where a list that begins at"),
        (POINTS, [[BEGUN, 1.0, 0]] * 2, "surface/torque.points holds .* where a list in the order of time"),
        (
            POINTS,
            [[BEGUN, 1.0, 0], [BEGUN + DECADES, 1.0, 0]],
            "surface/torque.points holds .* where a list that ends at",
        ),
        (
            ("channels", S, "waiting", 0),
            BEGUN + DECADES,
            "surface/speed.waiting holds .* where a time behind",
        ),
        (("channels", S, "pace_ns"), 0, "surface/speed.pace_ns holds 0 where"),
        (
            ("channels", S, "missing"),
            list(range(2000)),
            "surface/speed.missing holds .* a list of 1000 at the most",
        ),
        (("depths", "length"), math.inf, "intake.depths.length holds inf where a number from"),
        (
            ("depths", "told", SURFACE_BIT_DEPTH, 0),
            -1,
            "told.surface/bit_depth.0. holds -1 where a number from 0",
        ),
        (("frozen",), [[1, 2, 3, 4]], r"intake.frozen holds \[\[1, 2, 3, 4\]\] where a list of 2 is right"),
    ],
)
def test_what_is_wrong_is_told_with_its_place_and_what_is_right(
    place: Place, value: object, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        Intake(SMALL).restore(changed(remembered(), place, value))


def test_samples_of_decades_before_the_grid_was_laid_are_refused() -> None:
    """Of one channel alone, or of both: the other's first sample would lay the grid over all of it."""
    fresh = json.loads(json.dumps(Intake(SMALL).save()))
    far = [[BEGUN, 1.0, 0], [BEGUN + DECADES, 1.0, 0]]
    with pytest.raises(ValueError, match=r"surface/torque.points holds .* where a list that ends at"):
        Intake(SMALL).restore(changed(fresh, POINTS, far))
    spoken = changed(fresh, POINTS, far[:1])
    with pytest.raises(ValueError, match=r"anchor_ns holds None where a time, since both"):
        Intake(SMALL).restore(changed(spoken, ("channels", S, "points"), far[1:]))


def test_a_sample_missed_before_the_state_that_comes_behind_it_is_no_less_than_no_loss() -> None:
    intake = Intake(SMALL)
    intake.restore(remembered())
    assert intake.channels[T].counts.lost == 0
    intake.take(T, Sample(time_ns=BEGUN + 310 * MS, value=1.0, sequence=31))
    assert intake.channels[T].counts.lost == 0


def saved(engine: Engine) -> State:
    return checkpoint.whole(*checkpoint.remembered(engine.intake, engine.estimator))


def running() -> Engine:
    engine = Engine(SHORT)
    for topic, sample in samples(simulated(2)):
        list(engine.take(topic, sample))
    return engine


def nested(_: Any) -> str:
    return "[" * 100_000


def endless(_: Any) -> str:
    return json.dumps("x" * checkpoint.MOST_CHARACTERS)


def damaged(held: Any) -> str:
    return json.dumps(changed(held, ("anchor_ns",), "now"))


def lengthened(held: Any) -> str:
    return json.dumps(changed(held, ("depths", "length"), 15_000.0))


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (nested, "list within lists without end"),
        (endless, "takes more than 16777216 characters"),
        (damaged, "intake.anchor_ns holds 'now'"),
        (lengthened, "depths.length holds 15000.000 m where 1200.000 m is right"),
    ],
)
def test_a_state_whose_intake_is_refused_changes_nothing(harm: Callable[[Any], str], said: str) -> None:
    state = saved(running())
    state.intake = harm(json.loads(state.intake))
    engine = Engine(SHORT)
    before = saved(engine)
    with pytest.raises(ValueError, match=said):
        engine.take_up(state)
    assert saved(engine) == before


@pytest.mark.parametrize("command", ["verify", "estimate"])
def test_of_a_session_the_file_is_named_too(tmp_path: Path, command: str) -> None:
    path = tmp_path / "a.mcap"
    engine = running()
    state = saved(engine)
    state.intake = damaged(json.loads(state.intake))
    later = samples(simulated(4)[2 * RATE :], BEGUN_NS, 2 * RATE)
    rig = SHORT
    with SessionWriter(path, configuration=effective_toml(rig), metadata={}, compression="none") as writer:
        writer.write(SENSOR_STATE, state.SerializeToString(), 0, 0)
        for topic, sample in later:
            writer.write(topic, sample.SerializeToString(), 0, 0)
            for tick, estimate in engine.take(topic, sample):
                writer.write(SENSOR_TICK, tick.SerializeToString(), 0, 0)
                writer.write(BIT_ESTIMATE, estimate.SerializeToString(), 0, 0)
    output = ["-o", str(tmp_path / "b.csv")] if command == "estimate" else []
    done = CliRunner().invoke(app, [command, str(path), *output])
    assert done.exit_code == (1 if command == "verify" else 0)
    told = " ".join(done.output.split())
    assert f"{path}: " in told
    assert "intake.anchor_ns holds 'now' where a whole number from" in told
