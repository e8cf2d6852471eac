"""The components of the page in both schemes: readable, with names, none drawn by the browser."""

from __future__ import annotations

from typing import Any

import pytest
from page_flaws import flaws, violations
from ui_bench import reach, until

from rtgen.ui.serving import Server

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
DEFAULTS = """() => {
    const frame = document.body.appendChild(document.createElement("iframe"));
    const plain = frame.contentDocument;
    const look = each => {
        const style = getComputedStyle(each);
        const { backgroundColor, borderTopColor, borderTopStyle, borderRadius } = style;
        return [backgroundColor, borderTopColor, borderTopStyle, borderRadius].join();
    };
    const own = new Map();
    const found = [];
    for (const each of document.querySelectorAll("button, input, select, textarea")) {
        const key = `${each.tagName} ${each.type}`;
        if (!own.has(key)) {
            const other = plain.createElement(each.tagName);
            if (each.tagName === "INPUT") other.type = each.type;
            plain.body.append(other);
            own.set(key, look(other));
        }
        if (look(each) === own.get(key)) found.push(key);
    }
    frame.remove();
    return found;
}"""
"""The controls that look as the browser draws them without a style."""


@pytest.mark.sampled(1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_components_are_drawn_in_both_schemes(
    browser: Any, server: Server, scheme: str
) -> None:
    page = browser.new_page(
        viewport={"width": 1440, "height": 900}, color_scheme=scheme, locale="en"
    )
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.goto(f"{server.address(full=True)}#components")
    page.get_by_role("heading", name="Components of the page").wait_for()
    assert flaws(page) == []
    assert violations(page) == []
    assert page.evaluate(DEFAULTS) == []
    paper = page.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    assert paper == {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 23, 27)"}[scheme]

    page.get_by_role("tab", name="Values").focus()
    page.keyboard.press("ArrowRight")
    page.get_by_role("tab", name="Connections", selected=True).wait_for()
    opening = page.get_by_role("button", name="Open the window")
    opening.press("Enter")
    window = page.get_by_role("dialog", name="A window")
    window.wait_for()
    assert flaws(page, "[role=dialog]") == []
    page.keyboard.press("Escape")
    window.wait_for(state="detached")
    asking = page.get_by_role("button", name="Ask the question")
    asking.press("Enter")
    question = page.get_by_role("alertdialog")
    question.get_by_role("button", name="Cancel").and_(
        page.locator(":focus")
    ).wait_for()
    assert flaws(page, "[role=alertdialog]") == []
    page.keyboard.press("Escape")
    question.wait_for(state="detached")
    page.get_by_role("button", name="Open the menu").press("Enter")
    page.locator(".menu button:focus").wait_for()
    assert flaws(page, ".menu") == []
    page.keyboard.press("Escape")
    rename = page.get_by_role("button", name="Rename")
    rename.hover()
    page.get_by_role("tooltip").get_by_text("Rename").wait_for()
    grip = page.get_by_role("separator", name="Width of the panes")
    before = page.get_by_text("left pane").bounding_box()["width"]
    reach(page, grip)
    page.keyboard.press("ArrowLeft")
    left = page.get_by_text("left pane")
    until(page, lambda: left.bounding_box()["width"] < before)
    page.close()
    assert complaints == []
