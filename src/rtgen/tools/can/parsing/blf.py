"""The whole objects of a Vector BLF file, as a stream for python-can's reader.

The reader inflates a container as a whole, of any size, ends at the first damage, and says nothing
of an object that is cut off. This stream has the intact objects alone, in containers that are not
compressed, and what is missing is reported.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from typing import BinaryIO

from can.io import blf

_HEADER = struct.Struct("<4sL8xQ48x")
"""Magic, size of the header, size of the file."""
_OBJECT = blf.OBJ_HEADER_BASE_STRUCT
_CONTAINER = blf.LOG_CONTAINER_STRUCT
_MAGIC = b"LOBJ"
_PADDING = 8
"""An object begins within so many octets behind the one before it."""
_VERSIONS = {1: blf.OBJ_HEADER_V1_STRUCT.size, 2: blf.OBJ_HEADER_V2_STRUCT.size}
_BODIES = {
    blf.CAN_MESSAGE: blf.CAN_MSG_STRUCT.size,
    blf.CAN_MESSAGE2: blf.CAN_MSG_STRUCT.size,
    blf.CAN_ERROR_EXT: blf.CAN_ERROR_EXT_STRUCT.size,
    blf.CAN_FD_MESSAGE: blf.CAN_FD_MSG_STRUCT.size,
    blf.CAN_FD_MESSAGE_64: blf.CAN_FD_MSG_64_STRUCT.size,
}
"""Types of objects that are frames, and the least size of what follows their headers."""
_MAX_INFLATED = 1 << 25
"""Maximum octets of a container; Vector's tools write 128 KiB."""
_MAX_RESUMED = 16
"""Maximum number of containers with a wrong size after which octets are read again."""
_PIECE = 1 << 20

Report = Callable[[str], object]


class WholeObjects:
    """A stream that can be read, made from another one."""

    def __init__(self, source: BinaryIO, report: Report) -> None:
        """Raises ValueError if it has no header of BLF."""
        self._report = report
        self._source = source
        self._unread = bytearray()
        self._rest = b""
        self._is_lost = False
        self._parts = self._converted()
        self._unread += next(self._parts)

    def read(self, size: int) -> bytes:
        """Return up to `size` octets; less at the end."""
        while len(self._unread) < size and (part := next(self._parts, b"")):
            self._unread += part
        data = bytes(self._unread[:size])
        del self._unread[:size]
        return data

    def close(self) -> None:
        """Do nothing: the source is closed by its owner."""

    def _converted(self) -> Iterator[bytes]:
        header = self._source.read(_HEADER.size)
        if len(header) < _HEADER.size or not header.startswith(b"LOGG"):
            raise ValueError("there is no header")
        _, size, expected = _HEADER.unpack(header)
        header += self._read(size - _HEADER.size)
        yield header
        at, resumed = len(header), 0
        while head := self._source.read(_OBJECT.size):
            magic, _, _, size, kind = _OBJECT.unpack(head.ljust(_OBJECT.size, b"\0"))
            if len(head) < _OBJECT.size:
                break
            if magic != _MAGIC or size < _OBJECT.size:
                self._report(f"damaged at octet {at}")
                self._lose()
                skipped = self._skip(head)
                if skipped is None:
                    return
                at += skipped
                continue
            data = self._read(size - _OBJECT.size)
            is_whole = len(data) == size - _OBJECT.size
            if kind == blf.LOG_CONTAINER:
                inflated, unused = self._inflated(data, at, is_whole)
                yield from self._objects(inflated, at)
                if unused >= _PADDING and resumed < _MAX_RESUMED:
                    # The size is wrong: further objects begin where the container ends.
                    resumed += 1
                    self._report(f"damaged at octet {at}")
                    self._source.seek(-unused, 1)
                    at += len(head) + len(data) - unused
                    continue
            else:
                yield from self._alone(head + data, at)
            if not is_whole:
                at += len(data)
                break
            at += size + len(self._source.read(size % 4))
        else:
            if at >= expected and not self._rest.strip(b"\0"):
                return
        self._report(f"cut off at octet {at}")

    def _read(self, size: int) -> bytes:
        """Read `size` octets, in pieces: a size in a file is not trusted."""
        parts = []
        while size > 0 and (part := self._source.read(min(size, _PIECE))):
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    def _skip(self, head: bytes) -> int | None:
        """Skip to the next object; return the number of octets, None without one."""
        skipped, window = 1, head[1:]
        while (start := window.find(_MAGIC)) < 0:
            overlap = window[-len(_MAGIC) + 1 :]
            more = self._source.read(_PIECE)
            if not more:
                return None
            skipped += len(window) - len(overlap)
            window = overlap + more
        self._source.seek(start - len(window), 1)
        return skipped + start

    def _inflated(self, data: bytes, at: int, is_whole: bool) -> tuple[bytes, int]:
        """Return the octets of a container, and how many octets of `data` follow it.

        What is damaged is left out as a whole, since no octet of it is certain.
        """
        if len(data) < _CONTAINER.size:
            return b"", 0
        method, _ = _CONTAINER.unpack_from(data)
        packed = data[_CONTAINER.size :]
        if method == blf.NO_COMPRESSION:
            return packed, 0
        if method != blf.ZLIB_DEFLATE:
            self._report(f"compressed in an unknown way at octet {at}")
            self._lose()
            return b"", 0
        inflater = zlib.decompressobj()
        try:
            inflated = inflater.decompress(packed, _MAX_INFLATED)
        except zlib.error:
            inflated = None
        if inflated is not None and inflater.unconsumed_tail:
            raise ValueError(f"a container of more than {_MAX_INFLATED} octets")
        if inflated is None or (is_whole and not inflater.eof):
            self._report(f"damaged in the container at octet {at}")
            self._lose()
            return b"", 0
        return inflated, len(inflater.unused_data)

    def _lose(self) -> None:
        self._rest = b""
        self._is_lost = True

    def _alone(self, data: bytes, at: int) -> Iterator[bytes]:
        """Yield an object outside of containers; none of these is continued in it."""
        if self._rest.strip(b"\0"):
            self._report(f"damaged at octet {at}")
            self._lose()
        is_lost, self._is_lost, self._rest = self._is_lost, False, b""
        yield from self._objects(data, at)
        self._is_lost, self._rest = is_lost, b""

    def _objects(self, data: bytes, at: int) -> Iterator[bytes]:
        """Yield the whole objects, in containers; the rest is continued in the next one."""
        data = self._rest + data
        place = begin = 0
        if self._is_lost:
            place = begin = data.find(_MAGIC)
            if begin < 0:
                return
            self._is_lost = False
        while True:
            start = data.find(_MAGIC, place, place + _PADDING + len(_MAGIC) - 1)
            if start < 0 and place + _PADDING > len(data):
                break
            size = _size_of_object(data, start) if start >= 0 else 0
            if size == 0:
                self._report(f"damaged in the container at octet {at}")
                yield from _stored(data[begin:place])
                place = begin = data.find(_MAGIC, place + 1)
                if begin < 0:
                    self._lose()
                    return
                continue
            if size is None or start + size > len(data):
                break
            place = start + size
        yield from _stored(data[begin:place])
        self._rest = data[place:]


def _size_of_object(data: bytes, start: int) -> int | None:
    """Return the size of an object; 0 if it is impossible, None if its header is incomplete."""
    if start + _OBJECT.size > len(data):
        return None
    _, _, version, size, kind = _OBJECT.unpack_from(data, start)
    least = _OBJECT.size + _VERSIONS.get(version, 0) + _BODIES.get(kind, 0)
    if kind in _BODIES and version not in _VERSIONS:
        return 0
    return int(size) if least <= size <= _MAX_INFLATED else 0


def _stored(objects: bytes) -> Iterator[bytes]:
    if objects:
        size = _OBJECT.size + _CONTAINER.size + len(objects)
        head = _OBJECT.pack(_MAGIC, _OBJECT.size, 1, size, blf.LOG_CONTAINER)
        yield head + _CONTAINER.pack(blf.NO_COMPRESSION, len(objects))
        yield objects + bytes(size % 4)
