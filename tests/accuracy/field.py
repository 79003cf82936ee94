"""The real well: what a downhole sensor measured there."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from tests.accuracy import words
from tests.accuracy.score import Answer, Floats, answer
from tests.cases import Columns, midpoints, run, table
from tests.clocks import clock_rate, period, set_right
from vsensor.config import load
from vsensor.estimator.tune import FRICTION
from vsensor.units import factor

TURNING = 3.0
"""The bit turns when it is confirmed to be faster than this, rad/s: past where wall friction fades."""
RPM = factor("rad/s", "rpm")
CONFIGURATION = Path(__file__).parents[2] / "config" / "well-b.toml"


def field(folder: Path) -> Iterator[str]:
    """The page's part about the well."""
    truth, surface = table(folder / "well_b_1733m_downhole.csv"), table(folder / "well_b_1733m_surface.csv")
    third = surface["time_s"][-1] / 3
    rate = clock_rate(surface, truth)
    clocks = truth, set_right(truth, rate)
    above = period(surface["time_s"], surface["motor_torque_nm"])
    yield words.FIELD.format(
        third=third, turning=TURNING * RPM, above=above, below=above / rate, slow=1 - 1 / rate
    )
    yield f"| | surface speed | {followed(surface['time_s'], surface['motor_speed_rad_s'], clocks)} | | | | |"
    told_off = {"nothing": 0.0, "off bottom in the first third": third, "off bottom throughout": np.inf}
    for what, until in told_off.items():
        of, tuning = run(load(CONFIGURATION), folder / "well_b_1733m_surface.csv", until)
        tare = tared(answer(of, "confirmed"), third)
        for kind in ("confirmed", "now", "forecast"):
            here = answer(of, kind)
            known = np.isfinite(here.speed)
            late, rest = (here.torque[known & (here.time >= start)].mean() for start in (20, third))
            yield (
                f"| {what if kind == 'confirmed' else ''} | {kind} "
                f"| {followed(here.time[known], here.speed[known], clocks)} "
                f"| {late / 1e3:+.2f} | {rest / 1e3:+.2f} | {(rest - tare) / 1e3:+.2f} "
                f"| {f'{tuning[FRICTION]:+.0%}' if kind == 'confirmed' else ''} |"
            )


def followed(time: Floats, speed: Floats, clocks: Iterable[Columns]) -> str:
    """Errors and correlations of a bit speed by the downhole record as it stands, and by the right clock."""
    told = (midpoints(time, speed, truth) for truth in clocks)
    return " | ".join(f"{error * RPM:.1f} | {r:.3f}" for error, r in told)


def tared(confirmed: Answer, until_s: float) -> float:
    """Mean torque of a bit that turns off bottom, up to a time, N·m."""
    turning = (confirmed.time <= until_s) & (confirmed.speed > TURNING)
    return float(confirmed.torque[turning].mean())
