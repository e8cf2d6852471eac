"""Renames by a page: what follows the name changes with it, the run goes on, and it is undone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from heating_project import texts
from ui_bench import Bench, Page

from rtgen.cli import run as rtgen
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import RenameKind

RENAMES = {
    "component": (RenameKind.RENAME_COMPONENT, "", "Radiator"),
    "port": (RenameKind.RENAME_PORT, "temperature", "heat"),
    "parameter": (RenameKind.RENAME_PARAMETER, "warming", "rate_of_heat"),
    "instance": (RenameKind.RENAME_INSTANCE, "", "Boiler0"),
}


@pytest.fixture
def bench(warm: Path) -> Iterator[Bench]:
    made = Bench("systems/warm")
    yield made
    made.close()


def asked(kind: RenameKind, part: str, name: str, *, carried_out: bool) -> ui.Rename:
    return ui.Rename(kind, "Heater0", part, name, carried_out)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("what", RENAMES)
def test_a_rename_is_shown_carried_out_undone_and_redone(
    what: str, bench: Bench, warm: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    page, session = bench.page(), bench.session
    page.done("step", 1.5)
    kind, part, name = RENAMES[what]
    before = texts(warm)
    planned = page.done("renamed", asked(kind, part, name, carried_out=False))
    assert texts(warm) == before
    assert any(name in each.lines for each in planned.renamed)
    done = page.done("renamed", asked(kind, part, name, carried_out=True))
    assert [each.file for each in done.renamed] == [e.file for e in planned.renamed]
    after = texts(warm)
    assert after != before
    assert session.now == pytest.approx(1.5)
    instance = name if what == "instance" else "Heater0"
    [shown] = [c for c in session.whole().components if c.instance == instance]
    names = [shown.instance, shown.type]
    names += [each.name for each in (*shown.ports, *shown.parameters)]
    assert name in names
    assert session.edit_state().undo.startswith("rename ")
    capfd.readouterr()
    assert rtgen(["check"]) == 0, capfd.readouterr()
    page.done("undone", True)
    assert texts(warm) == before
    assert "Heater0" in session.system.instances
    assert session.edit_state().redo.startswith("rename ")
    page.done("redone", True)
    assert texts(warm) == after


def test_a_moved_behaviour_is_said(bench: Bench, warm: Path) -> None:
    page = bench.page()
    kind, part, name = RENAMES["component"]
    planned = page.done("renamed", asked(kind, part, name, carried_out=False))
    moves = {each.file: each.moved_to for each in planned.renamed if each.moved_to}
    assert moves["src/heating/heater.py"] == "src/heating/radiator.py"


@pytest.mark.parametrize(
    ("kind", "part", "name", "code", "reason"),
    [
        (RenameKind.RENAME_PORT, "temperature", "power", "UIS0005", "beside it"),
        (RenameKind.RENAME_PORT, "temperature", "1", "UIS0005", "is not a name"),
        (RenameKind.RENAME_PORT, "nothing", "power", "UIS0003", "no port"),
        (RenameKind.RENAME_INSTANCE, "", "Controller0", "UIS0005", "beside it"),
    ],
)
def test_an_impossible_rename_changes_nothing(
    kind: RenameKind,
    part: str,
    name: str,
    code: str,
    reason: str,
    bench: Bench,
    warm: Path,
) -> None:
    before = texts(warm)
    result = bench.page().ask("renamed", asked(kind, part, name, carried_out=True))
    assert (result.done, result.code) == (False, code)
    assert reason in result.message
    assert texts(warm) == before


def test_unsaved_edits_are_not_lost(bench: Bench) -> None:
    page = bench.page()
    moved = ui.Moved(instance="Heater0", where=ui.Location(10, 20))
    page.done("place", moved)
    rename = asked(*RENAMES["instance"], carried_out=True)
    result = page.ask("renamed", rename)
    assert (result.code, result.message.endswith("not saved")) == ("UIS0006", True)


def test_files_that_changed_meanwhile_are_not_replaced(
    bench: Bench, warm: Path
) -> None:
    page: Page = bench.page()
    page.done("renamed", asked(*RENAMES["instance"], carried_out=True))
    file = warm / "systems/warm/system.xml"
    changed = file.read_text() + "<!-- by hand -->\n"
    file.write_text(changed)
    result = page.ask("undone", True)
    assert not result.done
    assert file.read_text() == changed
