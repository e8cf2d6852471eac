"""Functions that pack a format of `struct`, which join large octets to the rest.

In these formats, `s` is octets and `o` is octets in any object with a buffer (numbers of an array).
"""

from __future__ import annotations

import re
import struct
import sys
from collections.abc import Callable
from itertools import zip_longest
from struct import Struct
from typing import Any, Final

LARGE: Final = 10_000
"""From this number of octets, `o` may be an array or a view. Fewer have to be `bytes`."""

_LARGE = re.compile(r"(?:\d{5,}(?=o)|\d{6,}(?=s))([os])")
"""Octets that are joined. For less than 100,000 that are `bytes`, the calls take longer."""

_NATIVE = "<" if sys.byteorder == "little" else ">"


def struct_of(order: str, format_: str) -> Struct:
    """Return the `Struct` of a format in a byte order.

    If the machine's own layout is the same, native mode is used: it packs and reads doubles in 0.8
    of the time, but does not reject floats that are too large. Native mode only ever adds padding.
    """
    format_ = format_.replace("o", "s")
    if (
        order == _NATIVE
        and "d" in format_
        and not {"e", "f"} & {*format_}
        and struct.calcsize(f"@{format_}") == struct.calcsize(order + format_)
    ):
        order = "@"
    return Struct(order + format_)


def packer(order: str, format_: str) -> Callable[..., bytes]:
    """Return the function that packs a format.

    `struct` copies octets to a message that it has filled with zeros; large ones are joined to the
    rest, which copies them once. That function also raises ValueError.
    """
    whole = struct_of(order, format_)
    texts = _LARGE.split(format_)
    if len(texts) == 1:
        return whole.pack
    steps = []
    start = 0
    for text, code in zip_longest(texts[::2], texts[1::2], fillvalue=""):
        if code == "s":
            text += "0s"  # lets `struct` check the type of the octets
        small = struct_of(order, text)
        end = start + len(small.unpack(bytes(small.size)))
        large = end - (code == "s")
        if code or small.size:
            steps.append((small.pack, slice(start, end), slice(large, large + 1)))
        start = large + 1

    def pack(*values: Any) -> bytes:
        parts: list[Any] = []
        for pack_small, few, large in steps:
            parts.append(pack_small(*values[few]))
            parts += values[large]
        octets = b"".join(parts)
        if len(octets) != whole.size:
            raise ValueError("a member changed while it was encoded")
        return octets

    return pack
