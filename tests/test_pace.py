"""Slots on an absolute grid: what is late stays as late as it was, and what is missed is counted."""

from fractions import Fraction
from itertools import islice, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsensor.grid import NS
from vsensor.service.pace import LEADS_NS, MonotonicClock, Pace, Slot

MS = 1_000_000
rates = st.floats(1, 5000)


class FakeClock:
    """Sleeps too long by what `overshoots` say, in turn."""

    def __init__(self, overshoots: list[int], start: int = 123) -> None:
        self.time = self.start = start
        self._overshoots = overshoots
        self._sleeps = 0

    def now_ns(self) -> int:
        return self.time

    def sleep_until(self, deadline_ns: int) -> None:
        if deadline_ns > self.time:
            self.time = deadline_ns + self._overshoots[self._sleeps % len(self._overshoots)]
            self._sleeps += 1


def slots(rate: float, clock: FakeClock, count: int, work_ns: int = 0) -> list[Slot]:
    taken = []
    for slot in islice(Pace(rate, clock).slots(), count):
        taken.append(slot)
        clock.time += work_ns
    return taken


@given(rates, st.lists(st.integers(0, 150_000), min_size=1, max_size=20), st.integers(0, 40_000))
def test_lateness_never_adds_up(rate: float, overshoots: list[int], work_ns: int) -> None:
    """The kernel oversleeps a little every time: each slot is late by its own oversleeping alone."""
    clock = FakeClock(overshoots)
    taken = slots(rate, clock, 400, work_ns)

    assert [slot.number for slot in taken] == list(range(1, 401))
    assert [slot.lateness_ns for slot in taken] == [overshoots[k % len(overshoots)] for k in range(400)]
    assert {slot.skipped for slot in taken} == {0}


@given(rates, st.integers(3, 10**6))
def test_deadlines_are_where_the_rate_says_after_any_time(rate: float, slot: int) -> None:
    clock = FakeClock([0])
    pace = Pace(rate, clock).slots()
    next(pace)
    clock.time = clock.start + round((slot - 0.5) * NS / rate)  # within the slot before
    assert next(pace)[::2] == (slot - 1, slot - 3)
    assert next(pace) == Slot(slot, 0, 0)
    assert abs(clock.time - clock.start - slot * Fraction(NS) / Fraction(rate)) <= 1


@given(rates, st.lists(st.integers(0, 10 * NS), min_size=1, max_size=10))
def test_no_slot_is_lost_from_the_books_nor_run_twice(rate: float, overshoots: list[int]) -> None:
    taken = slots(rate, FakeClock(overshoots), 50)
    assert taken[-1].number == len(taken) + sum(slot.skipped for slot in taken)
    assert all(a.number < b.number for a, b in pairwise(taken))
    assert all(slot.lateness_ns >= 0 for slot in taken)


def test_a_turn_that_takes_too_long_costs_slots_and_the_grid_stays() -> None:
    clock = FakeClock([0])
    pace = Pace(100.0, clock).slots()
    next(pace)
    clock.time += 35 * MS  # the loop comes back at 45 ms: slots 2 and 3 are over, the fourth is under way
    assert next(pace) == Slot(number=4, lateness_ns=25 * MS, skipped=2)
    assert next(pace) == Slot(number=5, lateness_ns=0, skipped=0)


def test_a_pause_while_asleep_is_told_in_the_slot_that_follows_it() -> None:
    """Not one later: what this turn has to make up for is known when it begins."""
    pace = Pace(100.0, FakeClock([0, 35 * MS, 0])).slots()
    assert next(pace).number == 1
    assert next(pace) == Slot(number=5, lateness_ns=35 * MS, skipped=3)
    assert next(pace) == Slot(number=6, lateness_ns=0, skipped=0)


def test_a_turn_a_little_over_its_time_skips_nothing_until_a_whole_slot_is_gone() -> None:
    taken = slots(100.0, FakeClock([0]), 10, work_ns=12 * MS)
    assert [(slot.lateness_ns // MS, slot.skipped) for slot in taken] == [
        (0, 0), (2, 0), (4, 0), (6, 0), (8, 0), (10, 1), (2, 0), (4, 0), (6, 0), (8, 0),
    ]  # fmt: skip


def test_the_clock_of_the_machine_returns_at_its_deadline_or_later() -> None:
    clock = MonotonicClock()
    deadline = clock.now_ns() + 5 * MS
    clock.sleep_until(deadline)
    assert clock.now_ns() >= deadline


def test_a_deadline_that_has_passed_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[float] = []
    monkeypatch.setattr("time.sleep", waited.append)
    clock = MonotonicClock()
    clock.sleep_until(clock.now_ns() - NS)
    assert waited == []


@pytest.mark.parametrize(
    ("rate", "leads_ns"),
    [(100.0, LEADS_NS), (500.0, (800_000, 400_000)), (1000.0, (400_000,)), (2000.0, ())],
)
def test_a_slot_is_prepared_where_there_is_time(rate: float, leads_ns: tuple[int, ...]) -> None:
    clock = FakeClock([0])
    prepared: list[tuple[int, int]] = []
    begun = clock.time

    def prepare(until_ns: int) -> int:
        prepared.append((clock.time, until_ns))
        return 0

    for _ in islice(Pace(rate, clock, prepare).slots(), 5):
        pass
    deadlines = [begun + round((k + 1) * NS / rate) for k in range(5)]
    assert prepared == [(slot - lead, slot - lead + lead // 2) for slot in deadlines for lead in leads_ns]


def test_a_slot_that_is_due_before_it_could_be_prepared_is_not() -> None:
    clock = FakeClock([0])
    prepared: list[int] = []

    def prepare(_until_ns: int) -> int:
        prepared.append(clock.time)
        return 0

    for slot in islice(Pace(100.0, clock, prepare).slots(), 4):
        if slot.number == 2:
            clock.time += 10 * MS - LEADS_NS[1] // 2
    assert len(prepared) == 3 * len(LEADS_NS)


def test_what_takes_until_the_second_time_to_prepare_is_not_prepared_twice() -> None:
    clock = FakeClock([0])
    prepared: list[int] = []

    def prepare(_until_ns: int) -> int:
        prepared.append(clock.time)
        clock.time += LEADS_NS[0] - LEADS_NS[1]
        return 0

    taken = list(islice(Pace(100.0, clock, prepare).slots(), 4))
    assert prepared == [clock.start + 10 * MS * slot.number - LEADS_NS[0] for slot in taken]


def test_preparing_for_too_long_makes_its_own_slot_late_and_no_other() -> None:
    clock = FakeClock([0])

    def prepare(_until_ns: int) -> int:
        clock.time += LEADS_NS[0] + 300_000 if clock.time < clock.start + 15 * MS else 0
        return 0

    taken = list(islice(Pace(100.0, clock, prepare).slots(), 4))
    assert [slot.lateness_ns for slot in taken] == [300_000, 0, 0, 0]


@pytest.mark.parametrize("takes_ns", [300_000, 700_000])
def test_what_would_take_longer_than_there_is_time_is_left_to_the_slot(takes_ns: int) -> None:
    """Samples that come between the first time and the second: after one slot that was late it is known."""
    clock = FakeClock([0])
    done: list[int] = []

    def prepare(until_ns: int) -> int:
        has_come = (clock.time - clock.start) % (10 * MS) > 10 * MS - LEADS_NS[0]
        if not has_come or clock.time >= until_ns:
            return 0
        done.append(clock.time)
        clock.time += takes_ns
        return 1

    taken = list(islice(Pace(100.0, clock, prepare).slots(), 20))
    fits = takes_ns < LEADS_NS[1]
    assert len(done) == (20 if fits else 1)
    assert sum(slot.lateness_ns for slot in taken) == (0 if fits else takes_ns - LEADS_NS[1])


def test_what_one_tick_takes_is_told_by_several_too() -> None:
    """Two have come by the first time, one more by the second, for which there is just time."""
    clock = FakeClock([0])
    done: list[int] = []

    def prepare(until_ns: int) -> int:
        if clock.time >= until_ns:
            return 0
        done.append(2 - len(done) % 2)
        clock.time += 350_000 * done[-1]
        return done[-1]

    taken = list(islice(Pace(100.0, clock, prepare).slots(), 20))
    assert done == [2, 1] * 20
    assert {slot.lateness_ns for slot in taken} == {0}


def test_after_a_pause_of_the_machine_slots_are_soon_prepared_again() -> None:
    clock = FakeClock([0])
    done: list[int] = []

    def prepare(until_ns: int) -> int:
        if clock.time + 50_000 >= until_ns:  # it wakes a little late
            return 0
        done.append(clock.time)
        clock.time += 650_000 if len(done) > 1 else 50 * MS
        return 1

    for _ in islice(Pace(100.0, clock, prepare).slots(), 200):
        pass
    assert len(done) >= 140
