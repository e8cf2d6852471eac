"""Load and worst-case response times of the messages on a CAN bus.

R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien: "Controller Area Network (CAN) schedulability
analysis: Refuted, revisited and revised", Real-Time Systems 35 (2007): the longest response is that
of all instances of a message in its busy period, not of the first one only. For messages that leave
a station in order of arrival: R. I. Davis, N. Navet: "Controller Area Network (CAN) schedulability
analysis for messages with arbitrary deadlines in FIFO and work-conserving queues" (2012). All times
are whole nanoseconds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import TypeAlias

import msgspec

NANOSECONDS = 1_000_000_000

_MAX_STEPS = 20_000
"""Maximum number of iterations for a message; a bus that needs more counts as overloaded."""
_MAX_ROUNDS = 200
"""Maximum number of rounds until jitters that depend on responses are stable."""


class Message(msgspec.Struct, frozen=True):
    """A frame that is sent repeatedly.

    `identifier` has 11 bits, or 29 bits if `extended`; `octets` is its length. `period` is the
    minimum time between two of them; `jitter` the maximum delay of queuing. Messages of the same
    `queue` leave their station in order of arrival; others compete by priority. One with a
    `trigger` is queued when the message of that name has ended.
    """

    name: str
    identifier: int
    octets: int
    period: int
    jitter: int = 0
    extended: bool = False
    remote: bool = False
    queue: str = ""
    trigger: str = ""

    @property
    def priority(self) -> tuple[int, int, int]:
        """The arbitration priority: the smallest wins.

        Among equal identifiers a data frame of 11 bits wins, then a remote frame, then 29 bits.
        """
        if not self.extended:
            return self.identifier, int(self.remote), 0
        return self.identifier >> 18, 2, self.identifier & 0x3FFFF


class Timing(msgspec.Struct, frozen=True):
    """The timing of a message; `response` is None if unbounded, or too large to compute."""

    message: Message
    transmission: int
    response: int | None


def frame_bits(octets: int, extended: bool = False) -> int:
    """Return the maximum bits of a data frame with stuff bits and interframe space."""
    fixed = 54 if extended else 34
    stuffed = fixed + 8 * octets
    return stuffed + 13 + (stuffed - 1) // 4


def bit_time(bit_rate: int) -> int:
    """Return the time of a bit, rounded up; the rate is in kbit/s."""
    return -(-1_000_000 // bit_rate)


def load(messages: Sequence[Message], bit_rate: int) -> float:
    """Return the worst-case utilization of the bus by the messages; above 1 it is overloaded."""
    return sum(_transmission(m, bit_rate) / m.period for m in messages)


def response_times(messages: Sequence[Message], bit_rate: int) -> Iterator[Timing]:
    """Yield the worst case of each message, the most urgent first; the rate is in kbit/s.

    A response time extends from the event that triggers a message to the end of its frame.
    """
    ordered = sorted(messages, key=lambda m: m.priority)
    delays = _Delays(ordered, bit_rate)
    for _ in range(_MAX_ROUNDS):
        if not delays.improve():
            break
    else:
        delays.give_up()
    for message, response in zip(ordered, delays.responses, strict=True):
        yield Timing(message, _transmission(message, bit_rate), response)


_Arriving: TypeAlias = tuple[int, int, int]
"""The arrival of a message at arbitration: period, jitter, transmission time."""


class _Delays:
    """Response times and jitters, which increase with the responses of triggers and queues.

    `messages` are in order of priority. Jitters never decrease from round to round; None if
    unbounded.
    """

    def __init__(self, messages: Sequence[Message], bit_rate: int) -> None:
        self.responses: list[int | None] = [None] * len(messages)
        self._messages = messages
        self._bit = bit_time(bit_rate)
        self._costs = [_transmission(m, bit_rate) for m in messages]
        self._blocking = _suffix_maxima(self._costs)
        shares = (c / m.period for c, m in zip(self._costs, messages, strict=True))
        self._loads = list(accumulate(shares))
        self._places = {message.name: n for n, message in enumerate(messages)}
        self._jitters: list[int | None] = [message.jitter for message in messages]
        self._waits: dict[str, int | None] = {m.queue: 0 for m in messages if m.queue}

    def improve(self) -> bool:
        """Recompute all responses; return whether a jitter has changed."""
        arriving = list(map(self._arriving, range(len(self._messages))))
        waits = {queue: self._queue_wait(queue, arriving) for queue in self._waits}
        bounded = True
        for place, message in enumerate(self._messages):
            if message.queue:
                own = min(self._costs[n] for n in self._members(message.queue))
                wait = waits[message.queue]
                response = _sum(wait, self._jitters[place], own)
            else:
                response = self._response(place, arriving) if bounded else None
            self.responses[place] = response
            bounded = bounded and arriving[place] is not None
        jitters = [
            (
                _sum(m.jitter, self.responses[self._places[m.trigger]])
                if m.trigger
                else m.jitter
            )
            for m in self._messages
        ]
        changed = (jitters, waits) != (self._jitters, self._waits)
        self._jitters, self._waits = jitters, waits
        return changed

    def give_up(self) -> None:
        """Mark all responses as unbounded."""
        self.responses = [None] * len(self._messages)

    def _arriving(self, place: int) -> _Arriving | None:
        """Return the arrival of a message at arbitration; None if its delay is unbounded."""
        message = self._messages[place]
        queued = self._waits[message.queue] if message.queue else 0
        jitter = _sum(self._jitters[place], queued)
        return None if jitter is None else (message.period, jitter, self._costs[place])

    def _members(self, queue: str) -> list[int]:
        return [n for n, m in enumerate(self._messages) if m.queue == queue]

    def _response(self, place: int, arriving: list[_Arriving | None]) -> int | None:
        own = arriving[place]
        if own is None or self._loads[place] >= 1:
            return None
        interference = [each for each in arriving[:place] if each is not None]
        return _response(own, interference, self._blocking[place], self._bit)

    def _queue_wait(self, queue: str, arriving: list[_Arriving | None]) -> int | None:
        """Return the longest wait of a queue's last message for arbitration.

        Each message must be in the queue at most once; otherwise there is no bound.
        """
        places = self._members(queue)
        last = places[-1]
        others = [n for n in range(last) if self._messages[n].queue != queue]
        higher = [each for n in others if (each := arriving[n]) is not None]
        if len(higher) < len(others) or self._loads[last] >= 1:
            return None
        costs = [self._costs[n] for n in places]
        blocking = max(*costs, self._blocking[last])
        before = blocking + sum(costs) - min(costs)
        wait = before
        for _ in range(_MAX_STEPS):
            longer = before + _demand(higher, wait + self._bit)
            if longer == wait:
                break
            wait = longer
        else:
            return None
        for place in places:
            response = _sum(self._jitters[place], wait, min(costs))
            if response is None or response > self._messages[place].period:
                return None
        return wait


def _suffix_maxima(costs: Sequence[int]) -> list[int]:
    """Return for each position the greatest of the following costs."""
    maxima, greatest = [], 0
    for cost in reversed(costs):
        maxima.append(greatest)
        greatest = max(greatest, cost)
    return maxima[::-1]


def _sum(*times: int | None) -> int | None:
    finite = [time for time in times if time is not None]
    return sum(finite) if len(finite) == len(times) else None


def _transmission(message: Message, bit_rate: int) -> int:
    return frame_bits(message.octets, message.extended) * bit_time(bit_rate)


def _response(
    message: _Arriving, interference: Sequence[_Arriving], blocking: int, bit: int
) -> int | None:
    """Return the longest response among the instances of a busy period."""
    period, jitter, own = message
    urgent = [*interference, message]
    steps = 0
    busy = own
    while (longer := blocking + _demand(urgent, busy)) != busy:
        busy = longer
        steps += 1
        if steps > _MAX_STEPS:
            return None
    instances = _ceiling(busy + jitter, period)
    worst = waiting = 0
    for instance in range(instances):
        before = blocking + instance * own
        waiting = max(waiting, before)
        while (longer := before + _demand(interference, waiting + bit)) != waiting:
            waiting = longer
            steps += 1
        steps += 1
        if steps > _MAX_STEPS:
            return None
        response = jitter + waiting - instance * period + own
        worst = max(worst, response)
    return worst


def _demand(messages: Sequence[_Arriving], time: int) -> int:
    """Return the bus time that messages require within an interval."""
    return sum(_ceiling(time + jitter, period) * c for period, jitter, c in messages)


def _ceiling(dividend: int, divisor: int) -> int:
    return -(-dividend // divisor)
