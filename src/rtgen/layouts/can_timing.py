"""Load and worst-case response times of the messages on a CAN bus.

After R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien: "Controller Area Network (CAN)
schedulability analysis: Refuted, revisited and revised", Real-Time Systems 35 (2007): the longest
response among all instances of a message in its busy period, not that of the first one alone. All
times are whole nanoseconds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

NANOSECONDS = 1_000_000_000

_MOST_STEPS = 20_000
"""Steps of the iteration for a message; a bus so full that more are needed counts as overloaded."""


@dataclass(frozen=True, slots=True)
class Message:
    """A data frame that is sent again and again.

    `identifier` is that of 11 bits, or of 29 bits if `extended`; `octets` are its data. `period` is
    the least time between two of them; `jitter` how late one can be queued.
    """

    name: str
    identifier: int
    octets: int
    period: int
    jitter: int = 0
    extended: bool = False

    @property
    def priority(self) -> tuple[int, bool, int]:
        """What arbitration decides by: the least wins, a frame of 11 bits before one of 29."""
        if not self.extended:
            return self.identifier, False, 0
        return self.identifier >> 18, True, self.identifier & 0x3FFFF


@dataclass(frozen=True, slots=True)
class Timing:
    """What is worked out for a message; `response` is None where it has no bound, or nearly so."""

    message: Message
    transmission: int
    response: int | None


def frame_bits(octets: int, extended: bool = False) -> int:
    """The most bits of a data frame, stuff bits and the gap of three bits after it included."""
    fixed = 54 if extended else 34
    stuffed = fixed + 8 * octets
    return stuffed + 13 + (stuffed - 1) // 4


def bit_time(bit_rate: int) -> int:
    """The time of a bit, rounded up; the rate is in kbit/s."""
    return -(-1_000_000 // bit_rate)


def load(messages: Sequence[Message], bit_rate: int) -> float:
    """The share of the bus's time that the messages take at most; above 1 they do not fit."""
    return sum(_transmission(m, bit_rate) / m.period for m in messages)


def response_times(messages: Sequence[Message], bit_rate: int) -> Iterator[Timing]:
    """The worst case of each message, the most urgent first; the rate is in kbit/s.

    A response time is that from the event that a message tells of to the end of its frame.
    """
    ordered = sorted(messages, key=lambda m: m.priority)
    for place, message in enumerate(ordered):
        higher, lower = ordered[:place], ordered[place + 1 :]
        response = None
        if load([*higher, message], bit_rate) < 1:
            response = _response(message, higher, lower, bit_rate)
        yield Timing(message, _transmission(message, bit_rate), response)


def _transmission(message: Message, bit_rate: int) -> int:
    return frame_bits(message.octets, message.extended) * bit_time(bit_rate)


def _response(
    message: Message, higher: Sequence[Message], lower: Sequence[Message], bit_rate: int
) -> int | None:
    own = _transmission(message, bit_rate)
    blocking = max((_transmission(m, bit_rate) for m in lower), default=0)
    interference = [(m.period, m.jitter, _transmission(m, bit_rate)) for m in higher]
    urgent = [*interference, (message.period, message.jitter, own)]
    steps = 0
    busy = own
    while (longer := blocking + _demand(urgent, busy)) != busy:
        busy = longer
        steps += 1
        if steps > _MOST_STEPS:
            return None
    instances = _ceiling(busy + message.jitter, message.period)
    worst = waiting = 0
    for instance in range(instances):
        before = blocking + instance * own
        waiting = max(waiting, before)
        while (
            longer := before + _demand(interference, waiting + bit_time(bit_rate))
        ) != waiting:
            waiting = longer
            steps += 1
        steps += 1
        if steps > _MOST_STEPS:
            return None
        response = message.jitter + waiting - instance * message.period + own
        worst = max(worst, response)
    return worst


def _demand(messages: Sequence[tuple[int, int, int]], time: int) -> int:
    """The bus time that (period, jitter, transmission) ask for within a time."""
    return sum(_ceiling(time + jitter, period) * c for period, jitter, c in messages)


def _ceiling(dividend: int, divisor: int) -> int:
    return -(-dividend // divisor)
