"""What becomes of samples: each is accepted, or refused for one reason."""

from vsensor.messages.vsensor_pb2 import ChannelStatus

REFUSALS = (
    "unreadable",
    "not_finite",
    "out_of_range",
    "doubled",
    "late",
    "jumped",
    "bad_at_source",
    "over_rate",
    "strays",
)
"""The reasons, as fields of ChannelStatus: received = accepted + the sum of these + one that may wait."""


LOSSES = ("lost", *REFUSALS)
"""All that may happen to a sample and should not: a number that never came, and the reasons."""


def refused(channel: ChannelStatus) -> int:
    """How many samples of a channel were refused."""
    return sum(getattr(channel, reason) for reason in REFUSALS)


def words(channel: ChannelStatus) -> str:
    """For which reasons, and how many each: "late 3, strays 1"."""
    counts = ((reason, getattr(channel, reason)) for reason in REFUSALS)
    return ", ".join(f"{reason.replace('_', ' ')} {count}" for reason, count in counts if count)
