"""How figures look and how they are written; no window, no global state, the same bytes each time."""

import io
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Okabe and Ito's palette: told apart by every kind of colour vision; line styles tell the same again.
BLACK, BLUE, RED, GREEN, ORANGE = "#000000", "#0072B2", "#D55E00", "#009E73", "#E69F00"
GREY = "#8C8C8C"

EXACT: dict[str, Any] = {"color": BLACK, "linewidth": 1.1, "label": "closed form"}
FINE: dict[str, Any] = {"color": BLUE, "linewidth": 1.8, "label": "distributed, stepped finely"}
PRINTED: dict[str, Any] = {
    "color": RED,
    "linewidth": 1.6,
    "marker": "o",
    "markersize": 4.5,
    "where": "post",
    "label": "distributed, one step a round trip (the paper's)",
}
LUMPED: dict[str, Any] = {"color": GREEN, "linewidth": 1.8, "linestyle": (0, (5, 1.5)), "label": "lumped"}

_RULES: Any = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "vsensor",
    "svg.fonttype": "path",
}
_DPI = 160


class Picture(NamedTuple):
    """A figure and what is said of it."""

    name: str
    """Of its files, without suffix."""
    figure: Figure
    caption: str
    alt: str
    """For those who do not see it."""


def panels(
    rows: int = 1, columns: int = 1, *, width: float = 8.0, height: float = 4.2, **shared: Any
) -> tuple[Figure, list[Axes]]:
    """A figure of so many panels (width and height in inches), and its panels row by row."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False, **shared)))


def speed_axes(axes: Axes, title: str, window: float | None = None) -> None:
    """Label a panel of speed over time."""
    axes.set(title=title, xlabel="time since the step of torque, s", ylabel="speed, rad/s")
    if window is not None:
        axes.set_xlim(0, window)


def rules() -> AbstractContextManager[None]:
    """The rules of the house, for as long as a figure is drawn and written."""
    return matplotlib.rc_context(_RULES)


def rendered(picture: Picture) -> tuple[bytes, bytes]:
    """A picture as PNG and as SVG."""
    with rules():
        png, svg = io.BytesIO(), io.BytesIO()
        picture.figure.savefig(png, format="png", dpi=_DPI, metadata={"Software": None})
        picture.figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    return png.getvalue(), svg.getvalue()
