"""A proxy with a node of the `canopen` package, in real time over python-can's virtual bus."""

from __future__ import annotations

import struct
import sys
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import canopen
import pytest
from canopen.objectdictionary import (
    DOMAIN,
    INTEGER32,
    UNSIGNED16,
    UNSIGNED32,
    VISIBLE_STRING,
    ODVariable,
)

from refrobots.rtc import Time, TimedLong
from rtgen.runtime import (
    SECOND,
    Component,
    LifeCycleState,
    RealClock,
    SampleRecord,
    System,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from proxy_bench import DriveProxy

NODE = 5
CHANNELS = count()


def dictionary() -> canopen.ObjectDictionary:
    objects = canopen.ObjectDictionary()
    for index, kind, value in (
        (0x1000, UNSIGNED32, 0x20192),
        (0x1008, VISIBLE_STRING, "a drive with a rather long name"),
        (0x1017, UNSIGNED16, 0),
        (0x2000, DOMAIN, b"?"),
        (0x6064, INTEGER32, 0),
        (0x607A, INTEGER32, 0),
        (0x6083, UNSIGNED32, 0),
    ):
        variable = ODVariable(f"o{index:04X}", index)
        variable.data_type = kind
        variable.access_type = "ro" if index == 0x1000 else "rw"
        variable.default = value
        objects.add_object(variable)
    objects.node_id = NODE
    return objects


class Slave:
    """A LocalNode with additions: boot, and answers to a reset."""

    def __init__(self, channel: str) -> None:
        self.network = canopen.Network()
        self.network.NOTIFIER_CYCLE = 0.05
        self.network.connect(interface="virtual", channel=channel)
        self.node = canopen.LocalNode(NODE, dictionary())
        self.network.add_node(self.node)
        self.targets: list[int] = []
        self.commands: list[int] = []
        self.network.subscribe(0, self._command)
        self.network.subscribe(0x200 + NODE, self._target)

    def boot(self) -> None:
        self.node.nmt.send_command(0)
        self.node.nmt.send_command(128)

    def send_position(self, value: int) -> None:
        self.network.send_message(0x180 + NODE, struct.pack("<i", value))

    def close(self) -> None:
        self.node.nmt.stop_heartbeat()
        self.network.disconnect()

    def _command(self, can_id: int, data: bytes, stamp: float) -> None:
        self.commands.append(data[0])
        if data[0] in (0x81, 0x82):
            self.boot()

    def _target(self, can_id: int, data: bytes, stamp: float) -> None:
        self.targets.append(struct.unpack("<i", data)[0])


class Bench:
    def __init__(self) -> None:
        channel = f"canopen{next(CHANNELS)}"
        self.slave = Slave(channel)
        self.system = System(RealClock())
        self.proxy = DriveProxy("Drive0")
        self.proxy.configuration_sets.set("channel", channel)
        self.source = Component("Source0")
        self.out = self.source.add_out_port("out", TimedLong)
        self.system.add(self.proxy, 200.0)
        self.system.add(self.source)
        self.system.connect(("Source0", "out"), ("Drive0", "rpdo1"))
        self.samples: list[SampleRecord] = []
        self.system.add_listener(self._note)
        self.slave.boot()

    def _note(self, record: object) -> None:
        if isinstance(record, SampleRecord):
            self.samples.append(record)

    @property
    def values(self) -> list[int]:
        return [s.value.data for s in self.samples if s.port == "tpdo1"]

    def until(self, state: str) -> None:
        wanted = LifeCycleState[f"{state}_STATE"]
        limit = self.system.time + 20 * SECOND
        self.system.run(limit, until=lambda s: s.state("Drive0") is wanted)
        assert self.system.state("Drive0") is wanted, self.proxy.reason

    def wait(self, condition: object) -> None:
        assert callable(condition)
        limit = self.system.time + 20 * SECOND
        assert self.system.run(limit, until=lambda s: bool(condition()))

    def activate(self) -> None:
        self.system.activate("Drive0")
        self.until("ACTIVE")


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.system.close()
    bench.slave.close()


def test_life_cycle(bench: Bench) -> None:
    bench.activate()
    assert bench.slave.node.nmt.state == "OPERATIONAL"
    bench.system.deactivate("Drive0")
    bench.until("INACTIVE")
    assert bench.slave.node.nmt.state == "PRE-OPERATIONAL"
    bench.activate()
    bench.slave.node.nmt.stop_heartbeat()
    bench.until("ERROR")
    assert bench.proxy.reason == "node 5 is lost: no heartbeat for 300 ms"
    bench.system.reset("Drive0")
    bench.until("INACTIVE")
    bench.activate()
    assert bench.slave.commands == [0x01, 0x80, 0x01, 0x02, 0x81, 0x01]


def test_states_that_nobody_asked_for(bench: Bench) -> None:
    bench.activate()
    bench.slave.node.nmt.state = "PRE-OPERATIONAL"
    bench.until("INACTIVE")
    bench.slave.node.nmt.state = "OPERATIONAL"
    bench.until("ACTIVE")
    bench.slave.node.nmt.state = "STOPPED"
    bench.until("ERROR")
    assert bench.proxy.reason == "node 5 was stopped"


def test_an_emergency(bench: Bench) -> None:
    bench.activate()
    bench.slave.node.emcy.send(0x4210, 9)
    bench.until("ERROR")
    assert bench.proxy.reason == (
        "node 5 reports EMCY 4210h device temperature (generic, temperature)"
    )


def test_pdos(bench: Bench) -> None:
    bench.activate()
    values = [0, 1, -1, 2**31 - 1, -(2**31), *range(100, 150)]
    begun = time.time_ns()
    for value in values:
        bench.slave.send_position(value)
    bench.wait(lambda: len(bench.values) == len(values))
    assert bench.values == values
    stamps = [s.value.tm.sec * SECOND + s.value.tm.nsec for s in bench.samples]
    assert sorted(stamps) == stamps
    assert begun - SECOND < stamps[0] <= stamps[-1] < time.time_ns() + SECOND
    for value in (5, -5, 10**9):
        bench.out.write(TimedLong(Time(), value))
    bench.wait(lambda: len(bench.slave.targets) == 3)
    assert bench.slave.targets == [5, -5, 10**9]


def test_objects(bench: Bench) -> None:
    bench.activate()
    proxy = bench.proxy
    assert bench.slave.node.sdo[0x6083].raw == 1000, "written at activation"
    assert proxy.read_object(0x1008) == "a drive with a rather long name"
    proxy.write_object(0x6083, 0, 2**32 - 1)
    assert bench.slave.node.sdo[0x6083].raw == 2**32 - 1
    assert proxy.read_object(0x6083) == 2**32 - 1
    for size in (1, 4, 5, 7, 8, 900):
        value = bytes(i % 256 for i in range(size))
        proxy.write_object(0x2000, 0, value)
        assert proxy.read_object(0x2000) == value
    with pytest.raises(SdoAbort, match="06020000h object does not exist"):
        proxy.read_object(0x3000)
    with pytest.raises(SdoAbort, match="06010002h write of a read-only object"):
        proxy.write_object(0x1000, 0, 1)


def test_parameters(bench: Bench) -> None:
    bench.activate()
    bench.system.configure("Drive0", "Acceleration", "77")
    bench.wait(lambda: bench.slave.node.sdo[0x6083].raw == 77)


def test_a_slave_that_is_missing() -> None:
    bench = Bench()
    try:
        bench.slave.close()
        bench.system.configure("Drive0", "boot_timeout", "200")
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.proxy.reason == "node 5 is missing: no answer within 0.2 s"
    finally:
        bench.system.close()
