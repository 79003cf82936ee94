"""Tables through the sensor: the same however they are cut into chunks, with times to the nanosecond."""

import math

import numpy as np
import pytest

from tests.rigs import BEGUN_NS, NS, RATE, SHORT, Surface, samples, simulated
from vsensor import offline
from vsensor.messages import SURFACE_SPEED
from vsensor.offline import Offline
from vsensor.tables import ESTIMATE_FIELDS


def estimate(feed: Surface) -> dict[str, np.ndarray[tuple[int], np.dtype[np.generic]]]:
    chunks = list(Offline(SHORT).estimates(feed))
    return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in ESTIMATE_FIELDS}


@pytest.fixture(scope="module")
def broken() -> Surface:
    """Four seconds, the clock set an hour on, four more seconds."""
    readings = simulated(8)
    return samples(readings[: 4 * RATE]) + samples(readings[4 * RATE :], BEGUN_NS + 3600 * NS)


def test_times_are_the_doubles_nearest_to_the_nanoseconds() -> None:
    """Rounded once: as doubles before they are divided, Unix nanoseconds would be rounded to 256 first."""
    for begun_ns in (BEGUN_NS + 123_456_789, -987_654_321, 0):
        feed = samples(simulated(3), begun_ns)
        columns = estimate(feed)
        first = feed[0][1].time_ns
        expected = [(first + k * NS // RATE) / NS for k in range(3 * RATE)]
        assert columns["time_s"].tolist() == expected


def test_the_columns_are_those_of_an_estimates_table(broken: Surface) -> None:
    (chunk, *_) = Offline(SHORT).estimates(broken)
    assert tuple(chunk) == tuple(ESTIMATE_FIELDS)


@pytest.mark.parametrize("chunk", [1, 7, 199, 200, 201])
def test_however_it_is_cut_the_answers_are_the_same(
    broken: Surface, chunk: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = estimate(broken)
    monkeypatch.setattr(offline, "CHUNK", chunk)
    for name, column in estimate(broken).items():
        assert column.tobytes() == whole[name].tobytes(), name


def test_a_clock_that_was_set_begins_anew(broken: Surface) -> None:
    """What was learned of the rock stays, and tells in the answers."""
    columns = estimate(broken)
    jump = int(np.argmax(np.diff(columns["time_s"].astype(float)))) + 1
    alone = estimate(samples(simulated(8)[4 * RATE + 1 :], BEGUN_NS + 3600 * NS))
    for name, column in alone.items():
        if name in ("time_s", "confirmed_time_s"):
            assert columns[name][jump:].tobytes() == column.tobytes(), name
    answered = np.isfinite(alone["confirmed_torque_nm"].astype(float))
    assert answered.any()
    assert np.array_equal(answered, np.isfinite(columns["confirmed_torque_nm"][jump:].astype(float)))
    for name, unit in (("speed", "rad_s"), ("torque", "nm")):
        miss = columns[f"confirmed_{name}_{unit}"][jump:].astype(float) - alone[f"confirmed_{name}_{unit}"]
        assert np.all(abs(miss)[answered] <= 2 * alone[f"confirmed_{name}_std_{unit}"][answered])


def test_what_is_not_known_yet_is_nan_and_bad(broken: Surface) -> None:
    columns = estimate(broken)
    assert columns["quality"][0] == "bad"
    assert all(
        math.isnan(float(columns[name][0])) for name in ESTIMATE_FIELDS if name not in ("time_s", "quality")
    )
    assert columns["quality"][4 * RATE - 5] == "good"
    assert math.isfinite(float(columns["forecast_torque_nm"][4 * RATE - 5]))


def test_one_channel_alone_gives_no_row() -> None:
    feed = [(topic, sample) for topic, sample in samples(simulated(2)) if topic == SURFACE_SPEED]
    assert list(Offline(SHORT).estimates(feed)) == []
