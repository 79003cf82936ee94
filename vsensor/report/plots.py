"""The report's plots, as Plotly draws them: plain dictionaries, their numbers packed."""

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from vsensor.report.again import Lateness, Portrait
from vsensor.report.along import Along
from vsensor.report.foretold import Skill
from vsensor.report.gather import OVER_TIME, Story
from vsensor.report.seconds import Severity
from vsensor.report.thin import Thinned
from vsensor.report.ticks import Floats, Ticks
from vsensor.units import factor

Plot = dict[str, Any]

# The live view's colours (Okabe and Ito's palette): told apart by every kind of colour vision.
TOP, CONFIRMED, NOW, FORECAST, LIMIT = "#8C8C8C", "#0072B2", "#E69F00", "#CC79A7", "#D55E00"
_GRID, _INK = "#E4E4E4", "#1c1c1c"
_UNIX_NS = 10**17
"""Times before (1973) count from the start of a record, not from 1970."""
_FEW = 20
"""So few points are marked: a line of one would not be seen."""
RPM, KNM = factor("rad/s", "rpm"), factor("N*m", "kN*m")


def over_time(story: Story, severity: Severity, worst: tuple[int, int]) -> Plot:
    """The whole session: speeds, torques and severity over one time, the worst minute shaded."""
    time_ns, (top, bit, top_torque, bit_torque) = story.over_time.drawn()
    thinned = Thinned(1)
    thinned.add(severity.time_ns, severity.value)
    severe_ns, (severe,) = thinned.drawn()
    time = _clock(time_ns)
    traces = [
        _line("bit", time, bit * RPM, CONFIRMED, width=1.0),
        _line("top of the string", time, top * RPM, TOP),
        _line("top of the string", time, top_torque * KNM, TOP, row=2, legend=False),
        _line("bit", time, bit_torque * KNM, CONFIRMED, row=2, width=1.0, legend=False),
        _line("severity", _clock(severe_ns), severe, LIMIT, row=3, legend=False),
    ]
    traces[-1]["mode"] = "lines+markers" if len(severe) < _FEW else "lines"
    layout = _rows(("speed, rpm", "torque, kN·m", "severity"), story.latest_ns, (0.42, 0.34, 0.24))
    begin, end = _clock(np.array(worst)).tolist()
    shade = {"type": "rect", "xref": "x", "yref": "paper", "x0": begin, "x1": end, "y0": 0, "y1": 1}
    stops = {"type": "line", "xref": "paper", "yref": "y3", "x0": 0, "x1": 1, "y0": 1, "y1": 1}
    layout["shapes"] = [
        {
            **shade,
            "visible": bool(end - begin < 0.5 * np.ptp(time)),
            "fillcolor": "#F0E442",
            "opacity": 0.35,
            "line": {"width": 0},
            "layer": "below",
        },
        {**stops, "line": {"color": LIMIT, "width": 1, "dash": "dot"}},
    ]
    layout["yaxis3"]["rangemode"] = "tozero"
    return {"data": traces, "layout": layout, "height": 640}


def closely(ticks: Ticks, worst: tuple[int, int]) -> Plot:
    """The worst minute: what the bit did, and what was said of it at the time and before."""

    def within(at_ns: npt.NDArray[np.int64], *names: str) -> tuple[Floats, list[Floats]]:
        own = (at_ns >= worst[0]) & (at_ns <= worst[1])
        return _clock(at_ns[own]), [ticks[name][own] for name in names]

    confirmed, (top, bit, top_torque, bit_torque) = within(ticks.confirmed_ns, *OVER_TIME)
    now, (bit_now, torque_now) = within(ticks.time_ns, "now_bit_speed_rad_s", "now_bit_torque_nm")
    ahead, (bit_ahead, torque_ahead) = within(
        ticks.forecast_ns, "forecast_bit_speed_rad_s", "forecast_bit_torque_nm"
    )
    traces = [
        _line("bit, foretold", ahead, bit_ahead * RPM, FORECAST, width=1.2),
        _line("bit, now", now, bit_now * RPM, NOW, width=1.2),
        _line("bit, confirmed", confirmed, bit * RPM, CONFIRMED, width=2.0),
        _line("top of the string", confirmed, top * RPM, TOP),
        _line("foretold", ahead, torque_ahead * KNM, FORECAST, row=2, width=1.2, legend=False),
        _line("now", now, torque_now * KNM, NOW, row=2, width=1.2, legend=False),
        _line("confirmed", confirmed, bit_torque * KNM, CONFIRMED, row=2, width=2.0, legend=False),
        _line("top", confirmed, top_torque * KNM, TOP, row=2, legend=False),
    ]
    layout = _rows(("speed, rpm", "torque, kN·m"), worst[1], (0.55, 0.45))
    return {"data": traces, "layout": layout, "height": 480}


def portrait(counted: Portrait, law: Sequence[float] | None) -> Plot:
    """Where the bit was in torque and speed, and how often; the load law over it.

    `law` is D (N·m·s/rad), T_k, T_s (N·m) and ω_s (rad/s).
    """
    counts, speeds, torques = counted.counts, counted.speeds * RPM, counted.torques * KNM
    with np.errstate(divide="ignore"):
        shade = np.where(counts > 0, np.log10(counts), np.nan)
    traces: list[dict[str, Any]] = [
        {
            "type": "heatmap",
            "x": _packed((speeds[1:] + speeds[:-1]) / 2),
            "y": _packed((torques[1:] + torques[:-1]) / 2),
            "z": [[None if np.isnan(v) else round(v, 3) for v in row] for row in shade.T.tolist()],
            "colorscale": [[0, "#DCEBF5"], [0.5, "#5BA3CF"], [1, "#08306B"]],
            "showscale": False,
            "hovertemplate": "%{x:.0f} rpm, %{y:.2f} kN·m<extra></extra>",
            "name": "confirmed",
        }
    ]
    if law is not None and counts.any():
        viscous, kinetic, static, stribeck = law
        w = np.linspace(0.0, max(float(counted.speeds[-1]), 1.0), 300)
        load = viscous * w + kinetic + (static - kinetic) * np.exp(-w / stribeck)
        traces.append(_line("load law, learned", w * RPM, load * KNM, LIMIT, width=2.5))
    layout = {**_BASE, "xaxis": _axis("bit speed, rpm"), "yaxis": _axis("bit torque, kN·m")}
    return {"data": traces, "layout": layout, "height": 420}


def along(worst: Along) -> Plot:
    """The greatest torque and stress at each depth, and what the components bear."""
    depth = worst.depth_m
    traces = [
        _line("greatest torque", worst.torque_nm * KNM, depth, CONFIRMED, width=2.0),
        _line("greatest stress", worst.stress_pa / 1e6, depth, CONFIRMED, column=2, width=2.0, legend=False),
        _line("least margin", 100 * worst.margin, depth, CONFIRMED, column=3, width=2.0, legend=False),
    ]
    if np.isfinite(worst.limit_nm).any():
        traces.insert(1, _line("limit", worst.limit_nm * KNM, depth, LIMIT, width=2.0))
    layout: dict[str, Any] = dict(_BASE)
    for column, title in enumerate(("torque, kN·m", "shear stress, MPa", "margin to the limit, %"), 1):
        suffix = "" if column == 1 else str(column)
        layout[f"xaxis{suffix}"] = {
            **_axis(title),
            "domain": [(column - 1) / 3 + 0.02, column / 3 - 0.02],
            "rangemode": "tozero",
        }
        layout[f"yaxis{suffix}"] = {
            **_axis("depth along the string, m" if column == 1 else ""),
            "autorange": "reversed",
            "anchor": f"x{suffix}",
            "showticklabels": column == 1,
            **({"matches": "y"} if column > 1 else {}),
        }
    return {"data": traces, "layout": layout, "height": 420}


def by_horizon(every_tick: Skill, counted: Skill, of_late: Skill) -> Plot:
    """How far predictions missed, by how far ahead they were made."""
    kinds = (
        (every_tick, "every tick", NOW, "solid"),
        (counted, "as the sensor counted", FORECAST, "solid"),
        (of_late, "in the last minute", FORECAST, "dot"),
    )
    traces = []
    for column, (name, unit) in enumerate((("speed_rad_s", RPM), ("torque_nm", KNM)), 1):
        for skill, label, colour, dash in kinds:
            if len(skill.ahead_s):
                trace = _line(
                    label, skill.ahead_s, getattr(skill, name) * unit, colour, column=column, width=2.0
                )
                trace |= {"mode": "lines+markers", "showlegend": column == 1}
                trace["line"]["dash"] = dash
                traces.append(trace)
    layout: dict[str, Any] = dict(_BASE)
    for column, title in enumerate(("bit speed missed, rpm", "bit torque missed, kN·m"), 1):
        suffix = "" if column == 1 else "2"
        domain = [0.0, 0.46] if column == 1 else [0.54, 1.0]
        layout[f"xaxis{suffix}"] = {
            **_axis("foretold ahead, s (0: now)"),
            "domain": domain,
            "rangemode": "tozero",
        }
        layout[f"yaxis{suffix}"] = {**_axis(title), "anchor": f"x{suffix}", "rangemode": "tozero"}
    return {"data": traces, "layout": layout, "height": 300}


def lateness(counted: Lateness) -> Plot:
    """How often the loop woke how late."""
    edges = counted.edges_ms
    bars = {
        "type": "bar",
        "x": _packed(np.sqrt(edges[1:] * edges[:-1])),
        "y": _packed(counted.counts),
        "width": _packed(np.diff(edges)),
        "marker": {"color": CONFIRMED},
        "hovertemplate": "%{x:.3g} ms: %{y} ticks<extra></extra>",
    }
    layout = {
        **_BASE,
        "bargap": 0,
        "xaxis": {**_axis("late by, ms"), "type": "log", "dtick": 1},
        "yaxis": {**_axis("ticks"), "type": "log", "dtick": 1},
    }
    return {"data": [bars], "layout": layout, "height": 260}


_BASE: dict[str, Any] = {
    "font": {"family": "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif", "size": 13, "color": _INK},
    "margin": {"l": 64, "r": 16, "t": 28, "b": 48},
    "plot_bgcolor": "#fff",
    "paper_bgcolor": "#fff",
    "hovermode": "closest",
    "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom"},
}


def _axis(title: str) -> dict[str, Any]:
    return {"title": {"text": title}, "gridcolor": _GRID, "zerolinecolor": "#BDBDBD", "automargin": True}


def _rows(titles: Sequence[str], latest_ns: int, heights: Sequence[float]) -> dict[str, Any]:
    """Rows of plots over one time, from the top down; where it counts from 1970, with dates."""
    dated = latest_ns >= _UNIX_NS
    layout: dict[str, Any] = {**_BASE, "hovermode": "x unified"}
    layout["xaxis"] = {
        **_axis("time of day, UTC" if dated else "time, s"),
        "anchor": f"y{len(titles)}",
        "ticks": "outside",
        "ticklen": 8,
        **({"type": "date"} if dated else {}),
    }
    top = 1.0
    for row, (title, height) in enumerate(zip(titles, heights, strict=True), 1):
        layout["yaxis" if row == 1 else f"yaxis{row}"] = {
            **_axis(title),
            "domain": [top - height + 0.04, top],
        }
        top -= height
    layout[f"yaxis{len(titles)}"]["domain"][0] = 0.0
    return layout


def _line(
    name: str,
    x: Floats,
    y: Floats,
    colour: str,
    *,
    row: int = 1,
    column: int = 1,
    width: float = 1.5,
    legend: bool = True,
) -> dict[str, Any]:
    place = "" if row == column == 1 else str(max(row, column))
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": _packed(x),
        "y": _packed(y),
        "xaxis": "x" if column == 1 else f"x{column}",
        "yaxis": f"y{place}",
        "line": {"color": colour, "width": width},
        "showlegend": legend,
        "hovertemplate": "%{y:.4g}",
    }


def _packed(values: Floats) -> dict[str, str]:
    """Doubles as Plotly takes them packed; text would be three times as long."""
    return {"dtype": "f8", "bdata": b64encode(np.ascontiguousarray(values, np.float64).tobytes()).decode()}


def _clock(time_ns: npt.NDArray[np.int64]) -> Floats:
    """Milliseconds since 1970 where times are dates; else seconds from the record's own zero."""
    dated = len(time_ns) and time_ns.max() >= _UNIX_NS
    return np.asarray(time_ns / (1e6 if dated else 1e9))
