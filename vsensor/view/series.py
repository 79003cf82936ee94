"""Where what is drawn has its place in Rerun's tree: one branch a view."""

# Rerun draws the lines of a plot, and the lanes of a timeline, in the alphabetical order of their
# entities: the surface first, and the bit on top of it.
GLANCE = "/glance"
SPEED = "/speed"
TORQUE = "/torque"

# Rerun writes the path of a lane above it: these are read.
BIT, AHEAD, ROUGHNESS, STRENGTH, TRUST = "/bit", "/stick-foretold", "/stick-slip", "/strength", "/trust"
DRILLER_STATES = (BIT, AHEAD, ROUGHNESS, STRENGTH, TRUST)
SENSOR = "/sensor"
STATE, QUALITY = f"{SENSOR}/state", f"{SENSOR}/quality"

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


def condition(name: str) -> str:
    """The lane of an event that lasts."""
    return f"{SENSOR}/{name.replace('_', '-')}"


def present(plot: str) -> str:
    """The dot that marks the present."""
    return f"{plot}/present"
