"""What is believed of one depth channel.

A depth counts for as long as its channel speaks. One that leaps farther than a bit can have moved is doubted
until it was told for some seconds: a single wrong one neither cuts the string anew nor lifts the bit.
"""

from typing import NamedTuple

from vsensor.grid import NS

FRESH_S = 5.0
PERIODS = 3
"""A depth counts for so long, or for so many of its channel's periods where those are longer, and"""
SILENT_S = 30.0
"""never for longer: then the channel is silent. One so far ahead of the tick is by another clock."""
STEP_M = 5.0
FASTEST_M_S = 2.0
"""No bit moves farther than this step and so much in each second: a greater leap is doubted."""
LASTING_S = 3.0
"""A leap is believed once it was told for so long, by two samples at least."""


class Told(NamedTuple):
    """A depth, m, and when it was measured."""

    value: float
    time_ns: int

    def leads_to(self, later: "Told") -> bool:
        """Whether a bit that was here can have got there."""
        seconds = (later.time_ns - self.time_ns) / NS
        near = abs(later.value - self.value) <= STEP_M + FASTEST_M_S * seconds
        return near and 0 <= seconds <= SILENT_S


class Known(NamedTuple):
    """A depth that is believed, and how long it counts."""

    told: Told
    lasts_ns: int

    @staticmethod
    def behind(before: Told, told: Told) -> "Known":
        """One that is told behind another."""
        period_ns = told.time_ns - before.time_ns
        return Known(told, min(max(round(FRESH_S * NS), PERIODS * period_ns), round(SILENT_S * NS)))


class Doubt(NamedTuple):
    """Depths that agree with one another, and not with what is known."""

    newest: Told
    since_ns: int
    samples: int


class Belief(NamedTuple):
    """What one channel has told so far, as far as it is believed."""

    known: Known | None = None
    doubt: Doubt | None = None
    refused: int = 0
    """Samples that were doubted, and not borne out."""

    def after(self, told: Told) -> "Belief":
        """What is believed once this was told too: it is `known` where it follows from what came before."""
        known, doubt = self.known, self.doubt
        if known is not None and abs(told.time_ns - known.told.time_ns) > SILENT_S * NS:
            known = None
        if known is not None and told.time_ns < known.told.time_ns:
            return self
        if known is not None and known.told.leads_to(told):
            return Belief(Known.behind(known.told, told), None, self._refused_with(doubt))
        if doubt is None or not doubt.newest.leads_to(told):
            return Belief(known, Doubt(told, told.time_ns, 1), self._refused_with(doubt))
        if told.time_ns - doubt.since_ns < LASTING_S * NS:
            return Belief(known, Doubt(told, doubt.since_ns, doubt.samples + 1), self.refused)
        return Belief(Known.behind(doubt.newest, told), None, self.refused)

    def _refused_with(self, doubt: Doubt | None) -> int:
        return self.refused + (doubt.samples if doubt is not None else 0)
