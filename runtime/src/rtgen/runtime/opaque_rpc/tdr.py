"""TDR, the data representation of TECS RPC: octets of basic values.

There are two kinds: `tNBOTDR`, network byte order with widths fixed by macros, and `tTDR`, byte
order and widths of the machine. They cannot be distinguished on the wire; both ends must be
configured.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Final, Literal, TypeAlias

import msgspec

from rtgen.facts.tdr import STRUCT_CODES, WIDTH_NAMES

Order: TypeAlias = Literal["network", "little", "big"]
"""`network` is `tNBOTDR`; `little` and `big` are `tTDR` of a machine with that byte order."""

SOP_REQUEST: Final = 0x672A
SOP_REPLY: Final = 0x561E
EOP_REPLY_FOLLOWS: Final = 0x5A3C
EOP_NOTHING_FOLLOWS: Final = 0x6D5E
SHARED_BEGIN: Final = 0x3141
"""Marker of a shared channel before the number of the sub-channel."""
SHARED_END: Final = 0x2718
"""Marker of a shared channel after an exchange."""


class Tdr(msgspec.Struct, frozen=True, gc=False):
    """A data representation. Widths are in bits: 16, 32 or 64.

    `low_word_first` applies to 128-bit integers in network order: a little-endian peer sends the
    low 8 bytes first, each half in network order; a big-endian one sends the high half first.
    """

    order: Order
    short_bits: int
    int_bits: int
    long_bits: int
    intptr_bits: int
    low_word_first: bool

    def __post_init__(self) -> None:
        if self.order not in ("network", "little", "big"):
            raise ValueError(f"{self.order!r} is not a TDR: network, little or big")
        for bits in (self.short_bits, self.int_bits, self.long_bits, self.intptr_bits):
            if bits not in STRUCT_CODES:
                raise ValueError(f"{bits} bits: a width is 16, 32 or 64")

    @property
    def byte_order(self) -> Literal["little", "big"]:
        """Byte order of a number on the wire."""
        return "little" if self.order == "little" else "big"

    def struct(self, kinds: str) -> struct.Struct:
        """Return the compiled form of a run of values.

        A kind is a letter of the `struct` module of a fixed size (`?bBhHiIqQfds`, also with
        counts), or one whose width is defined by the TDR: `k` short, `n` int, `l` long, `p`
        intptr_t, upper case if unsigned.
        """
        return struct.Struct(
            ("<" if self.order == "little" else ">") + self._own(kinds)
        )

    def int16(self, value: int) -> bytes:
        """Encode a magic number or function id, 0 to 0xFFFF."""
        return value.to_bytes(2, self.byte_order)

    def wide(self, value: int, signed: bool) -> bytes:
        """Encode a 128-bit integer. Raises OverflowError."""
        data = value.to_bytes(16, self.byte_order, signed=signed)
        return self._swapped(data)

    def from_wide(self, data: bytes, signed: bool) -> int:
        """Decode a 128-bit integer of 16 bytes."""
        return int.from_bytes(self._swapped(data), self.byte_order, signed=signed)

    def _swapped(self, data: bytes) -> bytes:
        if self.order == "network" and self.low_word_first:
            return data[8:] + data[:8]
        return data

    def _own(self, kinds: str) -> str:
        for letter, name in WIDTH_NAMES.items():
            code = STRUCT_CODES[getattr(self, name)]
            kinds = kinds.replace(letter, code)
            kinds = kinds.replace(letter.upper(), code.upper())
        return kinds


def make_tdr(
    order: Order = "network",
    *,
    short_bits: int = 16,
    int_bits: int = 32,
    long_bits: int | None = None,
    intptr_bits: int | None = None,
    low_word_first: bool = True,
) -> Tdr:
    """Return a TDR; by default, long and intptr_t have 32 bits in network order, else 64.

    Raises ValueError for an unknown order or width.
    """
    usual = 32 if order == "network" else 64
    return Tdr(
        order,
        short_bits,
        int_bits,
        long_bits or usual,
        intptr_bits or usual,
        low_word_first,
    )


NETWORK: Final = make_tdr("network")
LITTLE: Final = make_tdr("little")
BIG: Final = make_tdr("big")

INT8: Final[Mapping[int, int]] = {v: (v & 0xFF ^ 0x80) - 0x80 for v in range(-128, 256)}
"""8-bit integers as signed ones: 128 to 255 are accepted for the same bits."""
UINT8: Final[Mapping[int, int]] = {v: v & 0xFF for v in range(-128, 256)}
"""8-bit integers as unsigned ones: -128 to -1 are accepted for the same bits."""


class Items:
    """The scalars of one kind in arrays of any length.

    `width` is in bytes; the kinds `w` and `W` are 128-bit integers.
    """

    def __init__(self, tdr: Tdr, kind: str) -> None:
        self._tdr = tdr
        self._kind = kind
        self._sign = "<" if tdr.order == "little" else ">"
        if kind in "wW":
            self._letter, self.width = "", 16
        else:
            one = tdr.struct(kind)
            self._letter, self.width = one.format[1:], one.size

    def pack(self, values: Sequence[int] | Sequence[float] | Sequence[bool]) -> bytes:
        """Encode values. Raises struct.error, OverflowError or KeyError."""
        if self._kind == "b":
            return bytes([UINT8[int(value)] for value in values])
        if not self._letter:
            signed = self._kind == "w"
            return b"".join([self._tdr.wide(int(v), signed) for v in values])
        return self._run(len(values)).pack(*values)

    def integers(self, data: bytes, count: int, offset: int = 0) -> list[int]:
        """Decode `count` integers at the offset."""
        if not self._letter:
            signed = self._kind == "w"
            ends = range(offset + 16, offset + 16 * count + 1, 16)
            return [self._tdr.from_wide(data[end - 16 : end], signed) for end in ends]
        return list(self._run(count).unpack_from(data, offset))

    def booleans(self, data: bytes, count: int, offset: int = 0) -> list[bool]:
        """Decode `count` booleans at the offset; each byte but 0 is true."""
        return list(self._run(count).unpack_from(data, offset))

    def floats(self, data: bytes, count: int, offset: int = 0) -> list[float]:
        """Decode `count` floating-point numbers at the offset."""
        return list(self._run(count).unpack_from(data, offset))

    def _run(self, count: int) -> struct.Struct:
        return _compiled(f"{self._sign}{count}{self._letter}")


@lru_cache(256)
def _compiled(form: str) -> struct.Struct:
    return struct.Struct(form)
