"""Every number that the page tells, as one table: what the paper prints, and what it should be."""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vsensor.estimator import component
from vsensor.paper import cases, distributed
from vsensor.paper.results import RAISED_TORQUE, Results
from vsensor.paper.shaft import BIT, SHAFT, TORQUE, Response, load_as_printed, shear_stress

SAMPLES_TOLD = 6
"""Of eq. (24) and (25), from the first on."""


class Value(NamedTuple):
    """One number."""

    topic: str
    quantity: str
    unit: str
    value: float
    expected: float | None = None
    """What the paper prints, or another publication's outcome."""


def values(results: Results) -> tuple[Value, ...]:
    """Every number, by topic."""
    return (
        *_shaft(),
        *_distributed(results),
        *_closed_form(results),
        *_stick_slip(results),
        *_stress(results),
        *_errors(results),
        *(Value(o.case, o.quantity, o.unit, o.ours, o.expected) for o in results.outcomes()),
    )


def write_csv(path: Path, rows: tuple[Value, ...]) -> None:
    """Write the table with a head; `expected` is empty where nothing is."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Value._fields)
        writer.writerows(
            (*row[:3], *("" if n is None or math.isnan(n) else f"{n:.9g}" for n in row[3:])) for row in rows
        )


def _shaft() -> Iterator[Value]:
    theta = component.delay(SHAFT)
    told: tuple[tuple[str, str, float, float | None], ...] = (
        ("polar second moment J", "m⁴", component.polar_moment(SHAFT), None),
        ("wave speed c", "m/s", component.wave_speed(SHAFT), None),
        ("one-way delay θ", "s", theta, None),
        ("round trip T_p", "s", 2 * theta, 2.536),
        ("impedance ζ", "N·m·s/rad", component.impedance(SHAFT), None),
        ("stiffness GJ/L", "N·m/rad", component.stiffness(SHAFT), 580.0),
        ("own inertia ρJL", "kg·m²", component.inertia(SHAFT), 930.0),
        ("inertia of the load", "kg·m²", BIT.inertia, load_as_printed(SHAFT).inertia),
    )
    return (Value("shaft", *row) for row in told)


def _distributed(results: Results) -> Iterator[Value]:
    load, trip = load_as_printed(SHAFT), 2 * component.delay(SHAFT)
    alpha, beta = distributed.load_rule(load, trip)
    topic = "eq. (24), (25), J_L = 2500 kg·m²"
    yield Value(topic, "α_L", "1", alpha)
    yield Value(topic, "β_L", "rad/(N·m·s)", beta)
    yield Value(topic, "ζβ_L", "1", component.impedance(SHAFT) * beta)
    yield Value(
        topic,
        "steady speed, T₀/D_L",
        "rad/s",
        TORQUE / load.damping,
        distributed.steady_as_printed(SHAFT, load, TORQUE),
    )
    answer = results.paper.printed
    for end, trace in (("top ω₀", answer.top), ("bit ω₁", answer.end)):
        for time, speed in zip(*(part[:SAMPLES_TOLD].tolist() for part in trace), strict=True):
            yield Value(topic, f"{end} at {time:.4f} s", "rad/s", speed)


def _closed_form(results: Results) -> Iterator[Value]:
    theta = component.delay(SHAFT)
    for topic, truth in (
        ("closed form, J_L = 2500 kg·m²", results.paper.printed_truth),
        ("closed form, J_L = 1570 kg·m²", results.paper.truth),
    ):
        for words, time in (*((f"{n} θ", n * theta) for n in range(2, 6)), ("10 s", 10.0), ("20 s", 20.0)):
            yield Value(topic, f"bit ω₁ at {words}", "rad/s", float(truth.end_speed(np.array([time]))[0]))


def _stick_slip(results: Results) -> Iterator[Value]:
    motion, topic = results.stick_slip, "stick-slip of the lumped string"
    late = motion.time > motion.time[-1] / 2
    bit = motion.speeds[1][late]
    yield Value(topic, f"{TORQUE:.0f} N·m: period", "s", cases.period(motion.times("free")))
    yield Value(topic, f"{TORQUE:.0f} N·m: greatest speed of the bit", "rad/s", bit.max(), 0.8)
    yield Value(topic, f"{TORQUE:.0f} N·m: share of time at rest", "1", float(np.mean(bit == 0)))
    yield Value(topic, f"{RAISED_TORQUE:.0f} N·m: steady speed", "rad/s", results.smooth.speeds[1][-1])


def _stress(results: Results) -> Iterator[Value]:
    of = results.paper
    yield Value("shear stress", "steady", "Pa", float(shear_stress(of.shaft, TORQUE)))
    answers: tuple[tuple[str, Response], ...] = (
        ("lumped", of.lumped),
        ("one step a round trip", of.printed),
        ("stepped finely", of.fine),
    )
    for words, answer in answers:
        stress = shear_stress(of.shaft, answer.end_torque.value)
        yield Value("shear stress", f"greatest at the end, {words}", "Pa", float(stress.max()))
        yield Value("shear stress", f"least at the end, {words}", "Pa", float(stress.min()))


def _errors(results: Results) -> Iterator[Value]:
    for length, ends in results.errors.items():
        for end, errors in zip(("top", "bit"), ends, strict=True):
            for model, error in errors._asdict().items():
                yield Value(f"rms error, {length:.0f} m", f"{end}, {model}", "of the steady speed", error)
