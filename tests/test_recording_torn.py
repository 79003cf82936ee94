"""Torn and damaged sessions: what survived is read, and nothing else is believed."""

import struct
import tempfile
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode

from vsensor.errors import InputError
from vsensor.messages import SENSOR_TICK, SURFACE_TORQUE, Sample, Tick
from vsensor.recording.reader import Record, Session
from vsensor.recording.recover import recover
from vsensor.recording.writer import Compression, SessionWriter

CHUNKS, ROWS = 3, 8
COMPRESSIONS: tuple[Compression, ...] = ("zstd", "lz4", "none")


def session_of(compression: Compression) -> tuple[bytes, list[int], list[Record]]:
    """A session's bytes, how many of them make 0, 1, … chunks safe, and its messages."""
    sizes, records = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        with SessionWriter(path, configuration="c", metadata={"rig": "r"}, compression=compression) as writer:
            sizes.append(writer.part.stat().st_size)
            for number in range(CHUNKS * ROWS):
                tick = Tick(number=number, motor_torque_nm=number**0.5)
                told = tick if number % 2 else Sample(sequence=number, value=number**0.5)
                topic = SENSOR_TICK if number % 2 else SURFACE_TORQUE
                writer.write(topic, told.SerializeToString(), number, number)
                records.append(Record(topic, told, number, number))
                if (number + 1) % ROWS == 0:
                    writer.sync()
                    sizes.append(writer.part.stat().st_size)
        return path.read_bytes(), sizes, records


WHOLE = {compression: session_of(compression) for compression in COMPRESSIONS}


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("offset", range(5))
def test_cut_anywhere_every_whole_chunk_is_read_and_nothing_of_a_torn_one(
    tmp_path: Path, compression: Compression, offset: int
) -> None:
    data, sizes, records = WHOLE[compression]
    path = tmp_path / "a.mcap.part"
    for cut in (*range(1 + offset, len(data), 50), len(data) - 1 - offset):
        path.write_bytes(data[:cut])
        session = Session(path)
        found = list(session.messages())
        safe = ROWS * max(sum(size <= cut for size in sizes) - 1, 0)
        assert found == records[: len(found)], cut
        assert len(found) in (safe, safe + ROWS), cut  # the latter: whole but for its index
        assert not session.complete, cut
        assert session.summary().messages == len(found), cut
        if cut >= sizes[0]:
            assert (session.configuration, session.metadata) == ("c", {"rig": "r"}), cut


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_damage_anywhere_gives_sound_messages_or_a_clear_refusal(data: st.DataObject) -> None:
    whole, _, records = WHOLE[data.draw(st.sampled_from(COMPRESSIONS))]
    damaged = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        path.write_bytes(damaged)
        complete, found = read(path)
    if complete:
        assert found == records
    rest = iter(records)
    assert all(any(record == one for one in rest) for record in found)  # sound ones, in order


def read(path: Path) -> tuple[bool, list[Record]]:
    """Whether a file was read as a complete session, and its messages; a refusal must name the file."""
    found: list[Record] = []
    try:
        session = Session(path)
        session.summary()
        found.extend(session.messages())
    except InputError as error:
        if str(path) not in str(error):
            raise
        return False, found
    return session.complete, found


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=2000))
def test_what_follows_the_magic_may_be_anything(rubbish: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        path.write_bytes(WHOLE["none"][0][:8] + rubbish)
        session = Session(path)
        assert not session.complete
        assert list(session.messages()) == []


@pytest.mark.parametrize("opcode", [Opcode.MESSAGE, Opcode.CHUNK, Opcode.ATTACHMENT, Opcode.METADATA, 0x7F])
@pytest.mark.parametrize("length", [(1 << 32) - 1, (1 << 63) - 1])
def test_a_damaged_length_costs_no_memory(tmp_path: Path, opcode: int, length: int) -> None:
    data, sizes, records = WHOLE["zstd"]
    path = tmp_path / "a.mcap.part"
    # A length of 2³² − 1 is within the library's own limit; what follows reads as lengths too.
    path.write_bytes(data[: sizes[1]] + struct.pack("<BQ", opcode, length) + b"\xff\xff\xff\x7f" * 100)
    tracemalloc.start()
    try:
        found = list(Session(path).messages())
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert found == records[:ROWS]
    assert peak < 10_000_000


def test_zeros_after_a_power_cut_are_no_messages(tmp_path: Path) -> None:
    data, sizes, records = WHOLE["zstd"]
    path = tmp_path / "a.mcap.part"
    path.write_bytes(data[: sizes[2]] + bytes(100_000))

    assert list(Session(path).messages()) == records[: 2 * ROWS]
    assert Session(path).summary().holes.lost_bytes == 100_000


def test_a_recovered_session_is_complete_and_the_torn_one_is_kept(tmp_path: Path) -> None:
    data, sizes, records = WHOLE["lz4"]
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(data[: sizes[2] + 11])

    recovered = recover(torn)

    assert recovered.path == tmp_path / "a.mcap"
    assert (recovered.messages, recovered.lost_bytes) == (2 * ROWS, 11)
    session = Session(recovered.path)
    assert session.complete
    assert list(session.messages()) == records[: 2 * ROWS]
    assert session.configuration == "c"
    assert session.metadata == {
        "rig": "r",
        "recovered_from": "a.mcap.part",
        "could_not_be_read": f"11 bytes from byte {sizes[2]}",
    }
    assert torn.read_bytes() == data[: sizes[2] + 11]
    assert {p.name for p in tmp_path.iterdir()} == {"a.mcap", "a.mcap.part"}


def test_a_damaged_session_is_recovered_under_another_name(tmp_path: Path) -> None:
    data, sizes, records = WHOLE["zstd"]
    (tmp_path / "a.mcap").write_bytes(data[: sizes[1] + 40] + b"xxxx" + data[sizes[1] + 44 :])

    recovered = recover(tmp_path / "a.mcap")

    assert recovered.path == tmp_path / "a.recovered.mcap"
    assert list(Session(recovered.path).messages()) == records[:ROWS] + records[2 * ROWS :]


def test_a_session_that_was_whole_loses_nothing(tmp_path: Path) -> None:
    data, _, records = WHOLE["zstd"]
    (tmp_path / "a.mcap.part").write_bytes(data)  # complete, but the machine died before it got its name

    recovered = recover(tmp_path / "a.mcap.part")

    assert (recovered.messages, recovered.lost_bytes) == (len(records), 0)


def test_recovery_writes_over_nothing(tmp_path: Path) -> None:
    (tmp_path / "a.mcap.part").write_bytes(WHOLE["zstd"][0][:-3])
    (tmp_path / "a.mcap").write_bytes(b"precious")

    with pytest.raises(InputError, match="exists already"):
        recover(tmp_path / "a.mcap.part")

    assert (tmp_path / "a.mcap").read_bytes() == b"precious"
