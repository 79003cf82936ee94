"""What is so at a time, as coloured bars: the driller's questions, and the sensor's own conditions."""

from collections.abc import Iterator, Mapping

from vsensor.messages import Estimate, Event, Message, Profile, Status
from vsensor.messages.states import INPUT_LOST, RUNNING, STANDING_BY, STARTING, WAITING, WARMING_UP
from vsensor.view import series
from vsensor.view.batches import Batch, Colour, Lane, LaneLook
from vsensor.view.palette import BLUE, GREEN, GREY, ORANGE, PINK, VERMILION, YELLOW
from vsensor.view.part import Part
from vsensor.view.verdicts import Verdict, bit_state, roughness, strength, trust

CONDITIONS: Mapping[str, Colour] = {
    "input_lost": VERMILION,
    "stuck": VERMILION,
    "stick_slip": VERMILION,
    "over_torque": VERMILION,
    "depths_at_odds": YELLOW,
    "depths_silent": YELLOW,
    "contested": YELLOW,
    "clocks_apart": YELLOW,
    "off_bottom": BLUE,
    "connection": BLUE,
    "recording": GREEN,
}
"""Events that last until they end; others are over as soon as they are told, and in the log alone."""
AGREED = 3
"""A stick that is foretold or not by so many ticks one after the other is drawn so."""

_LOOKS: dict[str, Mapping[str, Colour]] = {
    series.BIT: {"turns": GREEN, "stands": VERMILION, "turns back": PINK, "rests": GREY},
    series.AHEAD: {"soon": ORANGE},
    series.ROUGHNESS: {"smooth": GREEN, "uneven": YELLOW, "stick-slip": VERMILION},
    series.STRENGTH: {"within limits": GREEN, "near a limit": YELLOW, "over a limit": VERMILION},
    series.TRUST: {"good": GREEN, "uncertain": YELLOW, "bad": VERMILION},
    series.STATE: {
        STARTING: GREY,
        STANDING_BY: GREY,
        WAITING: GREY,
        WARMING_UP: BLUE,
        RUNNING: GREEN,
        INPUT_LOST: VERMILION,
    },
}


class States(Part):
    """All lanes; each is drawn on where its state changes."""

    def __init__(self) -> None:
        self._shown: dict[str, str] = {}
        self._out: list[Batch] = [LaneLook(entity, colours) for entity, colours in _LOOKS.items()]
        self._qualities: dict[str, Colour] = {}
        self._foretold = False
        self._agreeing = 0

    def take(self, message: Message) -> None:
        """Take in one message."""
        match message:
            case Estimate():
                self._take_estimate(message)
            case Profile():
                self._show(series.STRENGTH, message.time_ns, strength(message))
            case Status():
                self._show(series.ROUGHNESS, self.at_ns, roughness(message))
                self._show_text(series.STATE, self.at_ns, message.state)
            case Event() if message.name in CONDITIONS:
                self._take_event(message)

    def batches(self) -> Iterator[Batch]:
        """Hand over what has changed since the last call."""
        out, self._out = self._out, []
        yield from out

    def _take_estimate(self, estimate: Estimate) -> None:
        if estimate.HasField("confirmed_time_ns"):
            self._show(series.BIT, estimate.confirmed_time_ns, bit_state(estimate, "confirmed"))
        foretold = estimate.HasField("stick_in_s") and estimate.stick_in_s > 0
        self._agreeing = self._agreeing + 1 if foretold == self._foretold else 1
        self._foretold = foretold
        if self._agreeing >= AGREED:
            self._show_text(series.AHEAD, estimate.time_ns, "soon" if foretold else "")
        self._show(series.TRUST, estimate.time_ns, trust(estimate))
        self._show_quality(estimate)

    def _show_quality(self, estimate: Estimate) -> None:
        """The verdict with its reasons: each set of them is a state of its own."""
        verdict = trust(estimate)
        state = f"{verdict.word}: {verdict.why}" if verdict.why else verdict.word
        if state and state not in self._qualities:
            self._qualities[state] = _LOOKS[series.TRUST][verdict.word]
            self._out.append(LaneLook(series.QUALITY, dict(self._qualities)))
        self._show_text(series.QUALITY, estimate.time_ns, state)

    def _take_event(self, event: Event) -> None:
        name = event.name.replace("_", " ")
        entity = series.condition(event.name)
        if entity not in self._shown:
            self._out.append(LaneLook(entity, {name: CONDITIONS[event.name]}))
        self._show_text(entity, event.time_ns, name if event.begins else "")

    def _show(self, entity: str, time_ns: int, verdict: Verdict) -> None:
        self._show_text(entity, time_ns, verdict.word)

    def _show_text(self, entity: str, time_ns: int, state: str) -> None:
        if self._shown.get(entity, "") != state:
            self._shown[entity] = state
            self._out.append(Lane(entity, time_ns, state))
