"""A short string that answers within a second, and what its surface sensors say."""

from collections.abc import Iterable

from tests.strings import PIPE, rig
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.simulate.rig import Reading, SimulatedRig
from vsensor.simulate.scenario import PLANS, Scenario

NS = 1_000_000_000
BEGUN_NS = 1_700_000_000 * NS
RATE = 50
BIT = {"inertia": 50.0, "kinetic_torque": 1e3, "static_torque": 2e3, "stribeck_speed": 1.5}
SHORT = rig(
    PIPE.model_copy(update={"length": 1200.0}),
    rate=RATE,
    bit=BIT,
    top_drive={"inertia": 500.0},
    estimator={"severity_window": 4.0},
)

Surface = list[tuple[str, Sample]]


def simulated(seconds: float, seed: int = 1) -> list[Reading]:
    """Readings of the short rig in smooth drilling."""
    source = SimulatedRig(SHORT, PLANS[Scenario.SMOOTH], seed)
    return [source.sample() for _ in range(round(seconds * RATE))]


def samples(readings: Iterable[Reading], begun_ns: int = BEGUN_NS, sequence: int = 0) -> Surface:
    """Readings as the samples that a rig sends, in turn."""
    sent: Surface = []
    for number, reading in enumerate(readings, sequence):
        time_ns = begun_ns + round(reading.time_s * NS)
        sent.append((SURFACE_TORQUE, Sample(time_ns=time_ns, value=reading.motor_torque, sequence=number)))
        sent.append((SURFACE_SPEED, Sample(time_ns=time_ns, value=reading.motor_speed, sequence=number)))
    return sent
