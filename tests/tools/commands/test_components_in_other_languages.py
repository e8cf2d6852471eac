"""Components whose RTC.xml names another language: rtgen does not run them."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.project import load
from rtgen.compiler.project.output import component_types
from rtgen.tools.running.factories import Factories

ROOT = Path(__file__).parents[3]
NAVIGATION = ROOT / "specs" / "navigation"

OTHERS = ["rh3_goal.xml", "ref_hard.inc"]
OTHERS += [
    f"{name}.idl"
    for name in (
        "PositionInput",
        "OmniTo2WD",
        "Navigation",
        "PathFollower",
        "RefHardRh3",
    )
]


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return RH3 with an odometry that is defined by the RTC.xml of a component in C++."""
    for name in OTHERS:
        shutil.copy(NAVIGATION / name, tmp_path)
    profile = ROOT / "generated/refrobots/components/odometry/RTC.xml"
    text = profile.read_text()
    assert text.count('rtc:kind="Python"') == 1
    (tmp_path / "RTC.xml").write_text(text.replace('kind="Python"', 'kind="C++"'))
    (tmp_path / "rtgen.toml").write_text(
        '[sources]\npaths = ["."]\n' f'include = ["{ROOT}/specs/idl"]\n'
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    return tmp_path


def test_a_run_looks_for_it_instead_of_its_skeleton(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["generate", "-q"]) == 0
    assert component_types(project / "generated").languages == {"Odometry": "C++"}
    assert run(["run", "rh3_goal.xml", "--until", "1"]) == 2
    said = capsys.readouterr().err
    assert "error[SYS0026]: Odometry0: a foreign component is reached by CORBA" in said
    assert "the profile of Odometry says C++: if it is implemented here" in said


def test_a_factory_of_the_project_is_run(project: Path) -> None:
    assert run(["generate", "-q"]) == 0
    assert Factories(load()).foreign == {"Odometry": "C++"}
    with (project / "rtgen.toml").open("a") as file:
        file.write('\n[components]\nOdometry = "refnav.odometry:Odometry"\n')
    assert run(["generate", "-q"]) == 0
    factories = Factories(load())
    assert not factories.foreign
    assert factories.types["Odometry"] == "refnav.odometry:Odometry"


def test_openrtm_starts_no_process_for_it(project: Path) -> None:
    assert run(["generate", "--target", "openrtm", "-q"]) == 0
    folder = project / "generated/openrtm/rh3_goal"
    assert not (folder / "Odometry0.conf").exists()
    assert (folder / "Navigation0.conf").exists()
    assert "Odometry0" not in (folder / "start.sh").read_text()
    assert 'foreign="localhost/Odometry0.rtc"' in (folder / "connect.py").read_text()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("language", ["", "python", "Python3", None])
def test_what_rtgen_runs(project: Path, language: str | None) -> None:
    file = project / "RTC.xml"
    element = '<rtc:Language xsi:type="rtcExt:language_ext" rtc:kind="C++"/>'
    text = file.read_text()
    assert element in text
    other = "" if language is None else element.replace("C++", language)
    file.write_text(text.replace(element, other))
    assert run(["generate", "-q"]) == 0
    assert not component_types(project / "generated").languages


def test_the_name_of_a_language_is_data(project: Path) -> None:
    file = project / "RTC.xml"
    file.write_text(file.read_text().replace("C++", "C&#10;[rtgen.components]"))
    assert run(["generate", "-q"]) == 0
    languages = component_types(project / "generated").languages
    assert languages == {"Odometry": "another language"}
