"""Names and texts of a definition are text on the page, in a real browser."""

from __future__ import annotations

import html
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from ui_bench import GOAL, ROOT, until

from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]

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


def test_hostile_texts_are_shown_and_do_nothing(page: Any, session: Session) -> None:
    dialogs: list[str] = []
    page.on("dialog", lambda dialog: dialogs.append(dialog.message))
    title = page.title()
    state = page.locator(".panel .state")
    scripts = page.locator("script").count()
    for name in (IMAGE, SCRIPT):
        page.locator(".react-flow__node").get_by_text(name, exact=True).wait_for()
        page.get_by_role("combobox", name="Component").select_option(name)
        for tab in page.get_by_role("tab").all():
            tab.click()
        button = page.get_by_role("button", name=f"Deactivate {name}", exact=True)
        button.click()
        until(page, lambda: state.inner_text() == "INACTIVE")
    assert {IMAGE, SCRIPT} <= {each.instance for each in session.whole().components}
    assert page.locator("img").count() == 0
    assert page.locator("script").count() == scripts
    assert page.locator("[href^='javascript:']").count() == 0
    assert page.title() == title
    assert dialogs == []
