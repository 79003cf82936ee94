"""A depth channel falls silent while the bit is lifted: the rock that follows is no friction of the wall."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from tests.rigs import BEGUN_NS, NS, RATE, SHORT, Surface, samples
from vsensor.depth.belief import FRESH_S, LASTING_S
from vsensor.estimator.tune import FRICTION
from vsensor.intake.arrivals import Arrivals
from vsensor.messages import SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH, SURFACE_SPEED, Estimate, Sample, Tick
from vsensor.offline import Offline
from vsensor.service.engine import Engine
from vsensor.simulate.rig import SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

LENGTH = SHORT.string[0].length
TOLD_S, TOUCHES_S, ALL_S = 16, 24, 60
ON_BOTTOM = ((0.0, 0.0), (TOUCHES_S, 0.0), (TOUCHES_S + 1.0, 1.0))
"""Times and shares of the load law on the bit."""


@pytest.fixture(scope="module")
def lifted() -> Surface:
    """A bit that turns off bottom and then drills; that it is lifted is told once a second, for 16 s."""
    source = SimulatedRig(SHORT, replace(PLANS[Scenario.SMOOTH], load=ON_BOTTOM), 1)
    feed: Surface = []
    for number, sample in enumerate(samples(source.sample() for _ in range(ALL_S * RATE))):
        if number % (2 * RATE) == 0 and number < TOLD_S * 2 * RATE:
            time_ns = BEGUN_NS + number // (2 * RATE) * NS
            for topic, metres in ((SURFACE_BIT_DEPTH, LENGTH - 9), (SURFACE_HOLE_DEPTH, LENGTH - 4)):
                feed.append((topic, Sample(time_ns=time_ns, value=metres)))
        feed.append(sample)
    return feed


@pytest.fixture(scope="module")
def told(lifted: Surface) -> tuple[Engine, list[tuple[Tick, Estimate]]]:
    engine = Engine(SHORT)
    return engine, [made for topic, sample in lifted for made in engine.take(topic, sample)]


def test_the_rock_that_follows_is_not_taken_for_friction_of_the_wall(
    told: tuple[Engine, list[tuple[Tick, Estimate]]],
) -> None:
    friction, doubt = told[0].estimator.tuning[FRICTION], told[0].estimator.tuning_std[FRICTION]
    assert abs(friction) < 3 * doubt
    assert doubt < SHORT.tuning.friction / 2  # a tare was taken while the depths were told


def test_the_law_is_in_force_again_and_tells_the_bits_torque(
    told: tuple[Engine, list[tuple[Tick, Estimate]]],
) -> None:
    last = told[1][-1][1]
    assert last.now_bit_torque_nm == pytest.approx(SHORT.bit.kinetic_torque, rel=0.3)


def test_the_bit_is_held_to_be_on_bottom_within_seconds(
    told: tuple[Engine, list[tuple[Tick, Estimate]]],
) -> None:
    engine, made = told
    free = [(tick.time_ns - BEGUN_NS) / NS for tick, _ in made if tick.off_bottom]
    ends_s = TOLD_S - 1 + FRESH_S
    assert free[0] == pytest.approx(LASTING_S, abs=1.1 / RATE)  # once it was told for long enough
    assert free[-1] == pytest.approx(ends_s, abs=1.1 / RATE)
    assert len(free) == pytest.approx((ends_s - LASTING_S) * RATE, abs=2)
    assert engine.intake.depths_silent
    assert not engine.intake.off_bottom


def test_by_columns_the_answers_are_the_same(
    lifted: Surface, told: tuple[Engine, list[tuple[Tick, Estimate]]]
) -> None:
    chunks = list(Offline(SHORT).estimates(_by_columns(lifted)))
    rows = np.concatenate([chunk["now_speed_rad_s"] for chunk in chunks])
    for row, (_, estimate) in zip(rows, told[1], strict=True):
        assert estimate.now_bit_speed_rad_s == (0.0 if np.isnan(row) else row)


def _by_columns(lifted: Surface) -> Iterator[Arrivals | tuple[str, Sample]]:
    run: Surface = []
    for topic, sample in [*lifted, (SURFACE_BIT_DEPTH, Sample(time_ns=BEGUN_NS, value=0.0))]:
        if topic not in (SURFACE_BIT_DEPTH, SURFACE_HOLE_DEPTH):
            run.append((topic, sample))
            continue
        yield _columns(run)
        yield topic, sample
        run = []


def _columns(run: Surface) -> Arrivals:
    return Arrivals(
        is_speed=np.array([topic == SURFACE_SPEED for topic, _ in run], bool),
        time_ns=np.array([sample.time_ns for _, sample in run], np.int64),
        value=np.array([sample.value for _, sample in run], float),
        quality=np.zeros(len(run), np.int64),
        sequence=np.array([sample.sequence for _, sample in run], np.uint64),
        numbered=np.ones(len(run), bool),
    )
