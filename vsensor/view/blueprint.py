"""How the screen is laid out: a tab each for who drills, who understands, and who looks after the sensor."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import rerun as rr
import rerun.blueprint as rrb

from vsensor.view import series
from vsensor.view.charts import chart, spacetime
from vsensor.view.palette import GROUND
from vsensor.view.units import Units

TIMELINE = "source time"

Tab = Literal["driller", "engineer", "service"]
TABS: tuple[Tab, ...] = ("driller", "engineer", "service")


class Reach(NamedTuple):
    """How late an answer is confirmed, and how far ahead it is foretold, s."""

    delay_s: float
    horizon_s: float


USUAL = Reach(1.5, 1.0)
"""Until the sensor has told its own."""

WIDE, NARROW = 0.16, 0.45
"""Room for the legend, before the oldest that a plot shows, as a share of the history: of a plot that takes
most of the screen's width, and where two stand side by side."""


def blueprint(history_s: float, units: Units, reach: Reach = USUAL, tab: Tab = "driller") -> rrb.Blueprint:
    """The layout; plots show the last `history_s` seconds before the time cursor: the forecast's end."""
    return rrb.Blueprint(
        rrb.Tabs(
            _driller(history_s, units, reach),
            _engineer(history_s, units),
            _service(history_s),
            active_tab=TABS.index(tab),
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _driller(history_s: float, units: Units, reach: Reach) -> rrb.Vertical:
    plots = rrb.Vertical(
        _bit_plot(series.SPEED, f"Speed, {units.speed}", history_s, reach),
        _bit_plot(series.TORQUE, f"Torque, {units.torque}", history_s, reach),
        _lanes(series.DRILLER_STATES, "What is so", history_s, WIDE),
        row_shares=[16, 16, 19],
    )
    side = rrb.Vertical(
        rrb.TextDocumentView(origin=series.PAGE, name="Answers"),
        _log(),
        row_shares=[9, 12],
    )
    glance = rrb.Spatial2DView(origin=series.GLANCE, name="Now", background=_ground())
    below = rrb.Horizontal(plots, side, column_shares=[7, 3])
    return rrb.Vertical(glance, below, row_shares=[2, 10], name="Driller")


def _engineer(history_s: float, units: Units) -> rrb.Vertical:
    field = rrb.Tabs(
        _chart(series.FIELD_TORQUE, f"Torque along the string, {units.torque}", spacetime.BOUNDS),
        _chart(series.FIELD_SPEED, f"Speed along the string, {units.speed}", spacetime.BOUNDS),
        active_tab=0,
    )
    twist = rrb.Spatial3DView(
        origin=series.TWIST,
        name="Twist and shear stress of the string",
        background=_ground(),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            position=(0.1, -1.35, -0.42), look_target=(0.08, 0.0, -0.52), eye_up=(0, 0, 1)
        ),
    )
    above = rrb.Horizontal(
        field, _chart(series.WAVES, "Waves in the delay lines", chart.BOUNDS), column_shares=[5, 4]
    )
    portrait = _chart(series.PORTRAIT, "What the rock asks: torque by speed", chart.BOUNDS)
    below = rrb.Horizontal(
        _chart(series.SPECTRUM, "Spectrum of speed", chart.BOUNDS), portrait, column_shares=[5, 4]
    )
    name = f"Foretold and come, {units.speed}"
    foretold = _plot(series.SPEED, name, history_s, WIDE, without=series.present(series.SPEED))
    left = rrb.Vertical(above, below, foretold, row_shares=[5, 5, 3])
    return rrb.Vertical(rrb.Horizontal(left, twist, column_shares=[7, 3]), name="Engineer")


def _service(history_s: float) -> rrb.Horizontal:
    lateness = _plot(series.LATENESS, "Lateness of the loop, ms", history_s, NARROW)
    work = _plot(series.WORK, "Work of a turn in each second, ms", history_s, NARROW)
    ages = _plot(series.AGES, "Age of the newest sample when the second ends, ms", history_s, NARROW)
    losses = _plot(series.LOSSES, "Losses in each second: samples, slots, messages", history_s, NARROW)
    queues = _plot(series.QUEUES, "What waits for …", history_s, NARROW)
    conditions = _lanes((f"{series.SENSOR}/**",), "Sensor, quality and conditions", history_s, NARROW)
    plots = rrb.Vertical(
        rrb.Horizontal(lateness, work), rrb.Horizontal(ages, losses), rrb.Horizontal(queues, conditions)
    )
    side = rrb.Vertical(
        rrb.TextDocumentView(origin=series.HEALTH, name="Counts since the daemon's start"),
        _log(),
        row_shares=[3, 2],
    )
    return rrb.Horizontal(plots, side, column_shares=[6, 4], name="Service")


def _bit_plot(origin: str, name: str, history_s: float, reach: Reach) -> rrb.TimeSeriesView:
    """Confirmed, then now, then foretold: each from where the one before it ends."""
    ahead = _visible(reach.horizon_s)
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=_axis(history_s, WIDE),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        time_ranges=_visible(history_s),
        overrides={
            series.bit(origin, "now"): _visible(reach.horizon_s + reach.delay_s),
            series.bit(origin, "forecast"): ahead,
            series.present(origin): _visible(reach.horizon_s + 0.05),
        },
    )


def _plot(origin: str, name: str, history_s: float, room: float, without: str = "") -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        contents=["$origin/**", f"- {without}"] if without else "$origin/**",
        name=name,
        axis_x=_axis(history_s, room),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        time_ranges=_visible(history_s),
    )


def _lanes(contents: Sequence[str], name: str, history_s: float, room: float) -> rrb.StateTimelineView:
    return rrb.StateTimelineView(
        contents=list(contents),
        name=name,
        time_view=_axis(history_s, room),
        time_ranges=_visible(history_s),
    )


def _chart(
    origin: str, name: str, bounds: tuple[tuple[float, float], tuple[float, float]]
) -> rrb.Spatial2DView:
    x_range, y_range = bounds
    return rrb.Spatial2DView(
        origin=origin,
        name=name,
        background=_ground(),
        visual_bounds=rrb.VisualBounds2D(x_range=x_range, y_range=y_range),
    )


def _ground() -> rrb.Background:
    return rrb.Background(color=GROUND, kind="SolidColor")


def _log() -> rrb.TextLogView:
    hidden = rrb.encodings.TimelineColumn(TIMELINE, visible=False)  # too narrow for more than the date
    columns = rrb.TextLogColumns(timeline_columns=[hidden], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin=series.LOG, name="Events", columns=columns)


def _axis(last_s: float, room: float) -> rrb.TimeAxis:
    """Of the last seconds; nothing is drawn in the room before them."""
    whole = rr.TimeRange(
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-last_s * (1 + room)),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    return rrb.TimeAxis(view_range=whole)


def _visible(last_s: float) -> rrb.VisibleTimeRanges:
    return rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-last_s),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
