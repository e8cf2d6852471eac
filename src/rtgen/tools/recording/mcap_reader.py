"""Reads MCAP files in file order, including truncated ones.

A file whose writer was killed can end anywhere: its complete chunks are read, the rest is ignored.
Lengths in the file are checked against its size before memory is allocated, and what compressed
chunks can require is limited by it, too.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from rtgen.facts.files import open_file
from rtgen.tools.recording.copies import Copy
from rtgen.tools.recording.errors import RecordingError, UnavailableError
from rtgen.tools.recording.mcap_writer import MAGIC as MAGIC
from rtgen.tools.recording.mcap_writer import require_library
from rtgen.tools.recording.schemas import Schema

if TYPE_CHECKING:
    from mcap.records import Chunk, McapRecord


_DAMAGE = (ValueError, OverflowError, struct.error)
"""Exceptions for invalid octets, in addition to `McapError`."""
_FRAMING = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence number, time of the log and of the publication."""
MAX_SIZE = 1 << 27
"""Maximum uncompressed size of a chunk or record in octets."""
_NO_OPCODE = 0
"""The opcode that is none: space that a writer has reserved, and never used."""
_FREE_OCTETS, _OCTETS_PER_OCTET = 1 << 29, 1_000
"""Uncompressed octets of a file: any number up to the first, then so many for each of its own."""
_MAX_DESCRIPTIONS = 1 << 26
"""Maximum size of all topics and schemas of a file in octets; they stay in memory."""
_FREE_RECORDS, _OCTETS_PER_RECORD = 500_000, 4
"""Records of a file: any number up to the first, then one for so many octets of its own.

In a compressed chunk, a message of a constant takes 21.
"""


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel: topic, schema and encoding of its messages."""

    id: int
    topic: str
    encoding: str
    schema: Schema
    metadata: tuple[tuple[str, str], ...]

    def get(self, key: str) -> str:
        """Return a metadata entry; empty if it is missing."""
        return dict(self.metadata).get(key, "")


@dataclass(frozen=True, slots=True)
class Message:
    """A message; `time` is that of the writer's clock [ns]."""

    channel: Channel
    time: int
    data: bytes


class McapFile:
    """An MCAP file that can be read several times from the start."""

    form = "mcap"

    def __init__(self, path: str | Path, copy: Copy | None = None) -> None:
        """Open a file, or its copy. Raises RecordingError if it is missing or not MCAP."""
        require_library()
        self.path = Path(path)
        self._copy = copy
        self.damaged = 0
        """Number of chunks skipped by the last call of `messages`."""
        with self._opened():
            pass

    @cached_property
    def metadata(self) -> dict[str, dict[str, str]]:
        """The metadata records at the head of the file, by name."""
        from mcap.records import Chunk, DataEnd, Metadata

        records: dict[str, dict[str, str]] = {}
        with self._opened() as stream:
            for record in _records(stream):
                if isinstance(record, Chunk | DataEnd):
                    break
                if isinstance(record, Metadata):
                    records[record.name] = record.metadata
        return records

    @cached_property
    def profile(self) -> str:
        """The profile in the header: `ros2` for a bag of ROS 2."""
        from mcap.records import Header

        with self._opened() as stream:
            first = next(_records(stream), None)
        return first.profile if isinstance(first, Header) else ""

    @cached_property
    def earliest(self) -> int | None:
        """The time of the earliest message [ns], as chunks state it; None without messages."""
        from mcap.records import Chunk
        from mcap.records import Message as MessageRecord

        times = []
        with self._opened() as stream:
            for record in _records(stream):
                if isinstance(record, Chunk) and record.uncompressed_size:
                    times.append(record.message_start_time)
                elif isinstance(record, MessageRecord):
                    times.append(record.log_time)
        return min(times, default=None)

    @cached_property
    def is_whole(self) -> bool:
        """Whether the writer has completed the file."""
        with self._opened() as stream:
            stream.seek(-len(MAGIC), 2)
            return stream.tell() > 0 and stream.read() == MAGIC

    def losses(self) -> list[str]:
        """Return what the last call of `messages` could not read, in words."""
        reasons = [] if self.is_whole else ["cut off: its last events are missing"]
        if self.damaged:
            chunks = "chunk" if self.damaged == 1 else "chunks"
            reasons.append(f"{self.damaged} damaged {chunks} left out")
        return reasons

    def messages(self) -> Iterator[Message]:
        """Yield all messages of complete chunks, in file order."""
        from mcap.records import Channel as ChannelRecord
        from mcap.records import Message as MessageRecord
        from mcap.records import Schema as SchemaRecord

        schemas: dict[int, SchemaRecord] = {}
        channels: dict[int, Channel] = {}
        self.damaged = 0
        with self._opened() as stream:
            work = Work(self.path, os.fstat(stream.fileno()).st_size)
            for record in self._unpacked(stream, work):
                match record:
                    case SchemaRecord():
                        if schemas.get(record.id) != record:
                            work.take_description(record.name, record.data)
                            schemas[record.id] = record
                    case ChannelRecord():
                        if record.id not in channels:
                            words = [
                                part
                                for pair in record.metadata.items()
                                for part in pair
                            ]
                            work.take_description(record.topic, *words)
                            schema = schemas.get(record.schema_id)
                            channels[record.id] = _channel(record, schema)
                    case MessageRecord():
                        channel = channels.get(record.channel_id)
                        if channel is None:
                            raise RecordingError(
                                f"{self.path}: a message of channel {record.channel_id},"
                                " which is not announced"
                            )
                        yield Message(channel, record.log_time, record.data)

    def _unpacked(self, stream: BinaryIO, work: Work) -> Iterator[McapRecord]:
        """Yield the records; complete chunks are replaced by their records.

        Raises RecordingError for chunks that decompress to more than a recording has.
        """
        from mcap.records import Chunk

        for record in _records(stream):
            if not isinstance(record, Chunk):
                yield record
                continue
            try:
                work.take_octets(record.uncompressed_size)
                content = _content(record)
            except ValueError:
                self.damaged += 1
                continue
            # One at a time: a small chunk may contain very many records.
            yield from _records(BytesIO(content), work.take_record)

    def _opened(self) -> BinaryIO:
        try:
            stream = open_file(self._copy.path if self._copy else self.path)
        except OSError as error:
            raise UnavailableError(
                f"cannot read {self.path}: {error.strerror}"
            ) from error
        if stream.read(len(MAGIC)) != MAGIC:
            stream.close()
            raise RecordingError(f"{self.path} is not an MCAP file")
        return stream


class Work:
    """What may still be read of a file whose size is known."""

    def __init__(self, path: Path, size: int) -> None:
        self._path = path
        self._octets = _FREE_OCTETS + size * _OCTETS_PER_OCTET
        self._records = _FREE_RECORDS + size // _OCTETS_PER_RECORD
        self._descriptions = _MAX_DESCRIPTIONS

    def take_octets(self, number: int) -> None:
        """Count the octets of a chunk. Raises RecordingError, ValueError for one too large."""
        if number > MAX_SIZE:
            raise ValueError(f"a chunk of {number} octets")
        self._octets -= number
        if self._octets < 0:
            raise self._error()

    def take_record(self) -> None:
        """Count a record of a chunk. Raises RecordingError."""
        self._records -= 1
        if self._records < 0:
            raise self._error()

    def take_description(self, *parts: object) -> None:
        """Count the texts of a topic or schema. Raises RecordingError."""
        texts = (part for part in parts if isinstance(part, str | bytes))
        self._descriptions -= sum(map(len, texts))
        if self._descriptions < 0:
            raise RecordingError(
                f"{self._path}: its topics and schemas have over {_MAX_DESCRIPTIONS} octets"
            )

    def _error(self) -> RecordingError:
        return RecordingError(
            f"{self._path}: its compressed chunks have more content than a recording of its size"
        )


def _channel(record: Any, schema: Any) -> Channel:
    metadata = tuple(record.metadata.items())
    if schema is None:
        none = Schema("", "", "")
        return Channel(record.id, record.topic, record.message_encoding, none, metadata)
    text = schema.data.decode("utf-8", "replace")
    return Channel(
        record.id,
        record.topic,
        record.message_encoding,
        Schema(schema.name, text, schema.encoding),
        metadata,
    )


def _records(
    stream: BinaryIO, count: Callable[[], None] = lambda: None
) -> Iterator[McapRecord]:
    """Yield the following complete records, up to the end of the data.

    `count` is called for each record, also for those that are skipped.
    """
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.opcode import Opcode

    types: dict[int, Any] = {
        Opcode.HEADER: records.Header,
        Opcode.CHANNEL: records.Channel,
        Opcode.SCHEMA: records.Schema,
        Opcode.CHUNK: records.Chunk,
        Opcode.METADATA: records.Metadata,
        Opcode.DATA_END: records.DataEnd,
    }
    here = stream.tell()
    end = stream.seek(0, 2)
    stream.seek(here)
    while here + _FRAMING.size <= end:
        opcode, length = _FRAMING.unpack(stream.read(_FRAMING.size))
        here += _FRAMING.size + length
        if here > end or opcode == _NO_OPCODE:
            return
        count()
        if (opcode not in types and opcode != Opcode.MESSAGE) or length > MAX_SIZE:
            stream.seek(here)
            continue
        if opcode == Opcode.MESSAGE:
            yield from _message(stream, length)
            continue
        try:
            yield types[opcode].read(ReadDataStream(BytesIO(stream.read(length))))
        except (*_DAMAGE, McapError):
            continue
        if opcode == Opcode.DATA_END:
            return


def _message(stream: BinaryIO, length: int) -> Iterator[McapRecord]:
    """Yield the message of the next `length` octets, unless they are too few."""
    from mcap.records import Message as MessageRecord

    head = stream.read(min(length, _MESSAGE.size))
    if len(head) == _MESSAGE.size:
        channel, sequence, time, published = _MESSAGE.unpack(head)
        content = stream.read(length - _MESSAGE.size)
        yield MessageRecord(channel, time, content, published, sequence)


def _content(chunk: Chunk) -> bytes:
    """Return the content of a chunk. Raises ValueError if it is damaged."""
    size = chunk.uncompressed_size
    data = decompressed(chunk.compression, chunk.data, size + 1)
    if len(data) != size or chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise ValueError("the chunk is damaged")
    return data


def decompressed(compression: str, data: bytes, most: int) -> bytes:
    """Decompress up to `most` octets. Raises ValueError."""
    if compression == "zstd":
        import zstandard

        try:
            return zstandard.ZstdDecompressor().stream_reader(data).read(most)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from error
    if compression == "lz4":
        import lz4.frame

        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, most))
        except RuntimeError as error:
            raise ValueError(str(error)) from error
    if compression:
        raise RecordingError(f"chunks are compressed by {compression!r}")
    return data
