"""Shear stress at the end and along the shaft, by each model: what the paper's abstract promises.

In a uniform shaft whose top feels the constant torque T₀ the wave f at the top says it all: g there
is 2 T₀ − f, and either stays as it is on its way. So

    T(x, t) = T₀ + ½ [f(t − x/c) − f(t + x/c)]

whoever says what f was: the closed form, the fine steps, or the paper's steps of a round trip.
"""

from collections.abc import Callable

import numpy as np

from vsensor.config import Component
from vsensor.estimator import component
from vsensor.paper.shaft import Floats, Response

Wave = Callable[[Floats], Floats]
"""The wave f = T₀ + ζω₀ at the top, N·m, at given times; 0 before time 0."""


def wave_between(response: Response, shaft: Component, torque: float) -> Wave:
    """f by a finely stepped answer, in straight lines from sample to sample."""
    time, speed = response.top
    sent = torque + component.impedance(shaft) * speed
    return lambda at: np.asarray(np.where(at < 0, 0.0, np.interp(at, time, sent)))


def wave_held(response: Response, shaft: Component, torque: float) -> Wave:
    """f by an answer that holds each of its samples until the next, as the paper's does."""
    time, speed = response.top
    sent = np.append(0.0, torque + component.impedance(shaft) * speed)
    return lambda at: np.asarray(sent[np.searchsorted(time, at, side="right")])


def torque_along(wave: Wave, shaft: Component, torque: float, depth: Floats, time: Floats) -> Floats:
    """Torque, N·m, at depths (m) and times (s, from 0 on), shape (depths, times); `torque` is the top's."""
    travel = depth[:, None] / component.wave_speed(shaft)
    return torque + 0.5 * (wave(time - travel) - wave(time + travel))
