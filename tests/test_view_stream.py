"""Messages to batches: what all parts of the view have in common."""

import pytest

from tests.view_rig import BEGUN_NS, DELAY_S, estimate, messages, status, tick
from vsensor.messages import Message, Sample, Status, Tick
from vsensor.view.batches import Batch, Look, Page, Picture, Points
from vsensor.view.series import GLANCE, PAGE
from vsensor.view.stream import FAR_BACK_NS, Stream

NS = 1_000_000_000


def drawn(*given: Message, stream: Stream | None = None) -> list[Batch]:
    stream = stream or Stream()
    for message in given:
        stream.take(message)
    return list(stream.batches())


def test_status_stands_on_the_sources_clock_however_far_away_the_daemons_own_is() -> None:
    years_on = BEGUN_NS + 10 * 365 * 86400 * NS
    batches = drawn(tick(0), status(time_ns=years_on))
    (page,) = (b for b in batches if isinstance(b, Page) and b.entity == "/health")
    assert page.time_ns == BEGUN_NS


def test_before_the_first_tick_status_stands_at_its_own_time() -> None:
    waiting = Status(time_ns=BEGUN_NS + 5, state="waiting for samples")
    pages = [b for b in drawn(waiting) if isinstance(b, Page)]
    assert {page.time_ns for page in pages} == {BEGUN_NS + 5}


def test_the_reach_of_the_answers_is_known_with_the_first_status_that_tells_it() -> None:
    stream = Stream()
    drawn(tick(0), Status(time_ns=BEGUN_NS), stream=stream)
    assert stream.reach is None
    drawn(status(), stream=stream)
    assert stream.reach == (DELAY_S, DELAY_S)


def test_a_source_set_far_back_belongs_on_a_new_recording() -> None:
    stream = Stream()
    stream.take(tick(0))
    assert not stream.falls_back(Tick(time_ns=BEGUN_NS - FAR_BACK_NS))
    assert stream.falls_back(Tick(time_ns=BEGUN_NS - FAR_BACK_NS - 1))
    assert not stream.falls_back(Status(time_ns=0))


@pytest.mark.parametrize(("rate", "every"), [(20, 1), (100, 1), (500, 1), (1000, 2), (2000, 4)])
def test_of_a_fast_sensor_not_every_tick_is_drawn(rate: int, every: int) -> None:
    """And of a source that was set back as many as before."""
    stream, numbers = Stream(), [*range(600, 660), *range(12)]
    times_ns = [BEGUN_NS + number * NS // rate for number in numbers]
    seen = [drawn(Tick(time_ns=at, motor_torque_nm=1, motor_speed_rad_s=1), stream=stream) for at in times_ns]
    lines = [any(isinstance(batch, Points) for batch in batches) for batches in seen]
    assert lines == [number % every == 0 for number in numbers]


def test_silence_is_told_at_the_newest_time_in_words_and_large() -> None:
    stream = Stream()
    before = drawn(tick(5), stream=stream)
    stream.silent(12.3, BEGUN_NS + 99 * NS)
    after = list(stream.batches())
    (page,) = (b for b in after if isinstance(b, Page))
    assert page.time_ns == tick(5).time_ns
    assert "No word for 12 s" in page.text
    large = [[b.png for b in batches if isinstance(b, Picture)] for batches in (before, after)]
    assert len(large[1]) == 1
    assert large[0] != large[1]


def test_samples_are_passed_over() -> None:
    assert not any(isinstance(b, Points) for b in drawn(Sample(time_ns=BEGUN_NS, value=1.0)))


def test_what_was_handed_over_is_not_handed_over_again() -> None:
    stream = Stream()
    assert drawn(*(message for _, message in messages(300)), stream=stream)
    assert list(stream.batches()) == []


@pytest.mark.parametrize("ticks", [300, 900])
def test_every_line_has_a_look(ticks: int) -> None:
    batches = drawn(*(message for _, message in messages(ticks)))
    looks = {batch.entity for batch in batches if isinstance(batch, Look)}
    dots = {"/speed/present", "/torque/present"}
    assert {batch.entity for batch in batches if isinstance(batch, Points)} <= looks | dots


def test_large_figures_and_the_page_of_answers_are_drawn_together() -> None:
    """Of one estimate: who looks from one to the other must not see two speeds."""
    stream = Stream()
    drawn(tick(0), stream=stream)  # the large figures are drawn once before any status
    together = []
    for number in range(1, 200, 7):
        batches = drawn(tick(number), estimate(number), *([status()] if number < 20 else []), stream=stream)
        large = [b for b in batches if isinstance(b, Picture) and b.entity == GLANCE]
        answers = [b for b in batches if isinstance(b, Page) and b.entity == PAGE]
        together.append((len(large), len(answers)))
    assert (1, 1) in together
    # A picture that is the same again is not sent.
    assert all(larges <= pages for larges, pages in together)
