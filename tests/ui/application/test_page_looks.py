"""Each view at both widths and in both colours: nothing cut, covered, faint or without a name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from page_flaws import flaws
from ui_bench import QUIET, ROOT, by_keyboard, opened, pick, select, until

from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
RH3 = str(ROOT / "specs/navigation/rh3_goal.xml")
BUS = str(ROOT / "specs/canopen/fourx.xml")
BOARD = str(ROOT / "specs/tecs/rh3_board.xml")
VIEWS = {
    (RH3, "Odometry0"): (
        *(
            "Values",
            "Connections",
            "Plots",
            "Map",
            "Drive",
            "Configuration",
            "Timeline",
        ),
    ),
    (BUS, "RefHardFourX0"): ("Buses",),
    (BOARD, "MotorBoardMarshaller0"): ("Services", "Boards"),
}
"""The views that show most of a system, by its file and a component."""
LOOKS = [(width, colours) for width in (1440, 1024) for colours in ("light", "dark")]
GRAPHICS = 3.0
"""The least contrast of curves (WCAG 2.2, 1.4.11)."""
PAPER = {"light": (255, 255, 255), "dark": (20, 23, 27)}


@pytest.fixture(scope="module")
def session() -> Session:
    project = CommandProject(QUIET, [file for file, _ in VIEWS])
    return Session(project, RH3, SimulatedClock)


@pytest.fixture(scope="module")
def any_look(browser: Any, server: Any) -> Iterator[Any]:
    """Yield a page whose width and colours are changed."""
    with opened(browser, server.address(full=True)) as page:
        yield page


def luminance(colour: Sequence[int]) -> float:
    """Return the relative luminance of a colour (WCAG 2.2)."""
    parts = [part / 255 for part in colour]
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in parts
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: Sequence[int], other: Sequence[int]) -> float:
    """Return the contrast of two colours."""
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize(("file", "component"), VIEWS, ids=["rh3", "bus", "board"])
def test_views_can_be_read_and_reached(
    any_look: Any, session: Session, file: str, component: str
) -> None:
    page = any_look
    page.get_by_role("combobox", name="System").select_option(file)
    until(page, lambda: session.file == file)
    page.get_by_role("heading", name=session.profile.name, exact=True).wait_for()
    page.get_by_label("Go to time in seconds").fill("2")
    page.get_by_role("button", name="Go", exact=True).click()
    until(page, lambda: session.now >= 2)
    select(page, component)
    for tab in VIEWS[file, component]:
        page.get_by_role("tab", name=tab).click()
        page.get_by_role("tabpanel", name=tab).wait_for()
        for width, colours in LOOKS:
            page.emulate_media(color_scheme=colours)
            page.set_viewport_size({"width": width, "height": 900})
            page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
            assert flaws(page) == [], (tab, width, colours)


INKS = """region => {
    const plot = region.querySelector(".plot");
    const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const colour = text => {
        pen.fillStyle = text;
        pen.fillRect(0, 0, 1, 1);
        return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
    };
    const picture = plot?.querySelector("canvas");
    if (!picture) return [];
    const { width, height } = picture;
    const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(picture, 0, 0);
    const { data } = copy.getImageData(0, 0, width, height);
    const drawn = ink => {
        let count = 0;
        for (let i = 0; i < data.length; i += 4)
            if (data[i + 3] === 255 && ink.every((part, j) => Math.abs(data[i + j] - part) < 3))
                count += 1;
        return count;
    };
    const text = colour(getComputedStyle(plot).color);
    const marks = [...region.querySelectorAll(".swatch")];
    return [text, ...marks.map(each => colour(getComputedStyle(each).backgroundColor))]
        .map(ink => [ink, drawn(ink)]);
}"""
"""The colours of the text and of each swatch of a plot, with their pixels in its picture."""
WIDTHS = """plot =>
    plot.querySelector(".u-wrap").getBoundingClientRect().width - plot.clientWidth"""
"""How much wider a picture is than its place."""


def test_swatches_and_curves_have_the_same_colours(
    any_look: Any, session: Session
) -> None:
    page = any_look
    page.get_by_role("combobox", name="System").select_option(RH3)
    until(page, lambda: session.file == RH3)
    page.get_by_label("Go to time in seconds").fill("6")
    page.get_by_role("button", name="Go", exact=True).click()
    until(page, lambda: session.now >= 6)
    select(page, "Odometry0")
    page.get_by_role("tab", name="Values").click()
    pose = page.get_by_role("region", name="Odometry0.OdometryPosition")
    for colours in ("light", "dark"):
        page.emulate_media(color_scheme=colours)
        paper = PAPER[colours]
        until(page, lambda: min((n for _, n in pose.evaluate(INKS)), default=0) > 20)
        _, *swatches = pose.evaluate(INKS)
        assert len(swatches) == 3
        assert all(contrast(ink, paper) > GRAPHICS for ink, _ in swatches)


def test_plots_follow_the_width_of_their_panel(any_look: Any, session: Session) -> None:
    page = any_look
    page.get_by_role("combobox", name="System").select_option(RH3)
    until(page, lambda: session.file == RH3)
    page.get_by_label("Go to time in seconds").fill("2")
    page.get_by_role("button", name="Go", exact=True).click()
    select(page, "Odometry0")
    page.get_by_role("tab", name="Values").click()
    pose = page.get_by_role("region", name="Odometry0.OdometryPosition")
    plot = pose.get_by_role("img", name="Values over time")
    found = set()
    for width in (1024, 1440, 1024):
        page.set_viewport_size({"width": width, "height": 900})
        plot.locator(".uplot").wait_for()
        until(page, lambda: plot.evaluate(WIDTHS) == 0)
        found.add(plot.evaluate("plot => plot.clientWidth"))
    assert len(found) == 2


def test_a_system_is_opened_when_it_is_chosen(any_look: Any, session: Session) -> None:
    """Keys that pass over systems, or close their list, open none."""
    page = any_look
    chooser = page.get_by_role("combobox", name="System")
    file, instances, now = session.file, session.system.instances, session.now
    other = "rh3_goal" if file != RH3 else "rh3_board"
    page.get_by_label(f"{instances[0]}, ").first.locator(".head").click()
    for leave in ("Escape", "Tab"):
        chooser.focus()
        for key in ("ArrowDown", "End", "Delete", leave):
            page.keyboard.press(key)
        until(page, lambda: chooser.input_value() == file)
    page.get_by_role("button", name="Step").press("Enter")
    until(page, lambda: session.now > now)
    assert (session.file, session.system.instances) == (file, instances)
    pick(chooser, other, by_keyboard)
    until(page, lambda: session.file != file and session.profile.name == other)
