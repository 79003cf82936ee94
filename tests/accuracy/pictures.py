"""The page's pictures: a sensor at work, and what its lag buys."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MultipleLocator, NullLocator

from tests.accuracy.score import Answer, Floats, answer
from tests.cases import Columns
from vsensor.config import Rig
from vsensor.estimator.estimator import Estimator
from vsensor.paper.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    RED,
    Picture,
    panels,
    rendered,
    rules,
)
from vsensor.units import factor

WINDOW_S = (25.0, 45.0)
LAGS_S = np.geomspace(0.05, 2.0, 14)
LEVELS = {"middling rock": 4, "restless rock": 6}
"""Of `gains.ROCK_LEVELS`, by name."""
RPM, KNM = factor("rad/s", "rpm"), 1e-3


class Trade(NamedTuple):
    """What a lag leaves of error, by noise and rock."""

    lag: Floats
    """s, shape (n,)."""
    rock: Floats
    """The rock's standard deviation, N·m, shape (2,)."""
    std: Floats
    """Standard deviations of confirmed bit speed and torque, and of the string's top, SI; shape (2, 4, n)."""


def trade(rig: Rig, lags: Floats = LAGS_S) -> Trade:
    """What is left of error over lag, by the sensor's own reckoning."""
    chosen = list(LEVELS.values())
    each = [
        Estimator(
            rig.model_copy(update={"estimator": rig.estimator.model_copy(update={"lag": float(lag)})})
        ).gains
        for lag in lags
    ]
    std = np.sqrt([gains.variance[chosen] for gains in each])
    return Trade(lags, each[0].levels[chosen], np.moveaxis(std, 0, -1))


def shown(picture: Picture, folder: Path) -> str:
    """Write NAME.png into the folder; returns the words that show it on a page beside that folder."""
    png, _ = rendered(picture)
    (folder / f"{picture.name}.png").write_bytes(png)
    return f"\n![{picture.alt}]({folder.name}/{picture.name}.png)\n\n{picture.caption}"


def at_work(told: Columns, surface: Columns, truth: Columns) -> Picture:
    """Twenty seconds of stick-slip."""
    with rules():
        figure, (speed, torque) = panels(2, 1, width=10.0, height=7.0, sharex=True)
        speed.plot(surface["time_s"], surface["motor_speed_rad_s"] * RPM, **_SURFACE)
        speed.plot(truth["time_s"], truth["bit_speed_rad_s"] * RPM, **_TRUTH)
        torque.plot(truth["time_s"], truth["bit_torque_nm"] * KNM, **_TRUTH)
        for kind, color in (("confirmed", BLUE), ("now", GREEN), ("forecast", RED)):
            of = answer(told, kind)
            _draw(speed, of, of.speed * RPM, of.speed_std * RPM, color, kind)
            _draw(torque, of, of.torque * KNM, of.torque_std * KNM, color, kind)
        seen = (truth["time_s"] >= WINDOW_S[0]) & (truth["time_s"] <= WINDOW_S[1])
        fastest = truth["bit_speed_rad_s"][seen].max() * RPM
        speed.set(
            title="Bit speed", ylabel="speed, rpm", xlim=WINDOW_S, ylim=(-0.15 * fastest, 1.15 * fastest)
        )
        speed.xaxis.set_major_locator(MultipleLocator(5))
        torque.set(title="Bit torque", ylabel="torque, kN·m", xlabel="the time that an answer is for, s")
        handles, labels = speed.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return Picture(
        "accuracy",
        figure,
        "Stick-slip: each answer at the time that it is for, the forecast with two standard deviations.",
        "Bit speed and torque over twenty seconds: truth, surface speed, confirmed, now and forecast.",
    )


_SURFACE: dict[str, Any] = {
    "color": BLACK,
    "linewidth": 1.2,
    "linestyle": (0, (5, 2)),
    "label": "surface speed",
}
_TRUTH: dict[str, Any] = {"color": BLACK, "linewidth": 3.4, "alpha": 0.25, "label": "truth"}


def _draw(axes: Axes, of: Answer, value: Floats, std: Floats, color: str, kind: str) -> None:
    axes.plot(of.time, value, color=color, linewidth=1.0, label=kind)
    if kind == "forecast":
        low, high = value - 2 * std, value + 2 * std
        axes.fill_between(
            of.time, low, high, color=color, alpha=0.12, linewidth=0, label="forecast ± 2 standard deviations"
        )


def lag(of: Trade, chosen_s: float) -> Picture:
    """What is left of error over lag; a dotted line at the configured one."""
    charts = (
        ("Confirmed bit speed", "rpm", RPM),
        ("Confirmed bit torque", "N·m", 1.0),
        ("Speed at the string's top", "rpm", RPM),
        ("Torque at the string's top", "N·m", 1.0),
    )
    with rules():
        figure, squares = panels(2, 2, width=10.0, height=7.0, sharex=True)
        for number, (axes, (title, unit, scale)) in enumerate(zip(squares, charts, strict=True)):
            for level, (name, color) in enumerate(zip(LEVELS, (BLUE, RED), strict=True)):
                label = f"{name}, {of.rock[level]:.0f} N·m"
                values = of.std[level, number] * scale
                axes.loglog(of.lag, values, color=color, marker="o", markersize=4, label=label)
            axes.axvline(chosen_s, color=GREY, linewidth=1.4, linestyle=":")
            axes.set(title=title, ylabel=f"standard deviation, {unit}")
            axes.set_xlabel("lag, s" if number >= 2 else "")
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_major_formatter("{x:g}")
                axis.set_minor_locator(NullLocator())
        handles, labels = squares[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return Picture(
        "lag",
        figure,
        "By the sensor's own reckoning, for two sizes of the rock's own torque, one standard deviation each; "
        "the dotted line is the configured lag.",
        "Standard deviations of confirmed bit speed and torque, and of the string's top, over lag.",
    )
