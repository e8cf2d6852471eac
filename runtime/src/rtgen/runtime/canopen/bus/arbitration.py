"""Arbitration and timing of frames on a CAN bus (ISO 11898-1)."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable
from functools import lru_cache
from heapq import heapify, heappop, heappush
from typing import Final, Generic, TypeVar

from rtgen.runtime.canopen.wire.frames import SECOND, Frame

S = TypeVar("S", bound=Hashable)


_CRC: Final = 0x4599
_CRC_BITS: Final = 15
_BEHIND_CRC: Final = 13
"""CRC delimiter, acknowledgement (2 bits), end of frame (7) and intermission (3)."""


class Arbiter(Generic[S]):
    """The frames that wait for a bus.

    Frames of one sender keep their order, as in the queue of a SocketCAN interface. Among the first
    frames of all senders the lowest identifier wins, then the earliest arrival.
    """

    def __init__(self) -> None:
        self._queues: dict[S, deque[tuple[int, Frame]]] = {}
        self._heads: list[tuple[int, int, S]] = []
        self._added = 0
        self._length = 0

    def __len__(self) -> int:
        return self._length

    def waiting(self, sender: S) -> int:
        """Return the number of frames of a sender that wait."""
        return len(self._queues.get(sender, ()))

    def put(self, sender: S, frame: Frame) -> int:
        """Queue a frame; return the number of frames of the sender that wait."""
        self._added += 1
        self._length += 1
        queue = self._queues.get(sender)
        if queue is None:
            queue = self._queues[sender] = deque()
            heappush(self._heads, (priority(frame), self._added, sender))
        queue.append((self._added, frame))
        return len(queue)

    def take(self) -> tuple[S, Frame]:
        """Remove and return the frame that wins arbitration, and its sender.

        Raises IndexError if empty.
        """
        sender = heappop(self._heads)[2]
        queue = self._queues[sender]
        frame = queue.popleft()[1]
        self._length -= 1
        if queue:
            added, following = queue[0]
            heappush(self._heads, (priority(following), added, sender))
        else:
            del self._queues[sender]
        return sender, frame

    def drop(self, sender: S) -> int:
        """Drop the frames of a sender; return their number."""
        dropped = len(self._queues.pop(sender, ()))
        if dropped:
            self._heads = [head for head in self._heads if head[2] != sender]
            heapify(self._heads)
            self._length -= dropped
        return dropped

    def clear(self) -> int:
        """Drop all frames; return their number."""
        dropped = self._length
        self._queues.clear()
        self._heads.clear()
        self._length = 0
        return dropped


def priority(frame: Frame) -> int:
    """Return the arbitration field in transmission order, most significant bit first.

    The lowest value wins.
    """
    if frame.extended:
        base, rest = frame.can_id >> 18, frame.can_id & 0x3FFFF
        return base << 21 | 0b11 << 19 | rest << 1 | frame.remote
    return frame.can_id << 21 | frame.remote << 20


def transmission_time(frame: Frame, bit_rate: int) -> int:
    """Return the time that a frame occupies the bus, in ns; `bit_rate` in bit/s."""
    return frame_bits(frame) * SECOND // bit_rate


def frame_bits(frame: Frame) -> int:
    """Return the length of a frame in bits, with stuff bits and the intermission of three bits."""
    # The data length code of a remote frame is 0 here.
    data = b"" if frame.remote else frame.data
    bits, register, state = _header(
        frame.can_id, frame.extended, frame.remote, len(data)
    )
    for octet in data:
        register = (register << 8 ^ _CRCS[(register >> 7 ^ octet) & 0xFF]) & 0x7FFF
        state, more = _STUFFING[state << 8 | octet]
        bits += more
    state, more = _STUFFING[state << 8 | register >> 7]
    # The octet is filled with a bit that adds no stuff bit.
    return (
        bits + more + _STUFFING[state << 8 | (register << 1 & 0xFF) | ~register & 1][1]
    )


@lru_cache(4096)
def _header(
    can_id: int, extended: bool, remote: bool, length: int
) -> tuple[int, int, int]:
    """Return the unstuffed bits of a frame after its header, and CRC and state there."""
    if extended:
        base, rest = can_id >> 18, can_id & 0x3FFFF
        header = ((base << 2 | 0b11) << 18 | rest) << 7 | remote << 6 | length
        bits = 39
    else:
        header = can_id << 7 | remote << 6 | length
        bits = 19
    fill = -bits % 8
    size = (bits + fill) // 8
    register = 0
    for octet in header.to_bytes(size, "big"):
        register = (register << 8 ^ _CRCS[(register >> 7 ^ octet) & 0xFF]) & 0x7FFF
    # Preceding bits are filled with alternating bits ending in 1, which add no stuff bits.
    filled = header | (0x55 & (1 << fill) - 1) << bits
    state, stuffed = 4, 0
    for octet in filled.to_bytes(size, "big"):
        state, more = _STUFFING[state << 8 | octet]
        stuffed += more
    return bits + stuffed + 8 * length + _CRC_BITS + _BEHIND_CRC, register, state


def _crc_of(octet: int) -> int:
    register = octet << 7
    for _ in range(8):
        register = (
            register << 1 ^ _CRC if register & 0x4000 else register << 1
        ) & 0x7FFF
    return register


def _stuffing(state: int, octet: int) -> tuple[int, int]:
    """Return the state after an octet, and its stuff bits.

    State: run length - 1, plus 4 if the level is 1.
    """
    level, run, stuffed = state >> 2, (state & 3) + 1, 0
    for place in range(7, -1, -1):
        bit = octet >> place & 1
        run = run + 1 if bit == level else 1
        level = bit
        if run == 5:
            stuffed += 1
            level, run = 1 - level, 1
    return level << 2 | run - 1, stuffed


_CRCS: Final = tuple(_crc_of(octet) for octet in range(256))
_STUFFING: Final = tuple(
    _stuffing(state, octet) for state in range(8) for octet in range(256)
)
