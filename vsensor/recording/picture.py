"""What changed between two runs, as a picture."""

from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vsensor.errors import InputError
from vsensor.recording.compare import Change

# Okabe and Ito's palette: told apart by every kind of colour vision.
RECORDED, CONFIRMED, NOW, FORECAST = "#8C8C8C", "#0072B2", "#E69F00", "#CC79A7"
_COLOURS = {"confirmed": CONFIRMED, "now": NOW, "forecast": FORECAST}
_RULES: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "axes.axisbelow": True,
    "legend.frameon": False,
}


def draw(path: Path, title: str, changes: list[Change]) -> None:
    """Write a PNG: of speed and torque the confirmed answers of both runs, and the changes of all.

    Raises InputError where it cannot be written.
    """
    with matplotlib.rc_context(_RULES):
        figure = Figure(figsize=(13, 7.5), dpi=110, layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, fontsize=11, x=0.01, ha="left")
        grid = figure.subplots(3, 2, sharex=True, height_ratios=(3, 2, 2))
        for column, name in enumerate(dict.fromkeys(change.quantity.name for change in changes)):
            of_name = [change for change in changes if change.quantity.name == name]
            _both(grid[0][column], of_name[0])
            _changes(grid[1][column], of_name[:1])
            _changes(grid[2][column], of_name[1:])
            grid[2][column].set_xlabel("s from the first tick")
        try:
            figure.savefig(path)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from error


def _both(axes: Axes, change: Change) -> None:
    shown, quantity = change.envelope, change.quantity
    _band(axes, shown.time_s, shown.recorded, RECORDED, "as recorded")
    _band(axes, shown.time_s, shown.now, CONFIRMED, "as it comes out now")
    axes.set_title(f"{quantity.kind} {quantity.name}, {quantity.unit}", loc="left", fontweight="bold")
    _key(axes)


def _changes(axes: Axes, changes: list[Change]) -> None:
    for change in reversed(changes):
        kind = change.quantity.kind
        label = f"{kind}: rms {change.rms:.3g}, at most {abs(change.largest):.3g}"
        _band(axes, change.envelope.time_s, change.envelope.change, _COLOURS[kind], label)
    axes.set_title(f"change, {changes[0].quantity.unit}", loc="left")
    _key(axes)


def _key(axes: Axes) -> None:
    """Beside the title, where it hides nothing."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.98),
        ncols=2,
        borderaxespad=0.2,
        handlelength=1.2,
        columnspacing=1.2,
    )


def _band(
    axes: Axes, time_s: list[float], bounds: list[tuple[float, float]], colour: str, label: str
) -> None:
    """A line where each column holds one tick, else the range of its ticks."""
    least, greatest = ([each[side] for each in bounds] for side in (0, 1))
    axes.plot(time_s, greatest, color=colour, linewidth=0.9, label=label)
    if least != greatest:
        axes.plot(time_s, least, color=colour, linewidth=0.9)
        axes.fill_between(time_s, least, greatest, color=colour, alpha=0.5, linewidth=0)
