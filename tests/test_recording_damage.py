"""One flipped bit costs what it hits: all else is saved, and what is lost is told."""

import struct
import tempfile
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from vsensor.errors import InputError
from vsensor.messages import SENSOR_TICK, SURFACE_TORQUE, Sample, Tick
from vsensor.recording.reader import Record, Session
from vsensor.recording.recover import recover
from vsensor.recording.scan import Scan
from vsensor.recording.writer import Compression, SessionWriter

CHUNKS, ROWS = 4, 8
COMPRESSIONS: tuple[Compression, ...] = ("zstd", "lz4", "none")


class Made:
    """A session of some chunks: its bytes, where each chunk begins, where the data end, its messages."""

    def __init__(self, compression: Compression) -> None:
        self.records: list[Record] = []
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.mcap"
            with SessionWriter(
                path, configuration="[rig]", metadata={"rig": "r"}, compression=compression
            ) as writer:
                self._write(writer)
            self.data = path.read_bytes()
            with path.open("rb") as file:
                summary = make_reader(file).get_summary()
        assert summary is not None
        self.chunks = [at.chunk_start_offset for at in summary.chunk_indexes]
        self.end = self.data.rindex(b"\x0f\x04" + bytes(7))

    def _write(self, writer: SessionWriter) -> None:
        for number in range(CHUNKS * ROWS):
            told = Tick(number=number) if number % 2 else Sample(sequence=number, value=number**0.5)
            topic = SENSOR_TICK if number % 2 else SURFACE_TORQUE
            writer.write(topic, told.SerializeToString(), number, number, sequence=number)
            self.records.append(Record(topic, told, number, number))
            if (number + 1) % ROWS == 0:
                writer.sync()

    def without(self, chunk: int) -> list[Record]:
        return self.records[: chunk * ROWS] + self.records[(chunk + 1) * ROWS :]


MADE = {compression: Made(compression) for compression in COMPRESSIONS}


def flipped(data: bytes, at: int, bit: int = 0) -> bytes:
    return data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]


@given(st.data())
def test_a_flipped_bit_costs_one_chunk_at_most(data: st.DataObject) -> None:
    made = MADE[data.draw(st.sampled_from(COMPRESSIONS))]
    whole = data.draw(st.booleans())
    begin = made.chunks[0 if whole else 1]  # where the first is lost, the end alone tells of the channels
    at = data.draw(st.integers(begin, made.end - 1))
    damaged = flipped(made.data, at, data.draw(st.integers(0, 7)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap.part"
        path.write_bytes(damaged if whole else damaged[: made.end])
        recovered = recover(path)
        found = list(Session(recovered.path).messages())
    assert found in (made.records, *(made.without(chunk) for chunk in range(CHUNKS))), at


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_what_a_damaged_chunk_has_cost_is_told_by_its_place(tmp_path: Path, chunk: int) -> None:
    made = MADE["zstd"]
    torn = tmp_path / "a.mcap"
    torn.write_bytes(flipped(made.data, made.chunks[chunk] + 100))
    recovered = recover(torn)
    assert list(Session(recovered.path).messages()) == made.without(chunk)
    (length,) = struct.unpack_from("<Q", made.data, made.chunks[chunk] + 1)
    assert recovered.lost_bytes == length + 9
    assert recovered.lost == f"{length + 9} bytes from byte {made.chunks[chunk]}, 8 of 32 messages"
    mended = Session(recovered.path)
    assert mended.metadata["could_not_be_read"] == recovered.lost
    assert (mended.configuration, mended.metadata["rig"]) == ("[rig]", "r")


def test_what_is_saved_is_as_it_stood(tmp_path: Path) -> None:
    made = MADE["none"]
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(made.data[: made.end])
    mended = recover(torn).path
    found, stood = ([message for _, _, message in Scan(path).messages()] for path in (mended, torn))
    assert found == stood
    assert [message.sequence for message in found] == [*range(CHUNKS * ROWS)]


def test_a_torn_one_is_read_past_what_is_damaged_in_it(tmp_path: Path) -> None:
    made = MADE["lz4"]
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(flipped(made.data, made.chunks[1] + 100)[: made.end - 3])
    session = Session(torn)
    assert list(session.messages())[: 2 * ROWS] == made.without(1)[: 2 * ROWS]
    assert f"bytes from byte {made.chunks[1]}, " in session.shortfall()
    assert session.summary().messages == 3 * ROWS


def test_channels_that_are_lost_are_had_from_the_end_of_a_file_that_is_torn(tmp_path: Path) -> None:
    made = MADE["zstd"]
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(flipped(made.data, made.chunks[0] + 100)[:-20])
    assert list(Session(recover(torn).path).messages()) == made.without(0)


def test_messages_of_which_nothing_tells_any_longer_are_counted(tmp_path: Path) -> None:
    made = MADE["zstd"]
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(flipped(made.data, made.chunks[0] + 100)[: made.end])
    with pytest.raises(InputError, match=r"part: nothing of it could be saved.* 24 messages of channels"):
        recover(torn)


def test_a_damaged_configuration_is_not_believed_and_costs_no_message(tmp_path: Path) -> None:
    made = MADE["zstd"]
    torn = tmp_path / "a.mcap"
    torn.write_bytes(flipped(made.data, made.data.index(b"[rig]") + 1))
    session = Session(torn)
    assert (session.configuration, session.metadata) == (None, {"rig": "r"})
    assert "bytes from byte" in str(session.lacks("holds no configuration"))
    recovered = Session(recover(torn).path)
    assert (recovered.configuration, recovered.metadata["rig"]) == (None, "r")
    assert list(recovered.messages()) == made.records


@pytest.mark.parametrize("rest", [b"", b"\r", bytes(92), bytes(3 << 20)], ids=len)
def test_of_nothing_no_session_is_made(tmp_path: Path, rest: bytes) -> None:
    torn = tmp_path / "a.mcap.part"
    torn.write_bytes(MADE["none"].data[: 8 if rest else 1] + rest)
    with pytest.raises(InputError, match=r"a\.mcap\.part: nothing of it could be saved"):
        recover(torn)
    assert list(tmp_path.iterdir()) == [torn]


def test_a_loss_before_is_not_forgotten_when_it_is_mended_again(tmp_path: Path) -> None:
    made = MADE["zstd"]
    torn = tmp_path / "a.mcap"
    torn.write_bytes(flipped(made.data, made.chunks[1] + 100))
    once = recover(torn)
    again = recover(once.path, tmp_path / "b.mcap")
    assert again.lost == ""
    assert Session(again.path).metadata["could_not_be_read"] == once.lost


def metadata(name: bytes) -> bytes:
    body = struct.pack("<I", len(name)) + name + struct.pack("<I", 0)
    return struct.pack("<BQ", 0x0C, len(body)) + body


def nested(size: int) -> bytes:
    """Records that lead to the end of the file, each with another behind its head."""
    piece = len(metadata(b"")) + 9
    return b"".join(
        metadata(b"") + struct.pack("<BQ", 0x90, size - piece * at - 5) for at in range(1, size // piece)
    )


@pytest.mark.parametrize(
    "rubbish",
    [nested(6 << 20), b"\x06" * (4 << 20), b"\x0f\x04" + bytes(7), (metadata(b"") + b"\x01") * (1 << 16)],
    ids=["nested", "chunks' opcodes", "an end", "broken in turn"],
)
def test_the_way_is_found_again_in_a_time_that_grows_with_the_file_alone(
    tmp_path: Path, rubbish: bytes
) -> None:
    made = MADE["zstd"]
    path = tmp_path / "a.mcap.part"
    path.write_bytes(made.data[: made.chunks[2]] + rubbish + made.data[made.chunks[2] : made.end])
    begun = time.process_time()
    scan = Scan(path, through=True)
    assert sum(1 for _ in scan.messages()) >= 2 * ROWS
    assert time.process_time() - begun < 20
    assert len(scan.holes.places) <= 8
    assert len(scan.holes.words()) < 1000
