"""Figs. 9 and 10 for shafts of any length, and how far each model is from the truth.

The paper concludes that its distributed model loses accuracy as the string grows. Errors here are root
mean squares over WINDOW, in parts of the steady speed T₀/D, of a model's speed from the closed form's.
Two truths tell what does the harm: the string with its load, each inertia counted once, and the paper's
own equations with the pipe's inertia counted twice, but solved exactly.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vsensor.config import Component
from vsensor.estimator import component
from vsensor.paper import distributed, fine, lumped
from vsensor.paper.exact import StepResponse
from vsensor.paper.shaft import BIT, TORQUE, Floats, Load, Response, Trace, load_as_printed, of_length

LENGTHS = (500.0, 1000.0, 2000.0, 4000.0, 8000.0)
"""Of the shaft, m; 4000 is the paper's."""

WINDOW = 40.0
"""What is compared: from the step of torque on, s."""

FINE_STEP = 1e-3
"""The program's own steps are about so long, s."""

_GRID = (np.arange(8000) + 0.5) * WINDOW / 8000
_SAMPLES = 2000
"""At most so many of a model's own samples are held against the closed form."""
_AFTER = 1e-9
"""At a front a model's sample is what follows it, s."""

Truth = Callable[[Floats], Floats]


class Models(NamedTuple):
    """Each model's answer for one shaft, and the two truths."""

    shaft: Component
    truth: StepResponse
    """The string with its load."""
    printed_truth: StepResponse
    """The paper's equations with the paper's load, solved exactly."""
    lumped: Response
    printed: Response
    """Eq. (24), (25): one step a round trip, J_L = J_r + J_b."""
    fine: Response


class Errors(NamedTuple):
    """Of one speed, rms over WINDOW in parts of the steady speed."""

    lumped: float
    printed: float
    """Eq. (24) or (25) from the string with its load, each sample held until the next."""
    stepping: float
    """The same from the paper's own equations solved exactly: what one step a round trip does alone."""
    samples: float
    """As `stepping`, but asked at the model's own samples only."""
    fine: float


class Study(NamedTuple):
    """How the error of the bit's speed depends on the step, for one shaft."""

    length: float
    step: Floats
    """s, shape (n,)."""
    papers_rule: Floats
    """With eq. (24), (25) in so many steps, shape (n,)."""
    kernels: Floats
    """With the program's kernels, shape (n,); NaN for one step a round trip, which they do not take."""


def models(length: float, until: float = WINDOW) -> Models:
    """Every model of the paper's shaft at a length (m), to `until` (s)."""
    shaft = of_length(length)
    printed = load_as_printed(shaft)
    return Models(
        shaft,
        StepResponse(shaft, BIT, TORQUE),
        StepResponse(shaft, printed, TORQUE),
        lumped.step_response(lumped.of_shaft(shaft), TORQUE, np.linspace(0, until, 4001)),
        distributed.step_response(distributed.difference(shaft, printed), TORQUE, until),
        fine.stepped(shaft, BIT, TORQUE, until, fine_steps(shaft)),
    )


def fine_steps(shaft: Component) -> int:
    """Steps in one delay, for steps of about FINE_STEP."""
    return math.ceil(component.delay(shaft) / FINE_STEP)


def errors(of: Models) -> tuple[Errors, Errors]:
    """Of the speeds at the top and at the end."""
    truth, same = of.truth, of.printed_truth
    return (
        _errors(of.lumped.top, of.printed.top, of.fine.top, truth.top_speed, same.top_speed),
        _errors(of.lumped.end, of.printed.end, of.fine.end, truth.end_speed, same.end_speed),
    )


def _errors(simple: Trace, printed: Trace, finely: Trace, truth: Truth, same: Truth) -> Errors:
    true = truth(_GRID)
    held = _held(printed, _GRID)
    return Errors(
        lumped=_rms(np.interp(_GRID, *simple) - true),
        printed=_rms(held - true),
        stepping=_rms(held - same(_GRID)),
        samples=error_at_samples(printed, same),
        fine=error_at_samples(finely, truth),
    )


def error_at_samples(trace: Trace, truth: Truth) -> float:
    """Rms of a model's samples from the truth, in parts of the steady speed."""
    every = max(1, len(trace.time) // _SAMPLES)
    time, value = trace.time[::every], trace.value[::every]
    return _rms(value - truth(time + _AFTER))


def _held(trace: Trace, time: Floats) -> Floats:
    return np.asarray(np.append(0.0, trace.value)[np.searchsorted(trace.time, time, side="right")])


def _rms(error: Floats) -> float:
    return float(np.sqrt(np.mean(error**2)) / (TORQUE / BIT.damping))


def study(length: float, halvings: int) -> Study:
    """The paper's equations for a shaft (m) in 1, 2, 4 … 2^halvings steps a round trip, by both rules."""
    shaft = of_length(length)
    load = load_as_printed(shaft)
    truth = StepResponse(shaft, load, TORQUE)
    steps = 2 ** np.arange(halvings + 1)
    papers = [_papers_rule(shaft, load, truth, int(n)) for n in steps]
    kernels = [_kernels(shaft, load, truth, int(n)) for n in steps[1:] // 2]
    return Study(length, 2 * component.delay(shaft) / steps, np.array(papers), np.array([math.nan, *kernels]))


def _papers_rule(shaft: Component, load: Load, truth: StepResponse, steps: int) -> float:
    answer = distributed.step_response(distributed.difference(shaft, load, steps), TORQUE, WINDOW)
    return error_at_samples(answer.end, truth.end_speed)


def _kernels(shaft: Component, load: Load, truth: StepResponse, steps: int) -> float:
    return error_at_samples(fine.stepped(shaft, load, TORQUE, WINDOW, steps).end, truth.end_speed)
