"""The index at a session's end: what the mcap library reads of it, in memory that no chunk adds to."""

import tracemalloc
from pathlib import Path

import pytest
from mcap.reader import make_reader

from vsensor.messages import SURFACE_SPEED, SURFACE_TORQUE, Sample
from vsensor.recording.index import Index, read_index
from vsensor.recording.reader import Session
from vsensor.recording.whole import WholeReads
from vsensor.recording.writer import SessionWriter

GOLDEN = Path(__file__).parent.parent / "recordings" / "stick_slip.mcap"


def of_chunks(path: Path, chunks: int) -> Path:
    """A session with a chunk for each sample of torque, and of speed in the middle alone."""
    with SessionWriter(path, configuration="x", metadata={"rig": "r"}, compression="zstd") as writer:
        for number in range(chunks):
            topics = (SURFACE_TORQUE, SURFACE_SPEED)[: 2 if number == chunks // 2 else 1]
            for topic in topics:
                writer.write(topic, Sample(time_ns=number).SerializeToString(), number, number)
            writer.sync()
    return path


def index_of(path: Path) -> Index:
    with WholeReads(path) as file:
        index = read_index(file)
    assert index is not None
    return index


@pytest.mark.parametrize("golden", [True, False])
def test_it_is_what_the_library_reads(tmp_path: Path, golden: bool) -> None:
    path = GOLDEN if golden else of_chunks(tmp_path / "a.mcap", 7)
    ours = index_of(path)
    with path.open("rb") as file:
        reader = make_reader(file)
        theirs = reader.get_summary()
        noted = [*reader.iter_attachments(), *reader.iter_metadata()]
    assert theirs is not None
    assert (ours.schemas, ours.channels) == (theirs.schemas, theirs.channels)
    assert ours.statistics == theirs.statistics
    assert ours.noted == noted
    for channel in theirs.channels:
        places = [
            chunk.message_index_offsets[channel]
            for chunk in theirs.chunk_indexes
            if channel in chunk.message_index_offsets
        ]
        assert (ours.first[channel], ours.last[channel]) == (places[0], places[-1])


def test_a_longer_session_takes_no_more_memory(tmp_path: Path) -> None:
    def peak(chunks: int) -> int:
        path = of_chunks(tmp_path / f"{chunks}.mcap", chunks)
        index_of(path)  # what is made once and kept
        tracemalloc.start()
        Session(path)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    few, many = peak(20), peak(1000)
    assert many < few + 20_000  # bytes; what the library makes of it takes half a million


def test_an_index_that_points_elsewhere_makes_a_torn_session_of_it(tmp_path: Path) -> None:
    """Its messages are read all the same."""
    path = of_chunks(tmp_path / "a.mcap", 3)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    place = summary.attachment_indexes[0].offset.to_bytes(8, "little")
    data = path.read_bytes()
    at = data.rindex(place)
    path.write_bytes(
        data[:at] + summary.chunk_indexes[0].chunk_start_offset.to_bytes(8, "little") + data[at + 8 :]
    )

    session = Session(path)

    assert not session.complete
    assert session.configuration == "x"
    assert len(list(session.messages())) == 4
