"""Samples by columns: the same ticks, and the same books, as of the same samples one by one."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strings import PIPE, rig
from tests.test_intake import BEGUN, MS, SMALL, S, T
from tests.test_intake_books import Fed, feeds
from vsensor.config import Rig
from vsensor.intake import Input, Intake, stretch
from vsensor.intake.arrivals import Arrivals, by_columns
from vsensor.intake.stretch import laid
from vsensor.messages import Sample


def columns(fed: list[tuple[str, Sample]]) -> Arrivals:
    return Arrivals(
        is_speed=np.array([topic == S for topic, _ in fed], np.bool_),
        time_ns=np.array([sample.time_ns for _, sample in fed], np.int64),
        value=np.array([sample.value for _, sample in fed], np.float64),
        quality=np.array([sample.quality for _, sample in fed], np.int64),
        sequence=np.array([sample.sequence for _, sample in fed], np.uint64),
        numbered=np.array([sample.HasField("sequence") for _, sample in fed], np.bool_),
    )


def one_by_one(intake: Intake, fed: list[tuple[str, Sample]]) -> list[Input]:
    return [tick for topic, sample in fed for tick in intake.take(topic, sample)]


def at_once(intake: Intake, fed: list[tuple[str, Sample]], cut: int) -> list[Input]:
    ticks: list[Input] = []
    for start in range(0, len(fed), cut):
        for inputs in laid(intake, columns(fed[start : start + cut])):
            ticks += map(Input._make, zip(*(column.tolist() for column in inputs), strict=True))
    return ticks


def as_one_by_one(of: Rig, fed: list[tuple[str, Sample]], cut: int, split: int) -> None:
    """Hold samples by columns, and such that another goes on with after `split`, against them one by one."""
    single, by_columns, first, second = (Intake(of) for _ in range(4))
    expected = one_by_one(single, fed)
    assert at_once(by_columns, fed, cut) == expected
    begun = one_by_one(first, fed[:split])
    second.restore(json.loads(json.dumps(first.save())))
    assert begun + at_once(second, fed[split:], cut) == expected
    assert by_columns.save() == second.save() == single.save()
    for topic, channel in single.channels.items():
        assert by_columns.channels[topic].counts == channel.counts


def by_columns_alone(of: Rig, fed: list[tuple[str, Sample]], patch: pytest.MonkeyPatch) -> Intake:
    """Hold samples of which none but the first two may be taken one by one against the same one by one."""
    single, by_columns = Intake(of), Intake(of)
    expected = one_by_one(single, fed)
    begun = one_by_one(by_columns, fed[:2])
    patch.setattr(Intake, "take", None)
    assert begun + at_once(by_columns, fed[2:], 10_000) == expected
    assert by_columns.save() == single.save()
    for topic, channel in single.channels.items():
        assert by_columns.channels[topic].counts == channel.counts
    return by_columns


def plain(count: int, start: int = 0) -> list[tuple[str, Sample]]:
    """Both channels in turn, the speed 3 ms behind."""
    return [
        (topic, Sample(time_ns=BEGUN + k * 10 * MS + late, value=(k % 7) / 50, sequence=k))
        for k in range(start, start + count)
        for topic, late in ((T, 0), (S, 3 * MS))
    ]


@given(feeds(), st.sampled_from([60.0, 100.0, 300.0]), st.sampled_from([1, 7, 50, 10_000]))
def test_whatever_comes_ticks_and_books_are_the_same(fed: Fed, rate: float, cut: int) -> None:
    """Hypothesis breaks what it can: holes, doubles, late and absurd ones among long stretches in order."""
    known = [(topic, sample) for topic, sample in fed if sample is not None]
    configured = rig(PIPE, rate=rate)
    one, other = Intake(configured), Intake(configured)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stretch, "FEWEST", 4)
        assert at_once(other, known, cut) == one_by_one(one, known)
    for topic, channel in one.channels.items():
        assert other.channels[topic].counts == channel.counts
        assert other.channels[topic].save() == channel.save()
    more = [(topic, Sample(time_ns=sample.time_ns, value=9.0)) for topic, sample in plain(5, 100)]
    assert one_by_one(other, more) == one_by_one(one, more)


def test_in_order_nothing_goes_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for the first, before which there is no grid."""
    intake, fed = Intake(SMALL), plain(5000)
    begun = one_by_one(intake, fed[:2])
    expected = one_by_one(Intake(SMALL), fed)
    monkeypatch.setattr(Intake, "take", None)
    assert begun + at_once(intake, fed[2:], 10_000) == expected


def test_what_is_between_the_columns_comes_in_its_place() -> None:
    """A string that was made longer is told at the first tick behind, by columns as one by one."""
    ticks = []
    for way in (one_by_one, lambda intake, fed: at_once(intake, fed, 10_000)):
        intake = Intake(SMALL)
        ticks.append(way(intake, plain(300)))
        intake.depths.command(True)
        intake.depths.lengthen(28.5)
        ticks[-1] += way(intake, plain(300, 300))
    assert ticks[0] == ticks[1]
    assert [tick.number for tick in ticks[1] if tick.longer_by] == [
        len(ticks[1]) - sum(t.off_bottom for t in ticks[1])
    ]


def test_no_ticks_are_columns_of_none() -> None:
    assert [len(column) for column in by_columns([])] == [0] * len(Input._fields)
