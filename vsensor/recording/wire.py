"""The packets in which the daemon hands its messages to the recorder's process; both ends read here.

A packet is a run of messages, each a head, its topic and its payload. It has no length and no
checksum of its own: the socket (SOCK_SEQPACKET) keeps packets whole and apart. A message without a topic
is an order to the recorder, as JSON. With some orders comes what the sensor remembers, in an open file
without a name: megabytes cross in one system call, and the socket's buffer holds but their number.
"""

import json
import math
import os
import socket
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from vsensor.messages import State

HEAD = struct.Struct("<BIqq")
"""Bytes of the topic, bytes of the payload, log time, publish time (ns, Unix)."""

PACKET_BYTES = 1 << 16
"""No packet is larger, so the receiver's buffer of this size never cuts one."""

READY = "ready"
"""What the recorder answers when it stands ready; any other answer is a complaint in plain text."""

FAREWELL, START, STOP, SPLIT, KEEP, SNAPSHOT = "farewell", "start", "stop", "split", "keep", "snapshot"
HEADING = "heading"
"""The orders: KEEP only tells what is remembered, FAREWELL is the daemon's last word, HEADING tells how
files begin from now on."""

_SIZE = struct.Struct("<I")


class Parcel(NamedTuple):
    """One message as it crosses from the daemon to the recorder."""

    topic: bytes
    data: bytes
    log_time_ns: int
    publish_time_ns: int


class Checkpoint(NamedTuple):
    """An order, and what the sensor remembers at that moment, as it crossed."""

    order: dict[str, Any]
    time_ns: int
    remembered: bytes


class Heading(NamedTuple):
    """What files that begin from now on say of themselves."""

    configuration: str
    metadata: Mapping[str, str]


def packed_order(order: dict[str, Any], time_ns: int) -> bytes:
    """An order as a packet of its own."""
    text = json.dumps(order).encode()
    return HEAD.pack(0, len(text), time_ns, time_ns) + text


def order_of(parcel: Parcel) -> dict[str, Any]:
    """What a message without a topic orders."""
    order: dict[str, Any] = json.loads(parcel.data)
    return order


def unpack(packet: bytes) -> Iterator[Parcel]:
    """Yield the messages of a packet, in the order in which they were offered."""
    at = 0
    while at < len(packet):
        topic_bytes, data_bytes, log_time_ns, publish_time_ns = HEAD.unpack_from(packet, at)
        topic_at = at + HEAD.size
        data_at = topic_at + topic_bytes
        at = data_at + data_bytes
        yield Parcel(packet[topic_at:data_at], packet[data_at:at], log_time_ns, publish_time_ns)


class Carrier:
    """The open file in which states cross.

    The same for one after the other, as its pages are there already: that takes a tenth of the time of new
    ones. Only where the last has not been read yet, the next crosses in a new file.
    """

    def __init__(self) -> None:
        self._file = -1
        self._sent = 0
        self.read = 0
        """The number of the last state that the recorder says it has read."""

    def send(
        self,
        over: socket.socket,
        order: dict[str, Any],
        time_ns: int,
        state: State,
        arrays: Sequence[memoryview],
    ) -> None:
        """Send an order with a state, its arrays apart; OSError where the socket cannot take it now."""
        if self._file < 0 or self.read != self._sent:
            self.close()
            self._file = os.memfd_create("vsensor state", os.MFD_CLOEXEC)
        header = state.SerializeToString()
        os.pwritev(self._file, [_SIZE.pack(len(header)), header, *arrays], 0)
        number = self._sent + 1
        socket.send_fds(over, [packed_order({**order, "state": number}, time_ns)], [self._file])
        self._sent = number

    def close(self) -> None:
        """Let go of the file; what is on its way stays."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def send_heading(over: socket.socket, heading: Heading, time_ns: int) -> None:
    """Send it in a file, for a long well path is larger than a packet; OSError where the socket is full."""
    file = os.memfd_create("vsensor heading", os.MFD_CLOEXEC)
    try:
        os.write(file, json.dumps(heading).encode())
        socket.send_fds(over, [packed_order({"order": HEADING}, time_ns)], [file])
    finally:
        os.close(file)


def receive(over: socket.socket) -> bytes | Checkpoint | Heading:
    """Wait for the next packet; empty where no more will come."""
    packet, files, _, _ = socket.recv_fds(over, PACKET_BYTES, 1)
    if not files:
        return packet
    try:
        content = os.pread(files[0], os.fstat(files[0]).st_size, 0)
    finally:
        os.close(files[0])
    (parcel,) = unpack(packet)
    order = order_of(parcel)
    if order["order"] == HEADING:
        return Heading(*json.loads(content))
    return Checkpoint(order, parcel.log_time_ns, content)


def state_of(remembered: bytes) -> State:
    """The state that crossed, its arrays put into it."""
    (size,) = _SIZE.unpack_from(remembered)
    at = _SIZE.size + size
    state = State.FromString(remembered[_SIZE.size : at])
    for array in state.arrays:
        end = at + math.prod(array.shape) * int(array.dtype[2:])
        array.data = remembered[at:end]
        at = end
    return state
