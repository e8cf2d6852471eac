"""The page asks before work is lost: files of others, edits; and says that it has saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from ui_bench import GOAL, QUIET, ROOT, by_both_hands, opened, until

from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.protocol import ui
from rtgen.ui.serving import Server
from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
OTHER = "rh3_path.xml"


@pytest.fixture(scope="module")
def session(
    look: tuple[int, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Session]:
    folder = tmp_path_factory.mktemp("asked") / "systems"
    copytree(GOAL.parent, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        files = [str(folder / name) for name in (GOAL.name, OTHER)]
        yield Session(CommandProject(QUIET, files), files[0], SimulatedClock)


def edit(page: Any, session: Session) -> None:
    """Move a box, behind the page."""
    place = ui.Location(len(session.places) + 1.0, session.places["Odometry0"][0] + 1)
    change = session.changes.move("Odometry0", (place.x, place.y))

    def move() -> None:
        session.places["Odometry0"] = (place.x, place.y)
        from rtgen.ui.edits import Edit

        session.edits.make(Edit("move", lambda: None, lambda: None, change))
        session.publish_edits()

    session.runner.submit(move)
    page.get_by_text("unsaved edits").wait_for()


@by_both_hands
def test_another_file_is_replaced_only_when_the_user_says_so(
    page: Any, session: Session, press: Callable[[Any], None]
) -> None:
    file = session.file
    other = Path(file).with_name(OTHER)
    text = other.read_bytes()
    field = page.get_by_label("File of the system")
    save = page.get_by_role("button", name="Save", exact=True)
    question = page.get_by_role("alertdialog")
    for answer in ("Cancel", "Escape"):
        field.fill(str(other))
        press(save)
        question.wait_for()
        assert "exists already" in question.inner_text()
        if answer == "Escape":
            page.keyboard.press("Escape")
        else:
            press(question.get_by_role("button", name="Cancel"))
        question.wait_for(state="detached")
        assert other.read_bytes() == text
        assert session.file == file
    press(save)
    press(question.get_by_role("button", name="Replace"))
    page.get_by_role("status").filter(has_text=f"Saved {other}").wait_for()
    assert other.read_bytes() == Path(file).read_bytes()
    kept = sorted(other.parent.glob(f"{OTHER}*~"))
    assert text in [each.read_bytes() for each in kept]
    other.write_bytes(text)
    field.fill(file)
    press(save)  # the same content
    page.get_by_role("status").filter(has_text=f"Saved {file}").wait_for()
    assert session.file == file


@by_both_hands
def test_edits_are_discarded_only_when_the_user_says_so(
    page: Any, session: Session, press: Callable[[Any], None]
) -> None:
    file = session.file
    edit(page, session)
    question = page.get_by_role("alertdialog")
    chooser = page.get_by_role("combobox", name="System")
    chooser.select_option(session.project.systems[1])
    question.wait_for()
    press(question.get_by_role("button", name="Cancel"))
    question.wait_for(state="detached")
    assert session.file == file
    assert chooser.input_value() == file
    press(page.get_by_role("button", name="Save", exact=True))
    page.get_by_role("status").filter(has_text=f"Saved {file}").wait_for()
    edit(page, session)
    chooser.select_option(session.project.systems[1])
    press(question.get_by_role("button", name="Discard edits"))
    for other in (session.project.systems[1], file):
        if other == file:
            chooser.select_option(file)
        until(page, lambda other=other: chooser.input_value() == other)
        assert session.file == other


def test_a_run_that_has_ended_says_why(page: Any, session: Session) -> None:
    def fail() -> None:
        session.system.at(session.system.time, lambda: 1 // 0)

    session.runner.submit(fail)
    session.runner.submit(session.runner.play)
    page.get_by_role("alert").filter(has_text="The run has ended at").wait_for()
    assert "ZeroDivisionError" in page.get_by_role("alert").first.inner_text()
    page.get_by_role("button", name="Go to 0").click()
    page.get_by_text("The run has ended at").wait_for(state="detached")
    until(page, lambda: session.now == 0.0)


def test_the_token_leaves_the_address(browser: Any, server: Server) -> None:
    with opened(browser, server.address(full=True)) as page:
        for _ in range(2):
            page.locator(".link.live").wait_for()
            address, _, _ = page.url.partition("#")
            assert address == f"http://127.0.0.1:{server.port}/"
            page.reload()
        page.go_back()
        assert "token" not in page.url
