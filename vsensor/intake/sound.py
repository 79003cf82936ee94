"""Whether what an intake was handed as remembered can be gone on with.

Each value is right already by itself. What they say together must hold too: samples far ahead of the grid
would at once make the ticks of a century.
"""

from collections.abc import Mapping
from typing import NamedTuple

from vsensor.grid import Grid
from vsensor.intake.channel import FARTHEST_NS, Channel
from vsensor.saved import Saved


class Laid(NamedTuple):
    """The grid: when it begins (None: not laid), how many ticks were given out, and when the last was."""

    anchor_ns: int | None
    number: int
    consumed_ns: int | None


def refuse_unsound(
    saved: Saved, laid: Laid, grid: Grid, channels: Mapping[str, Channel], reach_ns: int
) -> None:
    """Raise ValueError, naming the place in `saved` and what would be right, where no intake can be so.

    `reach_ns`: how far ahead of the next tick samples may wait for others.
    """
    anchor_ns, number, consumed_ns = laid
    if grid.after_ns(number) > (0 if anchor_ns is None else FARTHEST_NS):
        raise saved["number"].wrong("0 without an anchor, else the ticks of 146 years at the most,")
    newest_ns = None if anchor_ns is None or not number else anchor_ns + grid.after_ns(number - 1)
    if consumed_ns != newest_ns:
        raise saved["consumed_ns"].wrong(f"{newest_ns}, as anchor, number and rate have it,")
    next_ns = None if anchor_ns is None else anchor_ns + grid.after_ns(number)
    for topic, channel in channels.items():
        _refuse_unsound_points(saved["channels"][topic], channel, next_ns, reach_ns)
    if anchor_ns is None and all(channel.points for channel in channels.values()):
        raise saved["anchor_ns"].wrong("a time, since both channels have spoken,")


def _refuse_unsound_points(saved: Saved, channel: Channel, next_ns: int | None, reach_ns: int) -> None:
    points, waiting = channel.points, channel.waiting
    if next_ns is not None and not (points and points[0].time_ns <= next_ns):
        raise saved["points"].wrong(f"a list that begins at {next_ns} or before, the next tick's time,")
    if not points:
        if waiting is not None:
            raise saved["waiting"].wrong("null while the channel has no points")
        return
    farthest_ns = (points[0].time_ns if next_ns is None else next_ns) + reach_ns
    if points[-1].time_ns > farthest_ns:
        raise saved["points"].wrong(f"a list that ends at {farthest_ns} or before")
    if waiting is not None and not points[-1].time_ns < waiting.time_ns <= farthest_ns:
        raise saved["waiting"].wrong(f"a time behind {points[-1].time_ns} and up to {farthest_ns}")
