"""What the daemon may be doing: the words of `Status.state`."""

STARTING = "starting"
STANDING_BY = "standing by"
WAITING = "waiting for samples"
WARMING_UP = "warming up"
RUNNING = "running"
INPUT_LOST = "input lost"
STATES = (STARTING, STANDING_BY, WAITING, WARMING_UP, RUNNING, INPUT_LOST)
AS_IT_SHOULD = (STANDING_BY, WAITING, WARMING_UP, RUNNING)
"""Those in which nothing is amiss."""
