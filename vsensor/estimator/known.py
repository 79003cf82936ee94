"""What an estimator knows of itself between two ticks: its times, its errors, what it has learned."""

import numpy as np

from vsensor.config import Bit, Component, Rig
from vsensor.estimator.gains import Gains
from vsensor.estimator.noise import SHARES
from vsensor.estimator.responses import TOLD_TOP_SPEED
from vsensor.estimator.sections import Floats, Line
from vsensor.estimator.state import Model, State


class Known:
    """The estimator as far as it can be asked."""

    _rig: Rig
    _state: State
    _configured: Model
    _model: Model
    _told: Model
    """The model of the last answers: corrections come after them."""

    @property
    def string(self) -> tuple[Component, ...]:
        """The string as configured, with what was added while running."""
        return self._rig.string

    @property
    def warm_up(self) -> float:
        """How much input is needed before the first answer, s."""
        return self._configured.span / self._configured.rate

    @property
    def line(self) -> Line:
        """The string as cut into sections, delays and friction as corrected."""
        return self._model.line

    @property
    def steps_per_tick(self) -> int:
        """Internal steps in a tick."""
        return self._model.steps

    @property
    def confirmed_delay(self) -> float:
        """How long before its tick the last confirmed answer was for, s."""
        return (self._told.lag + self._told.now / self._told.steps) / self._told.rate

    @property
    def forecast_horizon(self) -> float:
        """How long after its tick the last forecast was for, s."""
        return (self._told.forecast - self._told.now) / self._told.steps / self._told.rate

    @property
    def noise(self) -> Floats:
        """Standard deviations that noise and rock leave to the confirmed speed and torque, shape (2,)."""
        variance = self._model.gains.variance[self._state.level[0], :TOLD_TOP_SPEED]
        return np.asarray(np.sqrt(self._state.noisier * variance))

    @property
    def profile_noise(self) -> Floats:
        """The same of `profile`, laid out like it."""
        return np.asarray(np.sqrt(self._state.noisier * self._model.gains.along[self._state.level[0]]))

    @property
    def noisier(self) -> float:
        """By what factor the channels are noisier than told, 1 where they are not."""
        return float(np.sqrt(self._state.noisier[0]))

    @property
    def ticks_a_reading(self) -> float:
        """For how many ticks a reading of motor speed stands, 1 where there is one for each."""
        return float(self._state.lasts[0])

    @property
    def coarse_steps(self) -> Floats:
        """Steps in which motor torque (N·m) and speed (rad/s) are read, shape (2,).

        0 where none are seen, or where they do not count beside the noise that was told.
        """
        steps = (
            self._state.resolution
        )  # judged as in noise.py; a kernel for it would be compiled when asked first
        return np.where(np.multiply(SHARES, steps) > self._model.noise, steps, 0.0)

    @property
    def bandwidth(self) -> float:
        """The frequency up to which at least half of the rock's torque is told, Hz."""
        return float(self._model.gains.band[self._state.level[0]])

    @property
    def gains(self) -> Gains:
        """How much innovations correct, and what error they leave, for each level of the rock."""
        return self._model.gains

    @property
    def tuning(self) -> Floats:
        """Corrections in force: delay, impedance, inertia, friction (shares), torque's offset, N·m; (5,)."""
        return self._state.tuning.value.copy()

    @property
    def tuning_std(self) -> Floats:
        """Standard deviations of what they leave uncertain, shape (5,)."""
        return np.asarray(np.sqrt(self._state.tuning.variance))

    @property
    def skill(self) -> Floats:
        """How predictions missed of late: how far ahead, s, rms of speed, rad/s, and of torque, N·m.

        Shape (H, 3), from now to the end of the forecast; NaN where none has come true yet.
        """
        model, (squares, ticks) = self._model, np.moveaxis(self._state.scores.misses, -1, 0)
        ahead = (model.horizons - model.now) / model.steps / model.rate
        rms = np.sqrt(np.divide(squares, ticks, out=np.full_like(ticks, np.nan), where=ticks > 0))
        return np.column_stack([ahead, rms])

    @property
    def rock_std(self) -> float:
        """Standard deviation of what the bit does that the load law does not foresee, as a torque, N·m."""
        return float(np.sqrt(self._state.rock_square[0]))

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
