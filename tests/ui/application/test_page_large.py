"""A large system of several processes on the page: legible at once, in groups, with a small map."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import pytest
from hostile_session import Hostile
from msgspec.structs import replace
from page_flaws import flaws, violations
from ui_bench import by_both_hands, opened, serving, until

from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
COMPONENTS = 100
PLACES = [
    f"10.0.0.1:2809/{host}.host_cxt/{process}.mgr_cxt"
    for host in ("robot", "desk")
    for process in ("drive", "plan")
]
LEGIBLE = 9
"""The least size of the letters of a name [px]."""


def component(number: int) -> ui.Component:
    place = PLACES[number * len(PLACES) // COMPONENTS]
    ports = [
        ui.Port(name=name, kind=kind, type="RTC::TimedDouble", type_number=-1)
        for name, kind in (
            ("taken", ui.PortKind.PORT_IN),
            ("given", ui.PortKind.PORT_OUT),
        )
    ]
    return ui.Component(
        instance=f"{place}/Controller{number}",
        type="Controller",
        place=place,
        current=ui.State.STATE_ACTIVE,
        ports=ports,
    )


class Large(Hostile):
    """Shows many components, each of which gives to the next one."""

    def __init__(self) -> None:
        super().__init__()
        components = [component(number) for number in range(COMPONENTS)]
        self.state = ui.SystemState(
            name="large",
            components=components,
            connections=[
                ui.Connection(
                    one.instance,
                    ui.PortAddress(one.instance, "given"),
                    ui.PortAddress(other.instance, "taken"),
                    [],
                )
                for one, other in pairwise(components)
            ],
            time=ui.ClockState(kind=ui.ClockKind.CLOCK_SIMULATED, speed=1.0),
            edits=ui.EditState("", "", saved=True, file="large.xml"),
        )

    def join(self, page: Outbox) -> None:
        """Send a page the state, and how many samples each connection loses."""
        flows = [
            ui.Flow(each.name, 100.0, 7 * (i % 50 == 0), "7 refused by a full buffer")
            for i, each in enumerate(self.state.connections)
        ]
        page.put(
            ui.Event.of_greeting(ui.Hello(ui.VERSION, self.name, full=True)),
            ui.Event.of_whole(self.state),
            ui.Event.of_flows(flows),
        )


@pytest.fixture(scope="module")
def large(browser: Any) -> Iterator[Any]:
    with (
        serving(Server(Large(), "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True)) as page,
    ):
        page.locator(".wiring[aria-busy=false] .react-flow__node").nth(99).wait_for()
        yield page


SEEN = """() => {
    const of = each => {
        const { left, top, right, bottom } = each.getBoundingClientRect();
        return [left, top, right, bottom];
    };
    const names = [...document.querySelectorAll(".box .head strong")].map(each => {
        const scale = each.getBoundingClientRect().width / each.offsetWidth;
        return parseFloat(getComputedStyle(each).fontSize) * scale;
    });
    const frames = [...document.querySelectorAll(".frame-of")]
        .map(each => [each.getAttribute("aria-label"), of(each)]);
    const boxes = [...document.querySelectorAll(".react-flow__node-component")]
        .map(each => [each.dataset.id, of(each)]);
    return [of(document.querySelector(".wiring")), boxes, names, frames];
}"""
Rectangle = tuple[float, float, float, float]


def within(inner: Rectangle, outer: Rectangle) -> bool:
    return (
        outer[0] <= inner[0] + 1
        and outer[1] <= inner[1] + 1
        and inner[2] <= outer[2] + 1
        and inner[3] <= outer[3] + 1
    )


def apart(one: Rectangle, other: Rectangle) -> bool:
    return (
        one[2] <= other[0]
        or other[2] <= one[0]
        or one[3] <= other[1]
        or other[3] <= one[1]
    )


class Long(Large):
    """Shows components with long names, half of whose connections lose samples."""

    def __init__(self, count: int) -> None:
        super().__init__()
        components = [
            replace(component(0), instance=LONG[n % len(LONG)] + str(n), place="")
            for n in range(count)
        ]
        self.state = replace(
            self.state,
            components=components,
            connections=[
                replace(
                    self.state.connections[0],
                    name=f"{one.instance} to {other.instance}",
                    source=ui.PortAddress(one.instance, "given"),
                    target=ui.PortAddress(other.instance, "taken"),
                )
                for one, other in pairwise(components)
            ],
        )

    def join(self, page: Outbox) -> None:
        connections = self.state.connections
        flows = [
            ui.Flow(each.name, 100.0, 700 * (i % 2), "700 refused by a full buffer")
            for i, each in enumerate(connections)
        ]
        page.put(
            ui.Event.of_greeting(ui.Hello(ui.VERSION, self.name, full=True)),
            ui.Event.of_whole(self.state),
            ui.Event.of_flows(flows),
        )


LONG = [
    "Arm",
    "Thermostat",
    "VeryLongNameThatNobodyWouldWriteInEarnest",
]


@pytest.mark.parametrize("count", [4, 40])
@pytest.mark.parametrize("size", [(1440, 900), (820, 1180), (390, 844)])
def test_losses_hide_no_name(browser: Any, count: int, size: tuple[int, int]) -> None:
    with (
        serving(Server(Long(count), "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True)) as page,
    ):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        boxes = page.locator(".wiring[aria-busy=false] .react-flow__node")
        boxes.nth(count - 1).wait_for()
        page.get_by_role("button", name="Fit View").click()
        page.locator(".health.lossy").first.wait_for()
        assert flaws(page) == []


FOUND_LATE = """async () => {
    const begun = await (await fetch("/")).text();
    return performance.getEntriesByType("resource").map(each => each.name.split("/").at(-1))
        .filter(each => each.endsWith(".js") && !each.startsWith("elk") && !begun.includes(each));
}"""
"""The scripts of the first view that the page has asked for when others had come."""


def test_a_hundred_boxes_are_legible_at_once(large: Any) -> None:
    assert large.evaluate(FOUND_LATE) == []
    whole = large.get_by_role("img", name="Map of the wiring")
    assert not whole.count(), "the small map shows what is in view"
    large.get_by_role("button", name="Zoom In").click()
    whole.wait_for()
    large.get_by_role("button", name="Fit View").click()
    whole.wait_for(state="detached")

    def is_legible() -> bool:
        wiring, boxes, names, _ = large.evaluate(SEEN)
        return (
            len(boxes) == COMPONENTS
            and all(within(each, wiring) for _, each in boxes)
            and min(names) >= LEGIBLE
        )

    until(large, is_legible)
    large.locator(".health.lossy").nth(1).wait_for()
    assert violations(large) == []


@by_both_hands
def test_boxes_are_grouped_by_process_and_by_host(
    large: Any, press: Callable[[Any], None]
) -> None:
    for by, names in (
        ("process", set(PLACES)),
        ("host", {each.rpartition("/")[0] for each in PLACES}),
        ("none", set[str]()),
    ):
        press(large.get_by_role("button", name="Groups: "))
        large.get_by_role("button", name=f"Groups: {by}").wait_for()
        large.locator(".wiring[aria-busy=false]").wait_for()

        def is_grouped(names: set[str] = names) -> bool:
            _, boxes, _, frames = large.evaluate(SEEN)
            groups = {name.removeprefix("Group "): frame for name, frame in frames}
            return (
                groups.keys() == names
                and all(
                    within(box, frame) is large_name(id_).startswith(f"{name}/")
                    for name, frame in groups.items()
                    for id_, box in boxes
                )
                and all(
                    one is other or apart(one, other)
                    for one in groups.values()
                    for other in groups.values()
                )
            )

        until(large, is_grouped)
        assert violations(large) == []


def large_name(id_: str) -> str:
    """Return the instance of a box; its id is escaped."""
    from urllib.parse import unquote

    return unquote(id_)
