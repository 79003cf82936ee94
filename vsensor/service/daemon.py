"""The daemon: drain what has come, step, publish, record, and never wait for anyone."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import NamedTuple

import zenoh

from vsensor.bus import SurfaceInbox
from vsensor.commands import obey
from vsensor.config import Rig
from vsensor.messages import (
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_DESCRIPTION,
    STRING_PROFILE,
    SURFACE_TOPICS,
    Estimate,
    Event,
    Status,
    Tick,
)
from vsensor.messages.states import INPUT_LOST, RUNNING, STANDING_BY, STARTING, WAITING, WARMING_UP
from vsensor.service.chores import Chores
from vsensor.service.describe import Describer
from vsensor.service.engine import Engine
from vsensor.service.health import Health
from vsensor.service.keeper import Keeper
from vsensor.service.owed import Owed
from vsensor.service.pace import Pace, Slot
from vsensor.service.profile import Noted, Profiler, profile_of, reckon
from vsensor.service.ration import Ration
from vsensor.service.realtime import Achieved
from vsensor.service.recording import Recorder, Recording
from vsensor.service.reload import Reload, take_up
from vsensor.service.seat import Seat
from vsensor.service.shed import NO_FORECAST, NO_PROFILE
from vsensor.service.voice import Sent, Voice
from vsensor.service.watch import Watch

REFUSING_SHARE = 0.5
"""Of a flood, half of what may be accepted in a turn is refused in it: the rest waits, and falls out."""
STEP_BACK_S = 3e-4
STEP_BACK_SHARE = 0.1
"""For so long, and no longer a share of a slot, the loop steps back when the answers have gone out: at its
priority it would keep a processor from those who pass them on."""
LEAST_STEP_S = 2e-4
"""Where that is shorter than this, not at all."""
ASIDE_HZ = 100.0
"""So often a second, at the most, is heard what is asked, and the recorder given what is for it."""
SEAT_PATIENCE_S = 1.5
"""Links to other routers are made by then, and it is known whether another sensor speaks."""


class Made(NamedTuple):
    """A tick that was run, and what came of it."""

    tick: Tick
    estimate: Estimate
    told: Sequence[Sent] = ()
    """What was told of it before its turn."""


Ear = Callable[[Status], object]
"""Who is told the status."""


class Daemon:
    """One rig's virtual sensor on the bus."""

    def __init__(
        self,
        rig: Rig,
        engine: Engine,
        session: zenoh.Session,
        recorder: Recorder | None,
        realtime: Achieved,
        keeper: Keeper | None = None,
        reload: Reload | None = None,
        *,
        stand_by: bool = False,
    ) -> None:
        self._rig = rig
        self._engine = engine
        self._recorder = recorder
        self._recording = None if recorder is None else Recording(rig, engine, recorder)
        most_refused = max(1, round(REFUSING_SHARE * rig.bus.max_rate / rig.loop.rate))
        self._keeper = keeper
        self._inbox = SurfaceInbox(
            session,
            rig.prefix,
            SURFACE_TOPICS,
            rig.bus.max_rate,
            most_refused,
            max_lead_s=rig.measurement.max_gap,
        )
        self._watch = Watch(rig)
        self._profiler = Profiler(rig, engine.estimator)
        self._describer = Describer(rig, engine.estimator)
        self.health = Health(rig, engine, self._watch.sticks, realtime)
        self.voice = Voice(session, rig, recorder, self.health)
        self._made: list[Made] = []
        _finish(self.health.take_stock(STARTING, recorder))
        self._per_second = round(rig.loop.rate)
        step_back_s = min(STEP_BACK_S, STEP_BACK_SHARE / rig.loop.rate)
        self._step_back_s = step_back_s if step_back_s >= LEAST_STEP_S else 0.0
        self._chores = Chores(rig.loop.rate)
        self._turns_apart = max(1, round(rig.loop.rate / ASIDE_HZ))
        self._ration = Ration(rig.loop.rate)
        self.faults: dict[str, str] = {}
        """What made the last unreadable sample of each topic unreadable."""
        self._owed = Owed(rig.loop.rate)
        self._reload = reload
        alone = not (rig.bus.connect or rig.bus.multicast_scouting)
        self._seat = Seat(
            session, rig.prefix, stand_by=stand_by, patience_s=0.0 if alone else SEAT_PATIENCE_S
        )
        self.voice.mute(not self._seat.taken)

    def run(self, pace: Pace, ears: Iterable[Ear], stopped: Callable[[], bool]) -> None:
        """Turn once each slot until told to stop; `ears` hear the status of each second, one a turn."""
        if self._recording is not None:
            self._recording.remember()
        if self._keeper is not None and (known := self._keeper.begun).words:
            self.voice.tell(self._watch.note("learned", not known.refused, known.words))
        second = 0
        for slot in pace.slots():
            begun = time.monotonic_ns()
            self.health.grid_ns = pace.start_ns
            self.health.begin(slot)
            begun += self._tell_prepared()
            self._turn(slot)
            if slot.number // self._per_second > second:
                second = slot.number // self._per_second
                self._chores.finish()
                self._chores.add(self._each_second(ears))
            self._chores.turn(time.monotonic_ns() - begun + slot.lateness_ns)
            if self.health.slots_run % self._turns_apart == 0:
                self._look_aside()
            self.health.end(time.monotonic_ns() - begun)
            if stopped():
                break
        # What had come when the word to stop did is still run, however long a turn that makes.
        self._take_in(slot, lambda: True, hold=False)
        self._chores.add(self._each_second(()))
        self._chores.finish()
        self.voice.hand_on()
        if self._keeper is not None and self._seat.taken:
            self._keeper.save()

    def prepare(self, until_ns: int) -> int:
        """Ahead of a slot, run what has come already: when it comes its estimates are ready to be told.

        How many ticks were run.
        """
        begun = time.monotonic_ns()
        if self._profiler.due(self._engine.intake.next_number):  # which has to be noted behind that tick
            until_ns -= self._profiler.took_ns
        made = list(self._run(lambda: time.monotonic_ns() < until_ns))
        self._made += made
        self.health.prepared(time.monotonic_ns() - begun)
        return len(made)

    def _tell_prepared(self) -> int:
        """Tell the answers that are ready and step back; for how long, ns."""
        if not self._made or not self._step_back_s:
            return 0
        self._made = [made._replace(told=self.voice.answer(made.estimate)) for made in self._made]
        begun = time.monotonic_ns()
        time.sleep(self._step_back_s)
        return time.monotonic_ns() - begun

    def _turn(self, slot: Slot) -> None:
        self._owed.turn(slot)
        self._ration.begin(slot.lateness_ns)
        self._take_in(slot, self._ration.lasts)
        self.health.listen()

    def _look_aside(self) -> None:
        self._seat.answer(self.health.status.SerializeToString, self._obey)
        self.voice.hand_on()

    def _take_in(self, slot: Slot, more: Callable[[], bool], *, hold: bool = True) -> None:
        prepared, self._made = self._made, []
        for made in chain(prepared, self._run(more, hold=hold)):
            self._publish_tick(slot, made)

    def _run(self, more: Callable[[], bool], *, hold: bool = True) -> Iterator[Made]:
        """Run the ticks of what has come, while there is time for more."""
        for received in self._inbox.drain(more, hold=hold):
            if received.over_rate:
                self._engine.intake.refuse_unread(received.topic)
                continue
            if received.unreadable is not None:
                self.faults[received.topic] = f"a sample {received.unreadable.fault}"
            self.voice.record_received(received)
            for tick, estimate in self._engine.take(received.topic, received.sample):
                if self.health.shedding.level < NO_PROFILE and (noted := self._profiler.note(estimate)):
                    self._chores.add(self._tell_along(noted))
                yield Made(tick, estimate)

    def _obey(self, words: str) -> str:
        if self._recording is not None and (said := self._recording.obey(words)) is not None:
            return said
        done = obey(words, self._engine.intake.depths)
        self.voice.tell(self._watch.command(words))
        return done

    def _publish_tick(self, slot: Slot, made: Made) -> None:
        tick, estimate = made.tick, made.estimate
        tick.slot, tick.lateness_ns, tick.caught_up = slot.number, slot.lateness_ns, self._owed.pay()
        self.health.ticks += 1
        # For the answers others wait; in a session they stand behind their tick.
        told = made.told or self.voice.answer(estimate)
        self.voice.publish(SENSOR_TICK, tick, tick.time_ns)
        for topic, data in told:
            self.voice.record(topic, data, tick.time_ns)
        for event in self._watch.tick(tick, estimate):
            self.voice.tell(event)
        self.health.published += 1

    def _tell_along(self, noted: Noted) -> Iterator[None]:
        reckoned = reckon(noted)
        yield
        profile = profile_of(reckoned)
        yield
        self.voice.publish(STRING_PROFILE, profile, profile.time_ns)
        if (over := self._watch.profile(profile)) is not None:
            self.voice.tell(over)

    def _each_second(self, ears: Iterable[Ear]) -> Iterator[None]:
        """What is due once a second, in parts: at 2 kHz a turn has time for one of them."""
        for note in self._recording.each_second() if self._recording is not None else ():
            self.voice.tell(self._watch.note(*note))
        if words := self._seat.look():
            self.voice.mute(not self._seat.taken)
            self.voice.tell(self._watch.note("seat", self._seat.taken, words))
        if self._keeper is not None and self._seat.taken:
            self._keeper.each_second()
        self._read_again()
        yield
        yield from self.health.look_back()
        yield
        self.health.bus_missed = self._inbox.missed
        self.health.inbox_waiting = self._inbox.most_waiting()
        level = self.health.second()
        self._engine.intake.forecast_shed = level >= NO_FORECAST
        for event in self._watch.shedding(level):
            self.voice.tell(event)
        yield
        for event in self._each_second_seen():
            self.voice.tell(event)
        yield
        yield from self.health.take_stock(self._state(), self._recorder, self._keeper)
        yield
        self.voice.publish(SENSOR_STATUS, self.health.status, self.health.status.time_ns)
        yield
        if description := self._describer.second():
            self.voice.publish(STRING_DESCRIPTION, description, description.time_ns)
        for ear in ears:
            yield
            ear(self.health.status)

    def _read_again(self) -> None:
        """Take up what may change of a configuration that was read again."""
        if self._reload is None or (read := self._reload.result(self._rig)) is None:
            return
        done = take_up(self._rig, read, self.health, self._recorder)
        self._rig = done.rig
        words = f"the configuration was read again: {done.words}"
        self.voice.tell(self._watch.note("configuration", not done.refused, words))

    def _each_second_seen(self) -> Iterator[Event]:
        yield from self._watch.second(self.health.severity, self.health.input_lost)
        intake, known = self._engine.intake, self._engine.estimator
        coarse, lasts = known.coarse_steps.tolist(), known.ticks_a_reading
        yield from self._watch.learned(known.tuning.tolist(), known.noisier, coarse, lasts)
        yield from self._watch.incoming(intake.depths, intake.depths_silent, intake.beats)
        newest_ns = [channel.newest_ns for channel in intake.channels.values()]
        yield from self._watch.sources(intake.contested, newest_ns)

    def _state(self) -> str:
        if not self._seat.taken:
            return STANDING_BY
        if self.health.input_lost:
            return INPUT_LOST
        if self.health.ticks == 0:
            return WAITING
        return RUNNING if self._engine.warm else WARMING_UP


def _finish(chores: Iterator[None]) -> None:
    for _ in chores:
        pass
