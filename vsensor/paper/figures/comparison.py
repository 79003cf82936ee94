"""Figs. 9 and 10: the models against one another and against the truth, for shafts of any length."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vsensor.estimator import component
from vsensor.paper.comparison import WINDOW, Models
from vsensor.paper.figures.style import (
    BLUE,
    EXACT,
    FINE,
    GREEN,
    GREY,
    LUMPED,
    PRINTED,
    RED,
    Picture,
    panels,
    speed_axes,
)
from vsensor.paper.results import Results
from vsensor.paper.shaft import Floats, Response, Trace

_TIME = np.linspace(0, WINDOW, 6001)
_LENGTHS_SHOWN = 20.0
_MARKERS = "osD^v"
_PERCENT = (1e-6, 1e2)


def fig09(results: Results) -> Picture:
    """The top."""
    figure, (axes,) = panels(height=4.8)
    _draw(axes, results.paper, lambda answer: answer.top, results.paper.truth.top_speed(_TIME))
    speed_axes(axes, "Fig. 9   Top of the shaft, 4000 m", WINDOW)
    axes.set_ylim(top=60)
    axes.legend(loc="upper right", ncols=2)
    return Picture(
        "fig09_top",
        figure,
        "The paper finds that its distributed model swings less than the lumped one. That is its "
        "stepping. The lumped model but ripples on its way up, and the string itself, stepped finely, "
        "swings hard: torque that is held lets each wave come back whole.",
        "Speed of the top over time by lumped, the paper's and the finely stepped model; the last jumps "
        "each round trip.",
    )


def fig10(results: Results) -> Picture:
    """The end."""
    figure, (axes,) = panels(height=4.8)
    _draw(axes, results.paper, lambda answer: answer.end, results.paper.truth.end_speed(_TIME))
    speed_axes(axes, "Fig. 10   End of the shaft, 4000 m", WINDOW)
    axes.legend(loc="lower right")
    theta = component.delay(results.paper.shaft)
    return Picture(
        "fig10_end",
        figure,
        f"As the paper says, the lumped bit turns at once and the distributed one after {theta:.2f} s. "
        f"But stepped once a round trip it has then jumped to {results.paper.printed.end.value[0]:.1f} "
        "rad/s, where a heavy load can only begin to turn.",
        "Speed of the bit over time by the three models; the finely stepped one zigzags around the others.",
    )


def fig_lengths(results: Results) -> Picture:
    """All lengths."""
    count = len(results.models)
    figure, axes = panels(count, 2, width=10.0, height=2.1 * count, sharex=True, sharey="col")
    for row, (length, of) in enumerate(results.models.items()):
        left, right = axes[2 * row], axes[2 * row + 1]
        _draw(left, of, lambda answer: answer.top, of.truth.top_speed(_TIME), markers=False)
        _draw(right, of, lambda answer: answer.end, of.truth.end_speed(_TIME), markers=False)
        trip = 2 * component.delay(of.shaft)
        speed_axes(left, f"{length:.0f} m, top   (round trip {trip:.2f} s)", _LENGTHS_SHOWN)
        speed_axes(right, f"{length:.0f} m, bit", _LENGTHS_SHOWN)
        right.set_ylabel("")
        if row < count - 1:
            left.set_xlabel("")
            right.set_xlabel("")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return Picture(
        "fig09_10_lengths",
        figure,
        "Figs. 9 and 10 for shafts of 500 to 8000 m. The longer the shaft, the longer the paper's model "
        "looks away.",
        "Ten panels of speed over time, one row for each length.",
    )


def fig_errors(results: Results) -> Picture:
    """Errors by length and by step."""
    figure, (by_length, by_step) = panels(1, 2, width=10.0, height=4.8)
    lengths = list(results.errors)
    for name, words, style in (
        ("printed", "the paper's, one step a round trip", {"color": RED, "marker": "o"}),
        ("lumped", "lumped", {"color": GREEN, "marker": "D", "linestyle": "--"}),
        ("fine", "stepped finely, 1 ms", {"color": BLUE, "marker": "^"}),
    ):
        values = [100 * getattr(end, name) for _, end in results.errors.values()]
        by_length.loglog(lengths, values, linewidth=1.8, label=words, **style)
    by_length.set(
        title="Error of the bit's speed by length",
        xlabel="length of the shaft, m",
        ylabel="rms error, % of the steady speed",
    )
    by_length.set_xticks(lengths, [f"{length:.0f}" for length in lengths])
    by_length.minorticks_off()
    by_length.set_ylim(_PERCENT)
    by_length.legend(loc="center left")
    _by_step(by_step, results)
    return Picture(
        "errors",
        figure,
        "Left: the paper's error grows with length, ours does not. Right, why: each line is one length. "
        "In steps of a given size a longer shaft does no worse. But the paper ties its step to the length "
        "(rings), and so runs up the slope as the shaft grows. By the program's kernels the error falls "
        "with the square of the step.",
        "Two logarithmic charts of error: over length, and over the step, with a line for each length.",
    )


def _by_step(axes: Axes, results: Results) -> None:
    for marker, study in zip(_MARKERS, results.studies, strict=True):
        small: dict[str, Any] = {"marker": marker, "markersize": 3.5, "linewidth": 1.0}
        axes.loglog(study.step, 100 * study.papers_rule, color=RED, **small)
        axes.loglog(study.step, 100 * study.kernels, color=BLUE, **small)
        axes.loglog(
            study.step[0],
            100 * study.papers_rule[0],
            "o",
            markersize=11,
            markerfacecolor="none",
            markeredgecolor=GREY,
        )
        axes.plot([], [], color=GREY, label=f"{study.length:.0f} m", **small)
    axes.set(
        title="Error of the bit's speed by step",
        xlabel="step, s",
        ylabel="rms error, % of the steady speed",
        ylim=_PERCENT,
    )
    axes.text(4e-4, 2, "the paper's load rule", color=RED)
    axes.text(0.08, 2e-4, "the program's kernels", color=BLUE)
    axes.legend(loc="lower right", ncols=2)


def _draw(
    axes: Axes, of: Models, pick: Callable[[Response], Trace], truth: Floats, *, markers: bool = True
) -> None:
    axes.plot(_TIME, truth, **EXACT | {"linewidth": 3.4, "alpha": 0.25})
    axes.plot(*pick(of.fine), **FINE | {"linewidth": 1.1})
    axes.plot(*pick(of.lumped), **LUMPED)
    start = Trace(np.append(0.0, pick(of.printed).time), np.append(0.0, pick(of.printed).value))
    style = {"markevery": slice(1, None)} if markers else {"marker": "", "linewidth": 1.3}
    axes.step(*start, **PRINTED | style)
