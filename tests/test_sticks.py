"""Sticks foretold are announced once, and held against what comes."""

import pytest

from tests.strings import PIPE, rig
from vsensor.grid import NS
from vsensor.messages import Estimate
from vsensor.service.sticks import AGREED, LEAD_NS, TOLERANCE_NS, Sticks

RATE, DELAY_S, AHEAD_S = 100, 1.0, 0.8
SMALL = rig(PIPE)


class Feed:
    """Ticks of a bit that sticks at known times, foretold with an error."""

    def __init__(self, sticks: list[float], *, lasting: float = 0.5, ahead_s: float = AHEAD_S) -> None:
        self.seen = Sticks(SMALL)
        self.announced: list[tuple[float, float]] = []
        self._sticks, self._lasting, self._ahead_s = sticks, lasting, ahead_s

    def run(self, until: float, *, off_s: float = 0.0, blind: bool = False) -> "Feed":
        for k in range(round(until * RATE)):
            now = k / RATE
            estimate = Estimate(time_ns=k * NS // RATE, confirmed_time_ns=round((now - DELAY_S) * NS))
            estimate.confirmed_bit_speed_rad_s = 0.0 if self._rests(now - DELAY_S) else 10.0
            estimate.forecast_time_ns = round((now + self._ahead_s) * NS)
            due = [at + off_s - now for at in self._sticks if 0 < at + off_s - now < self._ahead_s]
            if due and not blind:
                estimate.stick_in_s = due[0]
            told = self.seen.see(estimate)
            if told is not None:
                self.announced.append((told.made_ns / NS, told.expected_ns / NS))
        return self

    def _rests(self, time_s: float) -> bool:
        return any(at <= time_s < at + self._lasting for at in self._sticks)


def foretold(time_ns: int, stick_in_s: float) -> Estimate:
    return Estimate(time_ns=time_ns, forecast_time_ns=time_ns + NS, stick_in_s=stick_in_s)


def test_each_stick_is_announced_once_and_counted_when_it_has_come() -> None:
    feed = Feed([3.0, 6.0, 9.0]).run(12)
    made = [at for at, _ in feed.announced]
    assert made == pytest.approx([at - AHEAD_S + AGREED / RATE for at in (3, 6, 9)], abs=2 / RATE)
    assert [expected for _, expected in feed.announced] == pytest.approx([3, 6, 9], abs=2 / RATE)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (3, 0, 0)
    assert feed.seen.lead_s == pytest.approx(AHEAD_S, abs=0.05)


def test_sticks_that_follow_one_another_faster_than_they_are_confirmed_are_told_apart() -> None:
    feed = Feed([3.0, 4.2, 5.4, 6.6], lasting=0.3).run(10)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (4, 0, 0)


def test_a_stick_that_nobody_foretold_is_missed() -> None:
    feed = Feed([3.0]).run(6, blind=True)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (0, 1, 0)
    assert feed.seen.lead_s == 0


def test_one_that_comes_at_another_time_is_a_false_alarm_and_a_miss() -> None:
    late = 2 * TOLERANCE_NS / NS
    feed = Feed([3.0]).run(8, off_s=late)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (0, 1, 1)


def test_one_that_never_comes_is_a_false_alarm() -> None:
    feed = Feed([3.0], lasting=0.0).run(8)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (0, 0, 1)


def test_what_is_too_near_or_flickers_is_not_announced() -> None:
    sticks = Sticks(SMALL)
    near = [foretold(k, LEAD_NS / NS - 0.01) for k in range(10)]
    assert [sticks.see(estimate) for estimate in near] == [None] * 10
    for _ in range(5):
        for _ in range(AGREED - 1):
            assert sticks.see(foretold(0, 0.6)) is None
        assert sticks.see(Estimate(time_ns=0, forecast_time_ns=NS)) is None
    for _ in range(AGREED - 1):
        assert sticks.see(foretold(0, 0.6)) is None
    assert sticks.see(foretold(0, 0.6)) is not None


@pytest.mark.parametrize("ahead_s", [0.037, 0.12, 0.24])
def test_on_a_short_string_each_is_announced_with_most_of_its_delay_to_go(ahead_s: float) -> None:
    """Where no more is seen ahead than a long string's shortest warning, that little is told all the same."""
    feed = Feed([3.0, 4.0, 5.0], ahead_s=ahead_s).run(7)
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (3, 0, 0)
    assert feed.seen.lead_s >= 0.8 * ahead_s - 1 / RATE


def test_what_was_announced_before_a_restart_is_not_counted() -> None:
    feed = Feed([3.0]).run(2.5)
    assert len(feed.announced) == 1
    feed.seen.forget()
    feed.seen.see(Estimate(time_ns=9 * NS, confirmed_time_ns=8 * NS, confirmed_bit_speed_rad_s=9.0))
    assert (feed.seen.foretold, feed.seen.missed, feed.seen.false) == (0, 0, 0)


def test_a_bit_that_has_not_turned_yet_does_not_stick() -> None:
    sticks = Sticks(SMALL)
    for k in range(300):
        sticks.see(Estimate(time_ns=k, confirmed_time_ns=k, confirmed_bit_speed_rad_s=0.0))
    assert sticks.missed == 0
