"""A session's samples by columns: the same ticks as one by one, whatever the depths say between them."""

import pytest

from tests.strings import PIPE, rig
from vsensor.commands import COMMAND
from vsensor.intake import OBEYED, Input, Intake
from vsensor.intake.arrivals import Arrivals
from vsensor.intake.stretch import laid
from vsensor.messages import (
    SENSOR_EVENT,
    SURFACE_BIT_DEPTH,
    SURFACE_HOLE_DEPTH,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Event,
    Message,
    Sample,
)
from vsensor.recording import feed
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

RIG = rig(PIPE, PIPE, rate=100.0)
LENGTH, STAND = 2 * PIPE.length, RIG.depth.stand
ROWS = 2000


def told(row: int) -> list[tuple[str, Message]]:
    """Ten depths a second: drilling, lifted, a connection, drilling on; and a command for a while."""
    others: list[tuple[str, Message]] = []
    if row in (1200, 1400):
        words = "off bottom" if row == 1200 else "by depths"
        others.append((SENSOR_EVENT, Event(time_ns=row, name=COMMAND, text=words)))
    if row % 10 == 0:
        hole = LENGTH - 9 + row * 1e-4
        bit = hole - 5 if 500 <= row < 700 else hole + STAND if row >= 900 else hole
        deep = hole + STAND if row >= 900 else hole
        for topic, depth in ((SURFACE_BIT_DEPTH, bit), (SURFACE_HOLE_DEPTH, deep)):
            others.append((topic, Sample(time_ns=row * 10_000_000, value=depth)))
    return others


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    path = tmp_path_factory.mktemp("feed") / "depths.mcap"
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="lz4") as writer:
        for row in range(ROWS):
            time_ns = row * 10_000_000
            surface: list[tuple[str, Message]] = [
                (topic, Sample(time_ns=time_ns, value=row % 7, sequence=row))
                for topic in (SURFACE_TORQUE, SURFACE_SPEED)
            ]
            for topic, message in told(row) + surface:
                writer.write(topic, message.SerializeToString(), time_ns, time_ns)
    return Session(path)


def ticks_of(session: Session, intake: Intake, *settling: object) -> tuple[list[Input], int]:
    """The ticks, and into how many pieces the samples were parted."""
    ticks: list[Input] = []
    parts = 0
    for come in feed.feed(session, OBEYED, *settling):  # type: ignore[arg-type]
        if isinstance(come, Arrivals):
            parts += 1
            for inputs in laid(intake, come):
                ticks += map(Input._make, zip(*(column.tolist() for column in inputs), strict=True))
        else:
            ticks += intake.take(*come)
    return ticks, parts


def test_depths_that_settle_change_no_tick_and_leave_the_samples_together(session: Session) -> None:
    plain, settling = Intake(RIG), Intake(RIG)
    expected, many = ticks_of(session, plain)
    found, few = ticks_of(session, settling, settling.depths.settles)
    assert found == expected
    assert settling.depths.save() == plain.depths.save()
    assert [tick.longer_by for tick in expected if tick.longer_by] == [STAND]
    assert {tick.off_bottom for tick in expected} == {True, False}
    # But for those of the lifted bit, ten a second for two seconds.
    assert many >= ROWS / 10 > 6 * few
    assert few >= 20
