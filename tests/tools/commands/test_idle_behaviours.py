"""A run whose behaviour is still a skeleton says so; skeletons are known by what they do."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from user_project import CONTROLLER, forget_modules, write

from rtgen.cli import run
from rtgen.compiler.backends import Owner
from rtgen.compiler.compilation import compile_project
from rtgen.compiler.project import load
from rtgen.compiler.project.skeletons import is_skeleton

ROOT = Path(__file__).parents[3]
HEATER = CONTROLLER.replace("controller", "heater")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    forget_modules()
    return tmp_path


def skeletons() -> dict[str, str]:
    """Return the skeletons of all components of the reference application."""
    artifacts = compile_project(load(ROOT)).artifacts
    return {a.path: a.text for a in artifacts if a.owner is Owner.USER}


@pytest.mark.sampled(0)
def test_each_skeleton_is_known_and_each_behaviour_of_the_application() -> None:
    made = skeletons()
    assert len(made) > 30
    assert any("NotImplementedError" in text for text in made.values())
    assert [path for path, text in made.items() if not is_skeleton(text)] == []
    folder = ROOT / "reference/refnav"
    written = {path: (folder / path).read_text() for path in made}
    idle = [path for path, text in written.items() if is_skeleton(text)]
    assert idle == ["motor_board_client.py"]  # no system has it


SKELETON = '''\
"""A component."""

from rtgen.runtime import RTC_OK, ReturnCode_t
from warmth.components.heater import HeaterBase


class Heater(HeaterBase):
    """A component."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Called in every cycle."""
        return RTC_OK
'''


@pytest.mark.parametrize(
    ("old", "new", "skeleton"),
    [
        ("", "", True),
        ('        """Called in every cycle."""\n', "", True),
        ("class Heater", "# mine\n\n\nclass Heater", True),
        ('"""A component."""\n\n', "", True),
        ("return RTC_OK", "print(ec_id)\n        return RTC_OK", False),
        ("return RTC_OK", "return self.done()", False),
        ("return RTC_OK", "return RTC_ERROR", False),
        ("class Heater(", "ROOM = 20.0\n\n\nclass Heater(", False),
        ("    def on_execute", "    ROOM = 20.0\n\n    def on_execute", False),
        ("class Heater(", "def helper() -> None: ...\n\n\nclass Heater(", False),
        ("def on_execute", "def on_execute(:", False),
    ],
)
def test_content_decides(old: str, new: str, skeleton: bool) -> None:
    text = SKELETON.replace(old, new, 1) if old else SKELETON
    assert is_skeleton(text) is skeleton


def test_a_run_of_a_skeleton_says_so(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["run", "warm.xml", "--until", "1"]) == 0
    assert "SYS0031" not in capfd.readouterr().err
    (project / HEATER).unlink()
    assert run(["generate", "-q"]) == 0
    assert run(["run", "warm.xml", "--until", "1"]) == 0
    found = re.findall(
        r"^(\S+) warning\[SYS0031\]: (.*)$", capfd.readouterr().err, re.M
    )
    assert found == [
        (f"{HEATER}:11:7:", "Heater0 does nothing: the behaviour is a skeleton")
    ]


def test_a_run_of_a_misspelt_callback_says_so(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = project / CONTROLLER
    file.write_text(file.read_text().replace("def on_execute", "def on_excute"))
    assert run(["run", "warm.xml", "--until", "1"]) == 0
    err = capfd.readouterr().err
    assert "warning[PRJ0014]: on_excute is no callback" in err
    assert "did you mean on_execute?" in err


def test_a_run_without_a_behaviour_is_a_mistake_of_the_project(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Runs of other tests have added folders with such a module.
    paths = [each for each in sys.path if not Path(each, "heating").is_dir()]
    monkeypatch.setattr(sys, "path", paths)
    (project / CONTROLLER).unlink()
    assert run(["run", "warm.xml", "--until", "1"]) == 2
    assert "rtgen generate creates the skeleton" in capfd.readouterr().err
