"""What the loop leaves out to keep up when time is short, in order, and takes up again by itself."""

ALL, NO_PROFILE, NO_FORECAST = range(3)
"""Levels: what is confirmed and told for now is never left out."""

FULL = 0.9
"""A loop that worked for so much of a second is short of time."""
EASY = 0.6
"""With less than this there is time for more."""
PATIENCE_S = 5
"""So many easy seconds, one after the other, before something is taken up again;"""
MOST_PATIENCE_S = 320
"""twice as many each time that this proves hasty, up to so many."""


class Shedding:
    """The level in force, looked at once a second."""

    def __init__(self) -> None:
        self.level = ALL
        self.count = 0
        """How often something was left out."""
        self._patience = PATIENCE_S
        self._easy = 0
        self._returned = False
        self._since = 0

    def second(self, load: float) -> int:
        """Take the share of the last second that the loop worked; returns the level from now on."""
        self._since += 1
        if load > FULL:
            self._easy = 0
            if self.level < NO_FORECAST:
                self._leave_out()
        elif self.level > ALL and load < EASY:
            self._easy += 1
            if self._easy >= self._patience:
                self._move(-1)
        else:
            self._easy = 0
        return self.level

    def _leave_out(self) -> None:
        if self._returned:
            hasty = self._since <= self._patience
            self._patience = min(2 * self._patience, MOST_PATIENCE_S) if hasty else PATIENCE_S
        self.count += 1
        self._move(+1)

    def _move(self, step: int) -> None:
        self.level += step
        self._returned = step < 0
        self._since = self._easy = 0
