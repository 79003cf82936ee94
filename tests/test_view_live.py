"""The view's loop: ends with its window or when told, not with a viewer that died, and tells silence."""

from collections.abc import Iterable, Sequence
from typing import Self

import pytest

from tests.view_rig import DELAY_S, messages, status, tick
from vsensor.messages import Message
from vsensor.view import live
from vsensor.view.batches import Batch, Page, Points
from vsensor.view.blueprint import Reach
from vsensor.view.live import SILENCE_S, Live, Show, run
from vsensor.view.place import Place
from vsensor.view.stream import Stream


class Ears:
    """Hears one batch of messages a turn, and then nothing more."""

    def __init__(self, *turns: Sequence[Message]) -> None:
        self.turns = list(turns)

    def drain(self) -> Sequence[Message]:
        return self.turns.pop(0) if self.turns else []


class Screen:
    """Keeps what it was sent, one list a recording."""

    def __init__(self) -> None:
        self.recordings: list[list[Batch]] = [[]]

    def send(self, batches: Iterable[Batch]) -> None:
        self.recordings[-1].extend(batches)

    def begin(self) -> None:
        self.recordings.append([])

    def fit(self, reach: Reach) -> None:
        self.reach = reach


class Clock:
    """Time passes in sleep alone."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now

    def time_ns(self) -> int:
        return round(self.now * 1e9)

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(live, "time", clock)
    return clock


def a_live(*turns: Sequence[Message]) -> tuple[Live, Screen]:
    screen = Screen()
    return Live(Ears(*turns), Show(screen, Stream)), screen  # type: ignore[arg-type]


def viewer_that_ends(monkeypatch: pytest.MonkeyPatch, status: int) -> None:
    class Viewer:
        def __init__(self, place: Place) -> None:
            pass

        def __enter__(self) -> Self:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def ended(self) -> int:
            return status

    monkeypatch.setattr(live, "Viewer", Viewer)


def test_closing_the_window_ends_the_view(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> None:
    viewer_that_ends(monkeypatch, 0)
    said: list[str] = []
    run(a_live()[0].turn, Place("window"), lambda: clock.now > 200, said.append)
    assert clock.now == 100.0
    assert said == ["the window was closed"]


def test_a_viewer_that_died_is_told_of_once_and_the_view_goes_on(
    monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    viewer_that_ends(monkeypatch, -9)
    said: list[str] = []
    run(a_live()[0].turn, Place("window"), lambda: clock.now > 101, said.append)
    assert clock.now > 101
    assert len(said) == 1
    assert "rerun --connect rerun+http://127.0.0.1:9876/proxy" in said[0]


def test_what_came_before_the_end_is_shown(clock: Clock) -> None:
    the_live, screen = a_live([tick(0)])
    run(the_live.turn, Place("file"), lambda: True, lambda _: None)
    assert any(isinstance(batch, Points) for batch in screen.recordings[0])


def test_silence_is_told_once_a_second_until_something_comes(clock: Clock) -> None:
    the_live, screen = a_live([tick(0)])
    run(the_live.turn, Place("file"), lambda: clock.now >= 100 + SILENCE_S + 3, lambda _: None)
    told = [b.text for b in screen.recordings[0] if isinstance(b, Page) and "No word" in b.text]
    assert [text.split()[4] for text in told] == ["3", "4", "5", "6"]


def test_messages_each_second_are_no_silence(clock: Clock) -> None:
    the_live, screen = a_live(*[[tick(number)] for number in range(20)])
    run(the_live.turn, Place("file"), lambda: clock.now >= 115, lambda _: None)
    assert not any(isinstance(b, Page) and "No word" in b.text for b in screen.recordings[0])


def test_when_time_falls_back_the_rest_goes_on_a_new_recording(clock: Clock) -> None:
    heard = [message for _, message in messages(50)]
    earlier = [message for _, message in messages(70, begun_ns=10**18)]
    the_live, screen = a_live(heard + earlier)
    the_live.turn()
    drawn = [
        next(len(b.times_ns) for b in sent if isinstance(b, Points) and b.entity == "/speed/at_surface")
        for sent in screen.recordings
    ]
    assert drawn == [50, 70]


def test_the_layout_is_fitted_to_the_reach_of_the_answers_once_that_is_told(clock: Clock) -> None:
    the_live, screen = a_live([tick(0)], [status()])
    the_live.turn()
    assert not hasattr(screen, "reach")
    the_live.turn()
    assert screen.reach == (DELAY_S, DELAY_S)


def test_how_many_messages_waited_is_drawn_with_the_next_status(clock: Clock) -> None:
    the_live, screen = a_live([tick(0), tick(1), tick(2)], [status()])
    the_live.turn()
    the_live.turn()
    waited = [b for b in screen.recordings[0] if isinstance(b, Points) and b.entity == "/queues/view"]
    assert [batch.values.tolist() for batch in waited] == [[3.0]]


def test_a_session_is_shown_whole(clock: Clock) -> None:
    screen = Screen()
    Show(screen, Stream).fill(message for _, message in messages(950))  # type: ignore[arg-type]
    drawn = [b for b in screen.recordings[0] if isinstance(b, Points) and b.entity == "/speed/at_surface"]
    assert sum(len(batch.times_ns) for batch in drawn) == 950
    assert len(drawn) == 11
