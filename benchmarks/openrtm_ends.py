"""A process with a component of rtgen's runtime or of OpenRTM, for the benchmark `openrtm.py`.

    python benchmarks/openrtm_ends.py rtgen|openrtm Sender|Receiver NAMESERVER

Each component has a data port for each type of samples and each side, named after these. A command
is a line of the input, its answer a line of the output.

`send PORT COUNT PAUSE`: write samples, each as soon as the previous one was taken, after a pause in
seconds. The answer is the start, and processor time in ns. `receive PORT COUNT`: read samples by a
port that blocks, after an answer that reading begins. The second answer is the time of the last
read, processor time, and the latency of each sample. All are in ns of the system's monotonic clock.
`connect SENDER RECEIVER PORT PORT`: of OpenRTM alone, by its own function.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SIDES = ("openrtm", "rtgen")
TYPES = ("TimedPose2D", "TimedDoubleSeq")
NUMBERS = 100_000
"""Number of doubles of a TimedDoubleSeq: 0.8 MB."""
PORTS = tuple(f"{type_}_{side}" for type_ in TYPES for side in SIDES)
CONNECTOR = {
    "interface_type": "corba_cdr",
    "dataflow_type": "push",
    "subscription_type": "flush",
    "buffer.length": "64",
    "buffer.write.full_policy": "block",
    "buffer.read.empty_policy": "block",
}
SECOND = 1_000_000_000
RATE = 10.0
TIMEOUT = 60.0

Ports = dict[str, Any]


def sample_of(classes: Any, port: str) -> Any:
    """Return a sample of the port's type, of `RTC` of OpenRTM or of rtgen."""
    tm = classes.Time(0, 0)
    if port.startswith("TimedPose2D"):
        pose = classes.Pose2D(classes.Point2D(1.0, 2.0), 3.0)
        return classes.TimedPose2D(tm, pose)
    return classes.TimedDoubleSeq(tm, [float(number) for number in range(NUMBERS)])


def send(port: Any, sample: Any, taken: object, count: int, pause: float) -> list[int]:
    """Execute `send`; RuntimeError unless each write returns `taken`."""
    begun, busy = time.monotonic_ns(), time.process_time_ns()
    for _ in range(count):
        time.sleep(pause)
        sample.tm.sec, sample.tm.nsec = divmod(time.monotonic_ns(), SECOND)
        if (status := port.write(sample)) is not taken:
            raise RuntimeError(f"a sample was refused: {status!r}")
    return [begun, time.process_time_ns() - busy]


def receive(port: Any, count: int) -> list[Any]:
    """Execute `receive`; TimeoutError if samples do not arrive.

    When a read gives up, both sides return the sample before.
    """
    late: list[int] = []
    busy = time.process_time_ns()
    end = time.monotonic() + TIMEOUT
    before = port.last_read
    while len(late) < count:
        sample = port.read()
        now = time.monotonic_ns()
        written = 0 if sample is None else sample.tm.sec * SECOND + sample.tm.nsec
        if written > before:
            late.append(now - written)
            before = written
        elif time.monotonic() > end:
            raise TimeoutError(f"{len(late)} of {count} samples have come")
    port.last_read = before
    return [now, time.process_time_ns() - busy, late]


class Reader:
    """A port that is read, and the time of its last sample."""

    def __init__(self, port: Any) -> None:
        self.read = port.read
        self.last_read = 0


@contextmanager
def ours(kind: str, names: str) -> Iterator[tuple[Ports, Any, object, Any]]:
    """Yield a system with one component.

    Its ports, rtgen's types, the result of `write`, and nothing to connect with.
    """
    sys.path.insert(0, str(Path(__file__).parents[1] / "generated"))
    from rtgen.runtime import PORT_OK, Component, ComponentProfile, RealClock, System
    from rtgen.runtime.corba.transport import NamedCorba

    classes = importlib.import_module("refrobots.rtc")

    class Node(Component):
        profile = ComponentProfile(f"Rtgen{kind}", rate=RATE)

        def __init__(self) -> None:
            super().__init__(f"rtgen{kind}0")
            add = self.add_out_port if kind == "Sender" else self.add_in_port
            self.all = {
                port: add(port, getattr(classes, port.partition("_")[0]))
                for port in PORTS
            }

    with (
        NamedCorba(name_server=names, timeout=TIMEOUT) as transport,
        System(RealClock(), transport) as system,
    ):
        node = Node()
        system.add(node, RATE)
        system.activate(node.instance_name)
        system.run(until=lambda _: node.is_active)
        ended = threading.Event()
        running = threading.Thread(
            target=system.run, kwargs={"until": lambda _: ended.is_set()}
        )
        running.start()
        yield node.all, classes, PORT_OK, None
        ended.set()
        running.join()


@contextmanager
def theirs(kind: str, names: str) -> Iterator[tuple[Ports, Any, object, Any]]:
    """Yield a manager with one component.

    Its ports, OpenRTM's types, the result of `write`, and a function that connects.
    """
    rtm: Any = importlib.import_module("OpenRTM_aist")
    rtc: Any = importlib.import_module("RTC")
    options = {
        "corba.nameservers": names,
        "corba.endpoints": "127.0.0.1:",
        "corba.args": "-ORBgiopMaxMsgSize 67108864",
        "exec_cxt.periodic.rate": str(RATE),
        "logger.enable": "NO",
        "manager.shutdown_on_nortcs": "NO",
        "naming.formats": "%n.rtc",
    }
    settings = [t for key, value in options.items() for t in ("-o", f"{key}:{value}")]
    made: Ports = {}

    class Node(rtm.DataFlowComponentBase):  # type: ignore[misc]
        def onInitialize(self) -> Any:  # noqa: N802
            for port in PORTS:
                value = sample_of(rtc, port)
                if kind == "Sender":
                    made[port] = rtm.OutPort(port, value)
                    self.addOutPort(port, made[port])
                else:
                    made[port] = rtm.InPort(port, value)
                    self.addInPort(port, made[port])
            return rtc.RTC_OK

    name = f"openrtm{kind}"
    profile = ["implementation_id", name, "type_name", name, "version", "1.0", ""]
    manager = rtm.Manager.init(["benchmark", *settings])
    manager.activateManager()
    manager.runManager(True)
    manager.registerFactory(rtm.Properties(defaults_str=profile), Node, rtm.Delete)
    component = manager.createComponent(name)
    rtm.activate(component.getObjRef())
    while not rtm.is_in_active(component.getObjRef()):
        time.sleep(0.05)

    def connect(*ends: str) -> list[Any]:
        naming = rtm.CorbaNaming(manager.getORB(), names)
        found = []
        for instance, port in zip(ends[:2], ends[2:], strict=True):
            node = naming.resolve(f"{instance}.rtc")._narrow(rtc.RTObject)
            found.append(rtm.get_port_by_name(node, f"{instance}.{port}"))
        asked = rtm.Properties()
        for key, value in CONNECTOR.items():
            asked.setProperty(f"dataport.{key}", value)
        return [str(rtm.connect("wire", asked, *found))]

    yield made, rtc, True, connect


def main(side: str, kind: str, names: str) -> None:
    """Execute commands until the input ends."""
    made: Callable[..., Any] = ours if side == "rtgen" else theirs
    with made(kind, names) as (ports, classes, taken, connect):
        ready = {
            name: Reader(port) if kind == "Receiver" else sample_of(classes, name)
            for name, port in ports.items()
        }
        print('["ready"]', flush=True)
        for line in sys.stdin:
            command, *words = line.split()
            if command == "connect":
                answer = connect(*words)
            elif command == "send":
                port, count, pause = words
                told = int(count), float(pause)
                answer = send(ports[port], ready[port], taken, *told)
            else:
                print('["reading"]', flush=True)
                answer = receive(ready[words[0]], int(words[1]))
            print(json.dumps(answer), flush=True)


if __name__ == "__main__" and len(sys.argv) == 4:
    main(*sys.argv[1:])
    # Threads of omniORB that end together with the interpreter may abort the process.
    sys.stdout.flush()
    os._exit(0)
