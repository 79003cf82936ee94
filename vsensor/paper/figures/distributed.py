"""Fig. 8: the distributed-lumped string, as the paper steps it and as it should be."""

import numpy as np
from matplotlib.axes import Axes

from vsensor.estimator import component
from vsensor.paper import fine
from vsensor.paper.comparison import WINDOW
from vsensor.paper.exact import StepResponse
from vsensor.paper.figures.style import BLUE, EXACT, FINE, GREEN, PRINTED, Picture, panels, speed_axes
from vsensor.paper.results import Results
from vsensor.paper.shaft import Floats, Trace

_TIME = np.linspace(0, WINDOW, 6001)


def fig08(results: Results) -> Picture:
    """Eq. (24) and (25), against the exact solution of the very same equations."""
    of = results.paper
    figure, (top, end) = panels(2, height=6.4, sharex=True)
    same = of.printed_truth
    for axes, trace, true, words in (
        (top, of.printed.top, same.top_speed, "Fig. 8   Top, eq. (24), numerator mended"),
        (end, of.printed.end, same.end_speed, "Fig. 8   Bit, eq. (25), numerator mended"),
    ):
        axes.plot(_TIME, true(_TIME), **EXACT | {"label": "the same equations, solved exactly"})
        axes.step(*trace, **PRINTED)
        speed_axes(axes, words, WINDOW)
    top.set_xlabel("")
    top.set_ylim(top=56)
    top.legend(loc="upper right")
    return Picture(
        "fig08_distributed",
        figure,
        f"The paper's model: line and load looked at once a round trip, every {_round_trip(results):.2f} "
        "s. Both ends settle at 17.5 rad/s. Solved exactly, the same equations say something else: the "
        "wave comes back from the heavy load as from a wall, and the top swings from "
        f"−{-same.top_speed(_TIME).min():.0f} to {same.top_speed(_TIME).max():.0f} rad/s. The paper's "
        "samples fall on the very instants of its jumps.",
        "Two panels of speed over time. The paper's stairs rise in calm steps; the exact solution of the "
        "top jumps up and down.",
    )


def fig_fine(results: Results) -> Picture:
    """The kernels' answer on the closed form, and their difference."""
    of = results.paper
    figure, (top, end, difference) = panels(3, height=8.2)
    for axes, trace, true, words in (
        (top, of.fine.top, of.truth.top_speed, "Stepped finely   Top"),
        (end, of.fine.end, of.truth.end_speed, "Stepped finely   Bit"),
    ):
        axes.plot(*trace, **FINE)
        axes.plot(_TIME, true(_TIME), **EXACT | {"linestyle": (0, (1, 2))})
        speed_axes(axes, words, WINDOW)
        axes.set_xlabel("")
    top.set_ylim(top=60)
    top.legend(loc="upper right", ncols=2)
    step = 1e3 * float(np.diff(of.fine.end.time[:2])[0])
    _difference(difference, of.fine.end, of.truth, {"color": BLUE, "label": f"steps of {step:.2g} ms"})
    _difference(
        difference,
        results.refined.end,
        of.truth,
        {"color": GREEN, "label": f"two grids, {step:.2g} and {step / fine.THIRDS:.2g} ms, extrapolated"},
    )
    difference.set(title="Bit   Difference from the closed form", xlabel="time since the step of torque, s")
    difference.set(ylabel="|difference|, rad/s", yscale="log", xlim=(0, WINDOW), ylim=(1e-14, 1e-3))
    difference.legend(loc="upper left", ncols=2)
    return Picture(
        "fig08_fine",
        figure,
        "The same shaft with its load counted once, stepped by the program's own kernels and by the "
        "closed form (dotted over the line). The two were derived apart; their difference is the grid's, "
        "falls with the square of the step, and ends at rounding.",
        "Speed of top and bit, two solutions on top of one another; below, their difference, a millionth "
        "and less.",
    )


def _difference(axes: Axes, trace: Trace, truth: StepResponse, style: dict[str, str]) -> None:
    late = trace.time > component.delay(truth.shaft)
    time, value = trace.time[late][::8], trace.value[late][::8]
    gap: Floats = np.abs(value - truth.end_speed(time))
    axes.plot(time, np.maximum(gap, 1e-16), linewidth=0.9, **style)  # type: ignore[arg-type]


def _round_trip(results: Results) -> float:
    return 2 * component.delay(results.paper.shaft)
