"""A proxy with the complete slave: values of every kind by SDO, and detection of a second node."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pytest
from device_bench import DEVICE, number_of
from device_bench import NODE_ID as NODE
from proxy_bench import DriveProxy
from stations import Recorder
from test_object_values import BOUNDARIES

from rtgen.facts.canopen import SIGNED_KINDS, UNSIGNED_KINDS
from rtgen.runtime import LifeCycleState, System
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.simulated_bus import SimulatedCanBus
from rtgen.runtime.canopen.description import Kind, ObjectNumber, ObjectValue
from rtgen.runtime.canopen.hooks import Receiver, Sender
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.wire.nmt import NmtState
from rtgen.runtime.canopen.wire.sdo import SdoAbort

SECOND = 1000 * MILLISECOND


class SlaveProxy(DriveProxy):
    """The proxy of the slave with an object of each kind; without PDOs."""

    description = DEVICE

    def __init__(self) -> None:
        super().__init__("Slave0")
        self.received: list[bytes] = []

    def _receivers(self) -> Mapping[int, Receiver]:
        return {1: lambda data, now: self.received.append(data)}

    def _senders(self) -> Mapping[int, Sender]:
        return {}

    def _parameter_values(self) -> Mapping[ObjectNumber, ObjectValue]:
        return {}


class Bench:
    def __init__(self, **settings: Any) -> None:
        self.system = System()
        self.proxy = SlaveProxy()
        for name, value in settings.items():
            self.proxy.configuration_sets.set(name, str(value))
        self.link = open_link(self.system.clock)
        self.node = DeviceNode(DEVICE, NODE)
        self.recorder = Recorder()
        self.link.attach(self.recorder)
        self.link.attach(self.node)
        self.system.add(self.proxy, 100.0)
        self.send_all(self.node.boot(0))
        self.run(0.05)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *exception: object) -> None:
        self.system.close()

    @property
    def bus(self) -> SimulatedCanBus:
        assert isinstance(self.link, SimulatedCanBus)
        return self.link

    def send_all(self, frames: Iterable[Frame]) -> None:
        self.link.send(frames, self.node)
        self.link.refresh(self.node)

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def until(self, state: str) -> None:
        wanted = LifeCycleState[f"{state}_STATE"]
        limit = self.system.time + 10 * SECOND
        self.system.run(limit, until=lambda s: s.state("Slave0") is wanted)
        assert self.system.state("Slave0") is wanted, self.proxy.reason

    def activate(self) -> None:
        self.system.activate("Slave0")
        self.until("ACTIVE")


@pytest.fixture(scope="module")
def bench() -> Iterable[Bench]:
    with Bench() as bench:
        bench.activate()
        yield bench


@pytest.mark.parametrize(("kind", "value", "octets"), BOUNDARIES)
def test_boundaries_of_every_kind_round_trip(
    bench: Bench, kind: Kind, value: ObjectValue, octets: str
) -> None:
    index = number_of(kind)
    bench.proxy.write_object(index, 0, value)
    assert bench.node.get(index) == value
    back = bench.proxy.read_object(index)
    assert back == value
    assert type(back) is type(value)
    assert bench.proxy.read_octets(index, 0).hex() == octets


@pytest.mark.parametrize("kind", [*SIGNED_KINDS, *UNSIGNED_KINDS])
def test_limits_of_integers_round_trip(bench: Bench, kind: Kind) -> None:
    own = values.limits(kind)
    assert own is not None
    for value in own:
        bench.proxy.write_object(number_of(kind), 0, value)
        assert bench.proxy.read_object(number_of(kind)) == value


@pytest.mark.parametrize("kind", ["string", "wstring", "octets"])
@pytest.mark.parametrize("size", [1, 4, 5, 7, 8, 14, 500, 5000])
def test_long_values_round_trip(bench: Bench, kind: Kind, size: int) -> None:
    value: ObjectValue = "x" * size
    if kind == "octets":
        value = bytes(i % 256 for i in range(size))
    bench.proxy.write_object(number_of(kind), 0, value)
    assert bench.proxy.read_object(number_of(kind)) == value


@pytest.mark.parametrize(
    ("number", "value", "code"),
    [
        ((0x2100, 0), b"\0\0", sdo.READ_ONLY),
        ((0x2102, 0), b"\0\0", sdo.READ_ONLY),
        ((0x2101, 0), None, sdo.WRITE_ONLY),
        ((0x4000, 0), None, sdo.NO_OBJECT),
        ((0x1018, 9), None, sdo.NO_SUBINDEX),
        ((0x2103, 0), b"\x65\0", sdo.VALUE_TOO_HIGH),
        ((0x2103, 0), b"\x9b\xff", sdo.VALUE_TOO_LOW),
        ((0x2103, 0), b"\1", sdo.LENGTH_TOO_LOW),
        ((0x2103, 0), b"\1\0\0", sdo.LENGTH_TOO_HIGH),
    ],
)
def test_what_the_slave_refuses(
    bench: Bench, number: tuple[int, int], value: bytes | None, code: int
) -> None:
    proxy = bench.proxy
    arguments = number if value is None else (*number, value)
    with pytest.raises(SdoAbort) as caught:
        (proxy.read_octets if value is None else proxy.write_octets)(*arguments)
    assert caught.value.code == code


def test_a_second_slave_of_the_same_id() -> None:
    """The second node boots; the first one detects it, and sends an EMCY."""
    with Bench() as bench:
        bench.activate()
        second = DeviceNode(DEVICE, NODE)
        bench.link.attach(second)
        bench.link.send(second.boot(bench.link.now()), second)
        bench.until("ERROR")
        assert "node 5" in bench.proxy.reason


def test_the_slave_goes_off_the_bus_and_returns() -> None:
    with Bench() as bench:
        bench.activate()
        bench.run(0.5)
        bench.bus.cut(bench.node)
        bench.until("ERROR")
        assert bench.proxy.reason == "node 5 is lost: no heartbeat for 300 ms"
        bench.bus.mend(bench.node)
        bench.run(0.5)
        bench.system.reset("Slave0")
        bench.until("INACTIVE")
        bench.activate()


def test_the_proxy_goes_off_the_bus_and_returns() -> None:
    with Bench() as bench:
        bench.activate()
        assert bench.proxy._connection is not None
        bench.bus.cut(bench.proxy._connection.node)
        bench.until("ERROR")
        assert bench.proxy.reason == "node 5 cannot be reached: the bus is gone"
        bench.system.reset("Slave0")
        bench.run(0.1)
        assert bench.proxy.reason.endswith("is off")
        bench.bus.mend(bench.proxy._connection.node)
        bench.system.reset("Slave0")
        bench.until("INACTIVE")
        bench.activate()


def test_a_pdo_that_is_too_short_for_the_slave_is_reported() -> None:
    with Bench() as bench:
        bench.activate()
        bench.link.send([Frame(0x200 + NODE, b"\1\2")])
        bench.run(0.1)
        assert bench.proxy.reason == (
            "node 5 reports EMCY 8210h PDO too short (generic, communication)"
        )
        bench.run(0.2)
        assert bench.node.state is NmtState.OPERATIONAL
