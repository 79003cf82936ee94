"""What the daemon's seconds come to, in lines: each change once, rather than each second the same."""

from collections.abc import Iterable

from structlog.typing import FilteringBoundLogger

from vsensor.messages import Event, Status
from vsensor.messages.books import LOSSES
from vsensor.messages.states import AS_IT_SHOULD
from vsensor.recording.recorder import Recorder


class Teller:
    """Compares each second with the one before."""

    def __init__(self, log: FilteringBoundLogger, recorder: Recorder) -> None:
        self._log = log
        self._recorder = recorder
        self._state = ""
        self._trouble = ""
        self._before: dict[str, int] = {}

    def tell(self, status: Status, fault: str, events: Iterable[Event]) -> None:
        """Hear the status of this second, what the last unreadable sample lacked, and what happened."""
        for event in events:
            self._log.info(event.name, begins=event.begins, text=event.text)
        if status.state != self._state:
            self._state = status.state
            say = self._log.info if status.state in AS_IT_SHOULD else self._log.warning
            say("state", state=status.state)
        self._tell_of_recorder()
        for what, count in _losses(status).items():
            if (more := count - self._before.get(what, 0)) > 0:
                cause = {"last": fault} if fault and what.endswith("unreadable") else {}
                self._log.warning(what, more=more, total=count, **cause)
            self._before[what] = count

    def _tell_of_recorder(self) -> None:
        if (trouble := self._recorder.trouble()) != self._trouble:
            self._trouble = trouble
            if trouble:
                self._log.error("no longer recorded", why=trouble)


def _losses(status: Status) -> dict[str, int]:
    """All that should not happen, counted since the start."""
    losses = {"turns skipped": status.slots_skipped, "not recorded": status.recorder_dropped}
    losses["depths refused"] = status.depths_refused
    for channel in status.channels:
        for what in LOSSES:
            losses[f"{channel.channel} {what.replace('_', ' ')}"] = getattr(channel, what)
    return losses
