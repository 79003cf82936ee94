"""Prints docs/accuracy.md from the cases: `make accuracy`.

VSENSOR_REFERENCE_DATA and VSENSOR_FIELD_DATA name the folders of the cases.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.cases import Columns, estimated, folder, midpoints, reference_rig, table
from vsensor.config import load
from vsensor.units import factor

FROM_S = 10.0
RPM = factor("rad/s", "rpm")
CASES = {
    "stick_slip": "full stick-slip under a stiff speed controller",
    "smooth_drilling": "rotary drilling in rough rock",
    "deviated_off_bottom": "a lateral, off bottom: wall friction along the string",
}
HEAD = """# Accuracy

Made by `make accuracy` from cases whose truth is known. They are no part of this repository:
VSENSOR_REFERENCE_DATA and VSENSOR_FIELD_DATA name the folders where they lie. A stated standard deviation
of a confirmed answer holds the noise of the two channels, not an error of the configuration.

## Against exact truth

The cases were written by an independent program, a finely gridded solution of the wave equation, with
the noise of real channels: 80 N·m and 0.015 rad/s. Scored from 10 s on. *Share* is the rms error of bit
speed over the range of the true one; *within 2σ*, the share of speed errors within two stated standard
deviations. The load law starts from the true one and is learned on. For comparison, the surface speed
taken for the bit's.
"""
ROWS = """
| case | answer | speed error, rpm | share | torque error, kN·m | torque bias, N·m | within 2σ |
| --- | --- | ---: | ---: | ---: | ---: | ---: |"""
FIELD = """
## Against a real well

Well B of Aarsnes and Shor (2018), 1733 m, rotation started off bottom after a connection: least and
greatest bit speed of each half second from a downhole sensor. Configuration:
[config/well-b.toml](../config/well-b.toml), plain steel, nothing fitted but the wall friction, which is the
surface torque of steady rotation. The bit's true torque is zero.

| answer | midpoint error, rpm | correlation | mean torque, kN·m |
| --- | ---: | ---: | ---: |"""


def score(told: Columns, truth: Columns, kind: str) -> str:
    """One row of the table."""
    when = told["time_s"] if kind == "now" else told[f"{kind}_time_s"]
    use = np.isfinite(told[f"{kind}_speed_rad_s"]) & (when >= FROM_S) & (when <= truth["time_s"][-1])
    when = when[use]

    def error(quantity: str) -> NDArray[np.float64]:
        true = np.interp(when, truth["time_s"], truth[f"bit_{quantity}"])
        return np.asarray(told[f"{kind}_{quantity}"][use] - true)

    speed, torque = error("speed_rad_s"), error("torque_nm")
    within = np.mean(np.abs(speed) <= 2 * told[f"{kind}_speed_std_rad_s"][use])
    return (
        f"{kind} | {rms(speed) * RPM:.1f} | {rms(speed) / span(truth):.2%} | {rms(torque) / 1e3:.2f} "
        f"| {np.mean(torque):+.0f} | {within:.0%}"
    )


def by_surface(surface: Columns, truth: Columns) -> str:
    """The yardstick: what a driller sees today."""
    use = surface["time_s"] >= FROM_S
    error = np.interp(surface["time_s"][use], truth["time_s"], truth["bit_speed_rad_s"])
    error -= surface["motor_speed_rad_s"][use]
    return f"surface speed | {rms(error) * RPM:.1f} | {rms(error) / span(truth):.2%} | | |"


def rms(error: NDArray[np.float64]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(error**2)))


def span(truth: Columns) -> float:
    """Range of the true bit speed, rad/s."""
    return float(np.ptp(truth["bit_speed_rad_s"][truth["time_s"] >= FROM_S]))


def main() -> None:
    """Print the page."""
    cases, field = folder("VSENSOR_REFERENCE_DATA"), folder("VSENSOR_FIELD_DATA")
    print(HEAD + ROWS)
    for name, words in CASES.items():
        truth, surface = table(cases / f"{name}_downhole.csv"), table(cases / f"{name}_surface.csv")
        told = estimated(reference_rig(cases / f"{name}.json"), cases / f"{name}_surface.csv")
        print(f"| {words} | {by_surface(surface, truth)} |")
        for kind in ("confirmed", "now", "forecast"):
            print(f"| | {score(told, truth, kind)} |")
    truth, surface = table(field / "well_b_1733m_downhole.csv"), table(field / "well_b_1733m_surface.csv")
    rig = load(Path(__file__).parents[2] / "config" / "well-b.toml")
    told = estimated(rig, field / "well_b_1733m_surface.csv")
    print(FIELD)
    error, r = midpoints(surface["time_s"], surface["motor_speed_rad_s"], truth)
    print(f"| surface speed | {error * RPM:.1f} | {r:.3f} | |")
    for kind in ("confirmed", "now", "forecast"):
        when = told["time_s"] if kind == "now" else told[f"{kind}_time_s"]
        known = np.isfinite(told[f"{kind}_speed_rad_s"])
        error, r = midpoints(when[known], told[f"{kind}_speed_rad_s"][known], truth)
        late = known & (when >= 20)
        print(
            f"| {kind} | {error * RPM:.1f} | {r:.3f} | {told[f'{kind}_torque_nm'][late].mean() / 1e3:+.2f} |"
        )


if __name__ == "__main__":
    main()
