"""Overload: profile first, then forecast, then nothing more; back by itself; and exact all the same."""

import math
import signal
import time
from itertools import count
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.daemons import daemon, post, wait_until
from tests.rigs import NS, RATE, SHORT, Surface, samples, simulated
from vsensor.cli import main
from vsensor.config import Bus
from vsensor.intake import FORECAST_SHED
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_PROFILE,
    Estimate,
    Event,
    Sample,
    Status,
    Tick,
)
from vsensor.offline import Offline
from vsensor.recording.reader import Session
from vsensor.recording.verify import verify
from vsensor.service.engine import Engine
from vsensor.service.shed import ALL, MOST_PATIENCE_S, NO_FORECAST, NO_PROFILE, PATIENCE_S, Shedding

FULL, EASY, BETWEEN = 1.0, 0.3, 0.8


def levels(loads: list[float], shedding: Shedding | None = None) -> list[int]:
    shedding = shedding or Shedding()
    return [shedding.second(load) for load in loads]


def test_profile_first_then_forecast_then_nothing_more() -> None:
    assert levels([BETWEEN, FULL, FULL, FULL, FULL]) == [ALL, NO_PROFILE, *[NO_FORECAST] * 3]


def test_each_is_taken_up_again_after_easy_seconds_one_after_the_other() -> None:
    told = levels([FULL, FULL, *[EASY] * 2 * PATIENCE_S])
    waiting = [NO_FORECAST] * (PATIENCE_S - 1)
    assert told == [NO_PROFILE, NO_FORECAST, *waiting, *[NO_PROFILE] * PATIENCE_S, ALL]
    assert levels([FULL, *[EASY, BETWEEN] * 20])[-1] == NO_PROFILE


def test_what_was_taken_up_too_early_is_waited_for_longer_each_time() -> None:
    shedding = Shedding()
    waits = []
    for _ in range(10):
        assert levels([FULL], shedding) == [NO_PROFILE]
        waits.append(next(n for n in range(1, 1000) if shedding.second(EASY) == ALL))
    assert waits == [min(PATIENCE_S * 2**n, MOST_PATIENCE_S) for n in range(10)]
    assert shedding.count == 10
    levels([EASY] * (MOST_PATIENCE_S + 1), shedding)  # and is forgotten after a long calm
    assert levels([FULL, *[EASY] * PATIENCE_S], shedding)[-1] == ALL


def run(feed: Surface, shed: range) -> list[tuple[Tick, Estimate]]:
    """A short rig's engine that is short of time at some ticks."""
    engine = Engine(SHORT)
    told: list[tuple[Tick, Estimate]] = []
    for topic, sample in feed:
        engine.intake.forecast_shed = len(told) in shed
        told.extend(engine.take(topic, sample))
    return told


def test_confirmed_and_now_are_the_same_to_the_bit_and_the_forecast_returns() -> None:
    feed = samples(simulated(16))
    shed = range(8 * RATE, 11 * RATE)
    whole, less = (run(feed, range(0)), run(feed, shed))
    for number, ((_, one), (tick, other)) in enumerate(zip(whole, less, strict=True)):
        assert tick.forecast_shed == other.forecast_shed == (number in shed)
        for kind in ("confirmed", "now"):
            for what in ("speed_rad_s", "speed_std_rad_s", "torque_nm", "torque_std_nm"):
                name = f"{kind}_bit_{what}"
                assert getattr(one, name) == getattr(other, name)
        assert one.quality == other.quality
        if number in shed:
            assert not other.HasField("forecast_bit_speed_rad_s")
            assert not other.HasField("forecast_time_ns")
            assert not other.HasField("stick_in_s")
        elif number < shed.start or number >= shed.stop:
            assert one.HasField("forecast_bit_speed_rad_s") == other.HasField("forecast_bit_speed_rad_s")
    assert less[-1][1].forecast_bit_speed_std_rad_s == pytest.approx(
        whole[-1][1].forecast_bit_speed_std_rad_s, rel=0.2
    )


def test_offline_the_recorded_events_make_the_same_rows() -> None:
    feed = samples(simulated(12))
    begin, end = 8 * RATE * 2, 10 * RATE * 2
    told: list[tuple[str, Sample | Event]] = [
        *feed[:begin],
        (SENSOR_EVENT, Event(name=FORECAST_SHED, begins=True)),
        *feed[begin:end],
        (SENSOR_EVENT, Event(name=FORECAST_SHED, begins=False)),
        *feed[end:],
    ]
    forecasts = np.concatenate([chunk["forecast_speed_rad_s"] for chunk in Offline(SHORT).estimates(told)])
    engine = Engine(SHORT)
    live = [estimate for topic, sample in told for _, estimate in engine.take(topic, sample)]
    expected = [
        e.forecast_bit_speed_rad_s if e.HasField("forecast_bit_speed_rad_s") else math.nan for e in live
    ]
    assert np.isnan(expected[8 * RATE : 10 * RATE]).all()
    assert np.isfinite(expected[10 * RATE :]).all()
    assert forecasts.tobytes() == np.array(expected).tobytes()


@pytest.mark.process
def test_a_daemon_that_cannot_keep_up_sheds_says_so_and_its_session_is_exact(
    bus: Bus, tmp_path: Path
) -> None:
    """Minutes of samples at once, as after a long cut of the link: more than some seconds' work."""
    readings = simulated(6)
    with daemon(SHORT, bus, tmp_path) as sensor:
        with post(sensor) as rig:
            parts = (
                samples(readings, begun_ns + 6 * NS * part, len(readings) * part)
                for begun_ns in [time.time_ns()]
                for part in count()
            )
            told: list[Status] = []

            def overwhelmed() -> bool:
                rig.send(next(parts))
                time.sleep(0.02)  # more would be no flood: the daemon runs some thousand ticks a second
                told.extend(cast("list[Status]", rig.heard(SENSOR_STATUS))[len(told) :])
                return bool(told) and told[-1].shed == NO_FORECAST

            wait_until(overwhelmed, "a shed forecast")
            first = next(status for status in told if status.shed == NO_FORECAST)
            assert first.load > 0.9
            assert first.sheddings == 2
            rig.await_status(lambda status: status.ticks > told[-1].ticks, "ticks without a forecast")
        assert sensor.end(signal.SIGTERM) == 0
        (path,) = sensor.sessions
    session = Session(path)
    assert verify(session, Engine(SHORT)).exact
    events = [r.message for r in session.messages((SENSOR_EVENT,)) if isinstance(r.message, Event)]
    shedding = [(event.name, event.begins) for event in events if event.name.endswith("_shed")]
    assert shedding == [("profile_shed", True), (FORECAST_SHED, True)]
    estimates = [r.message for r in session.messages((BIT_ESTIMATE,)) if isinstance(r.message, Estimate)]
    shed = [e.number for e in estimates if e.forecast_shed]
    assert shed == list(range(shed[0], len(estimates)))
    ticks = [r.message for r in session.messages((SENSOR_TICK,)) if isinstance(r.message, Tick)]
    assert [tick.number for tick in ticks if tick.forecast_shed] == shed
    profiles = [record.message for record in session.messages((STRING_PROFILE,))]
    assert all(getattr(profile, "number", 0) < shed[0] for profile in profiles)

    again = tmp_path / "again.mcap"
    assert CliRunner().invoke(main.app, ["estimate", str(path), "-o", str(again)]).exit_code == 0
    made = [record.message.SerializeToString() for record in Session(again).messages((BIT_ESTIMATE,))]
    assert made == [estimate.SerializeToString() for estimate in estimates]
