"""What a view keeps for viewers that come late has an end, however long it runs."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

CODE = """
from pathlib import Path

import numpy as np

from tests.view_process import free_port
from vsensor.view import screen
from vsensor.view.batches import Points
from vsensor.view.blueprint import blueprint
from vsensor.view.place import Place
from vsensor.view.units import Units

def megabytes():
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if "VmRSS" in line)
    return int(line.split()[1]) / 1e3

screen._LIVE_MEMORY = "4MB"
place = Place("page", free_port(), free_port())
with screen.Screen("t", lambda reach: blueprint(30.0, Units(), reach), place) as shown:
    for turn in range(24_000):
        times = np.arange(10) + 10 * turn
        shown.send([Points("/line", times, np.random.default_rng(turn).normal(size=10))])
        if turn % 100 == 99:
            shown._recordings[-1].flush()  # what waits on its way is no memory that is kept
        if turn in (7_999, 23_999):
            print(megabytes())
"""


def test_once_the_memory_for_late_viewers_is_full_a_view_takes_no_more() -> None:
    """Of 16 000 columns more, which take 24 MB where nothing is forgotten, it keeps none."""
    run = subprocess.run(
        [sys.executable, "-c", CODE], check=True, capture_output=True, text=True, timeout=120
    )
    full, after = map(float, run.stdout.split())
    assert after - full < 8
