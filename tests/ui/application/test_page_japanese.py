"""The page in Japanese: each view at each width has no text of rtgen in English, and no flaw."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from page_flaws import flaws, violations
from ui_bench import QUIET, ROOT, WIDE, opened, until

from rtgen.compiler.kit.translation.catalogue import texts_of_page
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server
from rtgen.ui.session import Session
from rtgen.ui.texts import in_language

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
RH3 = str(ROOT / "specs/navigation/rh3_goal.xml")
BUS = str(ROOT / "specs/canopen/fourx.xml")
BOARD = str(ROOT / "specs/tecs/rh3_board.xml")
COMPONENT = ("Values", "Connections", "Configuration", "Services")
SYSTEM = ("Plots", "Map", "Drive", "Console", "Timeline")
VIEWS = {
    (RH3, "Odometry0"): (*COMPONENT, *SYSTEM),
    (BUS, "RefHardFourX0"): ("Buses",),
    (BOARD, "MotorBoardMarshaller0"): ("Services", "Boards"),
}
"""The views that show most of a system, by its file and a component."""
ON_BAR = {"Wiring", "Map", "Drive", "Timeline"}
"""The views that the bar of a narrow page has; `More` has the others."""
SAID = """() => {
    const found = [];
    const ours = each => !each.closest(".react-flow__attribution, bdi, script, style");
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
        const { data, parentElement } = texts.currentNode;
        const text = parentElement.querySelector(":scope > wbr") ? parentElement.textContent : data;
        if (text.trim() && ours(parentElement)) found.push(text.trim());
    }
    for (const each of document.querySelectorAll("*"))
        for (const name of ["aria-label", "title", "placeholder", "aria-valuetext"])
            if (each.getAttribute(name) && ours(each)) found.push(each.getAttribute(name));
    return found;
}"""
"""The texts of a page, as they are seen and heard."""

TO_TOP = "() => document.querySelectorAll('*').forEach(each => { each.scrollTop = 0; })"
"""What has been scrolled to be pressed may be below tabs."""


@pytest.fixture(scope="module")
def look() -> tuple[int, str]:
    """Return one look: tests set their own widths."""
    return WIDE


@pytest.fixture(scope="module")
def session() -> Session:
    project = CommandProject(QUIET, [file for file, _ in VIEWS])
    return Session(project, RH3, SimulatedClock)


@pytest.fixture(scope="module")
def texts() -> Callable[[str], str]:
    """Return the translation of a text of the page, with values by name."""
    japanese = texts_of_page("ja")

    def translated(english: str, **values: object) -> str:
        return japanese[english].format(**values)

    return translated


@pytest.fixture(scope="module")
def english() -> re.Pattern[str]:
    """Return what the English texts of the page match, beside single words, which names can be."""
    texts = (
        text
        for text, japanese in texts_of_page("ja").items()
        if text != japanese and re.search(r"^[A-Z]|[a-z]{2} [a-z]{2}", text)
    )
    parts = (
        "".join(
            ".+" if each.startswith("{") else re.escape(each)
            for each in re.split(r"(\{\w+\})", text)
        )
        for text in texts
    )
    return re.compile("|".join(parts), re.DOTALL)


@pytest.fixture
def japanese_page(browser: Any, server: Server) -> Iterator[Any]:
    """Yield a page on which Japanese has been chosen by its menu."""
    with opened(browser, server.address(full=True)) as page:
        page.get_by_role("button", name="Language: English").click()
        page.get_by_role("menuitem", name="日本語").click()
        page.locator("html[lang=ja]").wait_for()
        yield page
        page.evaluate("localStorage.clear()")


def test_the_choice_of_a_language_is_remembered(
    japanese_page: Any, texts: Callable[[str], str]
) -> None:
    page = japanese_page
    tab = page.get_by_role("tab", name=texts("Wiring"), exact=True)
    tab.wait_for()
    page.reload()
    tab.wait_for()
    # A refusal of the server is in the language of the page.
    page.get_by_label(texts("File of the system")).fill("a.txt")
    page.get_by_role("button", name=texts("Save"), exact=True).click()
    said = page.get_by_role("alert").inner_text()
    assert "XML ファイルでも YAML ファイルでもありません" in said, said
    page.get_by_role("button", name="言語: 日本語").click()
    page.get_by_role("menuitem", name="English").click()
    page.get_by_role("tab", name="Wiring", exact=True).wait_for()
    assert page.evaluate("document.documentElement.lang") == "en"


@pytest.mark.parametrize("width", [1440, 820, 390])
def test_each_view_is_japanese(
    japanese_page: Any,
    session: Session,
    texts: Callable[[str], str],
    english: re.Pattern[str],
    width: int,
) -> None:
    page = japanese_page
    page.set_viewport_size({"width": width, "height": 900})
    seen: set[str] = set()

    def look(part: str = "body") -> None:
        page.evaluate(TO_TOP)
        seen.update(page.evaluate(SAID))
        assert flaws(page, part) == []
        assert violations(page) == []

    def press(name: str) -> None:
        page.get_by_role("button", name=texts(name), exact=True).first.click()

    for (file, component), views in VIEWS.items():
        _open(page, "Wiring", texts, is_wide=width > 1000)
        if width < 600:
            press("More")
        page.get_by_role("combobox", name=texts("System")).select_option(file)
        until(page, lambda file=file: session.file == file)
        if width < 600:
            look("[role=dialog]")
            page.keyboard.press("Escape")
        page.locator(".wiring[aria-busy=false] .react-flow__node").first.wait_for()
        press("Play")
        until(page, lambda: session.now > 1.0)
        press("Pause")
        look()
        for view in views:
            _open(page, view, texts, is_wide=width > 1000)
            if view in COMPONENT:
                chooser = page.get_by_role(
                    "combobox", name=texts("Component"), exact=True
                )
                chooser.select_option(component)
            page.locator(f"[data-view={view}]").wait_for()
            look()
            if view in COMPONENT:
                chooser.select_option("")
    for keys in ("Control+k", "?"):
        page.keyboard.press("Escape")
        page.locator("body").press(keys)
        page.get_by_role("dialog").wait_for()
        look("[role=dialog]")
    assert sorted(each for each in seen if english.fullmatch(each)) == []


def _open(page: Any, view: str, texts: Callable[[str], str], *, is_wide: bool) -> None:
    name = texts(view)
    if is_wide:
        page.get_by_role("tab", name=name, exact=True).click()
        return
    bar = page.get_by_role("navigation", name=texts("Views"))
    if view in COMPONENT:
        bar.get_by_role("button", name=texts("Values"), exact=True).click()
        page.get_by_role("tab", name=name, exact=True).click()
    elif view in ON_BAR:
        short = texts("Time") if view == "Timeline" else name
        bar.get_by_role("button", name=short, exact=True).click()
    else:
        bar.get_by_role("button", name=texts("More"), exact=True).click()
        chosen = page.get_by_role("dialog")
        chosen.get_by_role("button", name=name, exact=True).click()


def test_texts_of_messages_are_translated_and_names_stay() -> None:
    details = "12 overwritten in a full buffer, 3 refused by a full buffer"
    flow = ui.Flow(name="move it", rate=1.0, lost=15, details=details)
    event = in_language(ui.Event.of_flows([flow]), "ja")
    [shown] = event.flows
    assert shown.name == "move it"
    assert shown.details == "満杯のバッファで上書き 12、満杯のバッファが拒否 3"
    value = ui.Result(request=1, done=True, text="undo", reply=b"\1")
    assert in_language(ui.Event.of_outcome(value), "ja").outcome.text == "undo"
    refused = ui.Result(request=1, done=False, message="Odometry0 has no port 'move'")
    outcome = in_language(ui.Event.of_outcome(refused), "ja").outcome
    assert outcome.message == "Odometry0 にポート 'move' はありません"


def test_the_page_is_in_the_language_of_its_server(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    from urllib.request import urlopen

    from rtgen.compiler.kit import translation

    address = server.address(full=True).partition("?")[0]

    def page() -> str:
        with urlopen(address) as answer:
            return answer.read().decode()

    assert '<html lang="en">' in page()
    monkeypatch.setattr(translation._Choice, "language", "ja")
    assert '<html lang="ja">' in page()
    with urlopen(f"{address}texts/ja.json") as answer:
        assert "配線" in answer.read().decode("utf-8")
