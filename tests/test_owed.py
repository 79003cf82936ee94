"""Ticks that are made up for: as many as slots were skipped, and soon, or they never were."""

from vsensor.service.owed import OWED_S, Owed
from vsensor.service.pace import Slot


def test_as_many_ticks_are_owed_as_slots_were_skipped() -> None:
    owed = Owed(100.0)
    owed.turn(Slot(5, 0, 2))
    owed.turn(Slot(8, 0, 1))
    assert [owed.pay() for _ in range(5)] == [True, True, True, False, False]


def test_what_has_not_come_after_some_seconds_never_was() -> None:
    owed = Owed(100.0)
    last = round(5 + 100 * OWED_S)
    owed.turn(Slot(5, 0, 3))
    owed.turn(Slot(last, 0, 0))
    assert owed.pay()
    owed.turn(Slot(last + 1, 0, 0))
    assert not owed.pay()
