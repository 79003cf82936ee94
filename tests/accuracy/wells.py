"""Simulated wells of many kinds: what the sensor makes of each.

    python -m tests.accuracy.wells [NAME ...] [--seed N]

prints it as text. Torques are in N·m there, and how far they are off in the mean is told too.
"""

from argparse import ArgumentParser
from collections.abc import Iterable, Iterator

import numpy as np

from tests.accuracy import words
from tests.accuracy.score import Score, answer, score
from tests.cases import Columns
from tests.leapfrog import Record
from tests.wells import CASES, Case, surface
from vsensor.config import Rig
from vsensor.offline import Offline
from vsensor.tables import SurfaceSamples

FROM_S = 10.0
KINDS = ("confirmed", "now", "forecast")
SMALL = 10.0
"""Torque, N·m, of which hundredths of a kN·m tell too little."""


def told(rig: Rig, record: Record) -> Columns:
    """The estimates table of a record."""
    chunks = list(Offline(rig).estimates(SurfaceSamples().of(surface(record))))
    return {name: np.concatenate([np.asarray(chunk[name]) for chunk in chunks]) for name in chunks[0]}


def truth(record: Record) -> Columns:
    """What was true downhole."""
    return {"time_s": record.time, "bit_torque_nm": record.bit_torque, "bit_speed_rad_s": record.bit_speed}


def scores(case: Case, seed: int = 1) -> list[Score]:
    """How each kind of answer does."""
    record = case.record(seed)
    return held(told(case.rig, record), record)


def held(estimates: Columns, record: Record) -> list[Score]:
    """Each kind of answer held against the truth."""
    return [score(answer(estimates, kind), truth(record), FROM_S) for kind in KINDS]


def section() -> Iterator[str]:
    """The page's part about them."""
    yield words.WELLS
    for case in CASES.values():
        yield f"| {case.words} | {' | '.join(cell for one in scores(case) for cell in cells(one))} |"


def cells(of: Score) -> tuple[str, ...]:
    """One answer's cells of a row."""
    torque = f"{of.torque / 1e3:{'.2f' if of.torque >= SMALL else '.2g'}}"
    return f"{of.share:.2%}", torque, f"{of.speed_within:.0%}", f"{of.torque_within:.0%}"


def _text(names: Iterable[str], seed: int) -> Iterator[str]:
    """The same as plain text, as it comes."""
    width = max(map(len, CASES))
    yield " " * width + "".join(f"  {kind:<31}" for kind in KINDS)
    yield " " * width + "   share     N·m    bias  2σω  2σT" * len(KINDS)
    for name in names:
        yield f"{name:<{width}}" + "".join(
            f"  {one.share:6.2%} {one.torque:7.4g} {one.bias:+7.3g} "
            f"{one.speed_within:4.0%} {one.torque_within:4.0%}"
            for one in scores(CASES[name], seed)
        )


def main() -> None:
    """Print the table of the named wells, or of all."""
    options = ArgumentParser(
        prog="python -m tests.accuracy.wells", description="What the sensor makes of simulated wells."
    )
    options.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(CASES)}; else all")
    options.add_argument("--seed", type=int, default=1, help="of noise and rock (default: 1)")
    asked = options.parse_args()
    for unknown in set(asked.names) - set(CASES):
        options.error(f"no well is called {unknown}: there are {', '.join(CASES)}")
    for line in _text(asked.names or CASES, asked.seed):
        print(line, flush=True)


if __name__ == "__main__":
    main()
