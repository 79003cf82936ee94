"""A bar for a command that reads a file: how much of it is read, as the kernel knows.

So no reader needs to tell, and none can forget to: the way in which `pv --watchfd` shows it for any program.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

_OPEN, _PLACES = Path("/proc/self/fd"), Path("/proc/self/fdinfo")
_TIMES_A_SECOND = 4.0
"""The bar is drawn by a thread, which the work waits for."""


@contextmanager
def reading(source: Path, doing: str, console: Console) -> Iterator[None]:
    """Within, show how far `source` is read, where the console is a terminal; nothing of it stays."""
    with _Reading(
        TextColumn(escape(f"{doing} {source.name}")),
        BarColumn(bar_width=None),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
        refresh_per_second=_TIMES_A_SECOND,
        transient=True,
        disable=not console.is_terminal,
    ) as bar:
        bar.watch(source)
        yield


def place(source: Path) -> int:
    """How far this program is in the file, bytes; 0 where it has not opened it, or nobody tells."""
    wanted = source.resolve()
    for opened in _OPEN.iterdir() if _OPEN.exists() else ():
        with suppress(OSError):  # closed meanwhile
            if opened.readlink() == wanted:
                return int((_PLACES / opened.name).read_text(encoding="ascii").split()[1])
    return 0


class _Reading(Progress):
    """A bar that asks, whenever it is drawn, how far the file is read; until it is, it runs to and fro."""

    _source = Path()

    def watch(self, source: Path) -> None:
        """Have this file's."""
        self._source = source
        self.add_task("", total=None)

    def get_renderables(self) -> Iterable[RenderableType]:
        for task in self.tasks:
            if read := place(self._source):
                self.update(task.id, completed=read, total=max(read, self._source.stat().st_size))
        yield from super().get_renderables()
