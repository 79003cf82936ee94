"""Sessions written: what stands in the file, under which name, and what is refused."""

from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from vsensor.errors import ConfigError, InputError
from vsensor.messages import BIT_ESTIMATE, SURFACE_SPEED, SURFACE_TORQUE, Estimate, Sample
from vsensor.recording.reader import Record, Session
from vsensor.recording.writer import Compression, SessionWriter

METADATA = {"rig": "well-b", "vsensor": "0.0"}


def writer(path: Path, compression: Compression = "zstd", configuration: str = "[rig]\n") -> SessionWriter:
    return SessionWriter(path, configuration=configuration, metadata=METADATA, compression=compression)


def sample(number: int) -> Sample:
    return Sample(time_ns=number * 10_000_000, value=float(number), sequence=number)


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_a_session_reads_back_as_it_was_written(tmp_path: Path, compression: Compression) -> None:
    path = tmp_path / "a.mcap"
    written = []
    with writer(path, compression) as session:
        for number in range(1000):
            message = Estimate(number=number, time_ns=number, now_bit_speed_rad_s=0.1 * number)
            topic = SURFACE_TORQUE if number % 2 else BIT_ESTIMATE
            told = sample(number) if number % 2 else message
            session.write(topic, told.SerializeToString(), 2 * number, number)
            written.append(Record(topic, told, 2 * number, number))

    read = Session(path)

    assert list(read.messages()) == written
    assert read.complete
    assert read.configuration == "[rig]\n"
    assert read.metadata == METADATA


def test_messages_stay_in_the_order_of_arrival_though_their_times_do_not(tmp_path: Path) -> None:
    times = [5, 3, 9, 1, 7]
    with writer(tmp_path / "a.mcap") as session:
        for time_ns in times:
            session.write(SURFACE_TORQUE, sample(time_ns).SerializeToString(), time_ns, time_ns)
            session.sync()

    assert [record.log_time_ns for record in Session(tmp_path / "a.mcap").messages()] == times


def test_other_programs_can_decode_it_by_the_schema_in_it(tmp_path: Path) -> None:
    with writer(tmp_path / "a.mcap") as session:
        session.write(SURFACE_SPEED, sample(3).SerializeToString(), 1, 2, sequence=3)

    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        ((schema, channel, message, decoded),) = reader.iter_decoded_messages()

    assert schema is not None
    assert (schema.name, schema.encoding) == ("vsensor.Sample", "protobuf")
    assert (channel.topic, channel.message_encoding) == (SURFACE_SPEED, "protobuf")
    assert (message.log_time, message.publish_time, message.sequence) == (1, 2, 3)
    assert (decoded.value, decoded.sequence) == (3.0, 3)


def test_it_bears_its_name_only_when_it_is_complete(tmp_path: Path) -> None:
    session = writer(tmp_path / "a.mcap")
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap.part"]
    session.close()
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap"]


def test_one_that_broke_off_keeps_its_unfinished_name(tmp_path: Path) -> None:
    def breaks_off() -> None:
        with writer(tmp_path / "a.mcap") as session:
            session.write(SURFACE_TORQUE, sample(1).SerializeToString(), 1, 1)
            session.sync()
            session.write(SURFACE_TORQUE, sample(2).SerializeToString(), 2, 2)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        breaks_off()

    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap.part"]
    assert [r.log_time_ns for r in Session(tmp_path / "a.mcap.part").messages()] == [1]


def test_configuration_and_metadata_are_on_the_disk_before_any_message(tmp_path: Path) -> None:
    session = writer(tmp_path / "a.mcap")
    torn = Session(session.part)
    session.close()

    assert not torn.complete
    assert (torn.configuration, torn.metadata) == ("[rig]\n", METADATA)


def test_synced_messages_can_be_read_while_it_is_being_written(tmp_path: Path) -> None:
    with writer(tmp_path / "a.mcap") as session:
        session.write(SURFACE_TORQUE, sample(1).SerializeToString(), 1, 1)
        session.sync()
        found = list(Session(session.part).messages())

    assert [record.message for record in found] == [sample(1)]


@pytest.mark.parametrize("taken", ["a.mcap", "a.mcap.part"])
def test_no_session_is_written_over(tmp_path: Path, taken: str) -> None:
    (tmp_path / taken).write_bytes(b"precious")

    with pytest.raises(InputError, match=rf"{taken}: exists already"):
        writer(tmp_path / "a.mcap")

    assert (tmp_path / taken).read_bytes() == b"precious"


def test_a_name_that_is_no_sessions_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"must end in \.mcap"):
        writer(tmp_path / "a.csv")


@pytest.mark.parametrize("folder", ["file", "file/sessions"])
def test_a_file_in_the_place_of_the_folder_is_named(tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(
        InputError, match=rf"a\.mcap\.part: cannot be .*: a file is in the way of .*/{folder}$"
    ):
        writer(tmp_path / folder / "a.mcap")


def test_missing_folders_are_made(tmp_path: Path) -> None:
    writer(tmp_path / "one" / "two" / "a.mcap").close()
    assert Session(tmp_path / "one" / "two" / "a.mcap").complete


def test_a_topic_without_a_message_is_refused(tmp_path: Path) -> None:
    with writer(tmp_path / "a.mcap") as session, pytest.raises(ValueError, match="'rig/colour'"):
        session.write("rig/colour", b"", 0, 0)


@pytest.mark.parametrize("time_ns", [-1, -(1 << 63), (1 << 64) + 5])
def test_a_time_that_the_format_cannot_hold_does_not_stop_the_recording(tmp_path: Path, time_ns: int) -> None:
    wild = Sample(time_ns=-5, value=1.0)
    with writer(tmp_path / "a.mcap") as session:
        session.write(SURFACE_TORQUE, wild.SerializeToString(), time_ns, time_ns)

    (record,) = Session(tmp_path / "a.mcap").messages()

    assert record.message == wild
    nearest = min(max(time_ns, 0), (1 << 64) - 1)
    assert (record.log_time_ns, record.publish_time_ns) == (nearest, nearest)


def test_a_folder_that_nobody_may_look_into_does_not_end_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.mcap"
    with writer(path) as session:
        with monkeypatch.context() as closed:
            closed.setattr(Path, "stat", refused)
            session.write(SURFACE_TORQUE, Sample(value=1.0).SerializeToString(), 1, 1)
            session.sync()
        session.write(SURFACE_TORQUE, Sample(value=2.0).SerializeToString(), 2, 2)
    assert Session(path).summary().messages == 2


def refused(path: Path) -> None:
    raise PermissionError(13, "Permission denied", str(path))
