"""Whatever others hand us is read or refused by name, never more: files, words, states, messages.

Samples, quantities, configurations and torn sessions have their own: test_messages_surface, test_units,
test_config_faults, test_recording_torn.
"""

import io
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as arrow_parquet
import pytest
from google.protobuf.message import DecodeError
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs import SHORT, samples, simulated
from tests.test_intake import BEGUN, MS, SMALL, S, T
from vsensor.checkpoint import remembered, take_up, whole
from vsensor.commands import obey
from vsensor.depth import Depths
from vsensor.errors import InputError
from vsensor.estimator.estimator import LENGTH, Estimator
from vsensor.intake import Intake
from vsensor.messages import Sample, State
from vsensor.messages.topics import _TYPES, Message
from vsensor.service.engine import Engine
from vsensor.tables.surface import read_surface
from vsensor.view.stream import Stream

VERBS = (
    "off bottom",
    "on bottom",
    "by depths",
    "longer",
    "shorter",
    "longer 28.5 m",
    "-",
    "m",
    "ft",
    "1e400",
)
KINDS = ("csv", "parquet", "feather", "npz")
FOLDER: list[Path] = []


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One for all examples: Hypothesis takes no fixture that is made anew for each test."""
    FOLDER[:] = [tmp_path_factory.mktemp("fuzz")]
    return FOLDER[0]


@given(st.one_of(st.text(), st.lists(st.one_of(st.sampled_from(VERBS), st.text())).map(" ".join)))
def test_any_words_are_a_command_or_refused_and_then_nothing_has_changed(words: str) -> None:
    depths = Depths(SMALL)
    before = depths.save()
    try:
        assert obey(words, depths)
    except ValueError:
        assert depths.save() == before
    assert 0 < depths.length < math.inf


def surface_table() -> pa.Table:
    times = [k * 0.01 for k in range(50)]
    return pa.table({"time_s": times, "motor_torque_nm": times, "motor_speed_rad_s": times})


def written(kind: str) -> bytes:
    if kind == "npz":
        archive = io.BytesIO()
        times, torque, speed = map(np.asarray, surface_table().columns)
        np.savez(archive, time_s=times, motor_torque_nm=torque, motor_speed_rad_s=speed)
        return archive.getvalue()
    sink = pa.BufferOutputStream()
    if kind == "csv":
        arrow_csv.write_csv(surface_table(), sink)
    elif kind == "parquet":
        arrow_parquet.write_table(surface_table(), sink)
    else:
        with pa.ipc.new_file(sink, surface_table().schema) as file:
            file.write_table(surface_table())
    return bytes(sink.getvalue())


def read_or_refused(kind: str, data: bytes) -> None:
    file = FOLDER[0] / f"table.{kind}"
    file.write_bytes(data)
    try:
        table = read_surface(file)
    except InputError as error:
        if file.name not in str(error):
            raise
        return
    assert not any(math.isinf(value) for value in table.motor_torque_nm)


@given(st.sampled_from(KINDS), st.binary())
def test_any_bytes_are_a_table_or_refused(kind: str, data: bytes) -> None:
    read_or_refused(kind, data)


# Arrow tells of a ragged row that is no text by a warning of its own, and then refuses the file.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@given(st.sampled_from(KINDS), st.data())
def test_a_damaged_table_is_read_or_refused(kind: str, data: st.DataObject) -> None:
    good = bytearray(written(kind))
    for _ in range(data.draw(st.integers(1, 8))):
        good[data.draw(st.integers(0, len(good) - 1))] = data.draw(st.integers(0, 255))
    read_or_refused(kind, bytes(good[: data.draw(st.integers(0, len(good)))]))


values: st.SearchStrategy[Any] = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(), inner, max_size=4)),
)


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(SMALL)


@pytest.fixture(scope="module")
def remembered_state(estimator: Estimator) -> bytes:
    intake = Intake(SMALL)
    for number in range(20):
        for topic in (T, S):
            intake.take(topic, Sample(time_ns=BEGUN + number * MS, value=1.0, sequence=number))
    return whole(*remembered(intake, estimator)).SerializeToString()


@given(data=st.data())
def test_a_state_that_does_not_fit_is_refused(
    remembered_state: bytes, estimator: Estimator, data: st.DataObject
) -> None:
    """One value of it is another, or one array: of another version, or damaged."""
    state = State.FromString(remembered_state)
    held: Any = json.loads(state.intake)
    part = held
    while True:
        key = data.draw(st.sampled_from(sorted(part)))
        if not (isinstance(part[key], dict) and part[key] and data.draw(st.booleans())):
            break
        part = part[key]
    part[key] = data.draw(values)
    state.intake = json.dumps(held)
    if data.draw(st.booleans()):
        array = data.draw(st.sampled_from(list(state.arrays)))
        array.dtype = data.draw(st.one_of(st.text(), st.sampled_from(["<f8", "O", "<i4", "V3", "<M8[ns]"])))
        array.data = data.draw(st.one_of(st.just(array.data), st.binary()))
        array.shape[:] = data.draw(st.lists(st.integers(0, 2**32 - 1), max_size=3))
    try:
        take_up(state, Intake(SMALL), estimator)
    except ValueError:
        return


@pytest.fixture(scope="module")
def drilling() -> bytes:
    """Remembered while all is learned, just before the configuration is corrected."""
    readings = simulated(24.5)
    engine = Engine(SHORT)
    for topic, sample in samples(readings):
        list(engine.take(topic, sample))
    return whole(*remembered(engine.intake, engine.estimator)).SerializeToString()


@pytest.fixture(scope="module")
def other() -> Estimator:
    return Estimator(SHORT)


numbers = st.one_of(
    st.binary(min_size=8, max_size=8),
    st.floats().map(lambda value: struct.pack("<d", value)),
    st.sampled_from([0.0, 1e-300, -1e-9, 1e12, -1e12]).map(lambda value: struct.pack("<d", value)),
    st.one_of(st.integers(-2, 3000), st.integers(-(1 << 63), (1 << 63) - 1)).map(
        lambda value: struct.pack("<q", value)
    ),
)


@given(data=st.data())
def test_a_state_of_other_numbers_is_refused_or_can_be_gone_on_with(
    drilling: bytes, other: Estimator, data: st.DataObject
) -> None:
    """Of the right names, types and shapes, and harmful all the same: no kernel looks where it should not."""
    state = State.FromString(drilling)
    arrays = {array.name: array for array in state.arrays if array.name != LENGTH}  # lays all out anew
    for name in data.draw(st.lists(st.sampled_from(sorted(arrays)), min_size=1, max_size=3)):
        array = arrays[name]
        held = bytearray(array.data)
        many = data.draw(st.booleans())
        for place in data.draw(st.lists(st.integers(0, len(held) // 8 - 1), min_size=1, max_size=4)):
            number = data.draw(numbers)
            held[8 * place :] = number * (len(held) // 8 - place) if many else number + held[8 * place + 8 :]
        array.data = bytes(held)
    try:
        take_up(state, Intake(SHORT), other)
    except ValueError:
        return
    for _ in range(50):
        values, _reasons = other.step(3e3, 9.0)
        assert not np.isinf(values).any()
    other.profile()


@given(st.sampled_from(sorted(_TYPES)), st.binary())
def test_any_message_can_be_shown(topic: str, data: bytes) -> None:
    stream = Stream()
    try:
        message: Message = _TYPES[topic].FromString(data)
    except DecodeError:
        return
    if not stream.falls_back(message):
        stream.take(message)
    list(stream.batches())
