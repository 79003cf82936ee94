"""What is drawn: each line's place in Rerun's tree, its name, colour and width."""

from vsensor.view.batches import Batch, Colour, LaneLook, Look

# One branch a view. Rerun draws the lines of a plot, and the lanes of a timeline, in the alphabetical
# order of their entities: the surface first, then the bands, and the bit on top of all.
SPEED = "/speed"
TORQUE = "/torque"
LATENESS = "/lateness"
SEVERITY = "/severity"
DAEMON = "/daemon"
EVENTS = "/event"
LOG = "/log"
PANEL = "/panel"
HEALTH = "/health"

EACH_TICK = f"{LATENESS}/each_tick"
P99 = f"{LATENESS}/p99"

# Okabe and Ito's palette, which the colour-blind tell apart as well (jfly.uni-koeln.de/color).
_GREY: Colour = (150, 150, 150, 255)
_PALE: Colour = (150, 150, 150, 110)
_BLUE: Colour = (86, 180, 233, 255)
_ORANGE: Colour = (230, 159, 0, 255)
_PINK: Colour = (204, 121, 167, 255)
_GREEN: Colour = (0, 158, 115, 255)
_VERMILION: Colour = (213, 94, 0, 255)

_BIT: dict[str, tuple[Colour, float]] = {
    "confirmed": (_BLUE, 4.0),
    "now": (_ORANGE, 2.0),
    "forecast": (_PINK, 2.0),
}
_STATES = {"running": _GREEN, "warming up": _BLUE, "waiting for samples": _GREY, "input lost": _VERMILION}


def surface(plot: str) -> str:
    """The surface's line in a plot."""
    return f"{plot}/at_surface"


def bit(plot: str, kind: str) -> str:
    """The bit's line in a plot; `kind` is confirmed, now or forecast."""
    return f"{plot}/bit/{kind}"


def band(plot: str, kind: str) -> str:
    """The edges of the ±2σ band about that line."""
    return f"{plot}/band/{kind}"


def event(name: str) -> str:
    """The lane of an event."""
    return f"{EVENTS}/{name.replace(' ', '_')}"


def event_look(name: str) -> Batch:
    """How an event's lane is drawn while it lasts."""
    return LaneLook(event(name), {name: _VERMILION})


def looks(confirmed_delay_s: float | None, forecast_horizon_s: float | None) -> list[Batch]:
    """How everything is drawn; the legend tells the delays, once they are known."""
    ago = "" if confirmed_delay_s is None else f" ({confirmed_delay_s:.1f} s ago)"
    ahead = "" if forecast_horizon_s is None else f" (in {forecast_horizon_s:.1f} s)"
    names = {"confirmed": f"bit confirmed{ago}", "now": "bit now", "forecast": f"bit forecast{ahead}"}
    all_looks: list[Batch] = [
        LaneLook(DAEMON, _STATES),
        Look(EACH_TICK, ("of each tick",), _GREEN, 1.5),
        Look(P99, ("99 % below, of each second",), _VERMILION, 2.0),
        Look(SEVERITY, ("severity",), _ORANGE, 2.0),
    ]
    for plot in (SPEED, TORQUE):
        all_looks.append(Look(surface(plot), ("surface",), _GREY, 1.5))
        for kind, (colour, width) in _BIT.items():
            all_looks.append(Look(bit(plot, kind), (names[kind],), colour, width))
            all_looks.append(Look(band(plot, kind), ("±2σ", "±2σ"), _PALE, 1.0))
    return all_looks
