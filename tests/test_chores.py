"""What may wait is done bit by bit, by turns that have time, and in the end by those that have none."""

from collections.abc import Iterator

import pytest

from vsensor.service.chores import PATIENCE_S, Chores

SLOT_NS = 500_000


def parts(done: list[str], *names: str) -> Iterator[None]:
    for name in names:
        done.append(name)
        yield


@pytest.mark.parametrize("spent_ns", [SLOT_NS // 4, SLOT_NS - 1])
def test_a_turn_that_is_done_within_its_slot_does_one_part_in_the_order_in_which_they_came(
    spent_ns: int,
) -> None:
    done: list[str] = []
    chores = Chores(2000.0)
    chores.add(parts(done, "a", "b"))
    chores.add(parts(done, "c"))
    told = []
    for _ in range(6):
        chores.turn(spent_ns)
        told.append("".join(done))
    assert told[:2] == ["a", "ab"]
    assert done == ["a", "b", "c"]


def test_a_turn_that_is_late_does_none_but_not_for_ever() -> None:
    done: list[str] = []
    chores = Chores(2000.0)
    chores.add(parts(done, "a", "b"))
    for _ in range(round(PATIENCE_S * 2000.0)):
        chores.turn(SLOT_NS + 1)
    assert done == []
    chores.turn(SLOT_NS + 1)
    chores.turn(SLOT_NS + 1)
    assert done == ["a"]


@pytest.mark.parametrize(("rate", "turns"), [(1.0, 1), (50.0, 6), (100.0, 12), (2000.0, 12)])
def test_a_slow_loop_does_as_much_in_a_second(rate: float, turns: int) -> None:
    done: list[str] = []
    chores = Chores(rate)
    chores.add(parts(done, *map(str, range(12))))
    for _ in range(turns):
        chores.turn(0)
    assert len(done) == 12


def test_to_finish_leaves_nothing() -> None:
    done: list[str] = []
    chores = Chores(2000.0)
    chores.add(parts(done, "a", "b"))
    chores.add(parts(done, "c"))
    chores.finish()
    chores.turn(0)
    assert done == ["a", "b", "c"]
