"""What a session comes to in figures: how rough it was, how long the bit stood, how well it was foretold."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from vsensor.messages import Status
from vsensor.report.gather import Story

Floats = npt.NDArray[np.float64]

STUCK = 0.5
"""A bit below this (rad/s, 5 rpm) stands,"""
TURNING = 1.0
"""while a top above this (rad/s, 10 rpm) turns."""
MOVING = 0.1
"""A mean speed below this (rad/s, 1 rpm) is no rotation."""
WORST_S = 60
"""So many seconds of a session are shown closely."""
_AT_ONCE = 100_000


class Severity(NamedTuple):
    """(max − min) / (2 · mean) of the bit's confirmed speed over the seconds before each second."""

    time_ns: npt.NDArray[np.int64]
    value: Floats
    window_s: float


class Skill(NamedTuple):
    """How predictions missed what was confirmed in the end, rms; `ahead_s` before it."""

    ahead_s: Floats
    speed_rad_s: Floats
    torque_nm: Floats


class Sticking(NamedTuple):
    """How long the bit stood while the top turned."""

    share: float
    """Of the time in which the top turned; NaN where it never did."""
    times: int
    longest_s: float


def rolled(time_ns: npt.NDArray[np.int64], speed: Floats, window_s: float) -> Severity:
    """Severity over a window, told each second; NaN where half of it is not known, or nothing turns."""
    if not len(time_ns):
        return Severity(time_ns, speed, window_s)
    second = (time_ns - time_ns.min()) // 1_000_000_000
    count = int(second.max()) + 1
    known = np.isfinite(speed)
    second, speed = second[known], speed[known]
    least, greatest = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(least, second, speed)
    np.maximum.at(greatest, second, speed)
    number, total = np.bincount(second, minlength=count), np.bincount(second, speed, count)
    width = max(1, min(round(window_s), count))

    def over(values: npt.NDArray[Any]) -> Floats:
        return np.asarray(np.lib.stride_tricks.sliding_window_view(values, width))

    with np.errstate(invalid="ignore", divide="ignore"):
        mean = over(total).sum(axis=1) / over(number).sum(axis=1)
        swing = over(greatest).max(axis=1) - over(least).min(axis=1)
        full = 2 * over(np.minimum(number, 1)).sum(axis=1) >= width
        value = np.where(full & (np.abs(mean) >= MOVING), swing / (2 * np.abs(mean)), np.nan)
    ends = (np.arange(len(value)) + width) * 1_000_000_000 + time_ns.min()
    return Severity(ends, value, float(width))


def worst_window(story: Story) -> tuple[int, int]:
    """Begin and end (ns) of the minute in which the bit's speed was furthest (rms) from the top's."""
    apart = story["confirmed_bit_speed_rad_s"] - story["top_speed_rad_s"]
    first = int(story.confirmed_ns.min())
    second = (story.confirmed_ns - first) // 1_000_000_000
    sums = np.bincount(second, np.nan_to_num(apart) ** 2)
    width = min(WORST_S, len(sums))
    begin = int(np.argmax(np.convolve(sums, np.ones(width), "valid")))
    return first + begin * 1_000_000_000, first + (begin + width) * 1_000_000_000


def sticking(story: Story) -> Sticking:
    """How long, and how often, the bit stood below 0.5 rad/s while the top turned at 1 rad/s or more."""
    bit, top = np.abs(story["confirmed_bit_speed_rad_s"]), np.abs(story["top_speed_rad_s"])
    turning = top >= TURNING
    stuck = turning & (bit < STUCK)
    known = turning & np.isfinite(bit)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], stuck.astype(np.int8), [0]))))
    begins, ends = edges[::2], edges[1::2]
    lengths = (story.time_ns[ends - 1] - story.time_ns[begins]) / 1e9
    share = float(stuck.sum() / known.sum()) if known.any() else float("nan")
    return Sticking(share, len(begins), float(lengths.max(initial=0.0)))


def counted(statuses: Sequence[Status]) -> Skill:
    """How predictions missed at each horizon, as the sensor counted while it ran: the rms of what was told.

    Each status tells of the last minute. Those of a string of other horizons than the last are left out.
    """
    told = [
        [(each.ahead_s, each.speed_rms_rad_s, each.torque_rms_nm) for each in status.skill]
        for status in statuses
        if status.skill and all(each.HasField("speed_rms_rad_s") for each in status.skill)
    ]
    table = np.array([rows for rows in told if [row[0] for row in rows] == [row[0] for row in told[-1]]])
    if not len(table):
        return Skill(*np.empty((3, 0)))
    return Skill(table[0, :, 0], *np.sqrt(np.mean(table[:, :, 1:] ** 2, axis=0)).T)


def skill(story: Story) -> Skill:
    """Now and forecast of every tick, held against what was confirmed in the end."""
    rows = [
        (0.0, *_missed(story, "now", story.time_ns)),
        (_horizon(story), *_missed(story, "forecast", story.forecast_ns)),
    ]
    told = np.array([row for row in rows if np.isfinite(row).all()]).reshape(-1, 3)
    return Skill(*told.T)


def _horizon(story: Story) -> float:
    known = np.isfinite(story["forecast_bit_speed_rad_s"])
    return float(np.median(story.forecast_ns[known] - story.time_ns[known]) / 1e9) if known.any() else np.nan


def _missed(story: Story, kind: str, at_ns: npt.NDArray[np.int64]) -> tuple[float, float]:
    """Rms of a prediction less what is confirmed for the time for which it is."""
    order = np.argsort(story.confirmed_ns, kind="stable")
    origin = story.confirmed_ns[order[0]]
    missed = []
    for quantity in ("bit_speed_rad_s", "bit_torque_nm"):
        truth = story[f"confirmed_{quantity}"]
        known = order[np.isfinite(truth[order])]
        if not len(known):
            return np.nan, np.nan
        when, truth = (story.confirmed_ns[known] - origin) / 1e9, truth[known]
        squares, count = 0.0, 0
        # Some at a time: of a long session each array costs as much as all of its answers of one kind.
        for start in range(0, len(at_ns), _AT_ONCE):
            asked = (at_ns[start : start + _AT_ONCE] - origin) / 1e9
            foretold = story[f"{kind}_{quantity}"][start : start + _AT_ONCE]
            # Beyond what is confirmed there is nothing to hold it against.
            within = np.isfinite(foretold) & (asked >= when[0]) & (asked <= when[-1])
            error = foretold[within] - np.interp(asked[within], when, truth)
            squares, count = squares + float(np.sum(error**2)), count + len(error)
        missed.append(float(np.sqrt(squares / count)) if count else np.nan)
    return missed[0], missed[1]
