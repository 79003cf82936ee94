"""The Rerun recording of the view, and where it goes."""

from collections.abc import Callable, Iterable
from typing import Self

import rerun as rr
import rerun.blueprint as rrb

from vsensor.view.batches import Batch
from vsensor.view.blueprint import USUAL, Reach
from vsensor.view.place import Place, ViewError
from vsensor.view.sink import send

_LIVE_MEMORY = "64MB"
"""What a viewer that comes late is told: some minutes; the oldest goes first.

Counted are the messages as they are sent. A page in a browser takes sixteen times as much to read them, and
may have 4 GB at most: one that was told 256 MB at once came to a stand there.
"""
_SESSION_MEMORY = "50%"
"""The same of a recorded session, which is to be seen whole."""
_SETTLED_S = 0.1
"""The layout is made anew where the reach of the answers has changed by more."""


class Screen:
    """A recording that is served, written to a file, or both.

    We serve and the viewers draw from us, not the other way round: a frozen viewer does not hold us up for
    long (20 s: a window is dropped by Rerun, a page by `stuck`), and one that died is opened again on all
    that was.
    """

    def __init__(
        self, name: str, layout: Callable[[Reach], rrb.Blueprint], place: Place, *, live: bool = True
    ) -> None:
        self._name = name
        self._layout = layout
        self._place = place
        self._live = live
        self._reach = USUAL
        self._recordings: list[rr.RecordingStream] = []
        self._count = 0

    def __enter__(self) -> Self:
        self.begin()
        return self

    def __exit__(self, *_: object) -> None:
        for recording in reversed(self._recordings):
            recording.disconnect()

    def send(self, batches: Iterable[Batch]) -> None:
        """Show what has come."""
        for batch in batches:
            send(batch, self._recordings[-1])

    def fit(self, reach: Reach) -> None:
        """Lay the plots out for answers of this reach."""
        if max(abs(new - old) for new, old in zip(reach, self._reach, strict=True)) > _SETTLED_S:
            self._reach = reach
            self._recordings[-1].send_blueprint(self._layout(reach))

    def begin(self) -> None:
        """Begin a recording; another one when time falls back, for on one timeline it must not.

        Viewers turn to the new one by themselves; a file gets a number.
        """
        if len(self._recordings) > 1:  # the first holds the server, and stays
            self._recordings.pop().disconnect()
        self._count += 1
        recording = rr.RecordingStream("vsensor")
        try:
            recording.set_sinks(*self._sinks())
        except RuntimeError as error:
            raise ViewError(f"--save {self._place.save}: {error}") from error
        recording.send_recording_name(self._name)
        recording.send_blueprint(self._layout(self._reach))
        self._recordings.append(recording)

    def _sinks(self) -> list[rr.GrpcServerSink | rr.GrpcSink | rr.FileSink]:
        sinks: list[rr.GrpcServerSink | rr.GrpcSink | rr.FileSink] = []
        if self._place.kind != "file":
            sinks.append(self._server() if self._count == 1 else rr.GrpcSink(self._place.source))
        if path := self._place.numbered(self._count):
            # A footer, an index, needs memory for each batch as long as the file is written.
            sinks.append(rr.FileSink(path, write_footer=not self._live))
        return sinks

    def _server(self) -> rr.GrpcServerSink:
        return rr.GrpcServerSink(
            self._place.bind,
            self._place.data_port,
            server_memory_limit=_LIVE_MEMORY if self._live else _SESSION_MEMORY,
            newest_first=True,
            cors_allow_origin=self._place.origins,
        )
