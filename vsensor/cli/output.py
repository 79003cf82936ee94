"""Standard output, as whoever called us has left it."""

import os
import sys
from io import BufferedWriter, FileIO, TextIOWrapper


class Output(TextIOWrapper):
    """A stream that knows why it could not be written the last time."""

    failure: OSError | None = None

    @classmethod
    def standard(cls) -> "Output":
        """Standard output: a letter that its encoding has not becomes a question mark.

        Where it was closed what is said is lost, and the work is done all the same.
        """
        if sys.stdout is None:
            return cls(BufferedWriter(FileIO(os.devnull, "w")), encoding="utf-8")
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
