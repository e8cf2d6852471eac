"""Each view at both widths and in both colours: nothing cut, covered, faint or without a name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from ui_bench import QUIET, ROOT, opened, until

from rtgen.cli.ui import CommandProject
from rtgen.runtime import SimulatedClock
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
RH3 = str(ROOT / "specs/navigation/rh3_goal.xml")
BUS = str(ROOT / "specs/canopen/fourx.xml")
BOARD = str(ROOT / "specs/tecs/rh3_board.xml")
VIEWS = {
    (RH3, "Odometry0"): (
        *("Values", "Connections", "Map", "Drive", "Configuration", "Timeline"),
    ),
    (BUS, "RefHardFourX0"): ("Buses",),
    (BOARD, "MotorBoardMarshaller0"): ("Services", "Boards"),
}
"""The views that show most of a system, by its file and a component."""
LOOKS = [(width, colours) for width in (1440, 820) for colours in ("light", "dark")]
CONTRAST = 4.5
"""The least contrast of text (WCAG 2.2, 1.4.3)."""

FLAWS = """([contrast]) => {
    const flaws = [];
    const about = each => {
        const name = each.getAttribute("aria-label") ?? each.textContent.trim().slice(0, 40);
        return `${each.tagName.toLowerCase()}.${each.className} "${name}"`;
    };
    const seen = each => {
        const { width, height } = each.getBoundingClientRect();
        return width > 2 && height > 2 && each.checkVisibility({ visibilityProperty: true });
    };
    const light = ([r, g, b]) => {
        const [x, y, z] = [r, g, b].map(
            v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
        return 0.2126 * x + 0.7152 * y + 0.0722 * z;
    };
    const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const colour = text => {
        pen.clearRect(0, 0, 1, 1);
        pen.fillStyle = text;
        pen.fillRect(0, 0, 1, 1);
        return [...pen.getImageData(0, 0, 1, 1).data];
    };
    const paper = each => {
        for (let at = each; at; at = at.parentElement) {
            const found = colour(getComputedStyle(at).backgroundColor);
            if (found[3] === 255) return found;
        }
        return colour("Canvas");
    };
    const page = document.documentElement;
    if (page.scrollWidth > innerWidth) flaws.push(`the page is ${page.scrollWidth} px wide`);
    for (const each of document.querySelectorAll("body *")) {
        if (!seen(each) || each.closest(".react-flow__attribution, .announced, svg")) continue;
        const style = getComputedStyle(each);
        const own = [...each.childNodes].some(n => n.nodeType === 3 && n.data.trim());
        const field = each.matches(
            "input:not([type=range], [type=checkbox], [type=radio]), textarea");
        if (each.matches("select")) {
            pen.font = style.font;
            const text = each.selectedOptions[0]?.textContent ?? "";
            if (pen.measureText(text).width > each.clientWidth - 20)
                flaws.push(`cut: ${about(each)}: ${text}`);
        } else if ((field || own) && style.display !== "inline"
            && (field || !["visible", "auto", "scroll"].includes(style.overflowX))
            && (each.scrollWidth > each.clientWidth + 1
                || each.scrollHeight > each.clientHeight + 3))
            flaws.push(`cut: ${about(each)}`);
        const off = each.closest(":disabled, [aria-disabled=true]");
        if (own && !off) {
            const [one, other] = [light(colour(style.color)), light(paper(each))];
            const found = (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
            if (found < contrast) flaws.push(`contrast ${found.toFixed(1)}: ${about(each)}`);
        }
        if (each.matches("button, select, input, textarea, [role=img], [role=application]")) {
            const label = each.getAttribute("aria-label") || each.labels?.[0]?.textContent
                || each.textContent || each.title;
            if (!label?.trim()) flaws.push(`no name: ${each.outerHTML.slice(0, 80)}`);
            const { left, top, width, height } = each.getBoundingClientRect();
            const [x, y] = [left + width / 2, top + height / 2];
            const hit = document.elementFromPoint(x, y);
            const pane = each.closest(".palette, .panel, .react-flow")?.getBoundingClientRect();
            const shown = !pane
                || (x > pane.left && x < pane.right && y > pane.top && y < pane.bottom);
            if (hit && shown && each.matches("button, select, input, textarea")
                && !each.contains(hit) && !hit.contains(each)
                && !each.labels?.[0]?.contains(hit))
                flaws.push(`covered: ${about(each)} by ${about(hit)}`);
        }
    }
    return flaws;
}"""


@pytest.fixture(scope="module")
def session() -> Session:
    project = CommandProject(QUIET, [file for file, _ in VIEWS])
    return Session(project, RH3, SimulatedClock)


@pytest.fixture(scope="module")
def any_look(browser: Any, server: Any) -> Iterator[Any]:
    """Yield a page whose width and colours are changed."""
    with opened(browser, server.address(full=True)) as page:
        yield page


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
    page.get_by_role("combobox", name="Component").select_option(component)
    for tab in VIEWS[file, component]:
        page.get_by_role("tab", name=tab).click()
        page.get_by_role("tabpanel", name=tab).wait_for()
        for width, colours in LOOKS:
            page.emulate_media(color_scheme=colours)
            page.set_viewport_size({"width": width, "height": 900})
            page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
            assert page.evaluate(FLAWS, [CONTRAST]) == [], (tab, width, colours)
