"""A file's records read whole: what stands there, wherever the room ends in which they are read; or none."""

import tempfile
from itertools import accumulate
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.exceptions import EndOfFile

from vsensor.recording import whole
from vsensor.recording.whole import HEAD, WholeReads

ROOM = 64
lengths = st.lists(st.integers(0, 3 * ROOM), min_size=1, max_size=20)


def records(sizes: list[int]) -> list[bytes]:
    """Records of so many bytes of content, no two alike."""
    return [HEAD.pack(k, size) + bytes((k + j) % 251 for j in range(size)) for k, size in enumerate(sizes)]


def read(path: Path, place: int = 0) -> list[bytes]:
    """The records from a place on, as far as they go."""
    found: list[bytes] = []
    with WholeReads(path) as file:
        file.seek(place)
        while True:
            begin = file.tell()
            try:
                opcode, content = file.record()
            except EndOfFile:
                return found
            found.append(HEAD.pack(opcode, len(content)) + bytes(content))
            assert file.tell() - begin == len(found[-1])


def begins(path: Path) -> list[int]:
    """Where each record begins that is read while those of kind 2 are passed over, and where it ends."""
    found = []
    with WholeReads(path) as file:
        while True:
            found.append(file.tell())
            try:
                file.record()
            except EndOfFile:
                return found
            file.pass_over(2)


@given(lengths, st.data())
def test_records_are_read_as_far_as_they_are_whole(sizes: list[int], data: st.DataObject) -> None:
    told = records(sizes)
    kept = data.draw(st.integers(0, sum(map(len, told))))
    ends = list(accumulate(map(len, told)))
    sound = sum(end <= kept for end in ends)
    first = data.draw(st.integers(0, sound))
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(whole, "ROOM_BYTES", ROOM)
        path = Path(folder) / "a"
        path.write_bytes(b"".join(told)[:kept])
        assert read(path) == told[:sound]
        assert read(path, place=[0, *ends][first]) == told[first:sound]


@given(st.lists(st.tuples(st.sampled_from([1, 2]), st.integers(0, ROOM)), min_size=1, max_size=20), st.data())
def test_only_whole_records_of_that_kind_are_passed_over(
    told: list[tuple[int, int]], data: st.DataObject
) -> None:
    ends = [0, *accumulate(HEAD.size + size for _, size in told)]
    kept = data.draw(st.integers(0, ends[-1]))
    sound = [kind for (kind, _), end in zip(told, ends[1:], strict=True) if end <= kept]
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(whole, "ROOM_BYTES", ROOM)
        path = Path(folder) / "a"
        path.write_bytes(b"".join(HEAD.pack(kind, size) + bytes(size) for kind, size in told)[:kept])
        *read, stopped = map(ends.index, begins(path))
        assert stopped == len(sound)  # at the tear
        assert {number for number, kind in enumerate(sound) if kind == 1} <= set(read)


@pytest.mark.parametrize("missing", range(12))
def test_a_crowd_of_records_is_passed_over_at_once_up_to_the_tear(tmp_path: Path, missing: int) -> None:
    path = tmp_path / "a"
    size = HEAD.size + 3
    data = HEAD.pack(1, 0) + 100 * (HEAD.pack(2, 3) + b"abc")
    path.write_bytes(data[: len(data) - missing])
    assert begins(path) == [0, len(data) - (size if missing else 0)]


def test_bytes_from_the_end_and_those_behind_a_record_are_read(tmp_path: Path) -> None:
    (record,) = records([3 * whole.ROOM_BYTES])
    path = tmp_path / "a"
    path.write_bytes(record + b"magic")
    with WholeReads(path) as file:
        assert len(file.record()[1]) == 3 * whole.ROOM_BYTES
        assert file.read(5) == b"magic"
        with pytest.raises(EndOfFile):
            file.read(1)
        file.seek_from_end(4)
        assert file.read(4) == b"agic"
        with pytest.raises(EndOfFile):
            file.seek_from_end(len(record) + 6)


def test_a_file_that_shrinks_while_it_is_read_has_ended(tmp_path: Path) -> None:
    told = records([whole.ROOM_BYTES] * 3)
    path = tmp_path / "a"
    path.write_bytes(b"".join(told))
    with WholeReads(path) as file:
        file.record()
        path.write_bytes(told[0])
        with pytest.raises(EndOfFile):
            file.record()
