"""A session by columns: what the general reader says of each message, to the bit, and the same complaints."""

import struct
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.well_known import MessageEncoding
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from vsensor.errors import InputError
from vsensor.messages import (
    BIT_ESTIMATE,
    SENSOR_EVENT,
    SENSOR_TICK,
    STRING_PROFILE,
    SURFACE_SPEED,
    SURFACE_TORQUE,
    Estimate,
    Event,
    Message,
    Profile,
    Sample,
    Tick,
    message_type,
)
from vsensor.recording.columns import Columns, read_columns
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

GOLDEN = Path(__file__).parents[1] / "recordings" / "stick_slip.mcap"
TOPICS: dict[str, type[Message]] = {
    SURFACE_SPEED: Sample,
    SENSOR_TICK: Tick,
    BIT_ESTIMATE: Estimate,
    STRING_PROFILE: Profile,
}
FIELDS = {
    topic: [field.name for field in kind.DESCRIPTOR.fields if field.type != field.TYPE_STRING]
    for topic, kind in TOPICS.items()
}
Told = list[tuple[str, bytes]]


def write(path: Path, told: Told) -> Session:
    with SessionWriter(path, configuration="", metadata={"rig": "r"}, compression="lz4") as writer:
        for number, (topic, data) in enumerate(told):
            writer.write(topic, data, number, 2 * number)
            if number % 7 == 6:
                writer.sync()
    return Session(path)


def as_read(session: Session, topic: str) -> list[dict[str, object]]:
    """The columns of a topic as rows, floats by their bits, absent where a field is not set."""
    rows: list[dict[str, object]] = []
    for piece in read_columns(session, {topic: FIELDS[topic]}):
        if topic in piece:
            rows += (row_of(piece[topic], k) for k in range(len(piece[topic])))
    return rows


def row_of(columns: Columns, k: int) -> dict[str, object]:
    row: dict[str, object] = {}
    for name, values in columns.values.items():
        if values.ndim == 2:
            doubles = values[k].tolist()
            row[name] = [bits(value) for value in doubles]
        elif columns.known[name][k]:
            row[name] = bits(values[k].item())
        else:
            assert not values[k]
    return row


def as_told(message: Message, most: Mapping[str, int]) -> dict[str, object]:
    """The same by the general reader; lists filled up to the longest of the piece."""
    row: dict[str, object] = {}
    for field in message.DESCRIPTOR.fields:
        if field.type == field.TYPE_STRING:
            continue
        if field.is_repeated:
            given = list(getattr(message, field.name))
            row[field.name] = list(map(bits, given + [float("nan")] * (most[field.name] - len(given))))
        elif message.HasField(field.name):  # type: ignore[arg-type]
            row[field.name] = bits(getattr(message, field.name))
    return row


def bits(value: object) -> object:
    return struct.pack("<d", value) if isinstance(value, float) else value


def check(session: Session, topic: str) -> None:
    messages = [record.message for record in session.messages([topic])]
    repeated = [field.name for field in TOPICS[topic].DESCRIPTOR.fields if field.is_repeated]
    most = {name: max((len(getattr(message, name)) for message in messages), default=0) for name in repeated}
    assert as_read(session, topic) == [as_told(message, most) for message in messages]


@pytest.mark.parametrize("topic", [topic for topic in TOPICS if topic != STRING_PROFILE])
def test_a_whole_session_is_as_the_general_reader_has_it(topic: str) -> None:
    check(Session(GOLDEN), topic)


def test_lists_of_a_whole_session_too() -> None:
    session = Session(GOLDEN)
    profiles = [record.message for record in session.messages([STRING_PROFILE])]
    assert all(isinstance(profile, Profile) for profile in profiles)
    pieces = [
        piece[STRING_PROFILE]
        for piece in read_columns(session, {STRING_PROFILE: ["depth_m", "margin"]})
        if STRING_PROFILE in piece
    ]
    for name in ("depth_m", "margin"):
        found = np.concatenate([piece.values[name] for piece in pieces])
        assert found.tobytes() == np.array([list(getattr(profile, name)) for profile in profiles]).tobytes()


def messages_of(topic: str) -> st.SearchStrategy[bytes]:
    """Messages with any of their fields, and bytes of all kinds before, among and behind them."""
    kind = TOPICS[topic]
    parts = st.lists(st.one_of(*(field_bytes(field.number) for field in kind.DESCRIPTOR.fields)), max_size=12)
    strange = st.sampled_from(
        [
            b"\xf8\x07\x05",  # field 127, a number
            b"\xfa\x07\x03abc",  # field 127, bytes
            b"\x8a\x80\x00\x01x",  # field 1 by a tag longer than need be, another type
            b"\x0b\x0c",  # a group
            b"\x00\x01",  # field 0: no message
            b"\x09\x01\x02",  # a number that ends too soon
            b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",  # no tag
            b"\x88\x01" + b"\xff" * 9 + b"\x01",  # field 17, −1
            b"\x90\x01\x81\x00",  # field 18, a number longer than need be
        ]
    )
    return st.lists(st.one_of(parts.map(b"".join), strange), max_size=3).map(b"".join)


def field_bytes(number: int) -> st.SearchStrategy[bytes]:
    """A field of this number in some wire type, its own or another."""

    def tagged(wire: int) -> bytes:
        tag = number << 3 | wire
        return bytes([tag]) if tag < 128 else bytes([tag & 127 | 128, tag >> 7])

    eight = st.binary(min_size=8, max_size=8)
    return st.one_of(
        eight.map(lambda data: tagged(1) + data),
        st.binary(min_size=4, max_size=4).map(lambda data: tagged(5) + data),
        st.integers(0, 127).map(lambda value: tagged(0) + bytes([value])),
        st.lists(eight, max_size=5).map(lambda each: tagged(2) + bytes([8 * len(each)]) + b"".join(each)),
    )


def is_message(topic: str, data: bytes) -> bool:
    kind = message_type(topic)
    assert kind is not None
    try:
        kind.FromString(data)
    except Exception:
        return False
    return True


@given(st.data(), st.sampled_from(sorted(TOPICS)))
def test_whatever_the_bytes_columns_say_what_the_general_reader_says(data: st.DataObject, topic: str) -> None:
    sent = data.draw(st.lists(messages_of(topic), max_size=12))
    with tempfile.TemporaryDirectory() as folder:
        session = write(Path(folder) / "a.mcap", [(topic, message) for message in sent])
        if all(is_message(topic, message) for message in sent):
            check(session, topic)
            return
        complaints = []
        for read in (lambda: list(session.messages([topic])), lambda: as_read(session, topic)):
            with pytest.raises(InputError) as caught:
                read()
            complaints.append(str(caught.value))
        assert complaints[0] == complaints[1]


def test_places_and_times_are_the_files(tmp_path: Path) -> None:
    sent: Told = [
        (topic, Sample(value=1.0).SerializeToString())
        for topic in (SURFACE_TORQUE, SURFACE_SPEED, SURFACE_SPEED, SURFACE_TORQUE) * 5
    ]
    session = write(tmp_path / "a.mcap", sent)
    for topic in (SURFACE_TORQUE, SURFACE_SPEED):
        pieces = [piece[topic] for piece in read_columns(session, {topic: ()})]
        place = np.concatenate([piece.place for piece in pieces]).tolist()
        assert place == [number for number, (to, _) in enumerate(sent) if to == topic]
        assert np.concatenate([piece.log_time_ns for piece in pieces]).tolist() == place
        assert np.concatenate([piece.publish_time_ns for piece in pieces]).tolist() == [
            2 * at for at in place
        ]


def test_few_messages_can_be_had_whole(tmp_path: Path) -> None:
    event = Event(name="command", text="off bottom")
    sent = [(SURFACE_SPEED, b""), (SENSOR_EVENT, event.SerializeToString())]
    (piece,) = read_columns(write(tmp_path / "a.mcap", sent), {}, whole=[SENSOR_EVENT])
    assert piece[SENSOR_EVENT].messages == [event]
    assert piece[SENSOR_EVENT].place.tolist() == [1]


def test_messages_outside_of_chunks_are_read_too(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start()
        channel = writer.register_channel(
            SURFACE_SPEED, MessageEncoding.Protobuf, register_schema(writer, Sample)
        )
        for number in range(5):
            writer.add_message(channel, number, Sample(value=number).SerializeToString(), number)
        writer.finish()  # type: ignore[no-untyped-call]
    check(Session(tmp_path / "a.mcap"), SURFACE_SPEED)


def test_only_numbers_and_lists_of_doubles_are_columns(tmp_path: Path) -> None:
    session = write(tmp_path / "a.mcap", [(SENSOR_EVENT, b"")])
    with pytest.raises(ValueError, match=r"vsensor\.Event\.text is neither a number nor a list of doubles"):
        list(read_columns(session, {SENSOR_EVENT: ["text"]}))


@pytest.mark.parametrize("keep", [1.0, 0.7, 0.5, 0.2])
def test_of_a_torn_session_all_whole_chunks_are_read(tmp_path: Path, keep: float) -> None:
    sent: Sequence[tuple[str, bytes]] = [
        (SURFACE_SPEED, Sample(value=k).SerializeToString()) for k in range(70)
    ]
    path = write(tmp_path / "a.mcap", list(sent)).path
    path.write_bytes(path.read_bytes()[: int(keep * path.stat().st_size)])
    check(Session(path), SURFACE_SPEED)


def test_damage_is_told_as_by_the_general_reader(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap", [(SURFACE_SPEED, Sample(value=k).SerializeToString()) for k in range(70)]
    ).path
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(100, len(whole) - 100, 60).tolist():
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        told = []
        for read in (lambda s: list(s.messages([SURFACE_SPEED])), lambda s: as_read(s, SURFACE_SPEED)):
            try:
                read(Session(path))
                told.append("")
            except InputError as error:
                told.append(str(error))
        assert told[0] == told[1], place


def test_one_long_list_among_many_short_ones_takes_no_memory_for_all(tmp_path: Path) -> None:
    long = Profile(depth_m=[0.0] * 200_000).SerializeToString()
    session = write(tmp_path / "a.mcap", [(STRING_PROFILE, data) for data in (b"", long)])
    assert len(as_read(session, STRING_PROFILE)) == 2
    hostile = write(tmp_path / "b.mcap", [(STRING_PROFILE, long), *[(STRING_PROFILE, b"")] * 300])
    with pytest.raises(InputError, match=r"depth_m: lists of up to 200000 numbers in \d+ messages at once"):
        as_read(hostile, STRING_PROFILE)
