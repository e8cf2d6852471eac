"""Simulates random schedules on a CAN bus, and compares them with computed response times.

    python tests/fuzz/can_schedules.py 10000 [FIRST]

Each number is a bus: messages with random identifiers, lengths, periods, jitters and stations,
random times of their events, and random data with their stuff bits. Arbitration is simulated frame
by frame (CSMA/CR). A response later than the computed one is a defect.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from random import Random

from fuzzing import ViolationError

from rtgen.compiler.layouts.can_timing import (
    Message,
    bit_time,
    frame_bits,
    response_times,
)
from rtgen.runtime.canopen.bus.arbitration import frame_bits as real_bits
from rtgen.runtime.canopen.wire.frames import Frame

FRAMES = 250
"""Number of frames of a schedule."""
_US = 1000


@dataclass(slots=True)
class _Instance:
    """An event of a message, and the time since when its frame waits."""

    message: Message
    event: int
    queued: int
    cost: int


class Bus:
    """A bus with a random schedule, and its results."""

    def __init__(self, number: int) -> None:
        random = self._random = Random(number)
        self.messages: list[Message] = []
        self.worst: dict[str, int] = {}
        """The longest response of each message that was sent."""
        self.bit_rate = random.choice((50, 125, 250, 500, 1000))
        # Half of the buses carry the longest possible frames.
        self._longest = random.random() < 0.5
        self._punctual = random.random() < 0.5
        count = random.randint(2, 12)
        identifiers = random.sample(range(1, 0x7F0), count)
        room = count / random.uniform(0.3, 0.95)
        for place, identifier in enumerate(identifiers):
            octets, extended = random.randint(0, 8), random.random() < 0.2
            cost = frame_bits(octets, extended) * bit_time(self.bit_rate)
            period = round(cost * room * random.uniform(0.8, 4.0))
            jitter = random.choice((0, 0, random.randrange(period)))
            queue = "host" if random.random() < 0.4 else ""
            trigger = "m0" if place and random.random() < 0.2 else ""
            if extended:
                identifier = identifier << 18 | random.getrandbits(18)
            self.messages.append(
                Message(
                    f"m{place}", identifier, octets, period,
                    jitter=0 if trigger else jitter, extended=extended, queue=queue,
                    trigger=trigger,
                )
            )  # fmt: skip
        # A triggered message comes as often as its trigger.
        period = self.messages[0].period
        self.messages = [
            Message(
                m.name, m.identifier, m.octets, period, extended=m.extended,
                queue=m.queue, trigger=m.trigger,
            ) if m.trigger else m
            for m in self.messages
        ]  # fmt: skip

    def run(self) -> None:
        """Simulate `FRAMES` frames; record the longest response of each message."""
        coming: list[tuple[int, int, _Instance]] = []
        events = {m.name: self._events(m) for m in self.messages if not m.trigger}
        for place, message in enumerate(self.messages):
            if not message.trigger:
                first = next(events[message.name])
                heappush(coming, (first.queued, place, first))
        waiting: dict[str, deque[_Instance]] = {}
        now, added = 0, len(self.messages)
        for _ in range(FRAMES):
            if not any(waiting.values()):
                now = max(now, coming[0][0])
            while coming and coming[0][0] <= now:
                instance = heappop(coming)[2]
                message = instance.message
                line = waiting.setdefault(message.queue or message.name, deque())
                line.append(instance)
                if not message.trigger:
                    added += 1
                    following = next(events[message.name])
                    heappush(coming, (following.queued, added, following))
            heads = [line for line in waiting.values() if line]
            line = min(heads, key=lambda line: line[0].message.priority)
            sent = line.popleft()
            now += sent.cost
            name = sent.message.name
            self.worst[name] = max(self.worst.get(name, 0), now - sent.event)
            for message in self.messages:
                if message.trigger == name:
                    added += 1
                    triggered = _Instance(message, sent.event, now, self._cost(message))
                    heappush(coming, (now, added, triggered))

    def _events(self, message: Message) -> Iterator[_Instance]:
        """Yield the events of a message, at least a period apart; frames keep their order."""
        random, queued = self._random, 0
        event = 0 if random.random() < 0.5 else random.randrange(message.period)
        late = message.jitter
        while True:
            queued = max(queued, event + late)
            yield _Instance(message, event, queued, self._cost(message))
            pause = 0 if self._punctual else random.choice((0, 0, message.period))
            event += message.period + (random.randrange(pause) if pause else 0)
            # The first event late, later ones in time: the worst case for others.
            late = random.choice((0, random.randint(0, message.jitter)))

    def _cost(self, message: Message) -> int:
        bits = frame_bits(message.octets, message.extended)
        if not self._longest:
            octet = self._random.choice((0x00, 0xFF, 0x0F, None))
            data = (
                self._random.randbytes(message.octets)
                if octet is None
                else bytes((octet,)) * message.octets
            )
            bits = real_bits(Frame(message.identifier, data, extended=message.extended))
        return bits * bit_time(self.bit_rate)


class ScheduleTarget:
    """The schedules as a target of `fuzzing.run`."""

    def __init__(self, folder: Path) -> None:
        pass

    def known(self, message: Message) -> Message:
        """Return a message as input of the analysis."""
        return message

    def make(self, number: int) -> bytes:
        return str(number).encode()

    def check(self, number: int, data: bytes) -> Iterator[str]:
        bus = Bus(number)
        known = list(map(self.known, bus.messages))
        bounds = {
            t.message.name: t.response for t in response_times(known, bus.bit_rate)
        }
        bus.run()
        for name, worst in bus.worst.items():
            bound = bounds[name]
            yield "no bound" if bound is None else "bound"
            if bound is None:
                continue
            if worst > bound:
                raise ViolationError(
                    f"{name}: {worst / _US} us, computed {bound / _US} us"
                )
            if worst >= 0.9 * bound:
                yield "nearly reached"


def main() -> None:
    """Print the results of a range of schedules."""
    from fuzzing import run

    count = int(sys.argv[1])
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    report = run(ScheduleTarget, range(first, first + count))
    print(dict(report.labels), [failure.detail for failure in report.failures])
    sys.exit(bool(report.failures))


if __name__ == "__main__":
    main()
