"""A proxy whose node is in a network: PDOs, identity, configuration, and with a manager."""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from types import ModuleType

import pytest
from msgspec.structs import replace
from proxy_bench import DESCRIPTION, MS, NODE, Bench

from refrobots.rtc import Time, TimedLong
from rtgen.runtime import Component
from rtgen.runtime.canopen.description import (
    Network,
    NodeDescription,
    PdoDescription,
    Write,
)
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.master.proxied_node import wiring
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState

RAMP = Write(0x6083, 0, struct.pack("<I", 77))
BEAT = Write(0x1017, 0, struct.pack("<H", 50))
PLACED = NodeDescription(
    "left", NODE, "Drive", (0x20192, 0x111, 0x222, None, None), (BEAT, RAMP),
    (
        PdoDescription("tpdo", 1, 0x1C5, False, 255, ((0x6064, 0, 32),)),
        PdoDescription("rpdo", 1, 0x2C5, False, 255, ((0x607A, 0, 32),)),
    ),
    heartbeat=50, heartbeat_timeout=150,
)  # fmt: skip
NETWORK = Network("net", 500, 127, 0, 100, (PLACED,))


def put(monkeypatch: pytest.MonkeyPatch, network: Network) -> None:
    """Use it as the content of the generated module `net`."""
    package, module = ModuleType("canopen_networks"), ModuleType("canopen_networks.net")
    package.__path__ = [str(Path(__file__).parent / "networks")]
    module.NETWORK = network  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, package.__name__, package)
    monkeypatch.setitem(sys.modules, module.__name__, module)


def ready(**settings: object) -> Bench:
    bench = Bench(settings={"network": "net", **settings})
    bench.with_node()
    bench.run(0.05)
    return bench


# Without a manager.


def test_the_network_says_which_pdos_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, NETWORK)
    with ready() as bench:
        bench.activate()
        bench.node.send(Frame(0x1C5, struct.pack("<i", 4)))
        bench.node.send(Frame(0x180 + NODE, struct.pack("<i", 5)))
        bench.run(0.02)
        assert bench.values() == [4]
        source = Component("Source0")
        out = source.add_out_port("out", TimedLong)
        bench.system.add(source)
        bench.system.connect(("Source0", "out"), ("Drive0", "rpdo1"))
        out.write(TimedLong(Time(), 6))
        bench.run(0.02)
        assert Frame(0x2C5, struct.pack("<i", 6)) in bench.recorder.frames


def test_a_master_identifies_and_configures_the_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, NETWORK)
    with ready(Acceleration=5) as bench:
        bench.activate()
        assert bench.node.objects.writes == [
            ((0x1017, 0), BEAT.value),
            ((0x6083, 0), RAMP.value),
            ((0x6083, 0), struct.pack("<I", 5)),
        ]
        assert bench.node.period == 50 * MS
        bench.node.mute()
        bench.until("ERROR")
        assert bench.reason == "node 5 is lost: no heartbeat for 150 ms"


@pytest.mark.parametrize(
    ("number", "what"),
    [((0x1000, 0), "device type"), ((0x1018, 1), "vendor"), ((0x1018, 2), "product")],
)
def test_another_device_is_reported(
    monkeypatch: pytest.MonkeyPatch, number: tuple[int, int], what: str
) -> None:
    put(monkeypatch, NETWORK)
    with ready() as bench:
        bench.node.objects.values[number] = struct.pack("<I", 0x999)
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason.startswith(f"node 5 is another device: its {what} ")
        assert "is 0x999, not 0x" in bench.reason
        assert bench.node.objects.writes == []


def test_a_device_that_does_not_keep_its_configuration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, NETWORK)
    with ready() as bench:
        bench.node.objects.write = lambda index, subindex, value: None  # type: ignore[method-assign]
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "node 5 does not keep the value written to 1017h:0"


def test_a_device_that_tells_no_lengths_keeps_its_configuration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, NETWORK)
    with ready() as bench:
        objects = bench.node.objects
        read = objects.read

        def padded(index: int, subindex: int) -> bytes:
            return read(index, subindex).ljust(4, b"\0")

        monkeypatch.setattr(objects, "read", padded)
        bench.activate()


def test_a_device_that_starts_by_itself_is_identified(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, NETWORK)
    with ready() as bench:
        bench.node.objects.values[0x1018, 1] = struct.pack("<I", 0x999)
        bench.node.go(NmtState.OPERATIONAL)
        bench.until("ERROR")
        assert bench.reason.startswith("node 5 is another device: its vendor ")


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"network": "other"}, "there is no network 'other'; there are net"),
        ({"network": "os.path"}, "there is no network 'os.path'; there are net"),
        ({"node_id": 9}, "the network net has no node 9"),
    ],
)
def test_networks_that_do_not_fit(
    monkeypatch: pytest.MonkeyPatch, settings: dict[str, object], reason: str
) -> None:
    put(monkeypatch, NETWORK)
    with Bench(settings={"network": "net", **settings}) as bench:
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == reason


def test_a_node_of_another_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    node = replace(PLACED, module="Board")
    put(monkeypatch, replace(NETWORK, nodes=(node,)))
    with Bench(settings={"network": "net"}) as bench:
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "node 5 of the network net is not a Drive, but Board"


def test_the_boot_time_out_is_that_of_the_network(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, replace(NETWORK, nodes=(replace(PLACED, boot_timeout=3500),)))
    with Bench(settings={"network": "net"}) as bench:
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "node 5 is missing: no answer within 3.5 s"


def test_what_another_node_sends_a_proxy_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """PDO linking: the RPDO has the COB-ID of the other node's TPDO."""
    board = PdoDescription("tpdo", 4, 0x2C5, False, 255, ((0x6401, 1, 32),))
    other = replace(PLACED, name="board", id=6, module="Board", pdos=(board,))
    linked = replace(NETWORK, nodes=(PLACED, other))
    assert wiring(DESCRIPTION, NODE, linked).unsent == {1: "another node sends it"}
    put(monkeypatch, linked)
    with ready() as bench:
        bench.activate()
        source = Component("Source0")
        out = source.add_out_port("out", TimedLong)
        bench.system.add(source)
        bench.system.connect(("Source0", "out"), ("Drive0", "rpdo1"))
        out.write(TimedLong(Time(), 6))
        bench.run(0.02)
        assert bench.proxy.lost == 1
        assert 0x2C5 not in bench.recorder.ids
        assert bench.state == "ACTIVE"


def test_pdos_that_are_not_valid_are_neither_taken_nor_sent() -> None:
    node = replace(
        PLACED,
        pdos=tuple(replace(pdo, cob_id=0x80000000 | 0x1C5) for pdo in PLACED.pdos),
    )
    wired = wiring(DESCRIPTION, NODE, replace(NETWORK, nodes=(node,)))
    assert (wired.received, wired.sent) == ({}, {})
    assert wired.unsent == {1: "it is not valid"}


# With a manager.


def managed(bench: Bench) -> ManagerStation:
    manager = ManagerStation(bench.link, NETWORK)
    manager.start()
    return manager


def test_a_manager_configures_and_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, NETWORK)
    with Bench(settings={"network": "net", "master": False}) as bench:
        bench.system.activate("Drive0")
        bench.with_node()
        bench.run(0.02)
        manager = managed(bench)
        bench.until("ACTIVE")
        assert [number for number, _ in bench.node.objects.writes] == [
            (0x1017, 0),
            (0x6083, 0),
            (0x6083, 0),
        ]
        assert bench.node.objects.values[0x6083, 0] == struct.pack("<I", 1000)
        bench.system.deactivate("Drive0")
        bench.until("INACTIVE")
        bench.run(0.5)
        assert bench.state == "INACTIVE"
        assert bench.node.state is NmtState.PRE_OPERATIONAL
        bench.activate()
        manager.halt()
        bench.until("INACTIVE")


def test_a_proxy_follows_what_its_manager_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(monkeypatch, NETWORK)
    with ready(master=False) as bench:
        managed(bench)
        bench.until("ACTIVE")
        assert (NmtCommand.START, NODE) in bench.commands()


def test_a_reset_goes_by_the_manager(monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, NETWORK)
    with ready(master=False) as bench:
        managed(bench)
        bench.until("ACTIVE")
        bench.node.mute()
        bench.until("ERROR")
        bench.run(0.5)
        assert bench.state == "ERROR"
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.until("ACTIVE")


def test_what_the_manager_finds_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, NETWORK)
    with ready(master=False) as bench:
        bench.node.objects.values[0x1018, 1] = struct.pack("<I", 0x999)
        managed(bench)
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason.startswith("node 5: ")
        assert "vendor" in bench.reason


def test_a_node_that_the_manager_misses(monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, NETWORK)
    with Bench(settings={"network": "net", "master": False}) as bench:
        managed(bench)
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert "node 5: no boot-up message within 2000 ms" in bench.reason


def test_a_heartbeat_is_watched_when_the_manager_has_configured_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Before that a node may send heartbeats at the rate of its EDS, however slowly."""
    idle = replace(NETWORK, nodes=(replace(PLACED, start=False),))
    put(monkeypatch, idle)
    with ready(master=False) as bench:
        bench.node.beat(NmtState.PRE_OPERATIONAL)
        bench.run(2.0)
        assert bench.state == "INACTIVE"
        ManagerStation(bench.link, idle).start()
        bench.run(1.0)
        assert bench.state == "INACTIVE"
        bench.node.mute()
        bench.until("ERROR")
        assert bench.reason == "node 5 is lost: no heartbeat for 150 ms"
