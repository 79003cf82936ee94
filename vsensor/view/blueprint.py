"""How the screen is laid out: a tab to see at a glance what the bit does, and one for the sensor's health."""

import rerun as rr
import rerun.blueprint as rrb

from vsensor.view import series

TIMELINE = "source time"

TAIL_S = 4.0
"""How far back the forecast and the bands about now and forecast are drawn: where they tell something yet."""


def blueprint(history_s: float) -> rrb.Blueprint:
    """The layout; the plots show the last `history_s` seconds before the time cursor."""
    return rrb.Blueprint(
        rrb.Tabs(_bit_tab(history_s), _health_tab(history_s)),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _bit_tab(history_s: float) -> rrb.Horizontal:
    plots = rrb.Vertical(
        _bit_plot(series.SPEED, "Speed, rpm", history_s),
        _bit_plot(series.TORQUE, "Torque, kN·m", history_s),
        _lanes(history_s),
        row_shares=[9, 8, 6],
    )
    side = rrb.Vertical(
        rrb.TextDocumentView(origin=series.PANEL, name="The bit now"),
        _lateness(history_s),
        _log(),
        row_shares=[11, 5, 8],
    )
    return rrb.Horizontal(plots, side, column_shares=[7, 3], name="Bit")


def _health_tab(history_s: float) -> rrb.Horizontal:
    severity = "Stick-slip severity, (max − min) / (2 mean) of the bit's speed"
    plots = rrb.Vertical(_plot(series.SEVERITY, severity, history_s), _lateness(history_s, legend=True))
    losses = rrb.TextDocumentView(origin=series.HEALTH, name="Losses and timing")
    return rrb.Horizontal(plots, losses, column_shares=[6, 4], name="Health")


def _bit_plot(origin: str, name: str, history_s: float) -> rrb.TimeSeriesView:
    tails = [series.bit(origin, "forecast"), series.band(origin, "forecast"), series.band(origin, "now")]
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=rrb.TimeAxis(view_range=_range(history_s)),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        time_ranges=_visible(history_s),
        overrides={entity: _visible(TAIL_S) for entity in tails},
    )


def _plot(origin: str, name: str, history_s: float, *, legend: bool = False) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=rrb.TimeAxis(view_range=_range(history_s)),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
        time_ranges=_visible(history_s),
    )


def _lateness(history_s: float, *, legend: bool = False) -> rrb.TimeSeriesView:
    return _plot(series.LATENESS, "Lateness of the loop, ms", history_s, legend=legend)


def _lanes(history_s: float) -> rrb.StateTimelineView:
    return rrb.StateTimelineView(
        contents=[f"{series.DAEMON}/**", f"{series.EVENTS}/**"],
        name="Sensor and events",
        time_view=rrb.TimeAxis(view_range=_range(history_s)),
        time_ranges=_visible(history_s),
    )


def _log() -> rrb.TextLogView:
    hidden = rrb.encodings.TimelineColumn(TIMELINE, visible=False)  # too narrow for more than the date
    columns = rrb.TextLogColumns(timeline_columns=[hidden], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin=series.LOG, name="Events", columns=columns)


def _range(last_s: float) -> rr.TimeRange:
    return rr.TimeRange(
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-last_s),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )


def _visible(last_s: float) -> rrb.VisibleTimeRanges:
    return rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-last_s),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
