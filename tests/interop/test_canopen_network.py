"""Typed components and scripts of the package `canopen` on one bus: a shared `canopen.Network`."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from queue import Queue
from typing import Any

import can
import canopen
import pytest
from test_hand_slave import FOLDER, NODE, hand, of

from refrobots.fpalette import FPaletteObjects
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    RealClock,
    SampleRecord,
    System,
)
from rtgen.runtime.canopen.bus.canopen_network import NetworkBus, shared, typed
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.real_link import RealLink
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.values import ObjectValueError
from rtgen.runtime.canopen.wire.frames import Frame

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from stations import Recorder

__all__ = ["hand"]
EDS = str(FOLDER / "hand_slave.eds")
CHANNELS = count()
LIMIT = 20 * SECOND


@pytest.fixture
def channel() -> Iterator[str]:
    yield f"network{next(CHANNELS)}"
    left = [t.name for t in threading.enumerate() if t.name.startswith("rtgen ")]
    assert not left


@pytest.fixture
def network(channel: str) -> Iterator[canopen.Network]:
    made = canopen.Network()
    made.NOTIFIER_CYCLE = 0.05
    made.connect(interface="virtual", channel=channel)
    with shared(made, channel):
        yield made
    made.disconnect()


@pytest.fixture
def slave(channel: str) -> Iterator[Any]:
    """Yield a hand-written slave on a connection of its own."""
    ended = threading.Event()
    with can.Bus(interface="virtual", channel=channel) as bus:
        made = of("hand_slave", "Slave")(bus, NODE)

        def serve() -> None:
            made.reset()
            while not ended.is_set():
                made.step()

        thread = threading.Thread(target=serve)
        thread.start()
        yield made
        ended.set()
        thread.join()


def configured(component: Any, channel: str, **settings: object) -> Any:
    parameters = {"interface": "canopen", "channel": channel} | settings
    for name, value in parameters.items():
        component.configuration_sets.set(name, str(value))
    return component


def proxy(channel: str, **settings: object) -> Any:
    made = of("hand.components.hand_slave_proxy", "HandSlaveProxy")("Proxy0")
    return configured(made, channel, node_id=NODE, **settings)


def until(system: System, condition: Callable[[], bool]) -> None:
    assert system.run(system.time + LIMIT, until=lambda _: condition())


def test_a_manager_and_a_proxy_beside_a_script(
    network: canopen.Network, channel: str, slave: Any
) -> None:
    script = network.add_node(NODE, EDS)
    beats: Queue[int] = Queue()
    script.nmt.add_heartbeat_callback(lambda state: beats.put(state))
    samples: list[Any] = []
    with System(RealClock()) as system:
        typed = proxy(channel, network="hand")
        manager = of("hand.canopen.manager", "CanopenManager")("Manager0")
        system.add(typed, 200.0)
        system.add(configured(manager, channel), 100.0)
        system.add_listener(
            lambda record: (
                samples.append(record)
                if isinstance(record, SampleRecord) and record.instance == "Proxy0"
                else None
            )
        )
        for name in ("Manager0", "Proxy0"):
            system.activate(name)
        until(system, lambda: system.state("Proxy0") is ACTIVE_STATE)
        until(system, lambda: len(samples) > 5)
        # Both read and write the node; neither takes the other's answers for a second node's.
        for number in range(20):
            script.sdo[0x2003].raw = number
            assert typed.read_object(0x2003) == number
            typed.objects["Target"] = -number
            assert script.sdo[0x2003].raw == -number
        assert script.sdo["Device type"].raw == 0x191
        assert manager.station.reports()[0].reason == ""
        # A command of the script affects node, manager and component.
        assert any(beats.get(timeout=20) == 5 for _ in range(50))
        script.nmt.state = "PRE-OPERATIONAL"
        until(system, lambda: system.state("Proxy0") is INACTIVE_STATE)
        script.nmt.state = "OPERATIONAL"
        until(system, lambda: system.state("Proxy0") is ACTIVE_STATE)
        seen = len(samples)
        until(system, lambda: len(samples) > seen + 5)
        # PDOs of the node reach the script, too.
        script.tpdo.read()
        came = threading.Event()
        script.tpdo[1].add_callback(lambda _: came.set())
        until(system, came.is_set)


def test_a_typed_device_and_a_script_as_its_master(
    network: canopen.Network, channel: str
) -> None:
    """Both in one process: frames reach either side, although the bus does not return them."""
    script = network.add_node(NODE, EDS)
    base = of("hand.components.hand_slave_device", "HandSlaveDeviceBase")

    class Device(base):  # type: ignore[misc, valid-type]
        def __init__(self) -> None:
            super().__init__("Device0")

    with System(RealClock()) as system:
        device = configured(Device(), channel, node_id=NODE, network="")
        system.add(device, 200.0)
        script.sdo[0x2003].raw = 4711
        assert device.objects.Target == 4711
        typed = proxy(channel, network="", master=1)
        system.add(typed, 100.0)
        for number in range(50):
            typed.objects["Target"] = number
            assert script.sdo[0x2003].raw == number
            script.sdo[0x2003].raw = -number
            assert typed.read_object(0x2003) == -number
        script.nmt.state = "OPERATIONAL"
        until(system, lambda: system.state("Device0") is ACTIVE_STATE)
        script.sdo[0x1800][2].raw = 1
        script.tpdo.read()
        got: Queue[int] = Queue()
        script.tpdo[1].add_callback(lambda pdo: got.put(pdo[1].raw))
        device.objects.Position = -7
        network.sync.start(0.02)
        values: list[int] = []

        def has_come() -> bool:
            while not got.empty():
                values.append(got.get())
            return -7 in values

        until(system, has_come)
        network.sync.stop()


def test_a_network_that_is_disconnected_is_a_lost_bus(
    network: canopen.Network, channel: str, slave: Any
) -> None:
    with System(RealClock()) as system:
        typed = proxy(channel, network="", master=1)
        system.add(typed, 200.0)
        system.activate("Proxy0")
        until(system, lambda: system.state("Proxy0") is ACTIVE_STATE)
        network.disconnect()
        until(system, lambda: system.state("Proxy0") is ERROR_STATE)
        assert "the bus is gone" in typed.reason
        network.connect(interface="virtual", channel=channel)
        until(system, lambda: typed._connection.link.up)
        system.reset("Proxy0")
        until(system, lambda: system.state("Proxy0") is INACTIVE_STATE)
        system.activate("Proxy0")
        until(system, lambda: system.state("Proxy0") is ACTIVE_STATE)


def test_what_is_shared_is_left_as_it_was(
    network: canopen.Network, channel: str
) -> None:
    bus, listeners = network.bus, list(network.notifier.listeners)
    assert bus is not None
    link = open_link(RealClock(), "canopen", channel)
    station = Recorder()
    link.attach(station)
    network.send_message(0x123, b"1")
    assert link.wait(lambda: station.frames == [Frame(0x123, b"1")], LIMIT)
    link.detach(station)
    assert "send" not in vars(bus)
    assert network.notifier.listeners == listeners
    # Its bus is open still.
    with can.Bus(interface="virtual", channel=channel) as other:
        network.send_message(0x124, b"2")
        assert other.recv(20).arbitration_id == 0x124


def test_a_callback_of_a_script_that_fails_stops_nothing(
    network: canopen.Network, channel: str, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("a script's mistake")

    network.subscribe(0x123, fail)
    link = open_link(RealClock(), "canopen", channel)
    assert isinstance(link, RealLink)
    station = Recorder()
    link.attach(station)
    with can.Bus(interface="virtual", channel=channel) as other:
        link.send([Frame(0x123), Frame(0x124)], station)
        assert [other.recv(20).arbitration_id for _ in range(2)] == [0x123, 0x124]
    link.detach(station)
    assert "a script's mistake" in caplog.text


def test_what_cannot_be_shared(network: canopen.Network, channel: str) -> None:
    with pytest.raises(LinkError, match=r"no canopen\.Network is shared as 'nowhere'"):
        open_link(RealClock(), "canopen", "nowhere")
    with (
        pytest.raises(ValueError, match="shared as"),
        shared(canopen.Network(), channel),
    ):
        pass
    with pytest.raises(ValueError, match="by another name"), shared(network, "another"):
        pass
    with (
        shared(canopen.Network(), "unconnected"),
        pytest.raises(LinkError, match="the network is not connected"),
    ):
        open_link(RealClock(), "canopen", "unconnected")


def test_a_network_that_is_about_to_connect_is_not_connected(
    network: canopen.Network, channel: str
) -> None:
    """`Network.connect` sets the bus first; until then its notifier is a stopped one."""
    network.disconnect()
    network.bus = can.Bus(interface="virtual", channel=channel)
    with pytest.raises(can.CanInitializationError, match="not connected"):
        NetworkBus(channel)
    network.connect()
    with NetworkBus(channel) as joined:
        assert joined.shared_bus is network.bus


SPECS = Path(__file__).parents[2] / "specs" / "canopen"


@pytest.mark.parametrize("kind", [canopen.RemoteNode, canopen.LocalNode])
def test_typed_objects_of_a_node_of_the_package(kind: Any, channel: str) -> None:
    ends = [canopen.Network(), canopen.Network()]
    for end in ends:
        end.NOTIFIER_CYCLE = 0.05
        end.connect(interface="virtual", channel=channel)
    try:
        local = ends[0].create_node(5, str(SPECS / "f_palette.eds"))
        remote = ends[1].add_node(5, str(SPECS / "f_palette.eds"))
        node = local if kind is canopen.LocalNode else remote
        objects = typed(FPaletteObjects, node)
        objects.Digital_outputs_1_to_8 = 0xAA
        assert local.sdo[0x6200][1].raw == objects.Digital_outputs_1_to_8 == 0xAA
        objects["Angle_reference_offset"] = -7
        assert remote.sdo[0x2103].raw == objects.Angle_reference_offset == -7
        assert objects.Manufacturer_device_name == "f-palette"
        with pytest.raises(ObjectValueError, match="300 is over 255"):
            objects.Digital_outputs_1_to_8 = 300
        with pytest.raises(KeyError, match="FPalette has no object 'Speed'"):
            objects["Speed"]
    finally:
        for end in ends:
            end.disconnect()
