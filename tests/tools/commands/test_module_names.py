"""Modules of a project hide none that are needed: by construction, else by a finding."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.typemap.idl_keywords import escaped
from rtgen.facts.python_modules import LIBRARIES, MIDDLEWARE, STANDARD

NEEDED = sorted(
    name
    for name in STANDARD | LIBRARIES | MIDDLEWARE
    if name[0].isalpha() and escaped(name) == name and "__" not in name
)

IMPORT_ALL = """
import importlib, json, sys
from pathlib import Path
from rtgen.facts.python_modules import owner
folders = [Path(each).resolve() for each in sys.argv[2:]]
sys.path[:0] = map(str, folders)
for target in json.loads(sys.argv[1]):
    module, _, name = target.partition(":")
    made = getattr(importlib.import_module(module), name)("one")
    assert made.profile.type_name.lower() == name.rstrip("_").lower(), target
hidden = [
    name
    for name, module in sys.modules.items()
    if (owner(name) or name == "rover")
    and (file := getattr(module, "__file__", None))
    and Path(file).is_relative_to(folders[1])
]
assert not hidden, hidden
import msgspec, queue, rtgen, rtgen.runtime
assert queue.Queue and msgspec.Struct and rtgen.runtime.Component
"""


def generate(folder: Path, definitions: str, *output: str, code: int = 0) -> None:
    """Generate a project in the working folder."""
    (folder / "robot.idl").write_text(definitions)
    lines = "\n".join(output)
    settings = f'[sources]\npaths = ["."]\n[output]\n{lines}\n'
    (folder / "rtgen.toml").write_text(settings)
    assert run(["generate", "-q"]) == code


def simulated(system: str) -> subprocess.CompletedProcess[str]:
    """Run a system in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "rtgen", "run", system, "--until", "0.01"],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(autouse=True)
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.sampled(0)
@pytest.mark.parametrize("capital", [False, True])
def test_components_called_as_any_module(work: Path, capital: bool) -> None:
    """Skeletons at the top level, each with the name of another module, can all be imported."""
    names: dict[str, str] = {}
    for name in [*NEEDED, "rover"]:
        names.setdefault(name.lower(), name.title() if capital else name)
    used = [n for n in names.values() if escaped(n) == n]
    generate(work, "".join(f"component {n} {{}};\n" for n in used), 'package = "rover"')
    manifest = json.loads((work / "generated/.rtgen.json").read_text())
    factories = manifest["factories"]
    assert set(factories) == set(used)
    arguments = [json.dumps(list(factories.values())), "generated", "src"]
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_ALL, *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_a_system_of_a_package_with_the_name_of_its_component(work: Path) -> None:
    generate(work, "component Rover {}; component Signal {};", 'package = "rover"')
    assert (work / "src/rover_.py").is_file()
    assert run(["check", "-q"]) == 0
    assert run(["new", "system", "two"]) == 0
    done = simulated("systems/two.xml")
    assert done.returncode == 0, done.stderr
    assert "Rover0" in done.stdout


def test_skeletons_in_a_package_keep_their_names(work: Path) -> None:
    generate(
        work,
        "component Queue {}; component Rover {};",
        'package = "rover"',
        'skeletons = "src/nodes"',
    )
    assert sorted(p.name for p in (work / "src/nodes").iterdir()) == [
        "queue.py",
        "rover.py",
    ]


def test_two_components_with_one_skeleton(
    work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    generate(work, "component Queue {}; component queue_ {};", code=2)
    assert "both get the skeleton `queue_`" in capfd.readouterr().err


def test_a_behaviour_in_the_place_of_a_former_skeleton_stays(
    work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """An empty skeleton does not replace it without a word."""
    generate(work, "component Queue {};")
    behaviour = work / "src/queue_.py"
    behaviour.rename(work / "src/queue.py")
    for command in ("generate", "check"):
        assert run([command]) == 2
        printed = capfd.readouterr().err
        assert "RTC0109]: src/queue.py would hide another module" in printed
        assert "rename it to queue_.py" in printed
    assert not behaviour.exists()
    (work / "src/queue.py").rename(behaviour)
    assert run(["check", "-q"]) == 0


@pytest.mark.parametrize("package", ["msgspec", "click", "queue", "RTC", "generated"])
def test_a_package_that_would_hide_another_one(
    package: str, work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    generate(work, "component A {};", f'package = "{package}"', code=2)
    assert f"PRJ0004]: a package called '{package}'" in capfd.readouterr().err


@pytest.mark.parametrize("package", ["msgspec", "click", "queue"])
def test_a_package_of_skeletons_that_would_hide_another_one(
    package: str, work: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    generate(work, "component A {};", f'skeletons = "src/{package}"', code=2)
    assert f"PRJ0004]: a package called '{package}'" in capfd.readouterr().err


def test_a_factory_that_another_module_hides(work: Path) -> None:
    """The hint names both files."""
    generate(work, "component Arm {};", '[components]\nArm = "click:Arm"')
    (work / "src/click.py").write_text("from arm import Arm\n")
    assert run(["new", "system", "one"]) == 0
    done = simulated("systems/one.xml")
    assert done.returncode == 3
    assert "SYS0022" in done.stderr
    assert "src/click.py is hidden: " in done.stderr
