"""The virtual sensor: surface torque and speed in, the bit confirmed, now and foretold out."""

from collections.abc import Iterator, Mapping, Set
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vsensor.config import Rig
from vsensor.estimator import kernel
from vsensor.estimator.abreast import WORTHWHILE, most_abreast, room_for
from vsensor.estimator.along import SPEED, along, stations
from vsensor.estimator.arrays import LEARNED, fill, flat, is_learned
from vsensor.estimator.carry import carry
from vsensor.estimator.known import Known
from vsensor.estimator.learn import lose_sight
from vsensor.estimator.misfit import SETTLED_S, correct_by_misfit
from vsensor.estimator.model import model_of, timed, with_length
from vsensor.estimator.refit import refit_torque, refit_wall
from vsensor.estimator.responses import TOLD_BIT_SPEED, TOLD_TOP_SPEED
from vsensor.estimator.ring import mask_of
from vsensor.estimator.sections import Floats, cut, junction_depths, steps_per_tick
from vsensor.estimator.sound import refuse_unsound
from vsensor.estimator.state import NONE, Model, State, fresh, heard
from vsensor.estimator.tare import correct_by_bound, correct_by_tare
from vsensor.estimator.tune import EVERY_S, INERTIA, OFFSET, tuned

LENGTH = "length"
"""The name under which a saved state holds the length of the topmost component, m;"""
WAITING = ("scores.foretold", "scores.laws")
"""and those of what was foretold, until it can be held against what came."""
LONGEST_M = 25e3
"""Longer than any string that has grown: a length that was damaged, not one that was recorded."""


class Estimates(NamedTuple):
    """n ticks of answers. Speeds in rad/s, torques in N·m, NaN where not known yet."""

    values: Floats
    """Shape (n, 17): confirmed, now, forecast, the string's top, each speed, its deviation, torque, its
    deviation; then the time until a stick is foretold, s."""
    reasons: NDArray[np.uint32]
    """Flags of `quality.Reason`, shape (n,)."""
    delays: Floats
    """How long before each tick confirmed is for, and how long after it the forecast, s, shape (2, n)."""


class _Ticks(NamedTuple):
    """Room for n ticks as the kernels take and fill them: see `kernel.turns`."""

    torque: Floats
    speed: Floats
    reasons: NDArray[np.uint32]
    values: Floats
    lasting: NDArray[np.uint32]

    def part(self, start: int, end: int) -> "_Ticks":
        """Those of the ticks from `start` to before `end`."""
        torque, speed, reasons, values, lasting = self
        cut = slice(start, end)
        return _Ticks(torque[cut], speed[cut], reasons[cut], values[cut], lasting[cut])


class Estimator(Known):
    """Runs tick by tick at `rig.loop.rate`; knows no clock.

    The answers of one tick are for three times, each a fixed distance from the tick's own:
    confirmed `confirmed_delay` earlier, now at the tick, the forecast `forecast_horizon` later.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._between = round(EVERY_S * rig.loop.rate)
        # The string may become another while it runs; its waves are kept by steps, which stay as they are.
        self._steps = steps_per_tick(rig.string, 1 / rig.loop.rate)
        self._one = _Ticks(
            np.empty(1),
            np.empty(1),
            np.empty(1, np.uint32),
            np.empty((1, kernel.COLUMNS)),
            np.empty(1, np.uint32),
        )
        self._lay_out()
        self.reset()
        # Compiled, or loaded, here: never at the first tick.
        self._advance(self._one.part(0, 0))
        self.profile()
        self.restart()

    def _lay_out(self) -> None:
        rig = self._rig
        tick = 1 / rig.loop.rate
        cuts = rig.string, tick / self._steps, rig.estimator.section_length, rig.survey, rig.wellbore
        line = cut(*cuts)
        self.stations = stations(rig.string, line, junction_depths(*cuts))
        """Where along the string `profile` tells of it."""
        self._profile = np.empty((2, len(self.stations.depth)))
        self._configured = model_of(rig, line, self.stations, self._steps)
        self._room = room_for(self._configured)

    def reset(self) -> None:
        """Forget everything, as at the start."""
        self._take(self._new())

    def restart(self) -> None:
        """Forget all input, as after a long gap; what was learned stays."""
        state = self._new()
        fill(state, {name: array for name, array in flat(self._state).items() if is_learned(name)})
        lose_sight(state.learned)
        self._take(state)

    def lengthen(self, metres: float) -> None:
        """Make the topmost component longer by so much, or shorter; what is in the string's lines stays.

        Until all waves of before have left, inputs should be flagged `quality.Reason.STRING_CHANGED`.
        Raises ValueError where nothing would be left of that component, or it would be longer than any.
        """
        top = self._rig.string[0]
        if top.length + metres <= 0:
            raise ValueError(f'"{top.name}" is {top.length:g} m long and cannot become {-metres:g} m shorter')
        if not self._can_be(top.length + metres):
            raise ValueError(f'"{top.name}" is {top.length:g} m long and cannot become {metres:g} m longer')
        self._rig = with_length(self._rig, top.length + metres)
        old, before = self._state, self._model
        self._lay_out()
        state = self._new()
        if old.ticks[0] > 0:
            line = tuned(self._configured.line, old.tuning.value)
            carry(old, before, state, line)
        self._take(state)

    def save(self) -> dict[str, NDArray[np.generic]]:
        """The whole state as named arrays: restored, it goes on to the same bits."""
        return {LENGTH: np.array([self._rig.string[0].length]), **flat(self._state)}

    def restore(self, saved: Mapping[str, NDArray[np.generic]]) -> None:
        """Take up a saved state. Raises ValueError where it is of another string, rate or version."""
        self._take(self._filled(saved, {LENGTH, *flat(self._state)}))

    def learned(self) -> dict[str, NDArray[np.generic]]:
        """What is worth knowing after all input was forgotten, as named arrays."""
        told = {LENGTH: np.array([self._rig.string[0].length]), **flat(self._state, LEARNED)}
        for waiting in WAITING:  # predictions whose time will never come
            del told[waiting]
        return told

    def begin_with(self, learned: Mapping[str, NDArray[np.generic]]) -> None:
        """Begin with what was learned before. Raises ValueError where it is of another string or version."""
        state = self._filled(learned, set(self.learned()))
        lose_sight(state.learned)
        self._take(state)

    def _filled(self, saved: Mapping[str, NDArray[np.generic]], expected: Set[str]) -> State:
        """A new state with what was saved, the string as long as it was then."""
        if saved.keys() != expected:
            missing, unknown = sorted(expected - saved.keys()), sorted(saved.keys() - expected)
            raise ValueError(
                f"the saved state lacks {', '.join(missing) or 'nothing'}, "
                f"and holds {', '.join(unknown) or 'nothing'} unknown to this version"
            )
        length = saved[LENGTH]
        if length.shape != (1,) or not self._can_be(length[0]):
            raise ValueError(f"the saved topmost component is {length} m long")
        before = self._rig
        self._relay(with_length(before, float(length[0])))
        state = self._new()
        try:
            fill(state, {name: array for name, array in saved.items() if name != LENGTH})
            refuse_unsound(self._configured, self._rig.tuning, state)
        except ValueError:
            self._relay(before)
            raise
        return state

    def _can_be(self, length: float) -> bool:
        """Whether the topmost component can be so long."""
        return 0 < length <= max(LONGEST_M, self._rig.string[0].length)

    def _relay(self, rig: Rig) -> None:
        """Lay out the string of another rig, where it is another."""
        if rig != self._rig:
            self._rig = rig
            self._lay_out()

    def step(self, torque: float, speed: float, reasons: int = 0) -> tuple[Floats, int]:
        """Run one tick; returns the answers (17,), valid until the next call, and the flags."""
        one = self._one
        one.torque[0], one.speed[0], one.reasons[0] = torque, speed, reasons
        self._told = self._model
        next(self._turns)
        self._correct_in_time()
        return one.values[0], int(one.lasting[0])

    def profile(self) -> Floats:
        """Speed (rad/s) and torque (N·m) at each station at the time of the last confirmed answer.

        Shape (2, n), valid until the next call; as good as that answer, and without meaning before the first.
        """
        model, state = self._model, self._state
        step = self._common_step()
        said = heard(model, state)
        along(model.line, state.waves[0], state.returned, said, self.stations, step, self._profile)
        # A bit at rest is known to rest; the waves beside it are known but for their noise.
        bit = step + model.now - model.behind * model.steps
        self._profile[SPEED, -1] = state.told[0, TOLD_BIT_SPEED, bit & mask_of(state.told.shape[2])]
        return self._profile

    def top(self) -> tuple[float, float]:
        """Speed (rad/s) and torque (N·m) of the string's top at the time of the last confirmed answer."""
        at = self._common_step() & mask_of(self._state.told.shape[2])
        speed, torque = self._state.told[0, TOLD_TOP_SPEED:, at]
        return float(speed), float(torque)

    def _common_step(self) -> int:
        """The internal step at which the top stood when the bit did what is confirmed of it last."""
        travel = self._model.now - self._model.behind * self._model.steps
        return int((self._state.ticks[0] - self._model.lag) * self._model.steps - 1 - travel)

    def run(self, torque: ArrayLike, speed: ArrayLike, reasons: ArrayLike | None = None) -> Estimates:
        """Run n ticks of motor torque (N·m) and motor speed (rad/s), each of shape (n,).

        `reasons` (n,) flags what was wrong with the inputs. However the input is split into
        calls, the answers are the same to the bit. Raises ValueError where the lengths differ.
        """
        torques = np.ascontiguousarray(torque, dtype=np.float64)
        speeds = np.ascontiguousarray(speed, dtype=np.float64)
        n = len(torques)
        flags = np.zeros(n, np.uint32) if reasons is None else np.ascontiguousarray(reasons, dtype=np.uint32)
        if not len(speeds) == len(flags) == n:
            raise ValueError(
                f"{n} torques, {len(speeds)} speeds and {len(flags)} reasons: lengths must agree"
            )
        out = Estimates(np.empty((n, kernel.COLUMNS)), np.empty(n, np.uint32), np.empty((2, n)))
        for start, end in self._between_corrections(n):
            part = slice(start, end)
            self._advance(_Ticks(torques, speeds, flags, out.values, out.reasons).part(start, end))
            out.delays[0, part], out.delays[1, part] = self.confirmed_delay, self.forecast_horizon
        return out

    def _between_corrections(self, n: int) -> Iterator[tuple[int, int]]:
        """Cut n ticks where the configuration is corrected: at the same ticks however they come in."""
        start = 0
        while start < n:
            done = int(self._state.ticks[0])
            end = min(n, start + self._between - done % self._between)
            yield start, end
            start = end

    def _advance(self, ticks: _Ticks) -> None:
        self._told = self._model
        count = len(ticks.torque)
        if count > WORTHWHILE and (most := most_abreast(self._model)) > WORTHWHILE:
            kernel.advance_abreast(self._model, self._state, self._room, most, *ticks.part(0, count - 1))
            ticks = ticks.part(count - 1, count)
        next(kernel.turns(self._model, self._state, *ticks))
        if count:
            self._correct_in_time()

    def _correct_in_time(self) -> None:
        if self._state.ticks[0] % self._between == 0:
            self._correct()

    def _correct(self) -> None:
        tuning, enabled = self._state.tuning, self._rig.tuning.enabled
        offset = float(tuning.value[OFFSET])
        heard = correct_by_misfit(tuning, self._model.off, enabled and self._settled())
        tared = correct_by_tare(tuning, enabled)
        if correct_by_bound(tuning, enabled) or tared or heard:
            before = self._model.line
            # What is in the lines stays there: they are read at other delays from now on.
            self._run_by(self._corrected())
            refit_torque(self._model, self._state, float(tuning.value[OFFSET]) - offset)
            refit_wall(self._model, self._state, before)
            self._state.course[:] = NONE

    def _settled(self) -> bool:
        model = self._model
        return bool(self._state.ticks[0] > SETTLED_S * model.rate or not model.learns)

    def _new(self) -> State:
        return fresh(self._configured, self._rig.bit, self._rig.tuning)

    def _take(self, state: State) -> None:
        self._state = state
        self._run_by(self._corrected())
        self._told = self._model

    def _run_by(self, model: Model) -> None:
        self._model = model
        self._turns = kernel.turns(model, self._state, *self._one)

    def _corrected(self) -> Model:
        value = self._state.tuning.value
        line = tuned(self._configured.line, value)
        rates = self._configured.drive_rates * (1 + float(value[INERTIA]))
        return timed(self._configured._replace(line=line, drive_rates=rates))
