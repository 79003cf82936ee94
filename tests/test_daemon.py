"""One life of a daemon, from its first second to its end, with all that a bus can throw at it."""

import math
from itertools import pairwise
from pathlib import Path
from typing import cast

import pytest
from typer.testing import CliRunner

from tests.life import REFUSED, UNREADABLE, Life, live, torque
from tests.rigs import RATE, SHORT
from vsensor import __version__
from vsensor.cli import main
from vsensor.messages import (
    BIT_ESTIMATE,
    BIT_SPEED,
    BIT_TORQUE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    SENSOR_UNREADABLE,
    STRING_DESCRIPTION,
    STRING_PROFILE,
    SURFACE_TORQUE,
    Description,
    Estimate,
    Event,
    Profile,
    Sample,
    Status,
    Tick,
    Unreadable,
    surface,
)
from vsensor.recording.reader import Session
from vsensor.service.histogram import quantile_s

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def life(tmp_path_factory: pytest.TempPathFactory) -> Life:
    return live(tmp_path_factory.mktemp("life"))


def test_without_samples_it_waits_and_estimates_nothing(life: Life) -> None:
    waiting = life.statuses["waiting"]
    assert waiting.state == "waiting for samples"
    assert (waiting.ticks, waiting.published, life.estimates_while_waiting) == (0, 0, 0)


def test_it_says_that_it_lives(life: Life) -> None:
    assert life.alive


def test_its_status_can_be_asked_for(life: Life) -> None:
    (reply,) = life.replies
    assert (reply.rig, reply.version, reply.rate_hz) == (SHORT.rig.name, __version__, RATE)
    ahead = [skill.ahead_s for skill in reply.skill]
    assert ahead == sorted(ahead)
    assert (ahead[0], ahead[-1]) == (0.0, reply.forecast_horizon_s)


def test_each_form_of_a_sample_makes_ticks_and_none_of_the_bad_ones_stops_them(life: Life) -> None:
    """Ten seconds: four in protobuf, four in JSON, and two more with all the bad ones before them."""
    ticks = cast("list[Tick]", life.recorded(SENSOR_TICK))
    assert [tick.number for tick in ticks] == list(range(len(ticks)))
    assert len(ticks) >= 10 * RATE + 5
    assert life.statuses["back"].restarts == 0


def test_each_bad_sample_is_refused_and_counted_for_what_is_wrong_with_it(life: Life) -> None:
    books = torque(life.statuses["tormented"])
    assert {reason: books[reason] for reason in REFUSED} == REFUSED
    assert books["lost"] == 0


def test_the_books_balance_at_all_times(life: Life) -> None:
    told = cast("list[Status]", life.recorded(SENSOR_STATUS))
    assert len(told) >= 4
    for status in told:
        books = torque(status)
        assert books["received"] == books["accepted"] + sum(books[reason] for reason in REFUSED)
        assert status.slots_due == status.slots_run + status.slots_skipped


def test_estimates_go_on_after_it_all(life: Life) -> None:
    assert life.statuses["after"].published >= life.statuses["tormented"].published + RATE
    last = cast("Estimate", life.heard[BIT_ESTIMATE][-1])
    assert last.HasField("forecast_bit_torque_nm")


def test_the_loss_of_input_is_told_and_its_return(life: Life) -> None:
    told = [begins for name, begins in life.events if name == "input_lost"]
    assert told
    assert told == [True, False] * (len(told) // 2)
    silent = life.statuses["lost"]
    assert all(channel.age_s > 1 for channel in silent.channels)
    assert all(channel.age_s < 1.5 for channel in life.statuses["back"].channels)


def test_the_bit_is_published_as_a_real_sensor_would(life: Life) -> None:
    estimates = {e.number: e for e in cast("list[Estimate]", life.recorded(BIT_ESTIMATE))}
    for topic, name in ((BIT_SPEED, "now_bit_speed{}_rad_s"), (BIT_TORQUE, "now_bit_torque{}_nm")):
        heard = cast("list[Sample]", life.heard[topic])
        assert heard  # all of them only in the session: on a full line the bus drops, it never waits
        for sample in heard:
            estimate = estimates[sample.sequence]
            assert sample.value == getattr(estimate, name.format(""))
            assert sample.standard_deviation == getattr(estimate, name.format("_std"))
            assert (sample.time_ns, sample.quality) == (estimate.time_ns, estimate.quality)


def test_the_string_is_told_ten_times_a_second_at_the_confirmed_time(life: Life) -> None:
    """Over the bus as in the session, each under the schema that the file bears."""
    estimates = {e.number: e for e in cast("list[Estimate]", life.recorded(BIT_ESTIMATE))}
    recorded = {p.number: p for p in cast("list[Profile]", life.recorded(STRING_PROFILE))}
    known = [n for n, e in estimates.items() if n % 5 == 0 and e.HasField("confirmed_bit_speed_rad_s")]
    assert len(known) > 50
    # On a busy machine the loop may leave it out for some seconds, and says so.
    told = cast("list[Event]", life.recorded(SENSOR_EVENT))
    shed_ns = min((e.time_ns for e in told if e.name == "profile_shed"), default=math.inf)
    known = [n for n in known if estimates[n].time_ns < shed_ns]
    assert [n for n in sorted(recorded) if estimates[n].time_ns < shed_ns] == sorted(known)
    assert known
    for number, profile in recorded.items():
        assert profile.time_ns == estimates[number].confirmed_time_ns
        speed = estimates[number].confirmed_bit_speed_rad_s
        if abs(speed) > 1:  # a bit at rest, or hardly turning, is held by more than waves tell
            assert profile.speed_rad_s[-1] == pytest.approx(speed, abs=profile.speed_std_rad_s[-1])
        assert profile.depth_m[-1] == SHORT.string[0].length
    heard = cast("list[Profile]", life.heard[STRING_PROFILE])
    assert heard
    assert all(profile == recorded[profile.number] for profile in heard)


def test_what_the_string_is_is_told_too(life: Life) -> None:
    told = cast("list[Description]", life.recorded(STRING_DESCRIPTION))
    profile = cast("list[Profile]", life.recorded(STRING_PROFILE))[0]
    assert told
    assert all(description.depth_m == profile.depth_m for description in told)


def test_the_status_tells_what_becomes_of_the_power(life: Life) -> None:
    told = [s for s in cast("list[Status]", life.recorded(SENSOR_STATUS)) if s.HasField("top_power_w")]
    assert told
    for status in told:
        assert status.lost_power_w == pytest.approx(status.top_power_w - status.bit_power_w)
        assert 0 <= status.stuck_share <= 1
        assert 0 <= status.back_rotation_share <= 1


def test_each_turn_is_in_the_histograms_and_quantiles_come_of_them(life: Life) -> None:
    told = cast("list[Status]", life.recorded(SENSOR_STATUS))
    for before, status in pairwise(told):
        # The turn that tells has woken already, and is not done.
        assert sum(status.lateness.counts) == status.slots_run
        assert sum(status.work.counts) in (status.slots_run - 1, status.slots_run)
        for name in ("lateness", "work", "input_age", "publish"):
            counts, earlier = (list(getattr(each, name).counts) for each in (status, before))
            since = [now - then for now, then in zip(counts, earlier, strict=True)]
            assert status.HasField(f"{name}_p50_s") == any(since)  # type: ignore[arg-type]
            if any(since):
                assert getattr(status, f"{name}_p99_s") == quantile_s(since, 0.99)
    last = told[-1]
    assert last.input_age_p99_s >= last.input_age_p50_s > 0
    assert last.publish.sum_s < last.work.sum_s


def test_ctrl_c_ends_it_well_and_the_session_is_complete(life: Life) -> None:
    assert life.exit_status == 0
    assert f"event=recorded rig={SHORT.rig.name} path={life.session}" in life.said
    session = Session(life.session)
    assert session.complete
    assert session.recorder["ended"] == "closed by the daemon"
    assert life.statuses["back"].recording == str(life.session)


def test_what_came_in_is_recorded_even_where_it_was_refused(life: Life) -> None:
    books = torque(cast("list[Status]", life.recorded(SENSOR_STATUS))[-1])
    assert len(life.recorded(SURFACE_TORQUE)) == books["received"] - books["unreadable"]
    assert [message for message in life.recorded(SENSOR_EVENT) if message] != []


def test_what_could_not_be_read_is_recorded_as_it_came(life: Life) -> None:
    kept = cast("list[Unreadable]", life.recorded(SENSOR_UNREADABLE))
    came = [(payload if len(payload) <= surface.MAX_BYTES else b"", named) for payload, named in UNREADABLE]
    assert [(each.payload, each.encoding) for each in kept] == came
    assert {each.channel for each in kept} == {SURFACE_TORQUE}
    assert all(each.fault for each in kept)


def test_the_session_verifies(life: Life) -> None:
    result = CliRunner().invoke(main.app, ["verify", str(life.session)])
    assert (result.exit_code, result.output) == (
        0,
        f"{life.session}: exact: {len(life.recorded(BIT_ESTIMATE))} estimates came out bit for bit\n",
    )


def test_estimates_from_the_recorded_samples_are_those_of_the_life_bit_for_bit(
    life: Life, tmp_path: Path
) -> None:
    again = tmp_path / "again.mcap"
    result = CliRunner().invoke(main.app, ["estimate", str(life.session), "-o", str(again)])
    assert result.exit_code == 0, result.output
    made = [record.message.SerializeToString() for record in Session(again).messages((BIT_ESTIMATE,))]
    assert made == [message.SerializeToString() for message in life.recorded(BIT_ESTIMATE)]
