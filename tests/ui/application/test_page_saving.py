"""A system with a long path is saved from the page, by mouse and by keyboard, with its places."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from page_flaws import flaws, violations
from ui_bench import GOAL, QUIET, ROOT, until

from rtgen.compiler.systems.reading import read_file
from rtgen.runtime import SimulatedClock
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
FOLDER = "systems_of_the_robots_with_two_wheels_in_the_northern_building"


@pytest.fixture(scope="module")
def session(
    look: tuple[int, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Session]:
    folder = tmp_path_factory.mktemp("saved") / FOLDER
    copytree(GOAL.parent, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        file = str(folder / GOAL.name)
        yield Session(CommandProject(QUIET, [file]), file, SimulatedClock)


def test_by_keyboard_and_by_mouse(page: Any, session: Session) -> None:
    field = page.get_by_label("File of the system")
    assert field.input_value() == session.file
    assert FOLDER in session.file
    fits = "each => each.scrollWidth <= each.clientWidth"
    high = "each => each.scrollHeight <= each.clientHeight + 2"
    assert field.evaluate(fits)
    assert field.evaluate(high)
    save = page.get_by_role("button", name="Save", exact=True)
    field.fill(str(Path(session.file).with_name("none") / "made.xml"))
    save.click()
    page.locator("header").get_by_role("alert").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    assert flaws(page) == violations(page) == []
    for number, by_mouse in enumerate((False, True)):
        file = Path(session.file).with_name(f"made{number}.xml")
        field.fill(str(file))
        if by_mouse:
            save.click()
        else:
            field.press("Enter")
        until(page, file.exists)
        until(page, lambda file=file: session.file == str(file))
        until(page, lambda: save.get_attribute("aria-disabled") == "true")
        saved, findings, _ = read_file(file)
        assert saved is not None
        assert not findings
        places = {c.instance: c.location[:2] for c in saved.components if c.location}
        assert places == {
            name: (round(x), round(y)) for name, (x, y) in session.places.items()
        }
