"""`[output] package = "acme.rover"`: the same files, in a package of a namespace."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from msgspec.structs import replace

from rtgen import api
from rtgen.cli import run
from rtgen.compiler import compilation
from rtgen.compiler.backends import Options
from rtgen.compiler.backends.stage import emitted
from rtgen.compiler.model import Model
from rtgen.compiler.project import TARGETS, load

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def reference() -> tuple[Model, Options]:
    """Return the lowered model of the reference build, and its options."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        project = load()
        return compilation.read(project, lowered=True).model, project.options


def plain(path: str, text: str) -> str:
    """Return the text of a file as in the package `acme`, without breaks of lines."""
    text = text.replace("acme.rover", "acme").replace("acme/rover", "acme")
    return ast.unparse(ast.parse(text)) if path.endswith(".py") else text


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "target",
    [
        pytest.param(name, marks=() if name == "embedded" else pytest.mark.nightly)
        for name in TARGETS
    ],
)
def test_all_files_are_those_of_a_plain_package(
    target: str, reference: tuple[Model, Options]
) -> None:
    model, options = reference
    plain_one, dotted = (
        emitted(
            model, replace(options, package=package, target=target, ros_boards=None)
        )
        for package in ("acme", "acme.rover")
    )
    assert len(dotted.artifacts) > 100
    assert {plain("", a.path): plain(a.path, a.text) for a in dotted.artifacts} == {
        a.path: plain(a.path, a.text) for a in plain_one.artifacts
    }
    assert [plain("", d.message) for d in dotted.diagnostics] == [
        d.message for d in plain_one.diagnostics
    ]
    factories = dotted.components.factories
    assert {
        name: plain("", f) for name, f in factories.items()
    } == plain_one.components.factories
    assert not any(a.path.endswith("acme/__init__.py") for a in dotted.artifacts)


def start(folder: Path, package: str, component: str) -> Path:
    """Write and generate a project with a component that publishes a number."""
    folder.mkdir()
    (folder / "robot.idl").write_text(
        '#include "BasicDataType.idl"\n'
        f"component {component} {{ publishes RTC::TimedDouble speed; }};\n"
    )
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["."]\n'
        f'[output]\npackage = "{package}"\nskeletons = "src/{component.lower()}s"\n'
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "-q"]) == 0
        assert run(["check", "-q"]) == 0
    return folder


def test_two_projects_share_a_namespace(tmp_path: Path) -> None:
    rover = start(tmp_path / "one", "acme.rover", "Rover")
    arm = start(tmp_path / "two", "acme.arm", "Arm")
    path = [str(p / f) for p in (rover, arm) for f in ("generated", "src")]
    code = (
        f"import sys; sys.path[:0] = {path}\n"
        "from rovers.rover import Rover; from arms.arm import Arm\n"
        "from acme.rover.components.rover import RoverBase\n"
        "from acme.arm.components.arm import ArmBase\n"
        "assert issubclass(Rover, RoverBase) and issubclass(Arm, ArmBase)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_behaviours_are_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    project = start(tmp_path / "one", "acme.rover", "Rover")
    monkeypatch.chdir(project)
    behaviour = project / "src/rovers/rover.py"
    text = behaviour.read_text()
    behaviour.write_text(text + "        self.sped.write(1)\n")
    assert run(["check"]) == 1
    assert "PRJ0013" in (printed := capfd.readouterr().err)
    assert "did you mean speed?" in printed
    behaviour.write_text(text.replace("components.rover", "components.rovr"))
    assert run(["check"]) == 1
    assert "component of acme.rover.components.rovr" in capfd.readouterr().err


def test_a_skeleton_does_not_hide_the_namespace(tmp_path: Path) -> None:
    (tmp_path / "robot.idl").write_text("component Acme {}; component Rover {};\n")
    model = api.compile([tmp_path / "robot.idl"])
    options = Options("acme.rover", "", "0")
    users = [a.path for a in emitted(model, options).artifacts if a.owner == "user"]
    assert users == ["acme_.py", "rover.py"]


@pytest.mark.parametrize(
    ("package", "reason"),
    [
        ("acme..rover", "is not a Python identifier"),
        ("acme.", "is not a Python identifier"),
        (".rover", "is not a Python identifier"),
        ("acme.class", "is not a Python identifier"),
        ("acme.rover-2", "is not a Python identifier"),
        ("json.rover", "would hide that of Python"),
        ("rtgen.rover", "would hide that of rtgen"),
        ("rovers.own", "are both called 'rovers'"),
    ],
)
def test_packages_that_python_cannot_import(
    package: str,
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.idl").write_text("component Rover {};\n")
    (tmp_path / "rtgen.toml").write_text(
        '[sources]\npaths = ["."]\n[output]\n'
        f'package = "{package}"\nskeletons = "src/rovers"\n'
    )
    assert run(["generate"]) == 2
    assert "PRJ0004" in (printed := capfd.readouterr().err)
    assert reason in printed
