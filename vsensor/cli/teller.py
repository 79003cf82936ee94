"""What the daemon's seconds come to, in lines: each change once, rather than each second the same."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from structlog.typing import FilteringBoundLogger

from vsensor.messages import Event, Status
from vsensor.messages.books import LOSSES
from vsensor.messages.events import is_refusal
from vsensor.messages.states import AS_IT_SHOULD


class Trouble(NamedTuple):
    """Something beside the loop that may fail for a while."""

    begins: str
    ends: str
    ask: Callable[[], str]
    """Why it fails; empty while it does not."""


class Teller:
    """Compares each second with the one before."""

    def __init__(self, log: FilteringBoundLogger, troubles: Iterable[Trouble]) -> None:
        self._log = log
        self._troubles = dict.fromkeys(troubles, "")
        self._state = ""
        self._before: dict[str, int] = {}

    def tell(self, status: Status, faults: Mapping[str, str], events: Iterable[Event]) -> None:
        """Hear the status of this second, what each topic's last unreadable sample lacked, what happened."""
        for event in events:
            say = self._log.warning if is_refusal(event) else self._log.info
            say(event.name, begins=event.begins, text=event.text)
        if status.state != self._state:
            self._state = status.state
            say = self._log.info if status.state in AS_IT_SHOULD else self._log.warning
            say("state", state=status.state)
        self._tell_of_troubles()
        for what, count in _losses(status).items():
            if (more := count - self._before.get(what, 0)) > 0:
                topic, _, loss = what.partition(" ")
                cause = {"last": faults[topic]} if loss == "unreadable" and topic in faults else {}
                self._log.warning(what, more=more, total=count, **cause)
            self._before[what] = count

    def _tell_of_troubles(self) -> None:
        for trouble, said in self._troubles.items():
            if (why := trouble.ask()) != said:
                self._troubles[trouble] = why
                if why:
                    self._log.error(trouble.begins, why=why)
                else:
                    self._log.info(trouble.ends)


def _losses(status: Status) -> dict[str, int]:
    """All that should not happen, counted since the start."""
    losses = {"turns skipped": status.slots_skipped, "not recorded": status.recorder_dropped}
    losses |= {"depths refused": status.depths_refused, "missed on the bus": status.bus_missed}
    for channel in status.channels:
        for what in LOSSES:
            losses[f"{channel.channel} {what.replace('_', ' ')}"] = getattr(channel, what)
    return losses
