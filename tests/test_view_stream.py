"""Messages to what is drawn: everything at its own time, in the units that people read."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.view_rig import BEGUN_NS, DELAY_NS, bit_speed, estimate, messages, status, stuck, tick
from vsensor.messages import Estimate, Message, Sample, Status, Tick
from vsensor.quality import Reason
from vsensor.view.batches import Batch, Lane, LogLine, Look, Page, Points
from vsensor.view.stream import FAR_BACK_NS, Stream

RPM = 60 / (2 * math.pi)
NS = 1_000_000_000


def drawn(*given: Message, stream: Stream | None = None) -> list[Batch]:
    stream = stream or Stream()
    for message in given:
        stream.take(message)
    return list(stream.batches())


def points(batches: list[Batch]) -> dict[str, Points]:
    return {batch.entity: batch for batch in batches if isinstance(batch, Points)}


def pages(batches: list[Batch], entity: str) -> list[Page]:
    return [batch for batch in batches if isinstance(batch, Page) and batch.entity == entity]


def test_surface_speed_and_torque_are_drawn_from_ticks_in_rpm_and_kilonewton_metres() -> None:
    line = points(drawn(tick(0), tick(7)))
    assert line["/speed/at_surface"].times_ns.tolist() == [BEGUN_NS, BEGUN_NS + 70_000_000]
    np.testing.assert_allclose(line["/speed/at_surface"].values, [[10 * RPM], [10 * RPM]])
    np.testing.assert_allclose(line["/torque/at_surface"].values, [[7.0], [7.007]])


def test_behind_a_gear_the_surface_is_drawn_as_the_string_feels_it() -> None:
    line = points(drawn(tick(0), stream=Stream(gear_ratio=8.0, efficiency=0.9)))
    np.testing.assert_allclose(line["/speed/at_surface"].values, [[10 * RPM / 8]])
    np.testing.assert_allclose(line["/torque/at_surface"].values, [[7.0 * 8 * 0.9]])


def test_a_held_value_is_not_drawn_as_measured() -> None:
    held = tick(1)
    held.reasons = int(Reason.STALE_TORQUE)
    line = points(drawn(tick(0), held, tick(2)))
    assert np.isfinite(line["/speed/at_surface"].values).all()
    assert np.isnan(line["/torque/at_surface"].values).ravel().tolist() == [False, True, False]


@pytest.mark.parametrize(("kind", "shift_ns"), [("confirmed", -DELAY_NS), ("now", 0), ("forecast", DELAY_NS)])
def test_each_answer_stands_at_the_time_for_which_it_holds(kind: str, shift_ns: int) -> None:
    numbers = range(200, 600, 2)
    line = points(drawn(*(estimate(number) for number in numbers)))[f"/speed/bit/{kind}"]
    assert line.times_ns.tolist() == [BEGUN_NS + n * NS // 100 + shift_ns for n in numbers]
    truth = [bit_speed((time_ns - BEGUN_NS) / NS) * RPM for time_ns in line.times_ns.tolist()]
    np.testing.assert_allclose(line.values[:, 0], truth, atol=1e-6)


def test_a_band_lies_two_deviations_about_its_line() -> None:
    line = points(drawn(estimate(0)))
    np.testing.assert_allclose(line["/torque/bit/now"].values, [[3.1]])
    np.testing.assert_allclose(line["/torque/band/now"].values, [[3.5, 2.7]])


def test_what_is_not_known_yet_is_not_drawn() -> None:
    found = points(drawn(Estimate(number=0, time_ns=BEGUN_NS)))
    assert found == {}


def test_lateness_is_drawn_in_milliseconds_of_each_tick_and_of_the_second() -> None:
    line = points(drawn(tick(0), status()))
    np.testing.assert_allclose(line["/lateness/each_tick"].values, [[0.05]])
    np.testing.assert_allclose(line["/lateness/p99"].values, [[0.12]])
    np.testing.assert_allclose(line["/severity"].values, [[1.2]])


def test_status_stands_on_the_sources_clock_however_far_away_the_daemons_own_is() -> None:
    years_on = BEGUN_NS + 10 * 365 * 86400 * NS
    batches = drawn(tick(0), status(time_ns=years_on))
    assert pages(batches, "/health")[0].time_ns == BEGUN_NS
    assert points(batches)["/severity"].times_ns.tolist() == [BEGUN_NS]


def test_before_the_first_tick_status_stands_at_its_own_time() -> None:
    waiting = Status(time_ns=BEGUN_NS + 5, state="waiting for samples")
    page = pages(drawn(waiting), "/panel")[0]
    assert page.time_ns == BEGUN_NS + 5
    assert "waiting for samples" in page.text


def test_a_change_of_state_is_logged_once_and_drawn_as_a_lane() -> None:
    batches = drawn(
        tick(0), status("warming up"), status("warming up"), status("running"), status("input lost")
    )
    lines = [batch for batch in batches if isinstance(batch, LogLine)]
    assert [(line.level, line.text) for line in lines] == [
        ("WARN", "22:13:20 sensor: warming up"),
        ("INFO", "22:13:20 sensor: running"),
        ("WARN", "22:13:20 sensor: input lost"),
    ]
    lanes = [batch.state for batch in batches if isinstance(batch, Lane)]
    assert lanes == ["warming up", "running", "input lost"]


def test_an_event_is_logged_and_drawn_from_its_begin_to_its_end() -> None:
    batches = drawn(stuck(0, True), stuck(150, False))
    lines = [batch for batch in batches if isinstance(batch, LogLine)]
    lanes = [batch for batch in batches if isinstance(batch, Lane)]
    assert [line.text for line in lines] == [
        "22:13:20 stuck begins: the bit stands still",
        "22:13:21 stuck ends: the bit stands still",
    ]
    assert lanes == [
        Lane("/event/stuck", BEGUN_NS, "stuck"),
        Lane("/event/stuck", BEGUN_NS + 1_500_000_000, ""),
    ]


def test_the_legend_tells_the_delays_once_they_are_known() -> None:
    stream = Stream()
    before = {b.entity: b.names for b in stream.batches() if isinstance(b, Look)}
    after = {b.entity: b.names for b in drawn(status(), status(), stream=stream) if isinstance(b, Look)}
    assert before["/speed/bit/confirmed"] == ("bit confirmed",)
    assert after["/speed/bit/confirmed"] == ("bit confirmed (1.2 s ago)",)
    assert after["/torque/bit/forecast"] == ("bit forecast (in 1.2 s)",)
    assert not any(isinstance(batch, Look) for batch in drawn(status(), stream=stream))


def test_every_line_has_a_look() -> None:
    batches = drawn(*(message for _, message in messages(300)))
    looks = {batch.entity: batch for batch in batches if isinstance(batch, Look)}
    for entity, line in points(batches).items():
        assert len(looks[entity].names) == line.values.shape[1]


@given(st.lists(st.integers(0, 3), min_size=1, max_size=50))
def test_ticks_that_did_not_reach_the_view_are_counted(holes: list[int]) -> None:
    numbers = np.cumsum([hole + 1 for hole in holes]).tolist()
    batches = drawn(tick(0), *(tick(number) for number in numbers), status())
    assert f"ticks that this view has missed | {_bold(sum(holes))} |" in pages(batches, "/health")[-1].text


def test_a_restarted_estimator_is_no_loss() -> None:
    batches = drawn(tick(40), tick(41), tick(0), tick(1), status())
    assert "ticks that this view has missed | 0 |" in pages(batches, "/health")[-1].text


def test_the_panel_is_written_twice_a_second() -> None:
    batches = drawn(*(message for number in range(300) for message in (tick(number), estimate(number))))
    assert len(pages(batches, "/panel")) == 6


def test_a_source_set_far_back_belongs_on_a_new_recording() -> None:
    stream = Stream()
    stream.take(tick(0))
    assert not stream.falls_back(Tick(time_ns=BEGUN_NS - FAR_BACK_NS))
    assert stream.falls_back(Tick(time_ns=BEGUN_NS - FAR_BACK_NS - 1))
    assert not stream.falls_back(Status(time_ns=0))


def test_silence_is_told_at_the_newest_time() -> None:
    stream = Stream()
    stream.take(tick(5))
    stream.silent(12.3, BEGUN_NS + 99 * NS)
    page = pages(list(stream.batches()), "/panel")[-1]
    assert page.time_ns == tick(5).time_ns
    assert "No word for 12 s" in page.text


def test_samples_are_passed_over() -> None:
    assert not points(drawn(Sample(time_ns=BEGUN_NS, value=1.0)))


def test_what_was_handed_over_is_not_handed_over_again() -> None:
    stream = Stream()
    assert drawn(*(message for _, message in messages(300)), stream=stream)
    assert list(stream.batches()) == []


def _bold(count: int) -> str:
    return f"**{count}**" if count else "0"
