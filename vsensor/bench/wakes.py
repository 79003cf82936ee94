"""How late loops wake: the daemon's by its recorded ticks, a bare C loop's by its own word."""

import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vsensor.bench.compiler import build
from vsensor.errors import VsensorError
from vsensor.messages import Tick

Integers = NDArray[np.int64]
FLAGS = "-O3"


class Wakes(NamedTuple):
    """The turns of a loop on a grid of slots, and its books."""

    lateness_ns: Integers
    """Wake-up after the deadline, one a turn, shape (n,)."""
    due: int
    """Slots that passed."""
    skipped: int
    """Slots among them without a turn, since the one before had not ended."""

    def percentile_us(self, share: float) -> float:
        """Lateness that `share` per cent of the turns kept to, µs."""
        return float(np.percentile(self.lateness_ns, share)) / 1e3


def of_ticks(ticks: Iterable[Tick], due: int, skipped: int) -> Wakes:
    """The wake-ups that ran these ticks; several ticks of one slot are one."""
    slots = {tick.slot: tick.lateness_ns for tick in ticks}
    return Wakes(np.fromiter(slots.values(), np.int64, len(slots)), due, skipped)


def all_of(turns: Sequence[Wakes]) -> Wakes:
    """Several turns of one loop, together."""
    lateness, due, skipped = zip(*turns, strict=True)
    return Wakes(np.concatenate(lateness), sum(due), sum(skipped))


@contextmanager
def bare_loop(
    program: Path, rate_hz: float, seconds: float, scheduling: str = ""
) -> Iterator[Callable[[], Wakes]]:
    """Within, a loop in C does nothing but sleep to the same grid, as a process of its own.

    `scheduling` is what the daemon has, such as "SCHED_FIFO 40"; by default it is an ordinary process.
    Yields what waits for its end and tells of it; that raises VsensorError where it failed.
    """
    _, _, priority = scheduling.partition("SCHED_FIFO ")
    command = [str(program), repr(rate_hz), repr(seconds), priority or "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True) as process:
        try:
            yield lambda: _of_bare_loop(process)
        finally:
            process.kill()


def _of_bare_loop(process: subprocess.Popen[bytes]) -> Wakes:
    noted, _ = process.communicate()
    turns = np.frombuffer(noted, np.int64).reshape(-1, 2)
    if process.returncode or len(turns) == 0:
        raise VsensorError(f"the bare loop in C ended with status {process.returncode}")
    due = int(turns[-1, 0])
    return Wakes(turns[:, 1], due, due - len(turns))


def build_bare_loop(cc: str, folder: Path) -> Path:
    """Compile the bare loop into a folder."""
    program = folder / "wake"
    build(cc, "wake.c", FLAGS, program)
    return program
