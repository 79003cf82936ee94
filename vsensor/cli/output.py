"""The standard streams, as whoever called us has left them."""

import os
import sys
from io import BufferedWriter, FileIO, TextIOWrapper

STDIN, STDOUT, STDERR = range(3)


def open_closed() -> None:
    """Open to nothing what was closed: else a file of ours takes its place, and gets what is said there."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= STDERR:
        os.set_inheritable(handle, True)
    os.close(handle)
    sys.stdin = sys.stdin or os.fdopen(STDIN, closefd=False)
    sys.stderr = sys.stderr or os.fdopen(STDERR, "w", closefd=False)


class Output(TextIOWrapper):
    """A stream that knows why it could not be written the last time."""

    failure: OSError | None = None

    @classmethod
    def standard(cls) -> "Output":
        """Standard output, with a question mark for each letter that its encoding has not."""
        if sys.stdout is None:
            return cls(BufferedWriter(FileIO(STDOUT, "w", closefd=False)), encoding="utf-8")
        return cls(
            sys.stdout.buffer,
            encoding=sys.stdout.encoding,
            errors="replace",
            line_buffering=bool(sys.stdout.line_buffering),
        )

    def write(self, text: str) -> int:
        """Write as any stream does."""
        try:
            return super().write(text)
        except OSError as error:
            self.failure = error
            raise

    def flush(self) -> None:
        """Flush as any stream does."""
        try:
            super().flush()
        except OSError as error:
            self.failure = error
            raise
