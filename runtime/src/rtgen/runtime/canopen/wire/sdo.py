"""SDO protocol (CiA 301, 7.2.4) shared by server and client: abort codes, commands, blocks."""

from __future__ import annotations

import binascii
from typing import Final

import msgspec

MAX_SIZE: Final = 1 << 20
"""Default maximum length of a value in octets."""
TIMEOUT: Final = 1_000_000_000
"""Default time-out for a message of the other end, in ns."""

FRAME: Final = 8
EXPEDITED: Final = 4
"""Maximum length of a value in an expedited transfer."""
SEGMENT: Final = 7
"""Octets in a segment."""
MAX_BLOCK: Final = 127
"""Maximum number of segments in a block."""
_ATTEMPTS: Final = 5
"""Maximum number of consecutive blocks, or segments outside of blocks, that transfer nothing."""

ABORT: Final = 0x80
DOWNLOAD_SEGMENT: Final = 0x00
DOWNLOAD: Final = 0x20
DOWNLOAD_DONE: Final = 0x60
DOWNLOAD_SEGMENT_DONE: Final = 0x20
UPLOAD: Final = 0x40
UPLOAD_SEGMENT: Final = 0x60
BLOCK_DOWNLOAD: Final = 0xC0
BLOCK_DOWNLOAD_ANSWER: Final = 0xA0
BLOCK_UPLOAD: Final = 0xA0
BLOCK_UPLOAD_ANSWER: Final = 0xC0
BLOCK_END: Final = 0xC1
BLOCK_ENDED: Final = 0xA1
BLOCK_ACKNOWLEDGED: Final = 0xA2
BLOCK_START: Final = 0xA3

CODE: Final = 0xE0
"""The bits of the command specifier."""
WITH_CRC: Final = 0x04
WITH_SIZE: Final = 0x02
"""Size indicator of a block transfer; in other transfers the flag `e` (expedited)."""
SIZE_INDICATED: Final = 0x01
TOGGLE: Final = 0x10
LAST: Final = 0x01
LAST_IN_BLOCK: Final = 0x80

TOGGLE_ERROR: Final = 0x05030000
TIMED_OUT: Final = 0x05040000
COMMAND_UNKNOWN: Final = 0x05040001
BLOCK_SIZE_INVALID: Final = 0x05040002
SEQUENCE_INVALID: Final = 0x05040003
CRC_ERROR: Final = 0x05040004
OUT_OF_MEMORY: Final = 0x05040005
ACCESS_UNSUPPORTED: Final = 0x06010000
WRITE_ONLY: Final = 0x06010001
READ_ONLY: Final = 0x06010002
NO_OBJECT: Final = 0x06020000
NOT_MAPPABLE: Final = 0x06040041
MAPPING_TOO_LONG: Final = 0x06040042
HARDWARE_ERROR: Final = 0x06060000
LENGTH_MISMATCH: Final = 0x06070010
LENGTH_TOO_HIGH: Final = 0x06070012
LENGTH_TOO_LOW: Final = 0x06070013
NO_SUBINDEX: Final = 0x06090011
VALUE_INVALID: Final = 0x06090030
VALUE_TOO_HIGH: Final = 0x06090031
VALUE_TOO_LOW: Final = 0x06090032
GENERAL_ERROR: Final = 0x08000000
LOCAL_CONTROL: Final = 0x08000021
DEVICE_STATE: Final = 0x08000022
NO_DATA: Final = 0x08000024

ABORT_TEXTS: Final = {
    TOGGLE_ERROR: "toggle bit not alternated",
    TIMED_OUT: "protocol timed out",
    COMMAND_UNKNOWN: "command specifier unknown",
    BLOCK_SIZE_INVALID: "block size invalid",
    SEQUENCE_INVALID: "sequence number invalid",
    CRC_ERROR: "CRC error",
    OUT_OF_MEMORY: "out of memory",
    ACCESS_UNSUPPORTED: "access not supported",
    WRITE_ONLY: "read of a write-only object",
    READ_ONLY: "write of a read-only object",
    0x06010003: "sub-index cannot be written while sub-index 0 is not 0",
    NO_OBJECT: "object does not exist",
    NOT_MAPPABLE: "object cannot be mapped to the PDO",
    MAPPING_TOO_LONG: "mapped objects exceed the PDO",
    0x06040043: "general parameter incompatibility",
    0x06040047: "general internal incompatibility",
    0x06060000: "hardware error",
    LENGTH_MISMATCH: "type or length does not match",
    LENGTH_TOO_HIGH: "length too high",
    LENGTH_TOO_LOW: "length too low",
    NO_SUBINDEX: "sub-index does not exist",
    VALUE_INVALID: "value invalid",
    VALUE_TOO_HIGH: "value too high",
    VALUE_TOO_LOW: "value too low",
    0x06090036: "maximum less than minimum",
    0x060A0023: "resource not available",
    GENERAL_ERROR: "general error",
    0x08000020: "data cannot be transferred or stored",
    LOCAL_CONTROL: "data cannot be transferred or stored because of local control",
    DEVICE_STATE: "data cannot be transferred or stored in the present device state",
    0x08000023: "no object dictionary",
    NO_DATA: "no data available",
}
"""Texts of CiA 301, table 22."""


ANSWER: Final = "answer"
"""The first message that a client expects."""


class SdoAbort(Exception):
    """A transfer was aborted, or an access rejected; `code` is the abort code.

    `received`: the peer has sent it; otherwise this end did not accept the peer's message.
    `awaited` is the message that the client expected: `answer` to its request, `segment 3`.
    """

    def __init__(
        self, code: int, *, received: bool = False, awaited: str = ANSWER
    ) -> None:
        self.code = code
        self.received = received
        self.awaited = awaited
        self.within = 0
        """The time that the client has waited for the message, in ns; 0: it has come."""
        self.foreign = False
        """Whether messages have come meanwhile that do not belong to the transfer."""
        super().__init__(f"{code:08X}h {ABORT_TEXTS.get(code, 'unknown abort code')}")

    @property
    def explanation(self) -> str:
        """Who has ended the transfer of a client, and why."""
        if self.within:
            others = ", only messages of other transfers" if self.foreign else ""
            return f"no {self.awaited} within {self.within / 1e6:g} ms{others}"
        numbered = self.awaited.startswith("segment")
        what = self.awaited if numbered else f"the {self.awaited}"
        if not self.received:
            return f"{what} is not valid: {self}"
        if self.awaited == ANSWER:
            return f"the node refuses: {self}"
        return f"the node aborts in place of {what}: {self}"


class Target(msgspec.Struct, frozen=True, gc=False):
    """The object of a transfer: its multiplexer in octets 1 to 3."""

    index: int
    subindex: int

    @classmethod
    def of(cls, data: bytes) -> Target:
        """Return the object in a frame."""
        return cls(data[1] | data[2] << 8, data[3])

    def message(self, command: int, data: bytes = b"") -> bytes:
        """Return a message about the object, with up to 4 octets of data."""
        head = bytes((command, self.index & 0xFF, self.index >> 8, self.subindex))
        return head + data.ljust(EXPEDITED, b"\0")

    def abort(self, code: int) -> bytes:
        """Return the abort message."""
        return self.message(ABORT, code.to_bytes(4, "little"))


def size_octets(size: int) -> bytes:
    """Encode a length."""
    return size.to_bytes(4, "little")


def announced_size(data: bytes) -> int:
    """Return the length, or abort code, in octets 4 to 7."""
    return int.from_bytes(data[4:8], "little")


def expedited(command: int, target: Target, value: bytes) -> bytes:
    """Return an expedited message with a value of 1 to 4 octets."""
    unused = EXPEDITED - len(value)
    return target.message(command | unused << 2 | WITH_SIZE | SIZE_INDICATED, value)


def expedited_value(data: bytes) -> bytes:
    """Return the value in an expedited message; 4 octets if the size is not indicated."""
    unused = data[0] >> 2 & 3 if data[0] & SIZE_INDICATED else 0
    return data[4 : FRAME - unused]


def crc(data: bytes | bytearray) -> int:
    """Return the CRC of a block transfer: x^16+x^12+x^5+1 from 0 (CiA 301, 7.2.4.3.16)."""
    return binascii.crc_hqx(data, 0)


class Segments:
    """Splits a value into segments with the toggle bit."""

    def __init__(self, value: bytes) -> None:
        self._value = value
        self._at = 0
        self.toggle = 0

    @property
    def done(self) -> bool:
        """Whether the last segment has been sent; an empty value has one, too."""
        return self._at > 0 and self._at >= len(self._value)

    def next(self, command: int) -> bytes:
        """Return the next segment, with this command (CiA 301, 7.2.4.3.4 and .7)."""
        part = self._value[self._at : self._at + SEGMENT]
        self._at += SEGMENT
        last = LAST if self.done else 0
        head = command | self.toggle | (SEGMENT - len(part)) << 1 | last
        self.toggle ^= TOGGLE
        return bytes((head,)) + part.ljust(SEGMENT, b"\0")


class Collector:
    """Joins segments to a value: at most `limit` octets, exactly `size` if that was announced."""

    def __init__(self, limit: int, size: int | None) -> None:
        if size is not None and size > limit:
            raise SdoAbort(OUT_OF_MEMORY)
        self._limit = limit
        self._size = size
        self._value = bytearray()
        self._fruitless = 0
        self.toggle = 0

    def take(self, data: bytes) -> bool:
        """Append a segment; return whether it was the last one. Raises SdoAbort."""
        if data[0] & TOGGLE != self.toggle:
            raise SdoAbort(TOGGLE_ERROR)
        self.toggle ^= TOGGLE
        part = data[1 : FRAME - (data[0] >> 1 & 7)]
        self.add(part)
        is_last = bool(data[0] & LAST)
        self._fruitless = 0 if part or is_last else self._fruitless + 1
        if self._fruitless == _ATTEMPTS:
            raise SdoAbort(LENGTH_TOO_LOW)
        return is_last

    def add(self, part: bytes) -> None:
        """Append octets. Raises SdoAbort if there are too many."""
        self._value += part
        room = self._limit if self._size is None else self._size
        if len(self._value) > room:
            announced = self._size is not None
            raise SdoAbort(LENGTH_TOO_HIGH if announced else OUT_OF_MEMORY)

    def value(self) -> bytes:
        """Return the complete value. Raises SdoAbort if octets are missing."""
        if self._size is not None and len(self._value) != self._size:
            raise SdoAbort(LENGTH_TOO_LOW)
        return bytes(self._value)


class BlockSender:
    """Sends a value in blocks (CiA 301, 7.2.4.3.10 and .14), repeating lost segments."""

    def __init__(self, value: bytes) -> None:
        self._value = value
        self._at = 0
        self._sent = 0
        self._fruitless = 0

    @property
    def done(self) -> bool:
        """Whether every segment has been acknowledged; an empty value has one, too."""
        return self._at > 0 and self._at >= len(self._value)

    def block(self, size: int) -> list[bytes]:
        """Return the next block of up to `size` segments. Raises SdoAbort for an invalid size."""
        if not 1 <= size <= MAX_BLOCK:
            raise SdoAbort(BLOCK_SIZE_INVALID)
        segments: list[bytes] = []
        at = self._at
        while len(segments) < size:
            part = self._value[at : at + SEGMENT]
            at += SEGMENT
            last = at >= len(self._value)
            head = len(segments) + 1 | (LAST_IN_BLOCK if last else 0)
            segments.append(bytes((head,)) + part.ljust(SEGMENT, b"\0"))
            if last:
                break
        self._sent = len(segments)
        return segments

    def acknowledge(self, sequence: int) -> None:
        """Process the acknowledgement of the segments up to `sequence`. Raises SdoAbort."""
        self._fruitless = 0 if sequence else self._fruitless + 1
        if sequence > self._sent or self._fruitless == _ATTEMPTS:
            raise SdoAbort(SEQUENCE_INVALID)
        self._at += sequence * SEGMENT

    def end(self, with_crc: bool) -> bytes:
        """Return the message that ends the transfer."""
        unused = -len(self._value) % SEGMENT if self._value else SEGMENT
        check = crc(self._value) if with_crc else 0
        return (
            bytes((BLOCK_END | unused << 2,)) + check.to_bytes(2, "little") + bytes(5)
        )


class BlockReceiver:
    """Receives a value in blocks of `size` segments."""

    def __init__(
        self, limit: int, announced: int | None, size: int = MAX_BLOCK
    ) -> None:
        if announced is not None and announced > limit:
            raise SdoAbort(OUT_OF_MEMORY)
        self.size = size
        self._announced = announced
        self._limit = limit if announced is None else announced
        self._value = bytearray()
        self._sequence = 0
        self._fruitless = 0
        self.complete = False
        """Whether the last segment has arrived."""

    @property
    def next(self) -> int:
        """The number of the next segment in its block."""
        return self._sequence + 1

    def take(self, data: bytes) -> bytes | None:
        """Append a segment; return the acknowledgement at the end of a block. Raises SdoAbort.

        A segment out of sequence, and those after it, are expected again in the next block.
        """
        sequence = data[0] & ~LAST_IN_BLOCK
        last = bool(data[0] & LAST_IN_BLOCK)
        if not 1 <= sequence <= self.size:
            raise SdoAbort(SEQUENCE_INVALID)
        self._fruitless += 1
        if sequence == self._sequence + 1:
            self._fruitless = 0
            self._sequence = sequence
            self._value += data[1:FRAME]
            self.complete = last
            if len(self._value) - SEGMENT > self._limit:
                raise SdoAbort(OUT_OF_MEMORY)
        if self._fruitless == _ATTEMPTS * self.size:
            raise SdoAbort(SEQUENCE_INVALID)
        if not last and sequence < self.size:
            return None
        got, self._sequence = self._sequence, 0
        return bytes((BLOCK_ACKNOWLEDGED, got, self.size)) + bytes(5)

    def value(self, end: bytes, with_crc: bool) -> bytes:
        """Return the complete value, checked with the end message. Raises SdoAbort."""
        value = bytes(self._value[: len(self._value) - (end[0] >> 2 & 7)])
        if with_crc and int.from_bytes(end[1:3], "little") != crc(value):
            raise SdoAbort(CRC_ERROR)
        if len(value) > self._limit:
            raise SdoAbort(LENGTH_TOO_HIGH)
        if self._announced is not None and len(value) != self._announced:
            raise SdoAbort(LENGTH_TOO_LOW)
        return value
