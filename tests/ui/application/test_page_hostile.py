"""Names and texts of a definition are text on the page, in a real browser."""

from __future__ import annotations

import html
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from hostile_session import TEXTS, Hostile, component
from page_flaws import flaws
from ui_bench import (
    GOAL,
    NARROW,
    ROOT,
    WIDE,
    by_keyboard,
    choose,
    opened,
    select,
    serving,
    until,
)

from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]

IMAGE = "<img src=x onerror=document.title='broken'>"
SCRIPT = "\"'><script>document.title='broken'</script>"
LINK = "javascript:document.title='broken'//"


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, None]]:
    """Yield the pipeline to one goal with hostile instances, connectors, a parameter and texts."""
    text = GOAL.read_text(encoding="utf-8")
    for plain, hostile in {
        "Odometry0": IMAGE,
        "PathFollower0": SCRIPT,
        "RH3 drives to one goal": IMAGE,
        "The goal is in the parameters of PositionInput0.": LINK,
        "PositionInput0..positon_OmniTo2WD0.goal": SCRIPT,
    }.items():
        assert plain in text
        text = text.replace(plain, html.escape(hostile))
    systems = tmp_path_factory.mktemp("hostile") / "systems"
    copytree(ROOT / "specs/navigation", systems)
    file = systems / "hostile.xml"
    file.write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        yield file, None


@pytest.mark.parametrize("look", [WIDE], indirect=True)
def test_hostile_texts_are_shown_and_do_nothing(page: Any, session: Session) -> None:
    dialogs: list[str] = []
    page.on("dialog", lambda dialog: dialogs.append(dialog.message))
    title = page.title()
    state = page.locator(".panel .state")
    scripts = page.locator("script").count()
    for name in (IMAGE, SCRIPT):
        page.locator(".react-flow__node").get_by_text(name, exact=True).wait_for()
        select(page, name)
        for tab in page.get_by_role("tab").all():
            tab.click()
        select(page, name)
        button = page.get_by_role("button", name=f"Deactivate {name}", exact=True)
        button.click()
        until(page, lambda: state.inner_text() == "INACTIVE")
    assert {IMAGE, SCRIPT} <= {each.instance for each in session.whole().components}
    assert page.locator("img").count() == 0
    assert page.locator("script").count() == scripts
    assert page.locator("[href^='javascript:']").count() == 0
    assert page.title() == title
    assert dialogs == []


INTRUDERS = """part => {
    const { title } = document;
    const attributes = each => [...each.attributes].map(one => [one.name, one.value]);
    return [...document.querySelectorAll(`${part} *`)]
        .filter(each => !each.closest("svg") || each.matches("script, img, image, a"))
        .filter(each => each.matches("script, img, iframe, object, embed, a, link, b")
            && !each.closest(".react-flow__attribution")
            || attributes(each).some(([name]) => /^on|^(src|href|action|srcdoc)$/.test(name))
                && !each.closest(".react-flow__attribution"))
        .map(each => each.outerHTML.slice(0, 80))
        .concat(title === "rtgen ui" ? [] : [title]);
}"""
"""Elements and attributes that texts would create if they were markup."""

WORDS = """region => [region, ...region.querySelectorAll("*")].flatMap(each => [
    ...[...each.childNodes].filter(n => n.nodeType === 3).map(n => n.data),
    each.title, each.value, each.getAttribute("aria-label"),
]).filter(each => typeof each === "string").join("\\0")"""
"""All that a region says, and its titles."""


@pytest.fixture(scope="module")
def hostile() -> Hostile:
    return Hostile()


@pytest.fixture(scope="module")
def shown_texts(browser: Any, hostile: Hostile) -> Iterator[Any]:
    """Yield a page whose texts are all hostile; it opens no dialog."""
    dialogs: list[str] = []
    with (
        serving(Server(hostile, "127.0.0.1", 0)) as server,
        opened(browser, server.address(full=True)) as page,
    ):
        page.on("dialog", lambda dialog: dialogs.append(dialog.message))
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        page.get_by_role("navigation", name="Palette").wait_for()
        yield page
    assert dialogs == []


OF_COMPONENT = ("Values", "Connections", "Configuration", "Services")


def visit(page: Any, tab: str, i: int) -> None:
    """Open a view, and all in it that has texts of a number."""
    page.get_by_role("tab", name=tab, exact=True).click()
    if tab == "Connections":
        page.get_by_label("Chosen port").select_option(index=1)
        page.get_by_text("ports do not fit").wait_for()
    elif tab == "Services":
        page.get_by_role("button", name="Call ").first.click()
        page.get_by_role("status", name="Result of ").first.wait_for()
    elif tab == "Buses":
        page.get_by_role("combobox", name="Bus", exact=True).select_option(index=i)
        objects = page.get_by_role("region", name="Object dictionary")
        objects.get_by_label("Node").select_option(index=1)
        objects.get_by_label("Objects", exact=True).fill(f"{0x2000 + i:X}h:0")
        objects.get_by_role("button", name=f"Read {0x2000 + i:X}h:0").click()
        signals = page.get_by_role("region", name="Signals")
        signals.get_by_role("checkbox").first.check()
        signals.get_by_role("img", name="Signals over time").wait_for()
    page.wait_for_timeout(30)


@pytest.mark.parametrize("i", range(len(TEXTS)))
def test_each_text_is_text_in_each_view(shown_texts: Any, i: int) -> None:
    page, text = shown_texts, TEXTS[i]
    instance = component(i, text).instance
    select(page, instance)
    for tab in page.get_by_role("tab").all_inner_texts():
        visit(page, tab, i)
        if tab in OF_COMPONENT:
            assert text in page.locator(".panel").evaluate(WORDS), tab
        assert flaws(page, ".panel") == [], tab
        assert page.evaluate(INTRUDERS, ".panel") == [], tab
    assert page.evaluate(INTRUDERS, "body") == []
    assert flaws(page) == []
    select(page, instance)
    for region in (".wiring", ".palette", ".panel"):
        assert text in page.locator(region).evaluate(WORDS), region


def test_each_view_of_long_texts_has_room(shown_texts: Any) -> None:
    page = shown_texts
    width, colours = NARROW
    page.emulate_media(color_scheme=colours)
    page.set_viewport_size({"width": width, "height": 900})
    i = max(range(len(TEXTS)), key=lambda i: len(TEXTS[i].split(" ")[0]))
    select(page, component(i, TEXTS[i]).instance)
    for tab in page.get_by_role("tab").all_inner_texts():
        visit(page, tab, i)
        assert flaws(page) == [], tab
    page.set_viewport_size({"width": WIDE[0], "height": 900})


def test_names_come_back_as_they_are(shown_texts: Any, hostile: Hostile) -> None:
    """Boxes, ports and connections are found by names with any characters."""
    page = shown_texts

    def asked(kind: ui.CommandKind) -> list[Any]:
        return [each.value for each in hostile.asked if each.discriminator is kind]

    page.set_viewport_size({"width": 3000, "height": 3000})
    page.get_by_role("button", name="Fit View").click()
    boxes = page.locator(".react-flow__node-component")
    for i, text in enumerate(TEXTS):
        box, instance = boxes.nth(i), component(i, text).instance
        j = (i + 1) % len(TEXTS)
        box.focus()
        page.keyboard.press("Shift+F10")
        choose(page, "Remove", by_keyboard)
        until(page, lambda name=instance: name in asked(REMOVE))
        box.locator(".port.out .source").first.drag_to(
            boxes.nth(j).locator(".port.in .target")
        )
        other = component(j, TEXTS[j])
        ends = (instance, f"{text} 2"), (other.instance, other.ports[0].name)
        until(page, lambda ends=ends: ends in map(drawn, asked(CONNECT)))
        # The reason why it is refused takes the focus.
        reason = page.get_by_role("dialog")
        reason.wait_for()
        page.keyboard.press("Escape")
        reason.wait_for(state="hidden")
    names = [each.name for each in hostile.state.connections]
    for edge in page.locator(".react-flow__edge").all():
        edge.focus()
        page.keyboard.press("Enter")
        page.keyboard.press("Delete")
    until(page, lambda: set(asked(CUT)) == set(names))
    assert page.evaluate(INTRUDERS, "body") == []


REMOVE, CONNECT, CUT = (
    ui.CommandKind.COMMAND_REMOVE,
    ui.CommandKind.COMMAND_CONNECT,
    ui.CommandKind.COMMAND_CUT,
)


def drawn(wire: ui.Connect) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return the instance and the port of each end."""
    source, target = wire.source, wire.target
    return (source.instance, source.port), (target.instance, target.port)
