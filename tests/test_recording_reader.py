"""Sessions read: what a file that is none is told to be, and what one is summed up to."""

from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.well_known import MessageEncoding
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from vsensor.errors import InputError
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, SURFACE_TORQUE, Estimate, Sample
from vsensor.recording.reader import Session
from vsensor.recording.writer import RECORDER, SessionWriter


def session_file(path: Path, chunks: int = 3, rows: int = 20) -> Path:
    with SessionWriter(path, configuration="x", metadata={"rig": "r"}, compression="zstd") as writer:
        for number in range(chunks * rows):
            time_ns = 1_000_000_000 + number * 10_000_000
            writer.write(SURFACE_TORQUE, Sample(time_ns=time_ns, value=1).SerializeToString(), time_ns, 0)
            if number % 2:
                writer.write(BIT_ESTIMATE, Estimate(number=number).SerializeToString(), time_ns, 0)
            if (number + 1) % rows == 0:
                writer.sync()
    return path


def foreign_file(path: Path, topic: str, schema: str = "foxglove.Image") -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema_id = writer.register_schema(schema, "jsonschema", b"{}")
        channel = writer.register_channel(topic, "json", schema_id)
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", r"is empty \(0 bytes\)"),
        (b"time_s,motor_torque_nm\n", r"is no MCAP file \(it begins with b'time_s,m'\)"),
        (b"PAR1", "is no MCAP file"),
    ],
)
def test_what_is_no_mcap_is_said_to_be_none(tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.mcap: {said}.*a session written by vsensor"):
        Session(tmp_path / "a.mcap")


def test_a_folder_is_no_session(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        Session(tmp_path)


def test_a_missing_file_is_said_to_miss(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        Session(tmp_path / "a.mcap")


def test_an_mcap_of_another_program_is_described(tmp_path: Path) -> None:
    path = foreign_file(tmp_path / "a.mcap", "/camera")
    with pytest.raises(InputError, match=r"holds /camera \(foxglove\.Image, json\)"):
        Session(path)


def test_an_mcap_without_anything_of_ours_is_no_session(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(InputError, match="holds no messages"):
        Session(tmp_path / "a.mcap")


def test_our_topic_with_another_schema_is_refused(tmp_path: Path) -> None:
    path = foreign_file(tmp_path / "a.mcap", SURFACE_TORQUE, "rig.Torque")
    with pytest.raises(InputError, match=r"surface/torque holds rig\.Torque, json, where vsensor\.Sample"):
        Session(path)


def test_foreign_topics_beside_ours_are_passed_over(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        ours = writer.register_channel(
            SURFACE_TORQUE, MessageEncoding.Protobuf, register_schema(writer, Sample)
        )
        theirs = writer.register_channel("/camera", "json", writer.register_schema("I", "jsonschema", b"{}"))
        for channel, data in ((theirs, b"{}"), (ours, Sample(value=4).SerializeToString()), (theirs, b"{}")):
            writer.add_message(channel, 0, data, 0)
        writer.finish()  # type: ignore[no-untyped-call]

    session = Session(tmp_path / "a.mcap")

    assert [record.message for record in session.messages()] == [Sample(value=4)]
    assert session.metadata == {}
    assert session.configuration is None


def test_only_the_topics_asked_for_come(tmp_path: Path) -> None:
    session = Session(session_file(tmp_path / "a.mcap"))
    assert {record.topic for record in session.messages()} == {SURFACE_TORQUE, BIT_ESTIMATE}
    assert {record.topic for record in session.messages([BIT_ESTIMATE])} == {BIT_ESTIMATE}
    assert list(session.messages([SURFACE_SPEED])) == []


def test_a_message_that_cannot_be_decoded_is_named(tmp_path: Path) -> None:
    with SessionWriter(
        tmp_path / "a.mcap", configuration="", metadata={"rig": "r"}, compression="none"
    ) as writer:
        for data in (Sample(value=1).SerializeToString(), b"\xff\xff\xff"):
            writer.write(SURFACE_SPEED, data, 0, 0)

    with pytest.raises(
        InputError, match=r"a\.mcap: surface/speed, message 2: cannot be decoded as vsensor\."
    ):
        list(Session(tmp_path / "a.mcap").messages())


@pytest.mark.parametrize("within", ["chunk", "frame"])
def test_damage_within_a_complete_file_is_an_error_and_not_the_end(tmp_path: Path, within: str) -> None:
    path = session_file(tmp_path / "a.mcap")
    data = bytearray(path.read_bytes())
    with path.open("rb") as file:
        index = make_reader(file).get_summary()
    assert index is not None
    at = index.chunk_indexes[1].chunk_start_offset + (100 if within == "chunk" else 0)  # 0: its opcode
    data[at] ^= 0xFF
    path.write_bytes(data)

    with pytest.raises(InputError, match=r"is damaged after byte \d+: .*vsensor recover"):
        list(Session(path).messages())


def test_a_summary_tells_counts_times_and_rates(tmp_path: Path) -> None:
    summary = Session(session_file(tmp_path / "a.mcap")).summary()

    assert (summary.rig, summary.complete, summary.messages) == ("r", True, 90)
    assert summary.duration_s == pytest.approx(0.59)
    estimate, torque = summary.topics
    assert (torque.topic, torque.messages, torque.first_ns) == (SURFACE_TORQUE, 60, 1_000_000_000)
    assert torque.rate_hz == pytest.approx(100.0)
    assert (estimate.topic, estimate.messages) == (BIT_ESTIMATE, 30)
    assert estimate.rate_hz == pytest.approx(50.0)


def test_index_and_reading_through_sum_up_alike(tmp_path: Path) -> None:
    path = session_file(tmp_path / "a.mcap")
    indexed = Session(path).summary()
    path.write_bytes(path.read_bytes()[:-1])
    read = Session(path).summary()

    assert (indexed.complete, read.complete) == (True, False)
    assert read.topics == indexed.topics


@pytest.mark.parametrize(
    ("noted", "dropped"),
    [
        ({"dropped_by_daemon": "3", "dropped_by_recorder": "4"}, 7),
        ({"dropped_by_daemon": "unknown", "dropped_by_recorder": "4"}, None),
        ({}, None),
    ],
)
def test_drops_are_summed_up_where_they_are_known(
    tmp_path: Path, noted: dict[str, str], dropped: int | None
) -> None:
    with SessionWriter(tmp_path / "a.mcap", configuration="", metadata={}, compression="none") as writer:
        writer.write(SURFACE_SPEED, b"", 0, 0)
        writer.note(RECORDER, noted)

    assert Session(tmp_path / "a.mcap").summary().dropped == dropped
