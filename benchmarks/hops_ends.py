"""One of the two processes of a chain of `latency.py`, by rtgen or by a library alone.

python hops_ends.py KIND PROCESS HOPS SECONDS ADDRESS

Part 0 sends samples at 100 Hz; each further part is in the other process than the one before, and
passes on what it receives. The last one, which is in the first process, takes the time. KIND is
`rtgen`, `engine`, `dds`, `zenoh`, `corba` or `rclpy`. A process prints `open` when others can join
it, and `ready` when it is connected; it waits for a line, and writes its figures as JSON: processor
time [s], and the latencies [us] of the first process. The other one measures until its second line.
"""

from __future__ import annotations

import importlib
import json
import os
import struct
import sys
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests"))

RATE = 100.0
NS = 1_000_000_000
SAMPLE = struct.Struct("<4s2Ii")
HEAD = b"\0\1\0\0"

Take = Callable[[int], None]
"""What is called with the time [ns] at which a sample was sent."""


class Ends(ABC):
    """Writers and readers of a library alone; connection `n` is that of part `n` to the next."""

    @abstractmethod
    def writer(self, number: int) -> Take:
        """Return a function that sends a time over a connection."""

    @abstractmethod
    def read(self, number: int, take: Take) -> None:
        """Call a function with what comes over a connection."""

    def is_connected(self) -> bool:
        """Whether all readers are known."""
        return True


class Engine(Ends):
    """Publishers and subscriptions of rtgen, without components."""

    def __init__(self, process: int, address: str) -> None:
        from rtgen.runtime.distribution.medium import Qos

        self._medium = medium_of(process, address)
        self._qos = Qos(depth=64)
        self._publishers: list[Any] = []
        self._kept: list[Any] = []

    def writer(self, number: int) -> Take:
        from refrobots.rtc import Time, TimedLong
        from rtgen.runtime.distribution.data import encoder

        publisher = self._medium.publisher(_topic(number), self._qos)
        self._publishers.append(publisher)
        encode, publish = encoder(TimedLong), publisher.publish
        return lambda stamp: publish(encode(TimedLong(Time(*divmod(stamp, NS)), 0)))

    def read(self, number: int, take: Take) -> None:
        from refrobots.rtc import TimedLong
        from rtgen.runtime.distribution.data import received

        def on_sample(sample: Any) -> None:
            value = received(TimedLong, sample.octets)
            take(value.tm.sec * NS + value.tm.nsec)

        made = self._medium.subscribe(_topic(number), self._qos, on_sample)
        self._kept.append(made)

    def is_connected(self) -> bool:
        return all(publisher.matched for publisher in self._publishers)


def _topic(number: int) -> Any:
    from refrobots.rtc import TimedLong
    from rtgen.runtime.distribution.medium import Topic

    return Topic(f"hop{number}", TimedLong)


class Zenoh(Ends):
    """`put` and callbacks of zenoh-python, in the session that rtgen would open."""

    def __init__(self, process: int, address: str) -> None:
        self._session = medium_of(process, address)._session
        self._publishers: list[Any] = []
        self._kept: list[Any] = []

    def writer(self, number: int) -> Take:
        import zenoh

        publisher = self._session.declare_publisher(
            f"hop{number}", congestion_control=zenoh.CongestionControl.BLOCK
        )
        self._publishers.append(publisher)
        pack, put = SAMPLE.pack, publisher.put
        return lambda stamp: put(pack(HEAD, stamp // NS, stamp % NS, 0))

    def read(self, number: int, take: Take) -> None:
        unpack = SAMPLE.unpack

        def on_sample(sample: Any) -> None:
            _, sec, nsec, _ = unpack(sample.payload.to_bytes())
            take(sec * NS + nsec)

        self._kept.append(self._session.declare_subscriber(f"hop{number}", on_sample))

    def is_connected(self) -> bool:
        return all(p.matching_status.matching for p in self._publishers)


class Dds(Ends):
    """`write` and waiting readers of cyclonedds-python."""

    def __init__(self, process: int, address: str) -> None:
        from cyclonedds.domain import DomainParticipant
        from media import DOMAIN

        [(_, (self._name, _))] = json.loads(address).items()
        self._participant = DomainParticipant(DOMAIN)
        self._writers: list[Any] = []

    def _end(self, number: int, *, is_writer: bool) -> tuple[Any, Any]:
        from cyclonedds.core import Policy, Qos
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        from refrobots.rtc import TimedLong
        from rtgen.runtime.dds.types import idl_class

        class_ = idl_class(TimedLong)
        reliable = Policy.Reliability.Reliable(duration(seconds=1))
        qos = Qos(reliable, Policy.History.KeepLast(64))
        name = f"{self._name.replace('-', '_')}_hop{number}"
        topic = Topic(self._participant, name, class_, qos=qos)
        make = DataWriter if is_writer else DataReader
        return make(self._participant, topic, qos=qos), class_

    def writer(self, number: int) -> Take:
        writer, class_ = self._end(number, is_writer=True)
        self._writers.append(writer)
        sample = class_.deserialize(SAMPLE.pack(HEAD, 0, 0, 0))

        def write(stamp: int) -> None:
            sample.tm.sec, sample.tm.nsec = divmod(stamp, NS)
            writer.write(sample)

        return write

    def read(self, number: int, take: Take) -> None:
        from cyclonedds.util import duration

        reader, _ = self._end(number, is_writer=False)

        def wait() -> None:
            for sample in reader.take_iter(timeout=duration(days=1)):
                take(sample.tm.sec * NS + sample.tm.nsec)

        threading.Thread(target=wait, daemon=True).start()

    def is_connected(self) -> bool:
        return all(writer.get_matched_subscriptions() for writer in self._writers)


class Corba(Ends):
    """Calls of omniidl's stubs by omniORBpy; a topic is an object in the naming service."""

    def __init__(self, process: int, address: str) -> None:
        from corba_ends import CorbaEnds

        self._ends: Any = CorbaEnds(json.loads(address)["corba"])
        self._calls: dict[int, Any] = {}
        self._kept: list[Any] = []

    def writer(self, number: int) -> Take:
        from refrobots.rtc import Time, TimedLong

        self._calls[number] = None

        def write(stamp: int) -> None:
            made, call = self._calls[number]
            call(made(TimedLong(Time(*divmod(stamp, NS)), 0)))

        return write

    def read(self, number: int, take: Take) -> None:
        def taken(value: Any) -> None:
            take(value.tm.sec * NS + value.tm.nsec)

        self._kept.append(self._ends.bare_reader(f"hop{number}", taken))

    def is_connected(self) -> bool:
        from refrobots.rtc import TimedLong

        for number, found in self._calls.items():
            if found is None:
                try:
                    writer = self._ends.bare_writer(f"hop{number}", TimedLong)
                except AssertionError:  # the other process has not registered it
                    return False
                self._calls[number] = writer
        return True


class Rclpy(Ends):
    """A node of ROS 2 with callbacks, in a thread of its own."""

    def __init__(self, process: int, address: str) -> None:
        self._ros: Any = importlib.import_module("rclpy")
        self._ros.init()
        self._node = self._ros.create_node(f"process{process}")
        self._class: Any = importlib.import_module("std_msgs.msg").Int64
        self._publishers: list[Any] = []
        self._spinning: threading.Thread | None = None

    def writer(self, number: int) -> Take:
        publisher = self._node.create_publisher(self._class, f"hop{number}", 64)
        self._publishers.append(publisher)
        return lambda stamp: publisher.publish(self._class(data=stamp))

    def read(self, number: int, take: Take) -> None:
        def call(message: Any) -> None:
            take(message.data)

        self._node.create_subscription(self._class, f"hop{number}", call, 64)

    def is_connected(self) -> bool:
        if self._spinning is None:
            executor = importlib.import_module("rclpy.executors")
            spinner = executor.SingleThreadedExecutor()
            spinner.add_node(self._node)
            self._spinning = threading.Thread(target=spinner.spin, daemon=True)
            self._spinning.start()
        return all(p.get_subscription_count() for p in self._publishers)


def medium_of(process: int, address: str) -> Any:
    """Return a medium of a process; the first one of Zenoh listens where the other connects."""
    from media import SYSTEM, medium_at

    [(kind, place)] = json.loads(address).items()
    if kind == "corba":
        from corba_ends import CorbaEnds

        return CorbaEnds(place)
    if kind != "zenoh" or process:
        return medium_at(address)
    from rtgen.runtime.zenoh.medium import ZenohMedium
    from rtgen.runtime.zenoh.session import Endpoints

    return ZenohMedium(SYSTEM, Endpoints(None, (), place[:1], None))


def bare(ends: Ends, process: int, hops: int, latencies: list[float]) -> Iterator[None]:
    """Connect the parts of a process, then send samples; pauses where others have to be ready."""
    yield

    def last(stamp: int) -> None:
        latencies.append((time.monotonic_ns() - stamp) / 1000)

    first: Take = last
    for number in range(process, hops + 1, 2):
        take = ends.writer(number) if number < hops else last
        if number:
            ends.read(number - 1, take)
        else:
            first = take
    while not ends.is_connected():
        time.sleep(0.01)
    yield
    due = time.monotonic_ns()
    while not process:
        first(time.monotonic_ns())
        due += round(NS / RATE)
        time.sleep(max(0.0, (due - time.monotonic_ns()) / NS))
        yield


def rtgen(
    address: str, process: int, hops: int, latencies: list[float]
) -> Iterator[None]:
    """Do the same with components, which samples execute."""
    from media import transport_at

    from refrobots.rtc import Time, TimedLong
    from rtgen.runtime import RTC_OK, Component, ExecutionKind, RealClock, System
    from rtgen.runtime.distribution.transport import DistributedTransport

    class Part(Component):
        def __init__(self, number: int) -> None:
            super().__init__(f"part{number}")
            self.number = number
            self.input = self.add_in_port("in", TimedLong)
            self.output = self.add_out_port("out", TimedLong)

        def on_execute(self, ec_id: int) -> Any:
            if self.number == 0:
                time_ = Time(*divmod(time.monotonic_ns(), NS))
                self.output.write(TimedLong(time_, 0))
                return RTC_OK
            while self.input.is_new():
                sample = self.input.read()
                assert sample is not None
                if self.number < hops:
                    self.output.write(sample, move=True)
                else:
                    sent = sample.tm.sec * NS + sample.tm.nsec
                    latencies.append((time.monotonic_ns() - sent) / 1000)
            return RTC_OK

    if "corba" in address:
        transport = transport_at(address, 10.0)
    else:
        transport = DistributedTransport(medium_of(process, address), timeout=10.0)
    yield
    system = System(RealClock(), transport)
    own = [*range(process, hops + 1, 2)]
    for number in own:
        kind = ExecutionKind.EVENT_DRIVEN if number else ExecutionKind.PERIODIC
        system.add(Part(number), RATE, kind=kind)
    for number in range(hops):
        if "corba" in address and number not in own:
            continue  # one end makes a connection of CORBA
        system.connect((f"part{number}", "out"), (f"part{number + 1}", "in"))
    transport.await_others(30.0)
    for number in own:
        system.activate(f"part{number}")
    system.run(system.time + NS // 10)
    while True:
        yield
        system.run(system.time + NS // 10)


def main(kind: str, process: int, hops: int, seconds: float, address: str) -> None:
    """Measure one chain."""
    sys.path.insert(0, str(HERE.parent / "generated"))
    latencies: list[float] = []
    if kind == "rtgen":
        steps = rtgen(address, process, hops, latencies)
    else:
        classes = {
            "engine": Engine,
            "zenoh": Zenoh,
            "dds": Dds,
            "corba": Corba,
            "rclpy": Rclpy,
        }
        steps = bare(classes[kind](process, address), process, hops, latencies)
    next(steps)
    print("open", flush=True)
    next(steps)
    print("ready", flush=True)
    sys.stdin.readline()
    settled = time.monotonic() + 0.5
    while time.monotonic() < settled and not process:
        next(steps, None)
    latencies.clear()
    used = time.process_time()
    if process:
        sys.stdin.readline()
    end = time.monotonic() + seconds
    while time.monotonic() < end and not process:
        next(steps, None)
    figures = {"processor": time.process_time() - used, "latencies": latencies}
    print(json.dumps(figures), flush=True)
    sys.stdin.readline()
    os._exit(0)  # without waiting for threads of the libraries


if __name__ == "__main__":
    main(
        sys.argv[1],
        int(sys.argv[2]),
        int(sys.argv[3]),
        float(sys.argv[4]),
        sys.argv[5],
    )
