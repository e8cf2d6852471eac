"""Numbers of samples in their encapsulation headers, by which losses are counted.

Cyclone DDS neither shows the sequence numbers of samples nor counts those that a reliable writer
overwrote. DDS-XTypes 1.3, 7.6.3.1.2, uses the two low bits of the header's options for padding, and
lets receivers ignore the others: 14 bits, which hold a number from 1 to 16383. 0 is a sample of
another program.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable

_CYCLE = (1 << 14) - 1
DOUBLE = -1
WRITERS = 256
"""Maximum number of writers of one topic whose numbers are stored."""


def numbered(octets: bytes, sequence: int) -> bytearray:
    """Return a payload with its number, as the only copy."""
    number = (sequence - 1) % _CYCLE + 1
    marked = bytearray(octets)
    marked[2] = number >> 6
    marked[3] = number << 2 & 0xFC | octets[3] & 3
    return marked


def plain(octets: bytes | bytearray) -> bytes:
    """Return the payload without its number."""
    return b"".join((octets[:2], bytes((0, octets[3] & 3)), memoryview(octets)[4:]))


class Numbers:
    """Extends the numbers of each writer beyond their 14 bits."""

    def __init__(self) -> None:
        self._last: OrderedDict[Hashable, tuple[int, int]] = OrderedDict()
        """By writer: the number and the time stamp of the last sample."""

    def sequence(
        self, source: Hashable, octets: bytes | bytearray, stamp: int
    ) -> int | None:
        """Return the sequence number of a payload; None without one, DOUBLE for a duplicate.

        A writer's samples arrive in order, so each is less than a cycle after the previous one. A
        write that found no room with one reader of its process, and was repeated, arrives twice at
        the others; a durable writer that was out of reach sends its last samples again, with the
        time stamps [ns] of their writes.
        """
        number = int.from_bytes(octets[2:4], "big") >> 2
        if not number:
            return None
        last = self._last.get(source)
        if last is None:
            sequence = number
        else:
            step = (number - last[0]) % _CYCLE
            if not step or (stamp <= last[1] and step > _CYCLE // 2):
                return DOUBLE
            sequence = last[0] + step
        self._last[source] = sequence, stamp
        if len(self._last) > WRITERS:
            self._last.popitem(last=False)
        return sequence
