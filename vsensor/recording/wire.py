"""The packets in which the daemon hands its messages to the recorder's process; both ends read here.

A packet is a run of messages, each a head, its topic and its payload. It has no length and no
checksum of its own: the socket (SOCK_SEQPACKET) keeps packets whole and apart.
"""

import struct
from collections.abc import Iterator
from typing import NamedTuple

HEAD = struct.Struct("<BIqq")
"""Bytes of the topic, bytes of the payload, log time, publish time (ns, Unix)."""

PACKET_BYTES = 1 << 16
"""No packet is larger, so the receiver's buffer of this size never cuts one."""

READY = "ready"
"""What the recorder answers when its file stands open; any other answer is a complaint in plain text."""

FAREWELL = b""
"""The topic of the daemon's last word; its payload is the count of messages that it had to drop."""

COUNT = struct.Struct("<Q")


class Parcel(NamedTuple):
    """One message as it crosses from the daemon to the recorder."""

    topic: bytes
    data: bytes
    log_time_ns: int
    publish_time_ns: int


def unpack(packet: bytes) -> Iterator[Parcel]:
    """Yield the messages of a packet, in the order in which they were offered."""
    at = 0
    while at < len(packet):
        topic_bytes, data_bytes, log_time_ns, publish_time_ns = HEAD.unpack_from(packet, at)
        topic_at = at + HEAD.size
        data_at = topic_at + topic_bytes
        at = data_at + data_bytes
        yield Parcel(packet[topic_at:data_at], packet[data_at:at], log_time_ns, publish_time_ns)
