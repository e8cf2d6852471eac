"""Writes MCAP files in compressed chunks; the output is deterministic.

The records are those of the package `mcap`. Chunks and their indexes are assembled here, because
its `Writer` takes three times as long per message (https://mcap.dev/spec).
"""

from __future__ import annotations

import os
import struct
import threading
import zlib
from array import array
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from rtgen.facts.extras import installation
from rtgen.facts.files import create_file
from rtgen.runtime.closable import Closable
from rtgen.tools.recording.errors import UnavailableError

COMPRESSIONS: Final = ("zstd", "lz4", "none")
"""Names of compressions; the first one is the default."""
CHUNK: Final = 1 << 18
"""Minimum octets of a chunk before compression; a killed process loses at most one chunk."""
METADATA: Final = "rtgen"
"""Name of the metadata record at the start of rtgen's recordings."""
MAGIC: Final = b"\x89MCAP0\r\n"

_LIBRARY = "rtgen"
_packed = struct.Struct("<BQHIQQ").pack
_MESSAGE_OPCODE, _INDEX_OPCODE = 0x05, 0x07
_MESSAGE_HEAD = 22
"""Size of a message without its data, in octets."""
_NEVER = 1 << 64
_WORD = (1 << 32) - 1
_INDEX = struct.Struct("<BQHI")


def require_library() -> None:
    """Raise UnavailableError if the package `mcap` is not installed."""
    if find_spec("mcap") is None:
        raise UnavailableError(
            "recordings need mcap, which is not installed",
            hint=installation("record"),
        )


class McapWriter(Closable):
    """An MCAP file being written. Its methods can be called from any thread.

    A chunk is written as a whole, when it is full or contains `longest` ns of messages. So a file
    whose writer was killed can be read up to its last complete chunk. Memory contains a chunk and
    its index, and a few hundred octets for each chunk before it, which the summary needs.
    """

    def __init__(
        self,
        path: str | Path,
        compression: str = "zstd",
        longest: int | None = None,
        profile: str = "",
    ) -> None:
        """Create the file; `profile` is that of its header. Raises RecordingError."""
        require_library()
        from mcap import records

        self._records = records
        self._path = path
        self._longest = longest
        self._compression = "" if compression == "none" else compression
        self._compress = _compressor(compression)
        try:
            self._file = _File(path)
        except OSError as error:
            raise UnavailableError(f"cannot write {path}: {error.strerror}") from error
        self._chunk = bytearray()
        self._index: dict[int, array[int]] = {}
        """Time and offset of each message in the chunk, by channel."""
        self._due = _NEVER if longest is None else 0
        """Latest end of the chunk."""
        self._counts: dict[int, int] = {}
        self._span: list[int] = []
        self._schemas: list[Any] = []
        self._channels: list[Any] = []
        self._chunks: list[Any] = []
        self._metadata: list[Any] = []
        self._open = True
        self.lock = threading.RLock()
        self._write(MAGIC + _octets(records.Header(profile=profile, library=_LIBRARY)))

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Write a metadata record. Raises RecordingError."""
        with self.lock:
            octets = _octets(self._records.Metadata(name=name, metadata=dict(entries)))
            index = self._records.MetadataIndex(
                offset=self._file.at, length=len(octets), name=name
            )
            self._metadata.append(index)
            self._write(octets)

    def schema(self, name: str, encoding: str, text: str) -> int:
        """Announce a schema; return its id."""
        with self.lock:
            schema = self._records.Schema(
                id=len(self._schemas) + 1,
                data=text.encode(),
                encoding=encoding,
                name=name,
            )
            self._schemas.append(schema)
            self._chunk += _octets(schema)
            return len(self._schemas)

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel of messages in an encoding; return its id."""
        with self.lock:
            number = len(self._channels) + 1
            channel = self._records.Channel(
                id=number,
                topic=topic,
                message_encoding=encoding,
                metadata=dict(entries),
                schema_id=schema,
            )
            self._channels.append(channel)
            self._counts[number] = 0
            self._index[number] = array("Q")
            self._chunk += _octets(channel)
            return number

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Write a message with a time [ns]. Raises RecordingError if the file cannot be written."""
        with self.lock:
            self.put(channel, time, data)

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Write a message, for a caller that holds the lock."""
        chunk = self._chunk
        count = self._counts[channel]
        self._counts[channel] = count + 1
        index = self._index[channel]
        index.append(time)
        index.append(len(chunk))
        size = _MESSAGE_HEAD + len(data)
        number = count & _WORD
        chunk += _packed(_MESSAGE_OPCODE, size, channel, number, time, time)
        chunk += data
        if len(chunk) >= CHUNK or time >= self._due:
            self.end_chunk()
            if self._longest is not None:
                self._due = time + self._longest

    def close(self) -> None:
        """Write the last chunk and the summary; later messages are ignored."""
        with self.lock:
            if not self._open:
                return
            try:
                self.end_chunk()
                self._open = False
                self._write(_octets(self._records.DataEnd(data_section_crc=0)))
                self._write(self._summary())
            finally:
                self._open = False
                self._file.close()

    def end_chunk(self) -> None:
        """Write the chunk with its index, unless it has no messages."""
        index_of = {channel: index for channel, index in self._index.items() if index}
        if not index_of or not self._open:
            return
        records, content = self._records, bytes(self._chunk)
        data = self._compress(content)
        first = min(min(index[::2]) for index in index_of.values())
        last = max(max(index[::2]) for index in index_of.values())
        chunk = _octets(
            records.Chunk(
                compression=self._compression,
                data=data,
                message_start_time=first,
                message_end_time=last,
                uncompressed_crc=zlib.crc32(content),
                uncompressed_size=len(content),
            )
        )
        begin = self._file.at
        parts, offsets, at = [chunk], {}, begin + len(chunk)
        for channel, index in index_of.items():
            offsets[channel] = at
            parts += _index_record(channel, index)
            at += sum(map(len, parts[-2:]))
        self._chunks.append(
            records.ChunkIndex(
                message_start_time=first,
                message_end_time=last,
                chunk_start_offset=begin,
                chunk_length=len(chunk),
                message_index_offsets=offsets,
                message_index_length=at - begin - len(chunk),
                compression=self._compression,
                compressed_size=len(data),
                uncompressed_size=len(content),
            )
        )
        span = self._span or [first, last]
        self._span = [min(first, span[0]), max(last, span[1])]
        self._chunk.clear()
        for channel in index_of:
            self._index[channel] = array("Q")
        self._write(b"".join(parts))

    def _summary(self) -> bytes:
        """Return the summary: schemas, channels, statistics, indexes, and the footer."""
        records, begin = self._records, self._file.at
        first, last = self._span or (0, 0)
        statistics = records.Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts={n: c for n, c in self._counts.items() if c},
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_end_time=last,
            message_start_time=first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        groups = (
            self._schemas,
            self._channels,
            [statistics],
            self._chunks,
            self._metadata,
        )
        summary, offsets = bytearray(), bytearray()
        for group in groups:
            octets = b"".join(map(_octets, group))
            if octets:
                offset = records.SummaryOffset(
                    group_opcode=octets[0],
                    group_start=begin + len(summary),
                    group_length=len(octets),
                )
                offsets += _octets(offset)
                summary += octets
        offset_start = begin + len(summary)
        summary += offsets
        footer = _octets(
            records.Footer(
                summary_start=begin, summary_offset_start=offset_start, summary_crc=0
            )
        )
        crc = zlib.crc32(bytes(summary) + footer[:-4])
        return bytes(summary) + footer[:-4] + struct.pack("<I", crc) + MAGIC

    def _write(self, octets: bytes) -> None:
        try:
            self._file.write(octets)
        except OSError as error:
            message = f"cannot write {self._path}: {error.strerror}"
            raise UnavailableError(message) from error


def _compressor(compression: str) -> Callable[[bytes], bytes]:
    if compression == "zstd":
        import zstandard

        return zstandard.ZstdCompressor().compress
    if compression == "lz4":
        import lz4.frame

        compress: Callable[[bytes], bytes] = lz4.frame.compress
        return compress
    return lambda content: content


def _octets(record: Any) -> bytes:
    """Return a record in the encoding of the file."""
    from mcap.data_stream import RecordBuilder

    builder: Any = RecordBuilder()
    record.write(builder)
    octets: bytes = builder.end()
    return octets


def _index_record(channel: int, index: array[int]) -> tuple[bytes, bytes]:
    """Return the record with the times and offsets of a channel's messages in a chunk."""
    pairs = struct.pack(f"<{len(index)}Q", *index)
    return _INDEX.pack(_INDEX_OPCODE, 6 + len(pairs), channel, len(pairs)), pairs


class _File:
    """An unbuffered file, so that each chunk is written to the system at once."""

    def __init__(self, path: str | Path) -> None:
        with create_file(Path(path)) as stream:
            self._descriptor = os.dup(stream.fileno())
        self.at = 0
        """Number of octets written."""

    def write(self, data: bytes) -> None:
        """Write all octets. Raises OSError."""
        view = memoryview(data)
        while view:
            view = view[os.write(self._descriptor, view) :]
        self.at += len(data)

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)
