"""Files that a tear, a flipped bit or malice has made: read as far as they go or refused, within bounds."""

import math
import os
import random
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.writer import CompressionType, Writer
from typer.testing import CliRunner

from vsensor.cli.main import app
from vsensor.errors import InputError
from vsensor.messages import SENSOR_TICK, SURFACE_TORQUE, Sample, Tick
from vsensor.recording.course import Course
from vsensor.recording.reader import Session
from vsensor.recording.writer import SessionWriter

MEMORY = 192 << 20
"""What a file may cost beyond the program itself: a chunk of PLAUSIBLE_BYTES, twice while it is unpacked."""
MESSAGES = 8

pytestmark = pytest.mark.process


def messages() -> Iterator[tuple[str, bytes]]:
    """Samples and ticks in turn."""
    for number in range(MESSAGES):
        told = Tick(number=number) if number % 2 else Sample(time_ns=number, value=number)
        yield SENSOR_TICK if number % 2 else SURFACE_TORQUE, told.SerializeToString()


def session(path: Path) -> bytes:
    """A session of two chunks of four messages."""
    with SessionWriter(path, configuration="[rig]", metadata={"rig": "r"}, compression="zstd") as writer:
        for number, (topic, data) in enumerate(messages(), 1):
            writer.write(topic, data, number, number)
            if number == MESSAGES // 2:
                writer.sync()
    return path.read_bytes()


def small_session(path: Path) -> bytes:
    """The same, its schemas named and not told: a tenth of the bytes."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata("vsensor", {"rig": "r"})
        channels = {
            topic: writer.register_channel(topic, "protobuf", writer.register_schema(name, "protobuf", b""))
            for topic, name in ((SURFACE_TORQUE, "vsensor.Sample"), (SENSOR_TICK, "vsensor.Tick"))
        }
        for number, (topic, data) in enumerate(messages(), 1):
            writer.add_message(channels[topic], number, data, number)
            if number == MESSAGES // 2:
                writer.flush()  # type: ignore[no-untyped-call]
        writer.finish()  # type: ignore[no-untyped-call]
    return path.read_bytes()


def readings(folder: Path) -> dict[str, list[list[str]]]:
    """What became of each file in each way of reading it, by a process within its bounds."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.hostile", str(folder)],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, (done.stdout[-300:], done.stderr[-3000:])
    told: dict[str, list[list[str]]] = {}
    *lines, last = done.stdout.splitlines()
    assert int(last.removeprefix("grown ")) < MEMORY
    for line in lines:
        name, _, *ways = line.split(" ")
        told.setdefault(name, []).append(ways)
    return told


def test_cut_at_every_byte_it_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    folder = tmp_path / "cut"
    folder.mkdir()
    data = small_session(tmp_path / "whole.mcap")
    (folder / "a.cut").write_bytes(data)
    at_each = readings(folder)["a.cut"]
    assert len(at_each) == len(data) + 1
    assert at_each[0][:4] == ["8", "8", "4", "8"]
    assert at_each[-1] == ["refused"] * 5
    found = [0 if told[1] == "refused" else int(told[1]) for told in at_each]
    assert set(found) == {0, 4, 8}
    assert found == sorted(found, reverse=True)  # what was safe at some length is so at each greater one
    for told in at_each:
        assert told[0] == told[1] == told[3], told  # all ways see the same
        assert told[4:] in ([], ["refused" if told[0] == "0" else told[0]]), told
        assert set(told) <= {"0", "4", "2", "8", "refused"}


def chunk(compression: str, claimed: int, data: bytes) -> bytes:
    name = compression.encode()
    body = struct.pack("<QQQII", 1, 2, claimed, 0, len(name)) + name + struct.pack("<Q", len(data)) + data
    return struct.pack("<BQ", 0x06, len(body)) + body


def zeros(count: int) -> bytes:
    """A frame of zstd that holds so many zeros and says so."""
    packer = zstandard.ZstdCompressor(level=1).compressobj(size=count)
    block = bytes(1 << 20)
    return b"".join([*(packer.compress(block) for _ in range(count >> 20)), packer.flush()])


def spoilt(data: bytes) -> dict[str, bytes]:
    """Files made to hurt, each from a sound one."""
    at = data.index(struct.pack("<B", 0x06), 60)  # the first chunk's record, as the writer lays it
    head, rest = data[:at], data[at:]
    huge = (1 << 62, 0xFFFFFFFF, 1 << 31)
    bomb = zeros(3 << 30)
    summary = data.rindex(b"\x02" + struct.pack("<Q", 20))  # the footer's record
    files = {
        "bomb-zstd": head + chunk("zstd", 3 << 30, bomb) + rest,
        "bomb-zstd-modest": head + chunk("zstd", 1000, bomb) + rest,
        "bomb-lz4": head + chunk("lz4", 3 << 30, lz4.frame.compress(bytes(1 << 20))) + rest,
        "unknown-packing": head + chunk("brotli", 1000, b"1234") + rest,
        "no-index": data[: summary + 9] + bytes(16) + data[summary + 25 :],
    }
    for number, length in enumerate(huge):
        told = struct.pack("<Q", length)
        files |= {
            f"chunk-{number}": head + chunk("", length, b"1234") + rest,
            f"record-{number}": head + b"\x06" + told + rest,
            f"attachment-{number}": head + b"\x09" + told + rest,
            f"unheard-of-{number}": head + b"\x90" + told + rest,
            f"summary-{number}": data[: summary + 9] + told + data[summary + 17 :],
            f"schema-{number}": head + b"\x03" + struct.pack("<QHI", 20, 1, length & 0xFFFFFFFF) + rest,
        }
    return files


def test_an_index_that_knows_nothing_of_what_is_there_is_told_and_can_be_written_anew(tmp_path: Path) -> None:
    data = session(tmp_path / "whole.mcap")
    flipped, anew = tmp_path / "flipped.mcap", tmp_path / "anew.mcap"
    ahead, behind = data[: (at := data.rindex(SURFACE_TORQUE.encode()))], data[at:]
    flipped.write_bytes(ahead + behind.replace(b"surface", b"curface", 1))
    with pytest.raises(InputError, match=r"index at its end knows nothing: .*vsensor recover"):
        Course([Session(flipped)])
    result = CliRunner().invoke(app, ["recover", str(flipped), "-o", str(anew)])
    assert result.exit_code == 0, result.output
    whole, again = (Course([Session(tmp_path / name)]).between(0, math.inf) for name in ("whole.mcap", anew))
    assert len(list(again)) == len(list(whole)) > 0


def test_what_is_made_to_hurt_does_not(tmp_path: Path) -> None:
    folder = tmp_path / "spoilt"
    folder.mkdir()
    data = session(tmp_path / "whole.mcap")
    (folder / "0-sound").write_bytes(data)
    for name, content in spoilt(data).items():
        (folder / name).write_bytes(content)
    rng = random.Random(6)
    for number in range(150):
        flipped = bytearray(data)
        for _ in range(rng.randint(1, 3)):
            flipped[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        (folder / f"flip-{number}").write_bytes(flipped)
    told = readings(folder)
    assert told["0-sound"] == [["8", "8", "4", "8", "8"]]
    assert told["no-index"][0][1] == "8"
    assert len(told) == len(list(folder.iterdir()))
    for name, (ways,) in told.items():
        assert all(way == "refused" or way.isdecimal() for way in ways), (name, ways)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_files_of_others_are_told_apart(tmp_path: Path, compression: CompressionType) -> None:
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=compression)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel(SURFACE_TORQUE, "cdr", schema)
        writer.add_message(channel, 1, b"\x00\x01\x00\x00" + bytes(8), 1)
        writer.finish()  # type: ignore[no-untyped-call]
    for command in (("info",), ("verify",), ("replay",), ("recover",)):
        done = CliRunner().invoke(app, [*command, str(path)])
        assert done.exit_code == 1, (command, done.output)
        assert "std_msgs/msg/Float64, cdr" in done.output
        assert "Traceback" not in done.output


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    pipe, loop = tmp_path / "pipe.mcap", tmp_path / "loop.mcap"
    os.mkfifo(pipe)
    loop.symlink_to(loop)
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "folder.mcap").mkdir()
    expected = {
        pipe: "is neither file nor folder",
        loop: "cannot be read",
        tmp_path / "empty.mcap": r"is empty \(0 bytes\)",
        tmp_path / "folder.mcap": "is a folder",
        tmp_path / "nothing.mcap": "no such file",
        Path("/dev/zero"): "is neither file nor folder",
    }
    begun = time.monotonic()
    for path, fault in expected.items():
        with pytest.raises(Exception, match=fault) as raised:
            Session(path)
        assert str(path) in str(raised.value)
    assert time.monotonic() - begun < 30
