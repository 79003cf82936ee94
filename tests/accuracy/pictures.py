"""The page's pictures: a sensor at work, and what its bandwidth costs."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MultipleLocator, NullLocator

from tests.accuracy.score import Answer, Floats, answer
from tests.cases import Columns
from vsensor.config import Component, Rig
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
BANDWIDTHS_HZ = np.geomspace(0.5, 10.0, 14)
RPM, KNM = factor("rad/s", "rpm"), 1e-3
STUB = Component(name="stub", length=1.0, outer_diameter=0.127, inner_diameter=0.1086)
"""A string that ends where it begins: its bit is the string's top."""


class Trade(NamedTuple):
    """What a bandwidth gives the confirmed answer; arrays of shape (n,)."""

    bandwidth: Floats
    """Hz."""
    lag: Floats
    """How much later than the wave's travel time the answer comes, s."""
    top_torque: Floats
    """Standard deviation of the torque at the string's top, N·m."""
    bit_speed: Floats
    """Standard deviation of the bit's speed, rad/s."""


def trade(rig: Rig, bandwidths: Floats = BANDWIDTHS_HZ) -> Trade:
    """Lag and noise of a rig's confirmed answer over bandwidth."""
    rows = []
    for hertz in bandwidths:
        here = rig.model_copy(
            update={"estimator": rig.estimator.model_copy(update={"bandwidth": float(hertz)})}
        )
        bare = here.bit.model_copy(update={"inertia": 0.0})
        top = Estimator(here.model_copy(update={"string": (STUB,), "bit": bare}))
        bit = Estimator(here)
        rows.append((bit.confirmed_delay - bit.forecast_horizon, top.torque_noise, bit.speed_noise))
    return Trade(bandwidths, *np.array(rows).T)


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


def lag(of: Trade, chosen_hz: float) -> Picture:
    """Noise and lag over bandwidth; a dotted line at the configured one."""
    charts = (
        ("Torque at the string's top", "standard deviation, N·m", of.top_torque),
        ("Confirmed bit speed", "standard deviation, rpm", of.bit_speed * RPM),
        ("Lag beyond the travel time", "lag, s", of.lag),
    )
    with rules():
        figure, row = panels(1, 3, width=10.0, height=4.0)
        for axes, (title, label, values) in zip(row, charts, strict=True):
            axes.loglog(of.bandwidth, values, color=BLUE, marker="o", markersize=4)
            axes.axvline(chosen_hz, color=GREY, linewidth=1.4, linestyle=":")
            axes.set(title=title, xlabel="bandwidth, Hz", ylabel=label)
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_major_formatter("{x:g}")
                axis.set_minor_locator(NullLocator())
    return Picture(
        "lag",
        figure,
        "By the sensor's own reckoning; the dotted line is the configured bandwidth.",
        "Deviation of the string's top torque and of the confirmed bit speed, and lag, over bandwidth.",
    )
