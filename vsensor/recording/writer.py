"""Sessions as MCAP files that a power cut can tear but not destroy."""

import contextlib
import fcntl
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BufferedWriter
from pathlib import Path
from types import TracebackType
from typing import Literal, Self

from mcap.records import Channel, Message, Schema
from mcap.well_known import MessageEncoding
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import register_schema

from vsensor.errors import ConfigError, InputError, VsensorError
from vsensor.messages import message_type

Compression = Literal["zstd", "lz4", "none"]

CONFIGURATION = "configuration.toml"
"""The attachment that holds the configuration under which the session was made."""

METADATA = "vsensor"
"""The metadata record at the start: rig, versions, machine."""

RECORDER = "recorder"
"""The metadata record at the end: how much was written, how much dropped, how it ended."""

RECOVERED_FROM = "recovered_from"
"""In a mended session's metadata: the name of the torn one;"""

COULD_NOT_BE_READ = "could_not_be_read"
"""and how much of it, and where."""

CHUNK_BYTES = 256 * 1024
"""Small enough that compressing one (some ms) does not let the queue before it fill."""

_COMPRESSION = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
_MAX_TIME_NS = (1 << 64) - 1


def part_of(path: Path) -> Path:
    """The name that a session bears until it is complete."""
    return path.with_name(f"{path.name}.part")


class TornOffError(VsensorError):
    """The disk takes no more; what was written until then stays."""

    def __init__(self, part: Path, why: str) -> None:
        super().__init__(
            f"{part}: cannot be written on: {why}; what stands in it can be had by: vsensor recover {part}"
        )
        self.why = why


class GoneError(VsensorError):
    """The file is not where it was begun: all that was written to it is lost, or in somebody else's hands."""

    def __init__(self, part: Path) -> None:
        super().__init__(f"{part}: is not there any longer: it was removed or moved while it was written")


class SessionWriter:
    """Writes NAME.mcap.part (or `part`), and gives it its final name when it is complete.

    Configuration and metadata stand at the start, so that a torn file has them too. Raises
    InputError where a session of that name exists or cannot be created, ConfigError for another
    name, VsensorError where the disk takes no more, and what was written until then stays and can be
    recovered; GoneError where the file was taken away.
    """

    def __init__(
        self,
        path: Path,
        *,
        configuration: str,
        metadata: Mapping[str, str],
        compression: Compression,
        part: Path | None = None,
    ) -> None:
        self.path = path
        self.part = part or part_of(path)
        self.written = 0
        self._file = _create(path, self.part)
        self._mcap = Writer(self._file, chunk_size=CHUNK_BYTES, compression=_COMPRESSION[compression])
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._mcap.start()
        if configuration:
            now = time.time_ns()
            self._mcap.add_attachment(now, now, CONFIGURATION, "application/toml", configuration.encode())
        self.note(METADATA, metadata)
        self.sync()
        _sync_folder(path.parent)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._abandon()

    @property
    def size(self) -> int:
        """Bytes written to the file so far."""
        return self._file.tell()

    def note(self, name: str, data: Mapping[str, str]) -> None:
        """Add a metadata record."""
        try:
            self._mcap.add_metadata(name, dict(data))
        except OSError as error:
            raise self._torn_off(error) from error

    def write(
        self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int, sequence: int = 0
    ) -> None:
        """Write a message, its schema before the first of its topic; ValueError for a topic we do not know.

        MCAP's times start at 1970: one before is stored as 0. The message keeps its own, exactly.
        """
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._open_channel(topic)
        self._add(channel, data, log_time_ns, publish_time_ns, sequence)

    def copy(self, schema: Schema | None, channel: Channel, message: Message) -> None:
        """Write a message of another session as it stood there, under the schema that it had."""
        key = f"{channel.id} {channel.topic}"
        if key not in self._channels:
            self._channels[key] = self._mcap.register_channel(
                channel.topic,
                channel.message_encoding,
                0 if schema is None else self._schema(f"{schema.id} {schema.name}", schema),
                channel.metadata,
            )
        self._add(self._channels[key], message.data, message.log_time, message.publish_time, message.sequence)

    def sync(self) -> None:
        """Put all that was written on the disk; what comes before this call survives a power cut."""
        try:
            self._mcap.flush()  # type: ignore[no-untyped-call]
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._torn_off(error) from error
        self._check_there()

    def close(self) -> None:
        """Complete the file and give it its final name."""
        try:
            self._mcap.finish()  # type: ignore[no-untyped-call]
            self._file.flush()
            os.fsync(self._file.fileno())
            self._check_there()
            self._file.close()
            self.part.rename(self.path)
        except OSError as error:
            raise self._torn_off(error) from error
        _sync_folder(self.path.parent)

    def _add(self, channel: int, data: bytes, log_time_ns: int, publish_time_ns: int, sequence: int) -> None:
        try:
            self._mcap.add_message(
                channel,
                min(max(log_time_ns, 0), _MAX_TIME_NS),
                data,
                min(max(publish_time_ns, 0), _MAX_TIME_NS),
                sequence & 0xFFFFFFFF,
            )
        except OSError as error:
            raise self._torn_off(error) from error
        self.written += 1

    def _open_channel(self, topic: str) -> int:
        kind = message_type(topic)
        if kind is None:
            raise ValueError(f"no message is known for the topic {topic!r}")
        name = kind.DESCRIPTOR.full_name
        if name not in self._schemas:
            self._schemas[name] = register_schema(self._mcap, kind)
        self._channels[topic] = self._mcap.register_channel(
            topic, MessageEncoding.Protobuf, self._schemas[name]
        )
        return self._channels[topic]

    def _schema(self, key: str, schema: Schema) -> int:
        if key not in self._schemas:
            self._schemas[key] = self._mcap.register_schema(schema.name, schema.encoding, schema.data)
        return self._schemas[key]

    def _torn_off(self, error: OSError) -> VsensorError:
        self._abandon()
        return TornOffError(self.part, error.strerror or str(error))

    def _check_there(self) -> None:
        """To write goes well though nobody finds the file any longer: look whether it bears its name."""
        try:
            there = self.part.stat()
        except (FileNotFoundError, NotADirectoryError):
            there = None
        except OSError:  # a folder that nobody may look into any longer: it may well be there yet
            return
        if there is None or not os.path.samestat(there, os.fstat(self._file.fileno())):
            self._abandon()
            raise GoneError(self.part)

    def _abandon(self) -> None:
        """Leave the file under its unfinished name."""
        with contextlib.suppress(OSError):  # closing tries once more to write what the disk has refused
            self._file.close()


def _create(path: Path, part: Path) -> BufferedWriter:
    if path.suffix != ".mcap":
        raise ConfigError(f"{path}: a session's name must end in .mcap")
    for taken in (path, part):
        if taken.exists():
            raise InputError(f"{taken}: exists already, and no session is written over: choose another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = part.open("xb")
    except (FileExistsError, NotADirectoryError) as error:
        raise InputError(f"{part}: cannot be created: a file is in the way of {error.filename}") from error
    except OSError as error:
        raise InputError(f"{part}: cannot be created: {error.strerror}: {error.filename}") from error
    with contextlib.suppress(OSError):  # some network file systems know no locks
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # says to the mender that somebody writes it
    return file


def _sync_folder(folder: Path) -> None:
    """Put the file's name on the disk too; some network file systems cannot, and do without."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextmanager
def all_or_nothing(
    path: Path, *, configuration: str, metadata: Mapping[str, str], compression: Compression
) -> Iterator[SessionWriter]:
    """A session that is there as a whole or not at all: what fails or is stopped leaves nothing.

    Raises InputError where it cannot be written, ConfigError for a name that is none.
    """
    part = part_of(path)
    others = part.exists()
    try:
        with SessionWriter(
            path, configuration=configuration, metadata=metadata, compression=compression
        ) as writer:
            yield writer
    except BaseException as error:
        if others:
            raise
        part.unlink(missing_ok=True)
        if isinstance(error, TornOffError):
            raise InputError(f"{path}: cannot be written: {error.why}") from error
        raise
