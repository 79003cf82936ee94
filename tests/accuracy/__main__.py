"""Prints docs/accuracy.md from the cases and draws its pictures: `make accuracy`.

    python -m tests.accuracy FOLDER_OF_PICTURES

VSENSOR_REFERENCE_DATA and VSENSOR_FIELD_DATA name the folders of the cases.
"""

import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.accuracy import drawn, lumps, pictures, reference, sticks, tare, wells, words
from tests.accuracy.field import field
from tests.cases import folder
from vsensor.config import load

DRILLING = Path(__file__).parents[2] / "config" / "drilling.toml"


def page(images: Path) -> Iterator[str]:
    """The page's lines; the pictures are written into a folder on the way."""
    cases = reference.cases(folder("VSENSOR_REFERENCE_DATA"))
    sticking, smooth, _ = cases
    yield words.HEAD
    yield words.EXACT.format(choices=len(lumps.TUNINGS))
    for case in cases:
        yield from reference.exact(case)
    yield pictures.shown(pictures.at_work(sticking.right, sticking.surface, sticking.truth), images)
    yield from reference.limit(smooth)
    yield from wells.section()
    yield from drawn.section()
    slow, turned = (speed * reference.RPM for _, speed in tare.TURNED.speed[1::2])
    yield words.WRONG.format(tare=tare.FOR_S, slow=slow, turned=turned)
    for case in cases:
        yield from reference.wrong(case)
    yield words.SCRATCH
    for case in cases:
        yield from reference.scratch(case)
    rig = load(DRILLING)
    yield from sticks.section(((case.words, case.sticks) for case in cases), rig)
    yield words.LAG
    yield pictures.shown(pictures.lag(pictures.trade(rig), rig.estimator.lag), images)
    yield from field(folder("VSENSOR_FIELD_DATA"))


def main() -> None:
    """Print the page."""
    options = ArgumentParser(
        prog="python -m tests.accuracy", description="Print the page, draw its pictures."
    )
    options.add_argument("pictures", type=Path, help="the folder that the pictures are written into")
    try:
        for line in page(options.parse_args().pictures):
            print(line)
    except pytest.skip.Exception as missing:
        sys.exit(str(missing))


if __name__ == "__main__":
    main()
