"""The recorder's process: takes packets off the socket at once, writes them to the disk in its own time.

Started by `recorder.Recorder` as `python -m vsensor.recording.process FD PROCESSORS`, with what to write as
JSON on its standard input. Ends when the daemon closes the socket or dies: either way the file is completed.
"""

import contextlib
import json
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Collection
from pathlib import Path

from vsensor.errors import VsensorError
from vsensor.recording import wire
from vsensor.recording.backlog import Backlog, Item
from vsensor.recording.clerk import Clerk
from vsensor.recording.limits import Limits
from vsensor.recording.part import Head

BACKLOG_BYTES = 64 << 20
"""What may wait for a disk that does not answer: a minute and more at 1 kHz."""

SYNC_S = 1.0
"""At most this much is lost in a power cut."""

TELL_S = 1.0

_LOOK_S = 0.05  # often enough to keep the backlog short, seldom enough to cost nothing


class Reporter:
    """Gives the clerk's news to the daemon, whose log has it all; to the terminal where it is gone."""

    def __init__(self, clerk: Clerk, feed: socket.socket) -> None:
        self._clerk = clerk
        self._feed = feed
        self._said = ""
        self._due = 0.0

    def tell_each_second(self) -> None:
        """Tell, unless that was done less than a second ago: while a slow disk is written to, too."""
        if time.monotonic() >= self._due:
            self.tell()

    def tell(self) -> None:
        """Tell how things stand now, and what has happened since the last time."""
        self._due = time.monotonic() + TELL_S
        news = self._clerk.news()
        if not _tell(self._feed, json.dumps(news)) and news["trouble"] != self._said:
            self._said = news["trouble"]
            _say(self._said)
        if self._clerk.has_more:
            self.tell()


def main(descriptor: int, processors: Collection[int]) -> int:
    """Record until the daemon ends; 0 where the session was completed, 1 where it could not be."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _step_back(processors)
    feed = socket.socket(fileno=descriptor)
    order = json.load(sys.stdin)
    path = Path(order["path"])
    head = Head(order["configuration"], order["metadata"], order["compression"])
    backlog = Backlog(BACKLOG_BYTES)
    clerk = Clerk(path, head, Limits(**order["limits"]), backlog)
    try:
        if order["begin"]:
            clerk.begin(path)
        else:
            clerk.mend()
    except VsensorError as error:
        _tell(feed, str(error))
        return 1
    told: list[int] = []
    thread = threading.Thread(target=_receive, args=(feed, backlog), daemon=True)

    def end(number: int, _frame: object) -> None:
        told.append(number)
        with contextlib.suppress(OSError):  # what is in the buffer is still read, what comes after is refused
            feed.shutdown(socket.SHUT_RD)

    signal.signal(signal.SIGTERM, end)
    thread.start()
    _tell(feed, wire.READY)
    reporter = Reporter(clerk, feed)
    _record(backlog, clerk, reporter)
    clerk.close(told_to_end=bool(told))
    reporter.tell()
    return 1 if clerk.failed else 0


def _record(backlog: Backlog, clerk: Clerk, reporter: Reporter) -> None:
    next_sync = time.monotonic() + SYNC_S
    warned = False
    while True:
        last = backlog.ended.wait(_LOOK_S)  # asked before taking: nothing comes after the end
        for item in backlog.take():
            clerk.take(item)
            reporter.tell_each_second()
        clerk.work()
        if backlog.dropped and not warned:
            warned = True
            words = f"the disk does not keep up: {BACKLOG_BYTES >> 20} MiB wait for it, the rest is dropped"
            clerk.note("backlog_full", True, words)
        if last:
            return
        if time.monotonic() >= next_sync:
            clerk.each_second()
            reporter.tell()
            backlog.most = 0
            next_sync = time.monotonic() + SYNC_S


def _receive(feed: socket.socket, backlog: Backlog) -> None:
    try:
        while item := _item(feed):
            backlog.put(item)
    finally:
        backlog.ended.set()


def _item(feed: socket.socket) -> Item:
    try:
        return wire.receive(feed)
    except ConnectionResetError:  # the daemon died with our words unread; told once, its last words follow
        return wire.receive(feed)


def _tell(feed: socket.socket, text: str) -> bool:
    """Whether somebody is there to hear it."""
    try:
        feed.send(text.encode(), socket.MSG_DONTWAIT)
    except BlockingIOError:  # the daemon is busy, or stopped
        return True
    except OSError:
        return False
    return True


def _say(text: str) -> None:
    with contextlib.suppress(OSError):  # a closed terminal must not end the recording
        sys.stderr.write(f"vsensor recorder: {text}\n")
        sys.stderr.flush()


def _step_back(processors: Collection[int]) -> None:
    """Give up what the loop's thread handed down: its processor and priority are not for writing files."""
    if processors:
        with contextlib.suppress(OSError):
            os.sched_setaffinity(0, processors)
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), [int(number) for number in sys.argv[2].split(",") if number]))
