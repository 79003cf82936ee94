"""Where what is drawn has its place in Rerun's tree: one branch a view."""

# Rerun draws the lines of a plot, and the lanes of a timeline, in the alphabetical order of their
# entities: the surface first, and the bit on top of it.
GLANCE = "/glance"
SPEED = "/speed"
TORQUE = "/torque"
AHEAD, BIT, ROUGHNESS, STRENGTH, TRUST = "/ahead", "/bit", "/stick-slip", "/strength", "/trust"
DRILLER_STATES = (AHEAD, BIT, ROUGHNESS, STRENGTH, TRUST)
PAGE = "/answers"
LOG = "/log"

FIELD_TORQUE = "/string/torque"
FIELD_SPEED = "/string/speed"
WAVES = "/string/waves"
TWIST = "/string/twist"
PORTRAIT = "/rock/portrait"
SPECTRUM = "/swing/spectrum"

LATENESS = "/loop/lateness"
WORK = "/loop/work"
AGES = "/input/age"
LOSSES = "/losses"
QUEUES = "/queues"
SERVICE_STATES = "/service"
HEALTH = "/health"

EACH_TICK = f"{LATENESS}/each_tick"
P99 = f"{LATENESS}/p99"


def surface(plot: str) -> str:
    """The surface's line in a plot."""
    return f"{plot}/at_surface"


def limit(where: str) -> str:
    """The line of what the string bears, at the surface or at the bit."""
    return f"{TORQUE}/a_limit/{where.replace(' ', '_')}"


def bit(plot: str, kind: str) -> str:
    """The bit's line in a plot; `kind` is confirmed, now or forecast."""
    return f"{plot}/bit/{kind}"


def present(plot: str) -> str:
    """The dot that marks the present."""
    return f"{plot}/present"
