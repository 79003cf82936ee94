"""A layout for sessions that Rerun opens by itself (config/views/README.md).

Rerun reads each topic as one component, `vsensor.KIND:message`, of which a plot picks fields. The file
is made by `python -m vsensor.view.opened FILE.rbl`.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_STATUS,
    SENSOR_TICK,
    STRING_PROFILE,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    message_type,
)
from vsensor.view.batches import Colour
from vsensor.view.palette import BLUE, DIM, GREY, ORANGE, PINK, VERMILION

APPLICATION = "vsensor session"

Lines = Mapping[str, Mapping[str, tuple[str, Colour]]]
"""By topic and field: what a line is called, and its colour."""

SPEEDS: Lines = {
    SURFACE_SPEED: {"value": ("motor", DIM)},
    BIT_ESTIMATE: {
        "top_speed_rad_s": ("top of the string", GREY),
        "forecast_bit_speed_rad_s": ("bit, foretold", PINK),
        "now_bit_speed_rad_s": ("bit, now", ORANGE),
        "confirmed_bit_speed_rad_s": ("bit, confirmed", BLUE),
    },
}
TORQUES: Lines = {
    SURFACE_TORQUE: {"value": ("motor", DIM)},
    BIT_ESTIMATE: {
        "top_torque_nm": ("top of the string", GREY),
        "forecast_bit_torque_nm": ("bit, foretold", PINK),
        "now_bit_torque_nm": ("bit, now", ORANGE),
        "confirmed_bit_torque_nm": ("bit, confirmed", BLUE),
    },
}
ROUGHNESS: Lines = {
    SENSOR_STATUS: {"severity": ("severity", VERMILION), "stuck_share": ("share of time stuck", BLUE)},
    STRING_PROFILE: {"weakest_margin": ("least margin", PINK)},
}
LATENESS: Lines = {SENSOR_TICK: {"lateness_ns": ("lateness", BLUE)}}


def blueprint() -> rrb.Blueprint:
    """Speeds, torques and how rough it ran over the whole session; events and the loop behind."""
    what_happened = rrb.Vertical(
        _plot("Speed, rad/s", SPEEDS),
        _plot("Torque, N·m", TORQUES),
        _plot("Severity, share stuck, margin", ROUGHNESS),
        row_shares=[4, 4, 2],
        name="What happened",
    )
    beside = rrb.Vertical(
        rrb.DataframeView(origin=SENSOR_EVENT, name="Events"),
        _plot("Lateness of the loop, ns", LATENESS),
        name="Events and loop",
    )
    return rrb.Blueprint(
        rrb.Tabs(what_happened, beside, active_tab=0),
        rrb.TimePanel(state="collapsed", timeline="message_publish_time"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
    )


def _plot(name: str, lines: Lines) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=[f"+ /{topic}" for topic in lines],
        name=name,
        overrides={
            f"/{topic}": [_line(topic, field, *told) for field, told in fields.items()]
            for topic, fields in lines.items()
        },
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
    )


def _line(topic: str, field: str, name: str, colour: Colour) -> rrb.Visualizer:
    kind = message_type(topic)
    if kind is None:
        raise ValueError(f"no message is known for the topic {topic!r}")
    mapping = rrb.encodings.VisualizerComponentMapping(
        "Scalars:scalars",
        rrb.encodings.ComponentSourceKind.SourceComponent,
        source_component=f"{kind.DESCRIPTOR.full_name}:message",
        selector=f".{field}",
    )
    return rr.SeriesLines(names=name, colors=[colour], widths=1.5).visualizer(mappings=[mapping])


if __name__ == "__main__":
    blueprint().save(APPLICATION, Path(sys.argv[1]))
