"""A CAN bus on a page: decoded frames, states of nodes, load, frames sent by the page."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ui_bench import ROOT, Bench, Page, whole

from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.ui.protocol import ui

SYSTEM = ROOT / "specs/canopen/fourx.xml"
FILE = ROOT / "specs/canopen/fourx.toml"


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench(SYSTEM, buses={"": FILE})
    yield made
    made.close()


@pytest.fixture
def page(bench: Bench) -> Page:
    return bench.page()


def frames(page: Page) -> list[ui.Frame]:
    """Return the frames among the events of the last command."""
    return [
        frame
        for e in page.seen
        if e.discriminator is ui.EventKind.EVENT_FRAMES
        for frame in e.traffic
    ]


def bus_of(bench: Bench) -> ui.Bus:
    [bus] = whole(bench.page().events()).buses
    return bus


def test_frames_nodes_and_load(bench: Bench, page: Page) -> None:
    page.done("step", 0.1)
    first = {frame.kind for frame in frames(page)}
    page.done("step", 1.9)
    bus = bus_of(bench)
    assert bus.bit_rate == 1_000_000
    assert 0.0 < bus.computed_load < 1.0
    assert [node.name for node in bus.nodes] == [
        *("front_left", "front_right", "rear_left", "rear_right", "manager")
    ]
    assert {node.nmt_state for node in bus.nodes} == {"operational"}
    found = frames(page)
    assert {"heartbeat", "nmt", "sdo", "tpdo1"} <= first | {f.kind for f in found}
    pdo = next(f for f in found if f.kind == "tpdo1" and f.fields)
    assert pdo.node_id in range(1, 5)
    assert any(each.numeric and each.unit for f in found for each in f.fields)
    loads = [e.carried for e in page.seen if e.discriminator is ui.EventKind.EVENT_LOAD]
    assert loads
    assert all(0.0 < each.load < 1.0 and each.frames > 0 for each in loads)


def test_nodes_are_managed(bench: Bench, page: Page) -> None:
    page.done("step", 2.0)
    name = bus_of(bench).name
    page.done("managed", ui.NmtCommand(name, 1, "stop"))
    page.done("step", 0.05)
    assert any(f.kind == "nmt" and f.text == "stop" for f in frames(page))
    assert page.ask("managed", ui.NmtCommand(name, 1, "halt")).code == "UIS0003"
    assert page.ask("managed", ui.NmtCommand(name, 200, "stop")).code == "UIS0005"
    assert page.ask("managed", ui.NmtCommand("can9", 1, "stop")).code == "UIS0003"


def test_objects_are_read_and_written(bench: Bench, page: Page) -> None:
    page.done("step", 2.0)
    name = bus_of(bench).name
    objects = page.done("node", ui.NodeAddress(name, 1)).objects
    found = {(each.index, each.subindex): each for each in objects}
    assert found[0x6083, 0].access == "rw"
    access = ui.SdoAccess(name, 1, 0x6083, 0, "")
    before = page.done("read", access).text
    access.text = "1234"
    page.done("written", access)
    after = page.done("read", access).text
    assert before != after
    assert "1234" in after
    access.text = "fast"
    assert page.ask("written", access).code == "UIS0005"
    wrong = ui.SdoAccess(name, 1, 0x5FFF, 0, "1")
    assert page.ask("read", wrong).code == "UIS0007"
    assert page.ask("written", wrong).code == "UIS0003"
    assert page.ask("read", ui.SdoAccess(name, 0, 0x1000, 0, "")).code == "UIS0005"


@pytest.mark.sampled(0)
def test_frames_are_sent_once_and_again(bench: Bench, page: Page) -> None:
    page.done("step", 1.0)
    name = bus_of(bench).name
    assert simulated_bus(bench.session.system.clock.network, name).up
    frame = ui.SendFrame(name, 0x7A0, False, False, b"\1\2", 0.0)
    page.done("frame", frame)
    page.done("step", 0.01)
    assert [f.data for f in frames(page) if f.can_id == 0x7A0] == [b"\1\2"]
    frame.period = 0.01
    page.done("frame", frame)
    page.done("step", 0.1)
    sent = [f.time for f in frames(page) if f.can_id == 0x7A0]
    assert len(sent) == 10
    frame.period = 0.0
    page.done("frame", frame)
    page.done("step", 0.1)
    assert not [f for f in frames(page) if f.can_id == 0x7A0]
    frame.can_id = 0x800
    assert page.ask("frame", frame).code == "UIS0005"
    frame.can_id, frame.period = 0x7A0, float("nan")
    assert page.ask("frame", frame).code == "UIS0005"
