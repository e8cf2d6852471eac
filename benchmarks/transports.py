"""Samples and calls over dds and zenoh, between two processes, beside the libraries alone.

    python benchmarks/transports.py [ROUNDS]

Samples: the writer of one process, the reader of another, that counts what arrives. `write` is
the writer's path alone, per sample: ours (encoding, and the engine's publisher) beside
cyclonedds-python's `write` of its own class, and Zenoh's `put` of octets that `struct` has packed,
which is the least that a program has to do. `arrives` are samples per second until the last one is
there, `of` the share that arrived. Latency is half of a round trip by two topics, one sample at a
time. Calls have no arguments (over CORBA: `corba.py`). Rounds of ours and of a peer alternate;
figures are medians of rounds.
"""

from __future__ import annotations

import statistics
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))
sys.path.insert(0, str(HERE.parent / "generated"))

from media import engine, medium_at  # noqa: E402

from refrobots import rtc  # noqa: E402
from rtgen.runtime.distribution.data import encoder  # noqa: E402
from rtgen.runtime.distribution.medium import Medium, Qos, Topic  # noqa: E402
from rtgen.runtime.distribution.rpc_header import (  # noqa: E402
    OctetsClient,
    serve_octets,
)
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort  # noqa: E402
from rtgen.runtime.timing.guards import SINGLE_THREAD  # noqa: E402

POSE = struct.Struct("<4s2I3d")
HEAD = b"\0\1\0\0"
SIZES = (0, 1 << 10, 64 << 10, 1 << 20)
"""Octets of a TimedOctetSeq; 0 stands for a TimedPose2D."""
BUDGET = 16 << 20
TRIPS = 400


def value_of(size: int) -> Any:
    """A sample."""
    if size:
        return rtc.TimedOctetSeq(rtc.Time(1, 2), bytes(size))
    return rtc.TimedPose2D(rtc.Time(1, 2), rtc.Pose2D(rtc.Point2D(1.0, 2.0), 3.0))


def topic_of(name: str, size: int) -> Topic:
    """A topic of samples of this size."""
    return Topic(f"{name}/{size}", type(value_of(size)))


def count_of(size: int) -> int:
    """How many samples a round has."""
    return max(16, min(20_000, BUDGET // max(size, 40)))


# The other process.


def serve(medium: Medium) -> None:
    """Counts samples, and says so when the last is there; sends pings back; answers calls."""
    kept = []
    encode = encoder(rtc.TimedLong)
    for size in SIZES:
        counted = [0, 0]
        done = medium.publisher(Topic(f"done/{size}", rtc.TimedLong), Qos(depth=None))

        def on_sample(
            sample: Any, counted: Any = counted, done: Any = done, size: int = size
        ) -> None:
            counted[0] += 1
            # The number of the round's last sample is in the time stamp's nanoseconds.
            if sample.octets[8:12] == b"\xff\xff\xff\x7f":
                counted[1] += 1
                done.publish(
                    encode(rtc.TimedLong(rtc.Time(0, 0), counted[0])), counted[1]
                )
                counted[0] = 0

        medium.subscribe(topic_of("data", size), Qos(depth=None), on_sample)
        back = medium.publisher(topic_of("pong", size), Qos(depth=None))
        number = [0]

        def on_ping(sample: Any, back: Any = back, number: Any = number) -> None:
            number[0] += 1
            back.publish(sample.octets, number[0])

        medium.subscribe(topic_of("ping", size), Qos(depth=None), on_ping)
        kept += [done, back]
    serve_octets(medium, "empty", lambda octets, reply: reply(octets))
    print("ready", flush=True)
    sys.stdin.read()


# Measurements, each a median of what one process sees.


class Pair:
    """The measurements of one engine with its other process."""

    def __init__(self, medium: Medium) -> None:
        self.medium = medium
        self.sent: dict[int, int] = {}
        self.ports: dict[int, tuple[Any, Any]] = {}
        self.arrived: dict[int, Any] = {}

    def prepare(self, size: int) -> None:
        """Publisher and subscription of a size, once known to both."""
        event = threading.Event()
        numbers: list[int] = []

        def on_done(sample: Any) -> None:
            numbers.append(int.from_bytes(sample.octets[12:16], "little"))
            event.set()

        self.medium.subscribe(
            Topic(f"done/{size}", rtc.TimedLong), Qos(depth=None), on_done
        )
        publisher = self.medium.publisher(
            topic_of("data", size), Qos(depth=None, patience=60)
        )
        while not publisher.matched:
            time.sleep(0.01)
        time.sleep(0.3)
        self.ports[size] = publisher, (event, numbers)
        self.sent[size] = 0

    def flood(self, size: int) -> tuple[float, float, int]:
        """Seconds of a write, samples per second until the last is there, how many arrived."""
        publisher, (event, numbers) = self.ports[size]
        encode = encoder(type(value_of(size)))
        value, count = value_of(size), count_of(size)
        event.clear()
        numbers.clear()
        sent = self.sent[size]
        begun = time.perf_counter()
        for number in range(sent + 1, sent + count):
            publisher.publish(encode(value), number)
        written = time.perf_counter() - begun
        value.tm.nsec = 0x7FFFFFFF
        publisher.publish(encode(value), sent + count)
        self.sent[size] = sent + count
        if not event.wait(60):
            return written / count, 0.0, 0
        return (
            written / count,
            count / (time.perf_counter() - begun),
            numbers[-1],
        )

    def latency(self, size: int) -> list[float]:
        """Halves of round trips in seconds, sorted."""
        event = threading.Event()
        subscription = self.medium.subscribe(
            topic_of("pong", size), Qos(depth=None), lambda _: event.set()
        )
        publisher = self.medium.publisher(topic_of("ping", size), Qos(depth=None))
        while not publisher.matched:
            time.sleep(0.01)
        time.sleep(0.3)
        encode, value = encoder(type(value_of(size))), value_of(size)
        found = []
        for number in range(1, TRIPS + 1):
            event.clear()
            begun = time.perf_counter()
            publisher.publish(encode(value), number)
            if not event.wait(10):
                break
            found.append((time.perf_counter() - begun) / 2)
        publisher.close()
        subscription.close()
        return sorted(found)

    def calls(self) -> list[float]:
        """Seconds of an empty call, sorted."""
        client = OctetsClient(self.medium, "empty")
        found = []
        for number in range(TRIPS):
            begun = time.perf_counter()
            client.call(b"", 10)
            if number > TRIPS // 10:
                found.append(time.perf_counter() - begun)
        client.close()
        return sorted(found)


@contextmanager
def other(address: str) -> Iterator[None]:
    """The process that reads."""
    process = subprocess.Popen(
        [sys.executable, __file__, "--serve", address],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.readline()
    try:
        yield
    finally:
        process.communicate()


def direct(size: int) -> float:
    """Seconds of a write and a read within a process."""
    value = value_of(size)
    out_port: Any = OutPort("o", type(value), "a")
    in_port: Any = InPort("i", type(value), "b")
    DataConnector("c", out_port, in_port, {}, lambda: SINGLE_THREAD).attach()
    count = count_of(size)
    begun = time.perf_counter()
    for _ in range(count):
        out_port.write(value)
        in_port.read()
    return (time.perf_counter() - begun) / count


def timed(action: Callable[[], object], count: int) -> float:
    """Seconds of one of so many actions."""
    begun = time.perf_counter()
    for _ in range(count):
        action()
    return (time.perf_counter() - begun) / count


# The writers of TimedPose2D alone: what the goals are about.


def dds_writers(rounds: int) -> tuple[float, float]:
    """Seconds of a write: our path, and cyclonedds-python's own; a reader is matched to both."""
    from cyclonedds.core import Policy
    from cyclonedds.core import Qos as TheirQos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic as TheirTopic

    from rtgen.runtime.dds.types import idl_class

    value = value_of(0)
    with engine("dds") as network, ExitStack() as stack:
        medium = network.medium()
        stack.callback(medium.close)
        medium.subscribe(topic_of("data", 0), Qos(depth=8), lambda _: None)
        publisher = medium.publisher(topic_of("data", 0), Qos(depth=8))
        encode = encoder(type(value))
        theirs = idl_class(type(value))
        made = theirs.deserialize(encode(value))
        participant = DomainParticipant(89)
        qos = TheirQos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(8))
        topic = TheirTopic(participant, "pose", theirs, qos=qos)
        reader = DataReader(participant, topic, qos=qos)
        writer = DataWriter(participant, topic, qos=qos)
        number = iter(range(1, 1 << 30))
        ours, peers = [], []
        for _ in range(rounds):
            ours.append(
                timed(lambda: publisher.publish(encode(value), next(number)), 5000)
            )
            peers.append(timed(lambda: writer.write(made), 2000))
        del reader
    return statistics.median(ours), statistics.median(peers)


def zenoh_writers(rounds: int) -> tuple[float, float, float]:
    """Seconds of a write: our path; `put` of octets that `struct` packs; the same of ready ones."""
    import zenoh

    value = value_of(0)
    with engine("zenoh") as network, ExitStack() as stack:
        medium: Any = network.medium()
        reading = network.medium()
        stack.callback(medium.close)
        stack.callback(reading.close)
        session = medium._session
        reading.subscribe(topic_of("data", 0), Qos(depth=8), lambda _: None)
        plain = reading._session.declare_subscriber("plain", lambda _: None)
        publisher = medium.publisher(topic_of("data", 0), Qos(depth=8))
        encode = encoder(type(value))
        bare = session.declare_publisher(
            "plain", congestion_control=zenoh.CongestionControl.DROP
        )
        while not publisher.matched:
            time.sleep(0.01)
        pose, tm = value.data, value.tm
        place = pose.position

        def pack() -> bytes:
            return POSE.pack(HEAD, tm.sec, tm.nsec, place.x, place.y, pose.heading)

        assert pack() == encode(value)
        octets, number = pack(), iter(range(1, 1 << 30))
        found: tuple[list[float], ...] = ([], [], [])
        for _ in range(rounds):
            for seconds, action in zip(
                found,
                (
                    lambda: publisher.publish(encode(value), next(number)),
                    lambda: bare.put(pack()),
                    lambda: bare.put(octets),
                ),
                strict=True,
            ):
                seconds.append(timed(action, 5000))
                time.sleep(0.05)
        plain.undeclare()
    ours, packed, ready = (statistics.median(each) for each in found)
    return ours, packed, ready


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    ours, theirs = dds_writers(rounds)
    print(
        f"write of TimedPose2D, dds: {_us(ours)}, cyclonedds-python {_us(theirs)}:",
        end="",
    )
    print(f" {theirs / ours:.2f} times as fast")
    ours, packed, ready = zenoh_writers(rounds)
    print(
        f"write of TimedPose2D, zenoh: {_us(ours)}, zenoh-python with struct {_us(packed)},"
    )
    print(
        f"  of ready octets {_us(ready)}: {ours / packed:.2f} and {ours / ready:.2f} times as long"
    )
    print("\nsize       engine        write  arrives/s   of     latency  99 %")
    for size in SIZES:
        name = f"{size or 'TimedPose2D'}"
        print(
            f"{name:10} direct       {_us(statistics.median(direct(size) for _ in range(rounds)))}"
        )
    for kind in ("dds", "zenoh", "zenoh-router"):
        with engine(kind) as network, ExitStack() as stack:
            medium = network.medium()
            stack.callback(medium.close)
            stack.enter_context(other(str(network.address)))
            pair = Pair(medium)
            for size in SIZES:
                pair.prepare(size)
                floods = [pair.flood(size) for _ in range(rounds)]
                write, rate, got = (
                    statistics.median(each) for each in zip(*floods, strict=True)
                )
                trips = pair.latency(size)
                print(
                    f"{size or 'TimedPose2D':<10} {kind:12} {_us(write)} {rate:10,.0f} "
                    f"{got / count_of(size):5.2f}  {_us(statistics.median(trips))} "
                    f"{_us(trips[len(trips) * 99 // 100])}",
                    flush=True,
                )
            found = pair.calls()
            print(
                f"call       {kind:12} {_us(statistics.median(found))}, "
                f"99 % {_us(found[len(found) * 99 // 100])}"
            )


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:8.2f} us"


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(medium_at(sys.argv[2]))
    else:
        main()
