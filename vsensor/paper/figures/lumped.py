"""Figs. 2, 4 and 5: the lumped string, free and with dry friction."""

import numpy as np
from matplotlib.axes import Axes

from vsensor.paper.cases import period
from vsensor.paper.chain import Motion
from vsensor.paper.figures.style import BLUE, GREY, ORANGE, RED, Picture, panels, speed_axes
from vsensor.paper.results import RAISED_TORQUE, Results
from vsensor.paper.shaft import BIT, TORQUE
from vsensor.paper.stick_slip import CATCH_SPEED

_SHOWN = 30.0


def fig02(results: Results) -> Picture:
    """The lumped string under a step of torque."""
    figure, (axes,) = panels()
    top, end, _ = results.paper.lumped
    axes.plot(*top, color=BLUE, linewidth=1.8, label="top, $\\omega_0$ (eq. 3)")
    axes.plot(*end, color=RED, linewidth=1.8, linestyle="--", label="bit, $\\omega_1$ (eq. 2)")
    steady = TORQUE / BIT.damping
    axes.axhline(steady, color=GREY, linewidth=0.9)
    axes.annotate(
        f"$T_m/(C_r + C_b)$ = {steady:g} rad/s", (0.5, steady), xytext=(0, 4), textcoords="offset points"
    )
    speed_axes(axes, f"Fig. 2   The lumped string, {TORQUE:.0f} N·m", top.time[-1])
    axes.set_ylim(0, 1.1 * steady)
    axes.legend(loc="lower right")
    return Picture(
        "fig02_lumped",
        figure,
        "The lumped string, eq. (1) to (3). The bit moves at once, wherever it is, and neither end "
        f"overshoots (top at most {top.value.max():.2f}, bit {end.value.max():.2f} rad/s).",
        "Speed of top and bit over time; both rise smoothly to 17.5 rad/s.",
    )


def fig04(results: Results) -> Picture:
    """Stick-slip under the paper's torque."""
    motion = results.stick_slip
    figure, (axes,) = panels()
    _shade(axes, motion)
    _speeds(axes, motion)
    axes.axhline(CATCH_SPEED, color=GREY, linewidth=0.9)
    axes.annotate(f"{CATCH_SPEED:g} rad/s", (0, CATCH_SPEED), xytext=(4, 4), textcoords="offset points")
    speed_axes(axes, f"Fig. 4   Stick-slip, {TORQUE:.0f} N·m", _SHOWN)
    axes.legend(loc="upper right", ncols=2, frameon=True, framealpha=1, edgecolor="none")
    late = motion.time > motion.time[-1] / 2
    return Picture(
        "fig04_stick_slip",
        figure,
        f"Dry friction at the bit (our law, in the paper's words: caught from {CATCH_SPEED:g} rad/s on, "
        "released when at rest). After one large swing of the start the bit moves between 0 and "
        f"{motion.speeds[1][late].max():.2f} rad/s with a period of {period(motion.times('free')):.1f} s.",
        "Bit speed over time in pulses from zero to 0.8 rad/s, with pauses at zero between them.",
    )


def fig05(results: Results) -> Picture:
    """No stick-slip under more torque."""
    motion = results.smooth
    figure, (axes,) = panels()
    _shade(axes, motion)
    _speeds(axes, motion)
    speed_axes(axes, f"Fig. 5   The same under {RAISED_TORQUE:.0f} N·m", _SHOWN)
    axes.legend(loc="lower right", ncols=2, frameon=True, framealpha=1, edgecolor="none")
    return Picture(
        "fig05_smooth",
        figure,
        f"More torque ends it: the bit, though caught, is driven through and settles at "
        f"{motion.speeds[1][-1]:.2f} rad/s.",
        "Bit speed over time rises, swings a little and stays at 2.5 rad/s.",
    )


def _speeds(axes: Axes, motion: Motion) -> None:
    axes.plot(motion.time, motion.speeds[0], color=BLUE, linewidth=1.2, label="top")
    axes.plot(motion.time, motion.speeds[1], color=RED, linewidth=2.0, label="bit")


def _shade(axes: Axes, motion: Motion) -> None:
    """Colour the background where the bit is held and where it is caught."""
    ends = np.append([event.time for event in motion.events[1:]], motion.time[-1])
    for regime, colour, words in (("held", GREY, "held"), ("caught", ORANGE, "caught")):
        spans = [
            (event.time, end)
            for event, end in zip(motion.events, ends, strict=True)
            if event.regime == regime
        ]
        for number, (start, end) in enumerate(spans):
            label = words if number == 0 else None
            axes.axvspan(start, end, color=colour, alpha=0.18, linewidth=0, label=label)
