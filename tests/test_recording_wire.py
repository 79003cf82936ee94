"""What crosses from the daemon to its recorder, and where it waits there."""

from vsensor.recording.backlog import Backlog
from vsensor.recording.wire import HEAD, unpack


def packet(messages: int) -> bytes:
    return (HEAD.pack(1, 2, 3, 4) + b"t" + b"dd") * messages


def test_a_packet_is_unpacked_into_what_was_packed() -> None:
    assert list(unpack(packet(3))) == [(b"t", b"dd", 3, 4)] * 3


def test_the_backlog_is_bounded_and_counts_messages() -> None:
    backlog = Backlog(capacity=3 * len(packet(5)))
    for _ in range(5):
        backlog.put(packet(5))
    assert backlog.take() == [packet(5)] * 3
    assert backlog.dropped == 10
    backlog.put(packet(1))
    assert backlog.take() == [packet(1)]
    assert backlog.take() == []


def test_the_most_that_has_waited_is_known_after_it_was_taken() -> None:
    backlog = Backlog(capacity=1000)
    for _ in range(2):
        backlog.put(packet(5))
        backlog.put(packet(2))
        backlog.take()
    assert backlog.most == len(packet(7))
