"""The simulated rig on the air: one sample of each channel a slot, none left out."""

import csv
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vsensor.errors import InputError
from vsensor.grid import NS
from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.simulate.rig import Reading, SimulatedRig

TRUTH_COLUMNS = ("time_s", "bit_torque_nm", "bit_speed_rad_s")


def broadcast(
    rig: SimulatedRig,
    put: Callable[[str, Sample], object],
    turns: Iterator[int],
    *,
    samples: int,
    stopped: Callable[[], bool],
    truth: Path | None,
) -> int:
    """Publish `samples` readings (0: without end), the time stamps from the present on; returns how many.

    `turns` yields, whenever some are due, how many: what a late turn missed is made up for at once. Raises
    InputError where the `truth` cannot be written.
    """
    begun_ns = time.time_ns()
    done = 0
    with _truth(truth) as note:
        for due in turns:
            for _ in range(due):
                reading = rig.sample()
                time_ns = begun_ns + round(reading.time_s * NS)
                put(SURFACE_TORQUE, Sample(time_ns=time_ns, value=reading.motor_torque, sequence=done))
                put(SURFACE_SPEED, Sample(time_ns=time_ns, value=reading.motor_speed, sequence=done))
                note(reading, begun_ns)
                done += 1
                if done == samples:
                    return done
            if stopped():
                break
    return done


@contextmanager
def _truth(path: Path | None) -> Iterator[Callable[[Reading, int], None]]:
    if path is None:
        yield lambda _reading, _begun: None
        return
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(TRUTH_COLUMNS)

            def note(reading: Reading, begun_ns: int) -> None:
                time_s = (begun_ns + round(reading.bit_time_s * NS)) / NS
                writer.writerow((f"{time_s:.6f}", f"{reading.bit_torque:.3f}", f"{reading.bit_speed:.6f}"))

            yield note
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
