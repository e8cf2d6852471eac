"""A rename by a command or an editor: all that follows it fits without a hand."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from heating_project import FILES, texts, write
from lsprotocol.types import (
    PositionEncodingKind,
    RenameFile,
    TextDocumentEdit,
    TextEdit,
    WorkspaceEdit,
)

from rtgen.cli import run
from rtgen.tools.indexing.text import Text
from rtgen.tools.lsp.documents import path_of, uri_of
from rtgen.tools.lsp.features.rename import renamed
from rtgen.tools.lsp.workspace import Workspace
from rtgen.tools.renaming.definitions import RenameError

IDL = "idl/heating.idl"
MOVED = {"src/heating/heater.py": "src/heating/radiator.py"}

KINDS = {
    "Heater=Radiator": ("component Hea^ter {", 6),
    "Heater.temperature=heat": ("publishes Heating::Temperature temper^ature", 8),
    "Heater.warming=rate_of_heat": ("attribute double warm^ing", 6),
    "Heating::Temperature=Celsius": ("struct Temper^ature", 3),
    "Heating::Power::watt=watts": ("double wa^tt;", 4),
    "Heating::Setup=Service": ("interface Set^up", 2),
    "Heating::Setup::set_room=set_lab": ("double set_ro^om(", 5),
}
"""Renames, with the place of the name in the IDL, and the number of files that change."""
TRIED_ON_EACH = "Heater=Radiator"
"""The one for further interpreters, too; each takes seconds, most of them mypy's."""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "project"
    write(folder)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    assert run(["generate", "-q"]) == 0
    return folder


def edit_of(folder: Path, marked: str, name: str) -> WorkspaceEdit:
    """Return the edit by which an editor renames the name at the `^` in the IDL."""
    workspace = Workspace()
    file = folder / IDL
    before, after = marked.split("^")
    source = file.read_text()
    workspace.documents.open(uri_of(str(file)), 1, source)
    workspace.analyse(workspace.key_of(str(file)))
    view = workspace.view(uri_of(str(file)))
    assert view is not None
    offset = source.index(before + after) + len(before)
    return renamed(view, view.range(offset, offset).start, name)


def apply(edit: WorkspaceEdit) -> None:
    """Change and move files as an editor does."""
    for change in edit.document_changes or ():
        if isinstance(change, TextDocumentEdit):
            file = Path(path_of(change.text_document.uri) or "")
            text = Text(file.read_text(encoding="utf-8"))
            for each in reversed(change.edits):
                assert isinstance(each, TextEdit)
                text, _ = text.replaced(
                    each.range, each.new_text, PositionEncodingKind.Utf16
                )
            file.write_text(text.source, encoding="utf-8")
        else:
            assert isinstance(change, RenameFile)
            Path(path_of(change.old_uri) or "").rename(path_of(change.new_uri) or "")


def assert_fits(folder: Path, cache: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Check, run, type-check and test a project; `cache` has the types of the runtime."""
    capfd.readouterr()
    assert run(["check"]) == 0
    assert capfd.readouterr() == ("", "")
    run(["lint"])
    assert "system" not in capfd.readouterr().err
    paths = os.pathsep.join(str(folder / each) for each in ("src", "generated"))
    for command in (
        ["rtgen", "run", "systems/warm", "--until", "5"],
        [
            "mypy",
            "--strict",
            "--explicit-package-bases",
            f"--cache-dir={cache}",
            "src",
            "tests",
        ],
        ["pytest", "-q", "-p", "no:cacheprovider", "tests"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", *command],
            env={**os.environ, "PYTHONPATH": paths, "MYPYPATH": paths},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert "warning:" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    "rename",
    [
        pytest.param(
            each,
            marks=(
                pytest.mark.sampled(0) if each == TRIED_ON_EACH else pytest.mark.nightly
            ),
        )
        for each in KINDS
    ],
)
def test_the_command_and_the_editor(
    rename: str,
    project: Path,
    tmp_path_factory: pytest.TempPathFactory,
    capfd: pytest.CaptureFixture[str],
) -> None:
    before = texts(project)
    old, new = rename.split("=")
    assert run(["generate", "--rename", rename]) == 0
    said = capfd.readouterr().err
    assert "warning" not in said
    after = texts(project)
    changed = {name for name, text in after.items() if before.get(name) != text}
    assert len(changed - {"systems/warm/Radiator.conf"}) == KINDS[rename][1]
    if new == "Radiator":
        assert not MOVED.keys() & after.keys()
        assert "src/heating/radiator.py" in after
    assert_fits(project, tmp_path_factory.getbasetemp() / "types", capfd)

    # The definitions were renamed by hand before.
    _restore(project, before)
    (project / IDL).write_text(after[IDL])
    assert run(["generate", "-q"]) == 0
    assert texts(project).keys() == before.keys()
    assert run(["generate", "-q", "--rename", rename]) == 0
    assert texts(project) == after

    _restore(project, before)
    assert run(["generate", "-q"]) == 0
    apply(edit_of(project, KINDS[rename][0], new))
    assert texts(project) == after
    assert run(["generate", "-q"]) == 0
    assert run(["check"]) == 0
    assert (
        old.rpartition(":")[2].rpartition(".")[2] not in after[IDL].split(new)[0][-9:]
    )


def _restore(folder: Path, files: dict[str, str]) -> None:
    for name in texts(folder).keys() - files.keys():
        (folder / name).unlink()
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def test_names_of_comments_and_locals_stay(project: Path) -> None:
    assert run(["generate", "-q", "--rename", "Heater.power=input_power"]) == 0
    after = texts(project)
    heater = after["src/heating/heater.py"]
    assert '"""A vessel of water. The names power, value and temperature' in heater
    assert "        power = self.input_power.read_newest()\n" in heater
    assert "            self.watt = given([power])\n" in heater
    assert after["src/heating/controller.py"] == FILES["src/heating/controller.py"]
    system = after["systems/warm/system.xml"]
    assert 'rts:abstract="Heater and power"' in system
    assert 'rts:portName="input_power" rts:instanceName="Heater0"' in system
    assert 'rts:portName="Controller0.power"' in system
    assert (
        '(("C", "power"), ("Heater0", "input_power"))' in after["tests/test_heating.py"]
    )


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("rename", "reason"),
    [
        (
            "Heater=Controller",
            f"{IDL}:23:11: error[PRJ0022]: there is a component Controller",
        ),
        ("Heater=struct", "struct is a keyword of IDL"),
        ("Heater=two words", "'two words' is not a name"),
        ("Heater.temperature=power", "there is a port power beside it"),
        ("Nothing=Something", "no definition has the name Nothing, nor Something"),
        ("temperature=heat", "temperature means several things"),
        ("Heating::Power=Warming::Power", "is not a name beside"),
        ("Heating=Warming", "error[IDL0204]: warming clashes with Warming"),
        ("Heater", "is not OLD=NEW"),
    ],
)
def test_what_cannot_be_renamed_changes_nothing(
    rename: str, reason: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = texts(project)
    assert run(["generate", "--rename", rename]) == 2
    assert reason in capfd.readouterr().err
    assert texts(project) == before


def test_a_file_in_the_way_is_left(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    other = project / "src/heating/radiator.py"
    other.write_text("VALUE = 3\n")
    before = texts(project)
    assert run(["generate", "--rename", "Heater=Radiator"]) == 2
    err = capfd.readouterr().err
    assert (
        f"{IDL}:15:11: error[PRJ0022]: src/heating/radiator.py is there already" in err
    )
    with pytest.raises(RenameError, match="is there already"):
        edit_of(project, "component Hea^ter {", "Radiator")
    assert texts(project) == before


@pytest.mark.parametrize(
    ("rename", "place"),
    [
        ("Heater=Settings", "src/heating/heater.py:33:7"),
        ("Heating::Power=ROOM", "src/heating/heater.py:7:43"),
        ("Heater.temperature=celsius", "src/heating/heater.py:58:14"),
    ],
)
def test_a_name_that_a_behaviour_has_is_left(
    rename: str, place: str, project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = texts(project)
    assert run(["generate", "--rename", rename]) == 2
    message = capfd.readouterr().err.split("\n")[0]
    new = rename.partition("=")[2]
    assert f"src/heating/heater.py has something that is called {new}" in message
    assert message.startswith(place.rpartition(":")[0].rpartition(":")[0])
    assert texts(project) == before


@pytest.mark.sampled(0)
def test_attributes_of_what_is_not_known_stay_if_nothing_of_them_is_renamed(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = project / "src/heating/shown.py"
    file.write_text("def shown(body):\n    return body.heater, body.watt\n")
    assert run(["generate", "-q", "--rename", "Heater=Radiator"]) == 0
    assert capfd.readouterr().err == ""
    assert "body.heater" in file.read_text()
    assert run(["generate", "-q", "--rename", "Heating::Power::watt=watts"]) == 0
    assert "body.watt" in file.read_text()  # `self.watt` of the behaviour may be meant
    assert "shown.py:2:30: warning[PRJ0023]" in capfd.readouterr().err


@pytest.mark.nightly
def test_a_new_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    assert run(["new", "project", "plant"]) == 0
    folder = tmp_path / "plant"
    monkeypatch.chdir(folder)
    for rename in (
        "Scaler.state=output",
        "Scaler=Multiplier",
        "Multiplier.gain=factor",
    ):
        assert run(["generate", "-q", "--rename", rename]) == 0
    assert run(["check"]) == 0
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_copies_with_other_values_of_members(project: Path) -> None:
    file = project / "src/heating/half.py"
    file.write_text(
        "from copy import deepcopy\nfrom dataclasses import replace\n\n"
        "from warmth.heating import Power\n\n\n"
        "def half(power: Power, watt: float) -> Power:\n"
        "    return replace(deepcopy(power), watt=watt / 2) or replace(power, watt=watt)\n"
    )
    assert run(["generate", "-q", "--rename", "Heating::Power::watt=watts"]) == 0
    text = file.read_text()
    assert "replace(power, watts=watt)" in text
    assert "def half(power: Power, watt: float)" in text


def test_a_skeleton_makes_way_for_a_behaviour(project: Path) -> None:
    idl = (project / IDL).read_text()
    (project / IDL).write_text(idl.replace("component Heater", "component Radiator"))
    behaviour = project / "src/heating/heater.py"
    content = behaviour.read_text()
    behaviour.unlink()
    assert run(["generate", "-q"]) == 0  # a skeleton, since nothing is there
    assert (project / "src/heating/radiator.py").exists()
    behaviour.write_text(content)
    assert run(["generate", "-q", "--rename", "Heater=Radiator"]) == 0
    assert not behaviour.exists()
    assert (
        "class Radiator(RadiatorBase):"
        in (project / "src/heating/radiator.py").read_text()
    )


def test_a_file_that_cannot_be_written_leaves_all(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = texts(project)
    replaced = Path.replace

    def fail(self: Path, target: Path) -> Path:
        if Path(target).name == "system.xml":
            raise OSError(28, "No space left on device", str(target))
        return replaced(self, target)

    monkeypatch.setattr(Path, "replace", fail)
    assert run(["generate", "--rename", "Heater=Radiator"]) == 3
    assert "nothing was changed" in capfd.readouterr().err
    assert texts(project) == before


def test_an_editor_that_moves_no_files_is_told_the_command(project: Path) -> None:
    workspace = Workspace()
    file = project / IDL
    source = file.read_text()
    workspace.documents.open(uri_of(str(file)), 1, source)
    workspace.analyse(workspace.key_of(str(file)))
    view = workspace.view(uri_of(str(file)))
    assert view is not None
    place = source.index("component Heater") + len("component ")
    position = view.range(place, place).start
    with pytest.raises(RenameError, match="rtgen generate --rename Heater=Radiator"):
        renamed(view, position, "Radiator", moves=False)
    place = source.index("double watt") + len("double ")
    position = view.range(place, place).start
    assert renamed(view, position, "watts", moves=False).changes


KILLED = """
import os, sys
from rtgen.tools.renaming import writing
from rtgen.cli import run

def then(function, left=[int(sys.argv[1])]):
    def called(*args):
        if left[0] == 0:
            os._exit(9)
        left[0] -= 1
        return function(*args)
    return called

writing.replace_file = then(writing.replace_file)
writing._move = then(writing._move)
run(["generate", "--rename", sys.argv[2]])
"""


def killed(steps: int, rename: str) -> int:
    """Rename in a process that is killed after some files; return its exit code."""
    words = [sys.executable, "-c", KILLED, str(steps), rename]
    return subprocess.run(words, capture_output=True, check=False).returncode


@pytest.mark.sampled(0)
def test_a_rename_that_is_killed_is_completed(
    project: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    before = texts(project)
    assert run(["generate", "-q", "--rename", "Heater=Radiator"]) == 0
    after = texts(project)
    shutil.rmtree(project)
    for steps in range(8):
        write(project)
        monkeypatch.chdir(project)
        assert run(["generate", "-q"]) == 0
        assert texts(project) == before
        if killed(steps, "Heater=Radiator") != 9:
            assert steps > 5
            break
        assert (project / ".rtgen-rename.json").exists()
        capfd.readouterr()
        assert run(["generate"]) == 0
        err = capfd.readouterr().err
        assert (
            "warning[PRJ0027]: the rename of Heater to Radiator was interrupted" in err
        )
        assert texts(project) == after
        assert not (project / ".rtgen-rename.json").exists()
        assert run(["check"]) == 0
        shutil.rmtree(project)


def test_a_file_changed_since_is_left(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert killed(1, "Heater=Radiator") == 9
    changed = [f for f in project.rglob("*.xml") if "generated" not in f.parts]
    for file in changed:
        file.write_text(file.read_text() + "<!-- mine -->\n")
    run(["check"])
    err = capfd.readouterr().err
    assert "except in files that have changed since: " in err
    for file in changed:
        assert file.read_text().endswith("<!-- mine -->\n")


def test_a_journal_changes_nothing_outside_of_its_folder(
    project: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    outside = tmp_path / "outside.txt"
    outside.write_text("a")
    entry = {
        "names": ["A", "B"],
        "contents": [["../outside.txt", "YQ==", "Yg=="]],
        "moves": [],
    }
    (project / ".rtgen-rename.json").write_text(json.dumps(entry))
    run(["check"])
    assert "outside.txt" in capfd.readouterr().err
    assert outside.read_text() == "a"
    (project / ".rtgen-rename.json").write_text("{}")
    assert run(["check"]) == 3
    assert "cannot be completed" in capfd.readouterr().err
