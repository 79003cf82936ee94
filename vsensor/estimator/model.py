"""From a configuration to the model that runs: the line cut, the gains worked out, the times that follow."""

import math

import numpy as np

from vsensor.config import Rig
from vsensor.estimator.ahead import read_beyond, shares_of
from vsensor.estimator.along import Stations
from vsensor.estimator.gains import gains
from vsensor.estimator.responses import Plant, rock_fade
from vsensor.estimator.score import FORECAST, HORIZONS, NOW
from vsensor.estimator.sections import Integers, Line, longest_round_trips, stretched
from vsensor.estimator.state import Model
from vsensor.estimator.tune import BOUND, IMPEDANCE, INERTIA, SHADOWED, STRINGS, shadows

STICK_S = 0.1
"""A bit foretold to rest for so long sticks: shorter stops are the turning points of an oscillation."""
ROUND_TRIPS = 2
"""After so many the waves that were guessed at the start, those of steady rotation, are forgotten."""
SHADOW_DELAY = 0.008
SHADOW_IMPEDANCE = 0.03
SHADOW_INERTIA = 0.05
"""How far the shadows are off: enough to be told apart from rounding, too little to be another string."""


def model_of(rig: Rig, line: Line, at: Stations, steps: int) -> Model:
    """The model of a rig whose string was cut into `line`, `steps` internal steps in a tick."""
    rate, drive, measured = rig.loop.rate, rig.top_drive, rig.measurement
    passed = drive.gear_ratio * drive.efficiency
    plant = Plant(
        line=line,
        drag=rig.bit.viscous_friction,
        bit_rate=2 * rig.bit.inertia * rate * steps,
        drive_rate=2 * drive.inertia * rate * steps,
        steps=steps,
        rate=rate,
        torque_noise=measured.torque_noise * passed,
        speed_noise=measured.speed_noise / drive.gear_ratio,
        late=drive.torque_lag * rate,
        static=rig.bit.static_torque,
    )
    lag = max(1, round(rig.estimator.lag * rate))
    behind = math.ceil(plant.late)
    round_trip = int(line.round_trip.sum())
    asked = rig.estimator.horizon
    horizon = round_trip if asked is None else max(1, round(asked * rate * steps))
    shares = shares_of(rate, round_trip / steps)
    beyond = read_beyond(shares, steps)
    model = Model(
        line=line,
        impedances=line.impedance[None],
        round_trips=line.round_trip[None],
        mobilities=np.zeros((1, len(line.impedance) - 1)),
        drive_rates=np.array([plant.drive_rate]),
        off=np.zeros(SHADOWED),
        inside=longest_round_trips(line, BOUND * rig.tuning.delay + SHADOW_DELAY),
        shift=0,
        gains=gains(plant, at, lag, (_horizons(line, behind * steps, horizon, beyond) / steps).tolist()),
        bit_rate=plant.bit_rate,
        ringing=_ringing(line, rig.tuning.delay),
        passed=passed,
        turns=drive.gear_ratio,
        limits=(measured.torque_limit / drive.gear_ratio, measured.speed_limit * drive.gear_ratio),
        noise=(measured.torque_noise or math.inf, measured.speed_noise or math.inf),
        rate=rate,
        steps=steps,
        behind=behind,
        late=plant.late,
        lag=lag,
        now=0,
        forecast=0,
        horizons=np.zeros(HORIZONS, np.int64),
        horizon=horizon,
        lasting=math.ceil(STICK_S / (1.0 / (rate * steps))),
        span=behind + lag + -(-ROUND_TRIPS * round_trip // steps),
        fade=rock_fade(rate * steps),
        shares=shares,
        learns=rig.estimator.learn,
    )
    return timed(model)


def _ringing(line: Line, delay: float) -> float:
    """2 m / Δt of a mass m at the bit that makes the string's end ring lower by what is unsure of its pitch.

    What is below the greatest step of impedance, the collars mostly, rings by half a wave length, and as if
    longer by a share with so much of its own inertia ζθ at its end (Rayleigh 1894, section 90). Unsure are
    its delay as told, by the share `delay`, and as rounded.
    """
    steps = line.impedance[1:] / line.impedance[:-1]
    top = int(np.argmax(steps)) + 1 if len(steps) else 0
    told = float(line.depth[-1] - line.depth[top])
    rounding = float(line.round_trip[top:].sum()) / (2 * told) - 1
    return math.hypot(delay, rounding) * float(np.sum(line.impedance[top:] * line.round_trip[top:]))


def timed(model: Model) -> Model:
    """The model with its shadows, and the times that follow from its line."""
    beyond = read_beyond(model.shares, model.steps)
    horizons = _horizons(model.line, model.behind * model.steps, model.horizon, beyond)
    now, forecast = int(horizons[NOW]), int(horizons[FORECAST])
    return _shadowed(model._replace(now=now, forecast=forecast, horizons=horizons))


def _shadowed(model: Model) -> Model:
    """The model with shadows that are a little off: more and less of delay, of impedance, of inertia."""
    line, drive = model.line, float(model.drive_rates[0])
    shift = max(1, round(SHADOW_DELAY * line.depth[-1]))
    delay = shift / float(line.depth[-1])
    longer, shorter = stretched(line, delay), stretched(line, -delay)
    impedance, inertia = np.ones(STRINGS), np.ones(STRINGS)
    impedance[shadows(IMPEDANCE)] += SHADOW_IMPEDANCE, -SHADOW_IMPEDANCE
    inertia[shadows(INERTIA)] += SHADOW_INERTIA, -SHADOW_INERTIA
    lines = (line, longer, shorter, *[line] * (STRINGS - 3))
    impedances = impedance[:, None] * np.array([each.impedance for each in lines])
    return model._replace(
        impedances=impedances,
        round_trips=np.array([each.round_trip for each in lines]),
        mobilities=1.0 / (impedances[:, :-1] + impedances[:, 1:] + line.viscous[1:-1]),
        drive_rates=drive * inertia,
        off=np.array([delay, SHADOW_IMPEDANCE, SHADOW_INERTIA]),
        shift=shift,
    )


def _horizons(line: Line, behind: int, horizon: int, beyond: int) -> Integers:
    """Steps to what is foretold, the last where the waves on their way end, or sooner if less is asked.

    They must be on their way when a march sets out that is read so many steps `beyond`.
    """
    round_trip = int(line.round_trip.sum())
    now = behind + round_trip // 2
    end = min(max(now, round_trip - beyond), now + horizon)
    return np.rint(np.linspace(now, end, HORIZONS)).astype(np.int64)


def with_length(rig: Rig, length: float) -> Rig:
    """The rig with its topmost component of another length."""
    top, *rest = rig.string
    return rig.model_copy(update={"string": (top.model_copy(update={"length": length}), *rest)})
