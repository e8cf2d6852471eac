"""The gallery shows every system as it is wired now."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from gallery import ENTRIES, IMAGES, PAGE, ROOT, Entry, diagram, page

from rtgen import compiler
from rtgen.project import load


@pytest.fixture(scope="module")
def definitions() -> Iterator[None]:
    """The project's definitions are read once for all diagrams."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        read = compiler.read(load(), lowered=True)
        patch.setattr(compiler, "read", lambda project, lowered: read)
        yield


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `make gallery`"


@pytest.mark.usefixtures("definitions")
@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_the_diagram_is_up_to_date(entry: Entry) -> None:
    assert entry.wiring.read_text(encoding="utf-8") == diagram(
        entry
    ), "run `make gallery`"
    assert entry.result.stat().st_size > 1000


def test_every_system_is_shown_and_nothing_else() -> None:
    wanted = {file for entry in ENTRIES for file in (entry.wiring, entry.result)}
    assert set(IMAGES.iterdir()) == wanted
    shown = {entry.system for entry in ENTRIES}
    experiments = {
        path.parent.relative_to(ROOT).as_posix()
        for path in (ROOT / "specs" / "experiments").glob("*/system.xml")
    }
    assert experiments <= shown
    systems = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "specs").rglob("*.xml")
        if path.name != "system.xml"
    }
    # Parts of others.
    parts = {
        *("specs/canopen/rh3_pc.xml", "specs/canopen/rh3_drives.xml"),
        "specs/tecs/board.xml",
    }
    assert systems - parts <= shown
