"""What the service tab draws: the loop, the input, and everything that was lost."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.view_rig import BEGUN_NS, status, tick
from vsensor.messages import Message, Status
from vsensor.messages.books import REFUSALS
from vsensor.view import series
from vsensor.view.batches import Batch, Page, Points
from vsensor.view.service import Service


def drawn(*given: Message, part: Service | None = None) -> list[Batch]:
    part = part or Service()
    for message in given:
        part.hear(message, BEGUN_NS)
    return list(part.batches())


def values(batches: list[Batch]) -> dict[str, list[float]]:
    return {batch.entity: batch.values.tolist() for batch in batches if isinstance(batch, Points)}


def health(batches: list[Batch]) -> str:
    return [batch.text for batch in batches if isinstance(batch, Page)][-1]


def later(seconds: int, **changed: int) -> Status:
    told = status()
    told.uptime_s = 100.0 + seconds
    for name, value in changed.items():
        setattr(told.channels[0] if hasattr(told.channels[0], name) else told, name, value)
    return told


def test_lateness_work_and_age_are_drawn_in_milliseconds() -> None:
    told = status()
    told.channels[0].age_s = 0.012
    line = values(drawn(tick(0), told))
    np.testing.assert_allclose(line["/loop/lateness/each_tick"], [0.05])
    np.testing.assert_allclose(line["/loop/lateness/p99"], [0.12])
    np.testing.assert_allclose(line[f"{series.WORK}/p50"], [0.03])
    np.testing.assert_allclose(line[f"{series.WORK}/p99"], [0.09])
    np.testing.assert_allclose(line["/input/age/surface_torque"], [12.0])


def test_what_waits_is_drawn_where_the_daemon_tells_it() -> None:
    assert {*values(drawn(status()))} & {"/queues/inbox", "/queues/recorder", "/queues/disk"} == set()
    told = status()
    told.inbox_waiting, told.recorder_queue_bytes, told.recording_backlog_bytes = 7, 4500, 2_000_000
    line = values(drawn(told))
    assert line["/queues/inbox"] == [7]
    assert line["/queues/recorder"] == [4.5]
    assert line["/queues/disk"] == [2]


def test_losses_are_drawn_second_by_second() -> None:
    line = values(
        drawn(
            later(0),
            later(1, lost=10, late=6),
            later(2, lost=10, late=6, slots_skipped=5, recorder_dropped=9),
        )
    )
    assert line["/losses/lost"] == [3, 0]
    assert line["/losses/refused"] == [2, 0]
    assert line["/losses/skipped"] == [0, 2]
    assert line["/losses/unrecorded"] == [0, 4]


def test_whatever_is_refused_is_drawn_as_refused() -> None:
    for reason in REFUSALS:
        before = getattr(later(0).channels[0], reason)
        line = values(drawn(later(0), later(1, **{reason: before + 3})))
        assert line["/losses/refused"] == [3], reason


def test_a_daemon_that_began_anew_has_lost_nothing_of_the_ones_before() -> None:
    assert "/losses/lost" not in values(drawn(later(0, lost=100), later(-50, lost=0)))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=50))
def test_ticks_that_did_not_reach_the_view_are_counted(holes: list[int]) -> None:
    numbers = np.cumsum([hole + 1 for hole in holes]).tolist()
    batches = drawn(later(0), tick(0), *(tick(number) for number in numbers), later(1))
    count = f"**{sum(holes)}**" if sum(holes) else "0"
    assert f"ticks that this view has missed | {count} |" in health(batches)
    assert values(batches)["/losses/unseen"] == [sum(holes)]


def test_a_restarted_estimator_is_no_loss() -> None:
    batches = drawn(tick(40), tick(41), tick(0), tick(1), status())
    assert "ticks that this view has missed | 0 |" in health(batches)
