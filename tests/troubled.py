"""A rig whose samples suffer what a network, a source and a clock may do to them, and its books."""

import math
import random
import time
from collections import Counter
from dataclasses import dataclass, field

from tests.rigs import NS
from vsensor.bus import Outbox
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample

WILD = {SURFACE_TORQUE: 3e4, SURFACE_SPEED: 40.0}
CHANNELS = tuple(WILD)


@dataclass
class Books:
    """What the rig knows of what it sent, by channel."""

    published: Counter[str] = field(default_factory=Counter)
    withheld: Counter[str] = field(default_factory=Counter)
    """Numbers of the sequence that were never sent."""
    faults: Counter[str] = field(default_factory=Counter)


class TroubledRig:
    """A rig whose samples suffer what a network, a source and a clock may do to them."""

    def __init__(self, outbox: Outbox, rate: float, seed: int) -> None:
        self.books = Books()
        self.silent: set[str] = set()
        self.shift_ns = 0
        self._outbox = outbox
        self._rate = rate
        self._random = random.Random(seed)
        self._begun_ns = time.time_ns()
        self._begun = time.monotonic()
        self._number = 0
        self._sequence = dict.fromkeys(CHANNELS, 0)
        self._held: list[tuple[str, Sample]] = []

    def catch_up(self) -> None:
        """Send what is due by now."""
        while self._number < (time.monotonic() - self._begun) * self._rate:
            self._send_all(self._number / self._rate)
            self._number += 1

    def begin_anew(self) -> None:
        """Count from 0 again, as a publisher that was started again."""
        self.flush()
        self._sequence = dict.fromkeys(CHANNELS, 0)

    def flush(self) -> None:
        """Send what was held back."""
        while self._held:
            self._put(*self._held.pop())

    def end(self) -> None:
        """Send what was held back, and two last samples each: no hole is unseen, and none waits for more."""
        self.flush()
        for _ in range(2):
            time_ns = time.time_ns() + self.shift_ns
            for topic in CHANNELS:
                self._put(topic, Sample(time_ns=time_ns, value=10.0, sequence=self._sequence[topic]))
                self._sequence[topic] += 1

    def _send_all(self, at_s: float) -> None:
        swing = math.sin(2 * math.pi * at_s / 4)
        for topic, value in ((SURFACE_TORQUE, 8e3 + 3e3 * swing), (SURFACE_SPEED, 12 - swing)):
            if topic in self.silent:
                continue
            time_ns = self._begun_ns + round(at_s * NS) + self.shift_ns
            sample = Sample(time_ns=time_ns, value=value, sequence=self._sequence[topic])
            self._sequence[topic] += 1
            self._suffer(topic, sample)
        while self._held and self._random.random() < 0.1:
            self._put(*self._held.pop())

    def _suffer(self, topic: str, sample: Sample) -> None:
        """One in some hundred samples does not come as it should."""
        fate = self._random.random()
        if fate > 0.010:
            self._put(topic, sample)
        elif fate > 0.008:
            self.books.faults["wild"] += 1
            sample.value = WILD[topic] * self._random.choice((-1, 1))
            self._put(topic, sample)
        elif fate > 0.006:
            self.books.faults["withheld"] += 1
            self.books.withheld[topic] += 1
        elif fate > 0.004:
            self.books.faults["doubled"] += 1
            self._put(topic, sample)
            self._put(topic, sample)
        elif fate > 0.002:
            self.books.faults["held back"] += 1
            self._held.append((topic, sample))
        else:
            self._put(topic, sample)
            self._say_nonsense(topic, sample)

    def _say_nonsense(self, topic: str, sample: Sample) -> None:
        self.books.faults["nonsense"] += 1
        soon = sample.time_ns + 1
        without_value = Sample(time_ns=soon)
        kinds = (
            without_value,
            Sample(time_ns=soon, value=math.nan),
            Sample(time_ns=soon, value=1e9),
            Sample(time_ns=sample.time_ns + 3600 * NS, value=1.0),
        )
        self._put(topic, self._random.choice(kinds))

    def _put(self, topic: str, sample: Sample) -> None:
        self._outbox.put(topic, sample)
        self.books.published[topic] += 1
