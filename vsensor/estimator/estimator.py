"""The virtual sensor: surface torque and speed in, the bit confirmed, now and foretold out."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vsensor.config import Bit, Rig
from vsensor.estimator import kernel
from vsensor.estimator.along import SPEED, TORQUE, Stations, along, stations
from vsensor.estimator.learn import lose_sight
from vsensor.estimator.sections import Floats, Line, cut, junction_depths, steps_per_tick
from vsensor.estimator.state import LEARNED, Model, State, fill, flat, fresh
from vsensor.estimator.top_drive import smoothers

ERROR_MEMORY_S = 60.0
"""Time over which the running error of a prediction forgets: some ten periods of stick-slip."""


class Estimates(NamedTuple):
    """n ticks of answers. Speeds in rad/s, torques in N·m, NaN where not known yet."""

    values: Floats
    """Shape (n, 12): confirmed, now, forecast, each speed, its deviation, torque, its deviation."""
    reasons: NDArray[np.uint32]
    """Flags of `quality.Reason`, shape (n,)."""


class Estimator:
    """Runs tick by tick at `rig.loop.rate`; knows no clock.

    The answers of one tick are for three times, each a fixed distance from the tick's own:
    confirmed `confirmed_delay` earlier, now at the tick, the forecast `forecast_horizon` later.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        tick = 1 / rig.loop.rate
        steps = steps_per_tick(rig.string, tick, rig.estimator.bandwidth)
        cuts = rig.string, tick / steps, rig.estimator.section_length
        line = cut(*cuts)
        self.stations = stations(rig.string, line, junction_depths(*cuts))
        """Where along the string `profile` tells of it."""
        self._top = Stations._make(column[:1] for column in self.stations)
        self._profile = np.empty((2, len(self.stations.depth)))
        self._profile_top = np.empty((2, 1))
        self._model, noise = _with_deviations(_model(rig, line, steps), rig, self.stations)
        self.profile_noise = noise
        """Standard deviation of `profile` from the measurement's noise, laid out like it."""
        self._state = fresh(self._model, self._rig.bit)
        self._one = (
            np.empty((2, 1)),
            np.empty(1, np.uint32),
            np.empty((1, kernel.COLUMNS)),
            np.empty(1, np.uint32),
        )
        step = tick / steps
        self.confirmed_delay = self._model.now * step
        """How long before the tick the confirmed answer is for, s."""
        self.forecast_horizon = (self._model.forecast - self._model.now) * step
        """How long after the tick the forecast is for, s."""
        self.warm_up = self._model.span * tick
        """How much input is needed before the first answer, s."""
        self.speed_noise = self._model.speed_std
        """Standard deviation of the confirmed speed from the measurement's noise, rad/s."""
        self.torque_noise = self._model.torque_std
        """Standard deviation of the confirmed torque from the measurement's noise, N·m."""

    @property
    def line(self) -> Line:
        """The string as cut into sections."""
        return self._model.line

    @property
    def steps_per_tick(self) -> int:
        """Internal steps in a tick."""
        return self._model.steps

    @property
    def law(self) -> Bit:
        """The load law in force: as configured at first, then as learned."""
        viscous, kinetic, static, stribeck = (float(x) for x in self._state.learned.law)
        return self._rig.bit.model_copy(
            update={
                "viscous_friction": viscous,
                "kinetic_torque": kinetic,
                "static_torque": static,
                "stribeck_speed": stribeck,
            }
        )

    def reset(self) -> None:
        """Forget everything, as at the start."""
        self._state = fresh(self._model, self._rig.bit)

    def restart(self) -> None:
        """Forget all input, as after a long gap; what was learned of the rock and of our own errors stays."""
        before = self._state
        self.reset()
        fill(self._state, {k: v for k, v in flat(before).items() if k in LEARNED})
        lose_sight(self._state.learned)

    def save(self) -> dict[str, NDArray[np.generic]]:
        """The whole state as named arrays: restored, it goes on to the same bits."""
        return flat(self._state)

    def restore(self, saved: Mapping[str, NDArray[np.generic]]) -> None:
        """Take up a saved state. Raises ValueError where it is of another string, rate or version."""
        state = fresh(self._model, self._rig.bit)
        if saved.keys() != flat(state).keys():
            raise ValueError(f"the saved state holds {sorted(saved)}, not {sorted(flat(state))}")
        fill(state, saved)
        self._state = state

    def step(self, torque: float, speed: float, reasons: int = 0) -> tuple[Floats, int]:
        """Run one tick; returns the answers (12,), valid until the next call, and the flags."""
        inputs, flags, values, lasting = self._one
        inputs[0, 0], inputs[1, 0], flags[0] = torque, speed, reasons
        kernel.advance(self._model, self._state, inputs[0], inputs[1], flags, values, lasting)
        return values[0], int(lasting[0])

    def profile(self) -> Floats:
        """Speed (rad/s) and torque (N·m) at each station at the time of the last confirmed answer.

        Shape (2, n), valid until the next call; as good as that answer, and without meaning before the first.
        """
        _look(self._model, self._state, self.stations, self._profile)
        return self._profile

    def top(self) -> tuple[float, float]:
        """Speed (rad/s) and torque (N·m) of the string's top at the time of the last confirmed answer."""
        _look(self._model, self._state, self._top, self._profile_top)
        return float(self._profile_top[SPEED, 0]), float(self._profile_top[TORQUE, 0])

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
        out = Estimates(np.empty((n, kernel.COLUMNS)), np.empty(n, np.uint32))
        kernel.advance(self._model, self._state, torques, speeds, flags, out.values, out.reasons)
        return out


def _model(rig: Rig, line: Line, steps: int) -> Model:
    rate = rig.loop.rate
    smooth = smoothers(rig.top_drive, rig.measurement, rig.estimator.bandwidth, rate, steps)
    window = smooth.confirmed.speed_of_speed.shape[1]
    round_trip = int(line.round_trip.sum())
    return Model(
        line=line,
        bit_rate=2 * rig.bit.inertia * rate * steps,
        smooth=smooth,
        steps=steps,
        now=smooth.lag * steps + round_trip // 2,
        forecast=smooth.lag * steps + round_trip,
        # One step more than the waves need, for the bit's acceleration.
        span=window - 1 + -(-(round_trip + 1) // steps) + 1,
        memory=round(ERROR_MEMORY_S * rate),
        drive_rate=2 * rig.top_drive.inertia * rate * steps,
        rate=rate,
        learns=rig.estimator.learn,
        speed_std=0.0,
        torque_std=0.0,
    )


def _look(model: Model, state: State, at: Stations, told: Floats) -> None:
    """Fill `told` (2, n) with what stood at the stations at the time of the last confirmed answer."""
    travel = model.now - model.smooth.lag * model.steps
    common = int(state.ticks[0]) * model.steps - 1 - travel
    along(model.line, state.waves, state.returned, at, common, told)


def _with_deviations(model: Model, rig: Rig, at: Stations) -> tuple[Model, Floats]:
    """Enter the standard deviations that the measurement's noise gives the confirmed answer.

    Returns those along the string beside, shape (2, n).

    The estimator is linear but for Coulomb friction, so that white noise of each channel comes
    out with the root of the sum of squares of the answer to a unit impulse on that channel.
    """
    free = model.line._replace(
        kinetic=np.zeros_like(model.line.kinetic), static=np.zeros_like(model.line.static)
    )
    linear = model._replace(line=free)
    of_torque = _impulse_energy(linear, rig.bit, at, 1.0, 0.0)
    of_speed = _impulse_energy(linear, rig.bit, at, 0.0, 1.0)
    noise = rig.measurement
    (speed_std, torque_std), profile_std = (
        np.sqrt(torque * noise.torque_noise**2 + speed * noise.speed_noise**2)
        for torque, speed in zip(of_torque, of_speed, strict=True)
    )
    return model._replace(speed_std=float(speed_std), torque_std=float(torque_std)), profile_std


def _impulse_energy(
    model: Model, bit: Bit, at: Stations, torque: float, speed: float
) -> tuple[Floats, Floats]:
    """Sums of squares after a unit impulse: of confirmed bit speed and torque (2,), and along it (2, n)."""
    n = model.span + 1
    torques, speeds = np.zeros(2 * n), np.zeros(2 * n)
    torques[n], speeds[n] = torque, speed
    out = np.empty((2 * n, kernel.COLUMNS))
    flags = np.zeros(2 * n, np.uint32)
    state = fresh(model, bit)
    told = np.empty((2, len(at.depth)))
    energy = np.zeros_like(told)
    for first, end in [(0, n), *((k, k + 1) for k in range(n, 2 * n))]:
        ticks = slice(first, end)
        kernel.advance(
            model, state, torques[ticks], speeds[ticks], flags[ticks], out[ticks], flags[ticks].copy()
        )
        _look(model, state, at, told)
        energy += told**2
    answer = out[n:, [kernel.CONFIRMED + kernel.SPEED, kernel.CONFIRMED + kernel.TORQUE]]
    return np.asarray((answer**2).sum(axis=0)), energy
