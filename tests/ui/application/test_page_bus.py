"""A CAN bus on the page, in a real browser: frames sent there reach the nodes."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from page_flaws import violations
from ui_bench import ROOT, by_both_hands, by_mouse, choose, pick, until

from rtgen.runtime.timing.traffic import BusFrame
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]


@pytest.fixture(scope="module")
def shown() -> tuple[Path, None]:
    """Return a system whose bus file is found in the project by the name of its network."""
    return ROOT / "specs/canopen/fourx.xml", None


@pytest.fixture
def bus(page: Any) -> Any:
    """Return the page with the view of buses, whose nodes are operational."""
    page.get_by_role("tab", name="Buses").click()
    page.get_by_role("row", name="front_left operational").wait_for()
    return page


@pytest.mark.nightly
def test_the_bus_is_a_line_below_the_boxes(bus: Any, session: Session) -> None:
    line = bus.get_by_role("region", name="Bus can0")
    names = ["front_left", "front_right", "rear_left", "rear_right", "manager"]
    for number, name in zip([1, 2, 3, 4, 127], names, strict=True):
        label = f"{number} {name} operational, node of can0"
        line.get_by_role("button", name=label, exact=True).wait_for()
    # Each node has a device or the manager; each device also has a proxy.
    assert line.locator(".drop").count() == 9
    boxes = bus.locator(".box").evaluate_all(
        "all => all.map(each => each.getBoundingClientRect().top)"
    )
    [top] = line.evaluate_all("all => all.map(each => each.getBoundingClientRect().y)")
    hung = [each for each in session.system.instances if "Drive" in each]
    assert sum(each > top for each in boxes) == len(hung) + 1
    row = bus.get_by_role("table", name="Nodes").get_by_role("row", name="front_left")
    assert "FrontLeftWheel0, FrontLeftDrive0" in row.inner_text()
    bus.get_by_role("tab", name="Values").click()
    bus.get_by_role("button", name="127 manager").press("Enter")
    node = bus.get_by_role("region", name="Node", exact=True)
    node.get_by_role("row", name="NMT state operational").wait_for()
    node.get_by_role("button", name="Frames and objects").press("Enter")
    bus.get_by_role("table", name="Nodes").wait_for()
    bus.get_by_role("button", name="Layout").click()
    bus.get_by_role("menuitem", name="Bus", exact=True).click()
    views = bus.locator("[data-tab][aria-selected=true]")
    until(bus, lambda: views.all_inner_texts() == ["Buses", "Wiring", "Timeline"])


@pytest.mark.nightly
def test_frames_are_decoded_and_filtered(bus: Any) -> None:
    frames = bus.get_by_role("table", name="Frames")
    frames.get_by_text("heartbeat", exact=True).first.wait_for()
    bus.get_by_label("Filter", exact=True).fill("tpdo1 node2")
    frames.get_by_text("heartbeat", exact=True).first.wait_for(state="detached")
    frames.get_by_text("tpdo1", exact=True).first.wait_for()
    bus.get_by_role("img", name="Load of").wait_for()
    bus.get_by_text("computed").first.wait_for()
    bus.get_by_label("Filter", exact=True).fill("")


FILTERS = {
    "kind:heartbeat": {"heartbeat"},
    "id:701-704": {"heartbeat"},
    "kind:tpdo* | kind:heartbeat node:1": {"tpdo", "heartbeat"},
    "(kind:tpdo1 | kind:heartbeat) !kind:tpdo*": {"heartbeat"},
    "kind:heartbeat data:05 len=1": {"heartbeat"},
    "statusword>0 node!=1": {"tpdo"},
    '"no frame has this"': set(),
}


@pytest.mark.nightly
@pytest.mark.parametrize(("text", "kinds"), FILTERS.items(), ids=range(len(FILTERS)))
def test_filters_are_a_language(bus: Any, text: str, kinds: set[str]) -> None:
    # Rows of all identifiers do not depend on what came last.
    counted = bus.get_by_role("button", name="By identifier")
    if counted.get_attribute("aria-pressed") == "false":
        counted.press("Enter")
    filled = bus.get_by_label("Filter", exact=True)
    filled.fill(text)

    def shown() -> set[str]:
        rows = bus.get_by_role("table", name="Frames").locator("tbody td:nth-child(6)")
        return {re.sub(r"\d+$", "", kind) for kind in rows.all_inner_texts()}

    until(bus, lambda: shown() == kinds)
    filled.fill("")
    counted.click()


@pytest.mark.nightly
@pytest.mark.parametrize("text", ["(tpdo1", "id:xyz", "a | ", "!", "node>1-2", ")"])
def test_a_filter_that_is_wrong_says_why(bus: Any, text: str) -> None:
    filled = bus.get_by_label("Filter", exact=True)
    filled.fill(text)
    bus.locator("input[aria-invalid=true]").wait_for()
    bus.get_by_role("region", name="Frames").locator(".reason").wait_for()
    filled.fill("")
    bus.locator("input[aria-invalid=true]").wait_for(state="detached")


@pytest.mark.nightly
def test_values_of_frames_have_few_digits_and_titles_the_others(bus: Any) -> None:
    field = bus.get_by_role("searchbox", name="Filter", exact=True)
    field.fill("tpdo2")
    cells = bus.get_by_role("table", name="Frames").locator("tbody td.text:last-child")
    both = "all => all.map(each => [each.title, each.textContent])"

    def shortened() -> list[str]:
        return [text for title, text in cells.evaluate_all(both) if title != text]

    until(bus, lambda: bool(shortened()))
    numbers = re.findall(r"\d+\.\d+", " ".join(shortened()))
    assert all(len(each.replace(".", "").lstrip("0")) <= 5 for each in numbers)
    field.fill("")


@pytest.mark.nightly
def test_identifiers_have_a_row_each_with_what_changes(bus: Any) -> None:
    bus.get_by_role("button", name="By identifier").click()
    frames = bus.get_by_role("table", name="Frames")

    def row_of(identifier: str) -> Any:
        cell = bus.get_by_role("cell", name=identifier, exact=True)
        return frames.locator("tbody tr").filter(has=cell)

    row = row_of("080")
    count = row.locator("td").nth(1)
    before = int(count.inner_text())
    until(bus, lambda: int(count.inner_text()) > before + 2)
    assert row.count() == 1
    assert float(row.locator("td").nth(2).inner_text()) > 0
    # Frames of their own, since those of a robot that stands at its goal are all alike.
    send = bus.get_by_role("button", name="Send once")
    if not send.is_visible():
        bus.get_by_text("Send frames").click()
    for octet in ("02", "03"):
        bus.get_by_label("Frame", exact=True).fill(f"7b0#01{octet}")
        send.click()
        row_of("7B0").get_by_text(octet, exact=True).wait_for()
    until(bus, lambda: row_of("7B0").locator("mark").all_inner_texts() == ["03"])
    assert violations(bus) == []
    bus.get_by_role("button", name="By identifier").press("Enter")


@pytest.mark.nightly
@by_both_hands
def test_frames_are_cleared(bus: Any, press: Callable[[Any], None]) -> None:
    bus.get_by_role("button", name="Pause", exact=True).click()
    bus.get_by_role("button", name="Play").wait_for()
    rows = bus.get_by_role("table", name="Frames").locator("tbody tr")
    rows.first.wait_for()
    press(bus.get_by_role("button", name="Clear frames"))
    rows.first.wait_for(state="detached")
    bus.get_by_role("button", name="Play").click()
    rows.first.wait_for()


@pytest.mark.nightly
@by_both_hands
def test_frames_are_held(
    bus: Any, session: Session, press: Callable[[Any], None]
) -> None:
    newest = bus.get_by_role("table", name="Frames").locator("tbody td").first
    hold = bus.get_by_role("button", name="Hold")
    press(hold)
    bus.get_by_role("button", name="Hold", pressed=True).wait_for()
    held, now = newest.inner_text(), session.now
    load = bus.get_by_label("Time of the run")
    until(bus, lambda: float(load.inner_text().removesuffix(" s")) > now + 0.5)
    assert newest.inner_text() == held
    press(hold)
    until(bus, lambda: float(newest.inner_text()) > now)


@pytest.mark.nightly
@by_both_hands
def test_signals_are_plotted(bus: Any, press: Callable[[Any], None]) -> None:
    region = bus.get_by_role("region", name="Signals")
    region.get_by_label("Find a signal").fill("statusword")
    row = (
        region.get_by_role("table", name="Values of signals").locator("tbody tr").first
    )
    row.get_by_text("0x").first.wait_for()
    box = row.get_by_role("checkbox")
    plot = bus.get_by_role("img", name="Signals over time")
    for _ in ("shown", "hidden"):
        before = plot.count()
        if press is by_mouse:
            box.click()
        else:
            box.press("Space")
        until(bus, lambda before=before: plot.count() != before)
    region.get_by_label("Find a signal").fill("")


@pytest.mark.nightly
@by_both_hands
def test_nodes_are_stopped_and_started(
    bus: Any, session: Session, press: Callable[[Any], None]
) -> None:
    def state() -> str:
        [found] = [n for b in session.whole().buses for n in b.nodes if n.node_id == 1]
        return found.nmt_state

    def order(command: str) -> None:
        press(bus.get_by_role("button", name="NMT command to front_left"))
        choose(bus, command, press)

    order("stop")
    until(bus, lambda: state() == "stopped")
    bus.get_by_role("row", name="front_left stopped").wait_for()
    bus.get_by_role("button", name="1 front_left stopped, node of can0").wait_for()
    order("start")
    until(bus, lambda: state() == "operational")


@pytest.mark.nightly
@by_both_hands
def test_objects_are_read_and_written(bus: Any, press: Callable[[Any], None]) -> None:
    region = bus.get_by_role("region", name="Object dictionary")
    node = region.get_by_label("Node")
    if press is by_mouse:
        pick(node, "front_left", press)
    else:
        pick(node, "none", press)
        node.focus()
        bus.keyboard.press("f")
        bus.keyboard.press("Enter")
    region.get_by_label("Objects", exact=True).fill("6083")
    acceleration = "1234" if press is by_mouse else "4321"
    region.get_by_label("New value of 6083h:0").fill(acceleration)
    press(region.get_by_role("button", name="Write 6083h:0"))
    value = region.get_by_role("status", name="Value of 6083h:0")
    value.get_by_text(acceleration, exact=True).wait_for()
    # The octets are beside the value, the lowest first.
    octets = int(acceleration).to_bytes(4, "little").hex(" ")
    region.locator(".object").get_by_text(octets, exact=True).wait_for()
    region.get_by_label("New value of 6083h:0").fill("x")
    press(region.get_by_role("button", name="Write 6083h:0"))
    reason = region.get_by_role("alert")
    reason.wait_for()
    written = region.get_by_label("New value of 6083h:0")
    assert written.get_attribute("aria-describedby") == reason.get_attribute("id")
    assert written.input_value() == "x"
    written.press("Escape")
    reason.wait_for(state="detached")
    assert written.input_value() == ""
    region.get_by_label("Objects", exact=True).fill("")


@pytest.mark.nightly
@by_both_hands
def test_objects_are_a_tree(bus: Any, press: Callable[[Any], None]) -> None:
    region = bus.get_by_role("region", name="Object dictionary")
    if region.get_by_label("Node").input_value() != "2":
        pick(region.get_by_label("Node"), "front_right", press)
    region.get_by_label("Objects", exact=True).fill("")
    for branch in ("Communication", "1018h Identity"):
        press(region.locator("summary", has_text=re.compile(f"^{branch}")))
    press(region.get_by_role("button", name="Read all of 1018h Identity"))
    identity = region.get_by_role("status", name="Value of 1018h:4")
    until(bus, lambda: identity.inner_text() != "")
    region.get_by_role("status", name="Value of 1018h:1").get_by_text("0x").wait_for()
    assert violations(bus) == []
    for branch in ("1018h Identity", "Communication"):
        press(region.locator("summary", has_text=re.compile(f"^{branch}")))
    identity.wait_for(state="detached")


@pytest.mark.nightly
@by_both_hands
def test_frames_are_sent(
    bus: Any, session: Session, press: Callable[[Any], None]
) -> None:
    seen: list[int] = []

    def on_traffic(happening: object) -> None:
        if isinstance(happening, BusFrame):
            seen.append(happening.can_id)

    session.system.clock.traffic.watch(on_traffic)
    send = bus.get_by_role("button", name="Send once")
    if not send.is_visible():
        press(bus.get_by_text("Send frames"))
    frame = bus.get_by_label("Frame", exact=True)
    frame.fill("7a0#0102")
    press(send)
    until(bus, lambda: seen.count(0x7A0) == 1)
    history = bus.get_by_role("table", name="Emergencies")
    overruns = history.get_by_text("8110h CAN overrun")
    before = overruns.count()
    frame.fill("089#1081010000000000")
    frame.press("Enter")
    until(bus, lambda: overruns.count() > before)
    frame.fill("7a1#")
    press(bus.get_by_role("button", name="Send cyclically"))
    until(bus, lambda: seen.count(0x7A1) > 2)
    press(bus.get_by_role("button", name="End 7a1#"))
    bus.get_by_role("button", name="End 7a1#").wait_for(state="detached")
    bus.get_by_label("Sequence").fill("0 7a2#01\n0.2 7a3#02")
    press(bus.get_by_role("button", name="Send the sequence"))
    until(bus, lambda: 0x7A3 in seen)
    assert seen.index(0x7A2) < seen.index(0x7A3)
