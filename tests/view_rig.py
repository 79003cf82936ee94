"""Messages as a daemon sends them, of a bit that sticks and slips: plain formulas, no physics."""

import math
from collections.abc import Iterator

from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_DESCRIPTION,
    STRING_PROFILE,
    ChannelStatus,
    Description,
    Estimate,
    Event,
    Message,
    Profile,
    Status,
    Tick,
)
from vsensor.messages.vsensor_pb2 import GOOD

BEGUN_NS = 1_700_000_000_000_000_000
DELAY_S = 1.25
DELAY_NS = round(DELAY_S * 1e9)
RATE = 100


def bit_speed(time_s: float) -> float:
    """Stands still half of each 4 s, and turns up to 20 rad/s in the other."""
    return max(0.0, 20.0 * math.sin(math.pi * time_s / 2))


def tick(number: int, begun_ns: int = BEGUN_NS) -> Tick:
    return Tick(
        number=number,
        time_ns=begun_ns + number * 1_000_000_000 // RATE,
        motor_torque_nm=7000.0 + number,
        motor_speed_rad_s=10.0,
        reasons=0,
        slot=number,
        lateness_ns=50_000,
    )


def estimate(number: int, begun_ns: int = BEGUN_NS) -> Estimate:
    """The three answers, each right for its own time."""
    time_ns = begun_ns + number * 1_000_000_000 // RATE
    time_s = number / RATE
    return Estimate(
        number=number,
        time_ns=time_ns,
        confirmed_time_ns=time_ns - DELAY_NS,
        confirmed_bit_speed_rad_s=bit_speed(time_s - DELAY_S),
        confirmed_bit_speed_std_rad_s=0.1,
        confirmed_bit_torque_nm=3000.0,
        confirmed_bit_torque_std_nm=100.0,
        now_bit_speed_rad_s=bit_speed(time_s),
        now_bit_speed_std_rad_s=0.4,
        now_bit_torque_nm=3100.0,
        now_bit_torque_std_nm=200.0,
        forecast_time_ns=time_ns + DELAY_NS,
        forecast_bit_speed_rad_s=bit_speed(time_s + DELAY_S),
        forecast_bit_speed_std_rad_s=0.7,
        forecast_bit_torque_nm=3200.0,
        forecast_bit_torque_std_nm=300.0,
        top_speed_rad_s=10.0,
        top_torque_nm=7000.0,
        quality=GOOD,
        reasons=0,
    )


def status(state: str = "running", time_ns: int = BEGUN_NS) -> Status:
    return Status(
        time_ns=time_ns,
        rig="t",
        state=state,
        rate_hz=RATE,
        slots_due=1000,
        slots_skipped=3,
        restarts=2,
        recorder_dropped=5,
        lateness_p50_s=40e-6,
        lateness_p99_s=120e-6,
        work_p50_s=30e-6,
        work_p99_s=90e-6,
        channels=[ChannelStatus(channel="surface/torque", received=990, accepted=980, lost=7, late=4)],
        severity=1.2,
        severity_window_s=20.0,
        confirmed_delay_s=DELAY_S,
        forecast_horizon_s=DELAY_S,
    )


LENGTH = 3000.0
DEPTHS = [LENGTH * share / 10 for share in range(11)]
COMPLIANCE = 1e-6
IMPEDANCE = 400.0


def profile(number: int, begun_ns: int = BEGUN_NS) -> Profile:
    """Torque falls evenly from 8 kN·m at the top to 3 kN·m at the bit, which is the weaker end."""
    torque = [8000.0 - 5000.0 * depth / LENGTH for depth in DEPTHS]
    return Profile(
        number=number,
        time_ns=begun_ns + number * 1_000_000_000 // RATE - DELAY_NS,
        quality=GOOD,
        reasons=0,
        depth_m=DEPTHS,
        speed_rad_s=[bit_speed(number / RATE - DELAY_S)] * 11,
        torque_nm=torque,
        shear_stress_pa=[5e3 * each for each in torque],
        torque_limit_nm=[40e3] * 10 + [4e3],
        margin=[0.8] * 10 + [0.25],
        weakest_component="collars",
        weakest_depth_m=LENGTH,
        weakest_torque_nm=3000.0,
        weakest_limit_nm=4000.0,
        weakest_limited_by="make-up torque",
        weakest_margin=0.25,
    )


def description() -> Description:
    """Straight down to half its depth, then east at a right angle."""
    half = LENGTH / 2
    return Description(
        time_ns=BEGUN_NS,
        depth_m=DEPTHS,
        north_m=[0.0] * 11,
        east_m=[max(0.0, depth - half) for depth in DEPTHS],
        vertical_depth_m=[min(half, depth) for depth in DEPTHS],
        impedance_nm_s_rad=[IMPEDANCE] * 11,
        compliance_rad_nm_m=[COMPLIANCE] * 11,
        component=["pipe", "collars"],
        component_end_m=[2800.0, LENGTH],
        mode_hz=[0.25, 0.75, 1.25, 9.0],
        gear_ratio=1.0,
        efficiency=1.0,
    )


def stuck(number: int, begins: bool) -> Event:
    return Event(
        time_ns=BEGUN_NS + number * 1_000_000_000 // RATE,
        name="stuck",
        begins=begins,
        text="the bit stands still",
    )


def messages(ticks: int, begun_ns: int = BEGUN_NS) -> Iterator[tuple[str, Message]]:
    """What a daemon publishes: at each tick, each second, and each time the bit sticks or comes loose."""
    was = False
    for number in range(ticks):
        yield SENSOR_TICK, tick(number, begun_ns)
        yield BIT_ESTIMATE, estimate(number, begun_ns)
        if number % (RATE // 10) == 0:
            yield STRING_PROFILE, profile(number, begun_ns)
        if number % RATE == 0:
            yield SENSOR_STATUS, status()
            yield STRING_DESCRIPTION, description()
        if (sticks := bit_speed(number / RATE) == 0.0) != was:
            was = sticks
            yield SENSOR_EVENT, stuck(number, sticks)
