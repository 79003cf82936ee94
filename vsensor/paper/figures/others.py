"""Cases of others: what they published, run by our models."""

from typing import Any

from vsensor.paper.chain import Motion
from vsensor.paper.figures.style import BLUE, RED, Picture, panels, speed_axes
from vsensor.paper.results import Results
from vsensor.paper.shaft import Trace

_STYLES: tuple[dict[str, Any], ...] = ({"color": RED}, {"color": BLUE, "linestyle": "--"})
_SHOWN = (60.0, 100.0)


def fig_others(results: Results) -> Picture:
    """Stick-slip in four inertias and in a shaft with delay."""
    figure, (four, delay) = panels(2, height=6.4, sharex=True)
    for motion, words, style in zip(
        results.four_inertias,
        ("10 kN·m", "12 kN·m"),
        _STYLES,
        strict=True,
    ):
        four.plot(*_bit(motion), linewidth=1.8, label=words, **style)
    for trace, words, style in zip(
        results.neutral_delay,
        ("10 rad/s", "15 rad/s"),
        _STYLES,
        strict=True,
    ):
        delay.plot(*trace, linewidth=1.8, label=words, **style)
    speed_axes(four, "Four inertias (the paper's reference [3]): the bit")
    speed_axes(delay, "Shaft with delay, its motor under speed control: the bit")
    four.set_xlabel("")
    delay.set(xlabel="time, s", xlim=_SHOWN)
    for axes in (four, delay):
        axes.legend(loc="upper right", ncols=2)
        axes.set_ylim(-0.5, 18)
    return Picture(
        "others",
        figure,
        "Two strings that others have published, with friction that falls with speed: stick-slip, and its "
        "end by more torque or more speed.",
        "Bit speed over time in two panels: regular pulses from zero, and straight lines where the drive "
        "is raised.",
    )


def _bit(motion: Motion) -> Trace:
    return Trace(motion.time, motion.speeds[-1])
