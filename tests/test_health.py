"""What the daemon holds its input for."""

from collections.abc import Iterable

from tests.rigs import SHORT
from tests.test_intake_frozen import feed, noisy
from vsensor.service.engine import Engine
from vsensor.service.health import Health
from vsensor.service.realtime import Achieved
from vsensor.service.sticks import Sticks


def test_the_input_is_lost_while_both_channels_repeat_their_last_readings() -> None:
    engine = Engine(SHORT)
    realtime = Achieved("off", "SCHED_OTHER", (0,), (0,), False, False, 0.005, 0)
    health = Health(SHORT, engine, Sticks(SHORT), realtime)

    def lost_after(values: Iterable[tuple[float, float]], first: int) -> bool:
        for topic, sample in feed(values, first):
            engine.intake.take(topic, sample)
        health.listen()
        return health.input_lost

    live = noisy(1500)
    assert not lost_after(live, 0)
    assert lost_after([live[-1]] * 100, 1500)
    assert not lost_after(noisy(2), 1600)
