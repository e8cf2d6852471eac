"""Samples and calls over CORBA, DDS and Zenoh between two processes, compared with the libraries.

    python benchmarks/transports.py [--writers] [--engines NAME,...]

Samples: the writer of one process, the reader of another, which counts them. `write` is the
writer's path alone, per sample: rtgen's (encoding, and the engine's publisher) compared with
cyclonedds-python's `write` of its own class, and Zenoh's `put` of octets packed by `struct`, which
is the minimum for a program; until it returned, and processor time of the writing thread, since a
writer whose reader is slow waits for room in the queue of its link. Over Zenoh, both are received
by readers that use the library alone. `arrives` are samples per second until the last one is there,
`of` the share that arrived; `alone` are the same samples by cyclonedds-python's class and its
`write`, by omniORBpy's class and a call of omniidl's stub, and by `put` of ready octets, between
the same processes, with readers that keep all. Over CORBA a write is a call, which the reader
answers (`corba_ends.py`). Latency is half of a round trip by two topics, one sample at a time.
Calls have no arguments (over CORBA: `corba.py`). Rounds of both alternate; figures are medians of
rounds.
"""

from __future__ import annotations

import json
import statistics
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from tables import Arguments, Results, Table

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))
sys.path.insert(0, str(HERE.parent / "generated"))

from bare_engines import (  # noqa: E402
    LAST,
    LAST_NUMBER,
    await_match,
    bare_ends,
    bare_reader,
    bare_writer,
)
from corba_ends import CorbaEnds  # noqa: E402
from media import DOMAIN, engine, medium_at, transports  # noqa: E402

from refrobots import rtc  # noqa: E402
from rtgen.runtime.distribution.data import encoder  # noqa: E402
from rtgen.runtime.distribution.medium import Qos, Topic  # noqa: E402
from rtgen.runtime.distribution.qos import MIN_DEPTH  # noqa: E402
from rtgen.runtime.distribution.rpc_header import (  # noqa: E402
    OctetsClient,
    serve_octets,
)
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort  # noqa: E402
from rtgen.runtime.timing.guards import SINGLE_THREAD  # noqa: E402

POSE = struct.Struct("<4s2I3d")
HEAD = b"\0\1\0\0"
SIZES = (0, 64, 1 << 10, 64 << 10, 1 << 20, 10 << 20)
"""Octets of a TimedOctetSeq; 0 stands for a TimedPose2D."""
BUDGET = 16 << 20
CALLS = 400


def value_of(size: int) -> Any:
    """Return a sample."""
    if size:
        return rtc.TimedOctetSeq(rtc.Time(1, 2), bytes(size))
    return rtc.TimedPose2D(rtc.Time(1, 2), rtc.Pose2D(rtc.Point2D(1.0, 2.0), 3.0))


def topic_of(name: str, size: int) -> Topic:
    """Return a topic of samples of this size."""
    return Topic(f"{name}/{size}", type(value_of(size)))


def count_of(size: int) -> int:
    """Return the number of samples in a round."""
    return max(16, min(20_000, BUDGET // max(size, 40)))


def trips_of(size: int) -> int:
    """Return the number of round trips, fewer of samples that take a tenth of a second."""
    return 400 if size < 10 << 20 else 40


# The other process.


def serve(medium: Any) -> None:
    """Count samples, and report the last one; send pings back; answer calls."""
    kept: list[Any] = []
    encode = encoder(rtc.TimedLong)

    def counter(name: str) -> Callable[[bool], None]:
        """Return a function that counts a round's samples, and sends the count after the last."""
        done = medium.publisher(Topic(name, rtc.TimedLong), Qos(depth=None))
        kept.append(done)
        counted = 0

        def on_sample(last: bool) -> None:
            nonlocal counted
            counted += 1
            if last:
                done.publish(encode(rtc.TimedLong(rtc.Time(0, 0), counted)))
                counted = 0

        return on_sample

    for size in SIZES:
        count = counter(f"done/{size}")

        def on_sample(sample: Any, count: Any = count) -> None:
            count(sample.octets[8:12] == LAST)

        medium.subscribe(topic_of("data", size), Qos(depth=None), on_sample)
        back = medium.publisher(topic_of("pong", size), Qos(depth=None))

        def on_ping(sample: Any, back: Any = back) -> None:
            back.publish(sample.octets)

        medium.subscribe(topic_of("ping", size), Qos(depth=None), on_ping)
        count = counter(f"done-alone/{size}")
        kept += [
            back,
            bare_reader(medium, f"alone_{size}", type(value_of(size)), count),
        ]
    if not isinstance(medium, CorbaEnds):
        names = ["pose"]
        if hasattr(medium, "_keys"):
            names.append(medium._keys.topic(topic_of("alone", 0)))
        else:
            medium.subscribe(topic_of("alone", 0), Qos(depth=MIN_DEPTH), lambda _: None)
        kept += [
            bare_reader(medium, name, rtc.TimedPose2D, lambda _: None, depth=MIN_DEPTH)
            for name in names
        ]
        serve_octets(medium, "empty", lambda octets, reply: reply(octets))
    print("ready", flush=True)
    sys.stdin.read()
    # Zenoh can wait for Python's threads forever if its session is open at exit.
    medium.close()


# Measurements, each a median of what one process sees.


class Pair:
    """The measurements of one engine with its other process."""

    def __init__(self, medium: Any) -> None:
        self.medium = medium
        self.ports: dict[int, tuple[Any, Any]] = {}
        self.arrived: dict[int, Any] = {}

    def prepare(self, size: int) -> None:
        """Create publisher and subscription of a size, once known to both."""
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

    def flood(self, size: int) -> tuple[float, float, int]:
        """Return seconds of a write, samples per second until the last, and their number."""
        publisher, (event, numbers) = self.ports[size]
        encode = encoder(type(value_of(size)))
        value, count = value_of(size), count_of(size)
        event.clear()
        numbers.clear()
        begun = time.perf_counter()
        for _ in range(count - 1):
            publisher.publish(encode(value))
        written = time.perf_counter() - begun
        value.tm.nsec = LAST_NUMBER
        publisher.publish(encode(value))
        if not event.wait(60):
            return written / count, 0.0, 0
        return (
            written / count,
            count / (time.perf_counter() - begun),
            numbers[-1],
        )

    def alone(self, size: int, rounds: int) -> tuple[float, float, float]:
        """Return medians of the figures of `flood`, by the library alone."""
        event = threading.Event()
        numbers: list[int] = []

        def on_done(sample: Any) -> None:
            numbers.append(int.from_bytes(sample.octets[12:16], "little"))
            event.set()

        done = self.medium.subscribe(
            Topic(f"done-alone/{size}", rtc.TimedLong), Qos(depth=None), on_done
        )
        value, count = value_of(size), count_of(size)
        with bare_writer(self.medium, f"alone_{size}", type(value)) as (made, write):
            time.sleep(0.3)
            sample = made(value)
            value.tm.nsec = LAST_NUMBER
            last = made(value)
            found = []
            for _ in range(rounds):
                event.clear()
                begun = time.perf_counter()
                for _ in range(count - 1):
                    write(sample)
                written = time.perf_counter() - begun
                write(last)
                got = event.wait(60)
                seconds = time.perf_counter() - begun
                found.append(
                    (written / count, count / seconds, numbers[-1])
                    if got
                    else (written / count, 0.0, 0)
                )
        done.close()
        write_, rate, arrived = map(statistics.median, zip(*found, strict=True))
        return write_, rate, arrived

    def latency(self, size: int) -> list[float]:
        """Return halves of round trips in seconds, sorted."""
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
        for _ in range(trips_of(size)):
            event.clear()
            begun = time.perf_counter()
            publisher.publish(encode(value))
            if not event.wait(10):
                break
            found.append((time.perf_counter() - begun) / 2)
        publisher.close()
        subscription.close()
        return sorted(found)

    def calls(self) -> list[float]:
        """Return seconds of an empty call, sorted."""
        client = OctetsClient(self.medium, "empty")
        found = []
        for number in range(CALLS):
            begun = time.perf_counter()
            client.call(b"", 10)
            if number > CALLS // 10:
                found.append(time.perf_counter() - begun)
        client.close()
        return sorted(found)


@contextmanager
def other(address: str) -> Iterator[None]:
    """Start the process that reads."""
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
        try:
            process.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


@contextmanager
def joined(kind: str) -> Iterator[tuple[Any, str]]:
    """Yield the medium of this process, and the address for the other."""
    if kind != "corba":
        with engine(kind) as network, closing(network.medium()) as medium:
            yield medium, str(network.address)
        return
    with transports(kind) as corba, closing(ends_at(str(corba.address))) as ends:
        yield ends, str(corba.address)


def ends_at(address: str) -> Any:
    """Return the medium at an address, for the other process."""
    place = json.loads(address).get("corba")
    return medium_at(address) if place is None else CorbaEnds(place)


def direct(size: int) -> float:
    """Return seconds of a write and a read within a process."""
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


class Cost(NamedTuple):
    """Seconds of one action: until it returned, and of the processor in its thread."""

    wall: float
    thread: float


def timed(action: Callable[[], object], count: int) -> Cost:
    """Return the cost of one of `count` actions."""
    begun, busy = time.perf_counter(), time.thread_time()
    for _ in range(count):
        action()
    busy, end = time.thread_time() - busy, time.perf_counter()
    return Cost((end - begun) / count, busy / count)


def dds_writers(rounds: int) -> list[Cost]:
    """Return costs of a write: rtgen's, and cyclonedds-python's; each has a reader elsewhere."""
    from cyclonedds.domain import DomainParticipant

    from rtgen.runtime.dds.types import idl_class

    value = value_of(0)
    encode = encoder(type(value))
    with engine("dds") as network, ExitStack() as stack:
        medium = network.medium()
        stack.callback(medium.close)
        stack.enter_context(other(str(network.address)))
        publisher = medium.publisher(topic_of("alone", 0), Qos(depth=MIN_DEPTH))
        made = idl_class(type(value)).deserialize(encode(value))
        writer, own = bare_ends(
            DomainParticipant(DOMAIN), "pose", rtc.TimedPose2D, depth=MIN_DEPTH
        )
        del own
        await_match(lambda: publisher.matched)
        await_match(writer.get_matched_subscriptions)
        return interleaved(
            rounds,
            lambda: publisher.publish(encode(value)),
            lambda: writer.write(made),
        )


def zenoh_writers(rounds: int) -> list[Cost]:
    """Return costs of a write: rtgen's; `put` of octets that `struct` packs; of ready octets."""
    import zenoh

    value = value_of(0)
    encode = encoder(type(value))
    with engine("zenoh") as network, ExitStack() as stack:
        medium: Any = network.medium()
        stack.callback(medium.close)
        stack.enter_context(other(str(network.address)))
        publisher = medium.publisher(topic_of("alone", 0), Qos(depth=MIN_DEPTH))
        bare = medium._session.declare_publisher(
            "pose",
            congestion_control=zenoh.CongestionControl.DROP,
            reliability=zenoh.Reliability.RELIABLE,
        )
        await_match(lambda: publisher.matched)
        await_match(lambda: bare.matching_status.matching)
        pose, tm = value.data, value.tm
        place = pose.position

        def pack() -> bytes:
            return POSE.pack(HEAD, tm.sec, tm.nsec, place.x, place.y, pose.heading)

        assert pack() == encode(value)
        octets = pack()
        return interleaved(
            rounds,
            lambda: publisher.publish(encode(value)),
            lambda: bare.put(pack()),
            lambda: bare.put(octets),
        )


def interleaved(rounds: int, *actions: Callable[[], object]) -> list[Cost]:
    """Return the median cost of each action; a turn starts when the previous samples have left."""
    found: list[list[Cost]] = [[] for _ in actions]
    for _ in range(5 * rounds):
        for costs, action in zip(found, actions, strict=True):
            costs.append(timed(action, 2000))
            time.sleep(0.05)
    return [Cost(*map(statistics.median, zip(*each, strict=True))) for each in found]


def main() -> None:
    """Print the tables."""
    parser = Arguments(__doc__, rounds=5)
    parser.add_argument("--writers", action="store_true", help="writers alone")
    parser.add_argument("--engines", default="corba,dds,zenoh,zenoh-router")
    chosen = parser.parse_args()
    sizes, engines = SIZES, chosen.engines.split(",")
    if chosen.smallest:
        sizes, engines = SIZES[:1], ["zenoh"]
    with Results(__file__, chosen) as results:
        writers(
            results.table(
                "writers",
                "write of TimedPose2D",
                ("elapsed [µs]", ".2f"),
                ("processor time [µs]", ".2f"),
                ("rtgen's to it", ".2f"),
                ("of processor time", ".2f"),
            ),
            chosen.rounds,
        )
        if chosen.writers:
            return
        table = results.table(
            "engines",
            "sample, engine",
            ("write [µs]", ".2f"),
            ("arrive [1/s]", ",.0f"),
            ("of them", ".2f"),
            ("latency [µs]", ".0f"),
            ("99 % [µs]", ".0f"),
        )
        for size in sizes:
            seconds = statistics.median(direct(size) for _ in range(chosen.rounds))
            table.add(f"{title_of(size)}, direct", seconds * 1e6, *[None] * 4)
        for kind in engines:
            between(table, kind, sizes, chosen.rounds)


def writers(table: Table, rounds: int) -> None:
    """Fill the table of writers alone."""
    for names, costs in (
        (("rtgen over DDS", "cyclonedds-python"), dds_writers(rounds)),
        (
            ("rtgen over Zenoh", "put, packed by struct", "put of ready octets"),
            zenoh_writers(rounds),
        ),
    ):
        ours = costs[0]
        for name, cost in zip(names, costs, strict=True):
            both = cost.wall * 1e6, cost.thread * 1e6
            table.add(name, *both, ours.wall / cost.wall, ours.thread / cost.thread)


def between(table: Table, kind: str, sizes: Sequence[int], rounds: int) -> None:
    """Fill the table with samples and calls of an engine between two processes."""
    with ExitStack() as stack:
        medium, address = stack.enter_context(joined(kind))
        stack.enter_context(other(address))
        pair = Pair(medium)
        for size in sizes:
            pair.prepare(size)
            floods = [pair.flood(size) for _ in range(rounds)]
            trips = pair.latency(size)
            late = trips[len(trips) * 99 // 100]
            for name, (write, rate, got), latencies in (
                (
                    kind,
                    map(statistics.median, zip(*floods, strict=True)),
                    (statistics.median(trips) * 1e6, late * 1e6),
                ),
                (f"{kind} alone", pair.alone(size, rounds), (None, None)),
            ):
                figures = write * 1e6, rate, got / count_of(size)
                table.add(f"{title_of(size)}, {name}", *figures, *latencies)
        if kind != "corba":
            found = pair.calls()
            late = found[len(found) * 99 // 100] * 1e6
            figures = None, None, None, statistics.median(found) * 1e6, late
            table.add(f"call, {kind}: there and back", *figures)


def title_of(size: int) -> str:
    """Return the title of samples of a size."""
    return f"{size:,} octets" if size else "TimedPose2D"


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(ends_at(sys.argv[2]))
    else:
        main()
