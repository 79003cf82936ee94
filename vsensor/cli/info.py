"""`vsensor info`: what is in a session."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table
from rich.text import Text

from vsensor.cli.printable import printable
from vsensor.cli.wide import wide_console

if TYPE_CHECKING:
    from vsensor.recording.summary import Summary

_UNIX_NS = 10**17
"""Times before (1973) count from the start of a record, not from 1970."""


def info(session: Annotated[Path, typer.Argument(help="A session, whole or torn.")]) -> None:
    """Say what is in a session."""
    from vsensor.recording.reader import Session

    recorded = Session(session)
    summary = recorded.summary()
    console = wide_console()
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, text in _facts(summary, recorded.configuration is not None).items():
        table.add_row(Text(printable(name)), Text(printable(text)))
    console.print(table)
    console.print()
    console.print(_topics(summary))


def _facts(summary: "Summary", configured: bool) -> dict[str, str]:
    facts = {
        "session": f"{summary.path}, {summary.size_bytes / 1e6:.3g} MB",
        "state": _state(summary),
        "rig": summary.rig or "not named",
        "begins": _when(summary.first_ns),
        "lasts": f"{summary.duration_s:.3f} s",
        "messages": str(summary.messages),
        "configuration": "attached" if configured else "none",
        **{name.replace("_", " "): text for name, text in summary.metadata.items() if name != "rig"},
    }
    if summary.recorder:
        dropped = "unknown" if summary.dropped is None else f"{summary.dropped} messages"
        facts["not recorded"] = f"{dropped}, and what could not be read since" if summary.lost else dropped
        facts["ended"] = summary.recorder.get("ended", "unknown")
    return facts


def _state(summary: "Summary") -> str:
    lost = f": {summary.holes.words()} cannot be read" if summary.holes else ""
    if not summary.complete:
        return f"torn, damaged or still being written{lost}"
    if lost:
        return f"damaged{lost}"
    return "recovered, but not whole" if summary.lost else "complete"


def _when(time_ns: int) -> str:
    if time_ns < _UNIX_NS:
        return f"{time_ns / 1e9:.3f} s by a clock of its own"
    return datetime.fromtimestamp(time_ns / 1e9, UTC).isoformat(sep=" ", timespec="milliseconds")


def _topics(summary: "Summary") -> Table:
    table = Table("topic", "messages", "rate", "first", "last", box=None, padding=(0, 2, 0, 0))
    for column in table.columns[1:]:
        column.justify = "right"
    for topic in summary.topics:
        table.add_row(
            Text(printable(topic.topic)),
            str(topic.messages),
            f"{topic.rate_hz:.4g} Hz",
            *(f"{(time_ns - summary.first_ns) / 1e9:.3f} s" for time_ns in (topic.first_ns, topic.last_ns)),
        )
    return table
