"""A bunch is worked off turn by turn, a backlog at length."""

import itertools

import pytest

from vsensor.grid import NS
from vsensor.service import ration
from vsensor.service.ration import PATIENCE_S, Ration

LASTING = round(1000 * PATIENCE_S) + 150
"""Turns at 1 kHz after which a backlog has all the time there is."""


class Watch:
    """A clock that goes on when a sample is worked on, and no other time."""

    def __init__(self) -> None:
        self.ns = 0

    def monotonic_ns(self) -> int:
        return self.ns


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch) -> Watch:
    watch = Watch()
    monkeypatch.setattr(ration, "time", watch)
    return watch


def turn(given: Ration, watch: Watch, waiting: int, each_ns: int, lateness_ns: int = 0) -> int:
    """Work for one turn on what waits; returns how many are left."""
    given.begin(lateness_ns)
    while waiting and given.lasts():
        watch.ns += each_ns
        waiting -= 1
    return waiting


def test_a_bunch_makes_no_turn_longer_than_its_slot(watch: Watch) -> None:
    given, waiting, turns = Ration(1000.0), 10, 0
    while waiting:
        begun = watch.ns
        waiting = turn(given, watch, waiting, 300_000)
        turns += 1
        assert watch.ns - begun <= NS // 1000
    assert turns == 5  # two of them in each


@pytest.mark.parametrize("each_ns", [500_000, 700_000, 5_000_000])
def test_a_slow_machine_does_one_at_a_time(watch: Watch, each_ns: int) -> None:
    """Two would not end within the slot."""
    assert turn(Ration(1000.0), watch, 10, each_ns) == 9


@pytest.mark.parametrize(("first_ns", "turns"), [(450_000, 10), (560_000, 40)])
def test_a_backlog_is_worked_off_though_the_first_of_a_turn_takes_long(
    watch: Watch, first_ns: int, turns: int
) -> None:
    """Nothing of it is in the processor's caches; another comes with every turn, and no slot is skipped."""
    given, waiting = Ration(1000.0), 5
    for _ in range(turns):
        given.begin()
        waiting, each_ns, begun = waiting + 1, first_ns, watch.ns
        while waiting and given.lasts():
            watch.ns += each_ns
            waiting, each_ns = waiting - 1, 180_000
        assert watch.ns - begun <= 1.5 * NS / 1000
    assert waiting == 0


def test_a_turn_that_wakes_late_does_less(watch: Watch) -> None:
    """It would end within the next slot, and make that one late too."""
    given = Ration(1000.0)
    assert turn(given, watch, 10, 200_000) == 6
    assert turn(given, watch, 10, 200_000, lateness_ns=200_000) == 7
    assert turn(given, watch, 10, 200_000, lateness_ns=5_000_000) == 9


def test_a_slow_machine_without_a_backlog_is_given_no_longer_turns(watch: Watch) -> None:
    """Each turn ends with the only sample that there was, however little time that left."""
    given = Ration(1000.0)
    for _ in range(1000):
        assert turn(given, watch, 1, 650_000) == 0
    assert turn(given, watch, 10, 300_000) == 8


@pytest.mark.parametrize("waiting", [40, 400])
def test_a_backlog_is_worked_off_and_no_slot_skipped_though_none_has_time_for_two_ticks(
    watch: Watch, waiting: int
) -> None:
    """At 2 kHz two samples come with each slot, of which the second makes a tick: together 0.7 of a slot."""
    slot_ns, tooks_ns = NS // 2000, itertools.cycle([80_000, 270_000])
    given = Ration(2000.0)
    for due in range(1, 1500):
        watch.ns = max(watch.ns, due * slot_ns)
        assert watch.ns < (due + 1) * slot_ns
        waiting += 2
        given.begin(watch.ns - due * slot_ns)
        while waiting and given.lasts():
            watch.ns += next(tooks_ns)
            waiting -= 1
        watch.ns += 50_000  # what else there is to do
    assert waiting <= 2  # what is left in a turn of ordinary length


def test_a_backlog_that_lasts_is_given_the_time_there_is_late_or_not(watch: Watch) -> None:
    given = Ration(1000.0)
    for _ in range(LASTING):
        turn(given, watch, 1000, 100_000, lateness_ns=900_000)
    begun = watch.ns
    turn(given, watch, 20_000, 100_000, lateness_ns=900_000)
    assert watch.ns - begun == pytest.approx(ration.LONGEST_S * NS, rel=0.01)


def test_a_backlog_that_lasts_is_given_all_the_time_there_is(watch: Watch) -> None:
    given, waiting, took = Ration(1000.0), 99_000, []
    for _ in range(LASTING):
        begun = watch.ns
        waiting = turn(given, watch, waiting, 100_000)
        took.append(watch.ns - begun)
    assert max(took[: round(PATIENCE_S * 1000)]) < 1.5 * NS / 1000
    assert took[-1] == pytest.approx(ration.LONGEST_S * NS, rel=0.01)
    assert waiting > 0


def test_afterwards_it_is_short_again(watch: Watch) -> None:
    given = Ration(1000.0)
    for _ in range(LASTING):
        turn(given, watch, 1000, 300_000)
    assert turn(given, watch, 1, 300_000) == 0
    assert turn(given, watch, 10, 300_000) == 8


def test_a_slow_loop_has_most_of_a_slot_all_the_same(watch: Watch) -> None:
    given = Ration(2.0)
    assert turn(given, watch, 1000, NS // 100) == 965
