"""A session's inputs run under a rig that was not the recorded one."""

from vsensor.checkpoint import length_of
from vsensor.config import Rig
from vsensor.messages import State
from vsensor.service.engine import Engine


class Otherwise(Engine):
    """The engine of `rig`, where `recorded` was in force.

    What the recording sensor remembered is taken up as long as it is of the same string. Of another string's
    state nothing is true but how much longer that string was than configured: so much longer is this one.
    """

    def __init__(self, rig: Rig, recorded: Rig) -> None:
        super().__init__(rig)
        self._recorded = recorded
        self._configured_length = rig.string[0].length
        self._same_string = rig.string == recorded.string

    def take_up(self, state: State) -> None:
        """Go on from a recorded state; ValueError where it is of another string."""
        if self._same_string:
            super().take_up(state)
            return
        longer_by = length_of(state) - self._recorded.string[0].length
        # A recording has several states, and none of them tells how long this string is by now.
        wanted = self._configured_length + longer_by
        if missing := round(wanted - self.estimator.string[0].length, 6):
            self.estimator.lengthen(missing)
        raise ValueError("it is of the recorded string, and this one begins afresh")
