"""Reads octets and numbers of classic CDR, from chunks inside a value (CORBA 3.3 part 2, 9.3.4)."""

from __future__ import annotations

import struct
from typing import Any

from rtgen.runtime.marshalling.dynamic.writer import VALUE_TAG
from rtgen.runtime.marshalling.errors import Buffer, Fault

_WORK_PER_OCTET = 16
_MIN_WORK = 100_000


class Input(bytes):
    """The input body, with its values by the offsets of their headers.

    `work` is the remaining number of values that may be created.
    """

    values: dict[int, Any]
    work: int

    def __new__(cls, data: Buffer) -> Input:
        view = super().__new__(cls, memoryview(data))
        view.values = {}
        view.work = _MIN_WORK + _WORK_PER_OCTET * len(view)
        return view


class OctetReader:
    """Reads the octets of a body in order, and chunks inside a value. Raises Fault at their end."""

    def __init__(self, data: Buffer, little_endian: bool, offset: int = 0) -> None:
        self._data = data if isinstance(data, Input) else Input(data)
        self._little = bool(little_endian)
        self._order = "<" if little_endian else ">"
        self.offset = offset
        self._level = 0
        self._chunk_end = 0
        self._closed = 0

    def end(self) -> None:
        """Raise Fault for remaining octets."""
        rest = len(self._data) - self.offset
        if rest:
            raise Fault(f"{rest} octets too many")

    def _take(self, size: int, align: int) -> bytes:
        """Return a number of contiguous octets."""
        if self._level and self.offset >= self._chunk_end:
            self._open_chunk()
        start = self.offset + -self.offset % align
        end = self._chunk_end if self._level else len(self._data)
        if size > end - start:
            remaining = max(end - start, 0)
            raise Fault(f"truncated: {size} octets are needed, {remaining} are left")
        self.offset = start + size
        return self._data[start : self.offset]

    def _octets(self, count: int) -> bytes:
        """Return a number of octets, which may be split across chunks."""
        if not self._level:
            return self._take(count, 1)
        parts = []
        while count:
            if self.offset >= self._chunk_end:
                self._open_chunk()
            size = min(count, self._chunk_end - self.offset)
            parts.append(self._take(size, 1))
            count -= size
        return b"".join(parts)

    def _open_chunk(self) -> None:
        size = self._between("i")
        if self._closed or not 0 < size < VALUE_TAG:
            raise Fault("a value ends before its state does")
        if size > len(self._data) - self.offset:
            raise Fault("a chunk is longer than the remaining octets")
        self._chunk_end = self.offset + size

    def _between(self, code: str) -> int:
        """Return a number outside of chunks."""
        start = self.offset + -self.offset % 4
        if start + 4 > len(self._data):
            remaining = max(len(self._data) - self.offset, 0)
            raise Fault(f"truncated: 4 octets are needed, {remaining} are left")
        self.offset = start + 4
        number = struct.unpack_from(f"{self._order}{code}", self._data, start)[0]
        return int(number)

    def _number(self, code: str) -> Any:
        size = struct.calcsize(f"<{code}")
        return struct.unpack(self._order + code, self._take(size, size))[0]

    def _integer(self, code: str) -> int:
        return int(self._number(code))

    def _count(self, least: int) -> int:
        count = self._integer("I")
        remaining = len(self._data) - self.offset
        if count * least > remaining:
            raise Fault(f"a length of {count}, and {remaining} octets are left")
        return count

    def _skip(self, size: int) -> None:
        if size > len(self._data) - self.offset:
            raise Fault("a chunk is longer than the remaining octets")
        self.offset += size
