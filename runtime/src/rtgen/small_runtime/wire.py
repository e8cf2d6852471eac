# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""CDR, little-endian, in a preallocated buffer."""

import struct

_NOT_PACKED = (getattr(struct, "error", ValueError), ValueError, OverflowError)
"""Exceptions of `struct`; MicroPython's module does not define `error`."""


class CodecError(ValueError):
    """Octets that are not a value of the type, or a buffer that is too short."""


class Wire:
    """CDR, little-endian, in a preallocated buffer. `at` is the next offset."""

    __slots__ = ("at", "buffer", "end")

    def __init__(self, buffer: bytearray, end: int = -1) -> None:
        self.buffer = buffer
        self.at = 0
        self.end = len(buffer) if end < 0 else end

    def put(self, form: str, size: int, value: float) -> None:
        """Append a number of that format and size. Raises CodecError."""
        self._align(size)
        if self.at + size > self.end:
            raise CodecError("the buffer is too short")
        try:
            struct.pack_into(form, self.buffer, self.at, value)
        except _NOT_PACKED as error:
            raise CodecError(str(error)) from error
        self.at += size

    def take(self, form: str, size: int):
        """Return the next number. Raises CodecError."""
        self._align(size)
        if self.at + size > self.end:
            raise CodecError("the octets end too early")
        value = struct.unpack_from(form, self.buffer, self.at)[0]
        self.at += size
        return value

    def _align(self, size: int) -> None:
        while self.at % size:
            if self.at < self.end:
                self.buffer[self.at] = 0
            self.at += 1

    def take_boolean(self) -> bool:
        """Return the next boolean. Raises CodecError."""
        value = self.take("<B", 1)
        if value > 1:
            raise CodecError(f"{value} is not a boolean")
        return bool(value)

    def put_octets(self, value: bytes) -> None:
        """Append octets without a length. Raises CodecError."""
        end = self.at + len(value)
        if end > self.end:
            raise CodecError("the buffer is too short")
        self.buffer[self.at : end] = value
        self.at = end

    def take_octets(self, length: int) -> bytes:
        """Return the next `length` octets. Raises CodecError."""
        end = self.at + length
        if end > self.end:
            raise CodecError("the octets end too early")
        value = bytes(self.buffer[self.at : end])
        self.at = end
        return value

    def put_string(self, value: str) -> None:
        """Append a string. Raises CodecError."""
        octets = value.encode()
        if b"\x00" in octets:
            raise CodecError("a string cannot hold NUL")
        self.put("<I", 4, len(octets) + 1)
        self.put_octets(octets)
        self.put("<B", 1, 0)

    def take_string(self, most: int) -> str:
        """Return the next string, of at most `most` octets of UTF-8. Raises CodecError."""
        length = self.take_count(most + 1)
        octets = self.take_octets(length)
        if not octets or octets[-1]:
            raise CodecError("a string does not end with NUL")
        try:
            text = octets[:-1].decode()
        except UnicodeError as error:
            raise CodecError("a string is not UTF-8") from error
        if "\x00" in text:
            raise CodecError("a string cannot hold NUL")
        return text

    def take_count(self, most: int) -> int:
        """Return the count before a sequence. Raises CodecError."""
        count = self.take("<I", 4)
        if count > most:
            raise CodecError(f"{count} items, room for {most}")
        return int(count)


def to_cdr(sample, buffer: bytearray) -> int:
    """Encode a sample as CDR, little-endian; return the number of octets. Raises CodecError."""
    wire = Wire(buffer)
    sample._put_(wire)
    return wire.at


def from_cdr(sample, buffer: bytearray, length: int) -> None:
    """Decode a sample from CDR, little-endian, of exactly that length. Raises CodecError."""
    wire = Wire(buffer, length)
    sample._take_(wire)
    if wire.at != length:
        raise CodecError(f"{length - wire.at} octets too many")
