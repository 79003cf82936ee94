"""The simulated wells again, told as wrongly as `[tuning]` says that they may be, drawn by chance.

    python -m tests.accuracy.drawn [NAME ...]

prints the page's part about them.
"""

import sys
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, qmc

from tests.accuracy import words
from tests.accuracy.score import Score
from tests.accuracy.wells import cells, held, told
from tests.accuracy.wrong import wrong_friction, wrong_inertia, wrong_string
from tests.wells import CASES, Case
from vsensor.config import Rig

DRAWS = 4
"""Of each well."""
SEED = 1
PARAMETERS = 4


def drawn(rig: Rig, deviations: NDArray[np.float64]) -> Rig:
    """The rig as told where truth is so many of the stated deviations beside it.

    Of delay, impedance, inertia and friction, shape (4,).
    """
    tuning = rig.tuning
    shares = np.array([tuning.delay, tuning.impedance, tuning.inertia, tuning.friction])
    delay, impedance, inertia, friction = (1.0 / (1.0 + shares * deviations)).tolist()
    return wrong_friction(wrong_inertia(wrong_string(rig, delay, impedance), inertia), friction)


def chances(wells: int) -> NDArray[np.float64]:
    """Normal deviations (wells, DRAWS, PARAMETERS), evenly spread over what is likely (McKay 1979)."""
    shares = qmc.LatinHypercube(PARAMETERS, rng=SEED).random(wells * DRAWS)
    return np.asarray(norm.ppf(shares)).reshape(wells, DRAWS, PARAMETERS)


def scores(case: Case, deviations: NDArray[np.float64]) -> list[Score]:
    """How each kind of answer does, over draws (n, 4): rms errors, mean shares within."""
    record = case.record(1)
    each = [held(told(drawn(case.rig, one), record), record) for one in deviations]
    return [_over(kinds) for kinds in zip(*each, strict=True)]


def section(names: Sequence[str] = tuple(CASES)) -> Iterator[str]:
    """The page's part about them."""
    yield words.DRAWN.format(draws=DRAWS)
    rows = []
    for name, deviations in zip(CASES, chances(len(CASES)), strict=True):
        if name in names:
            rows.append(scores(CASES[name], deviations))
            yield f"| {CASES[name].words} | {' | '.join(cell for one in rows[-1] for cell in cells(one))} |"
    yield f"| *mean* | {' | '.join(cell for kind in zip(*rows, strict=True) for cell in _mean(kind))} |"


def _mean(of: Sequence[Score]) -> tuple[str, ...]:
    """Over wells, as cells of a row: errors of one are not those of another."""
    speed, torque = (
        np.mean([getattr(one, name) for one in of]) for name in ("speed_within", "torque_within")
    )
    return "", "", f"{speed:.1%}", f"{torque:.1%}"


def _over(of: Sequence[Score]) -> Score:
    table = np.array(of)
    columns = Score(*np.sqrt(np.mean(table**2, axis=0)).tolist())
    within = np.mean(table, axis=0)
    return columns._replace(speed_within=float(within[-2]), torque_within=float(within[-1]))


if __name__ == "__main__":
    for line in section(tuple(sys.argv[1:]) or tuple(CASES)):
        print(line)
