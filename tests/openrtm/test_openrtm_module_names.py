"""Modules of components whose names other modules have: OpenRTM's manager imports by name."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import hosting
import pytest
from patience import PATIENCE

from rtgen.cli import run

DEFINITION = """
module mm {{
    struct P {{ long x; }};
    interface I {{ void f(in P arg); }};
}};
component {component} {{
    consumes mm::P target;
    publishes mm::P state;
    provides mm::I served;
    uses mm::I used;
    attribute long speed;
}};
"""

AS_A_MANAGER_DOES = """
import importlib, sys, OpenRTM_aist
sys.path.append(sys.argv[1])
module = importlib.import_module(sys.argv[2])
assert module.__file__.startswith(sys.argv[1]), module
settings = ["-o", "corba.nameservers:127.0.0.1:1", "-o", "logger.enable:NO"]
manager = OpenRTM_aist.Manager.init(["test", *settings])
manager.activateManager()
getattr(module, sys.argv[2] + "Init")(manager)
component = manager.createComponent(sys.argv[2])
assert component.getTypeName() == sys.argv[2]
behaviour = type(component._host.behaviour)
print(behaviour.__module__, behaviour.__name__, flush=True)
component.exit()
manager.shutdown()
"""


def generated(folder: Path, component: str, package: str, skeletons: str) -> int:
    """Generate a project for OpenRTM with one component; return the exit code."""
    (folder / "robot.idl").write_text(DEFINITION.format(component=component))
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["robot.idl"]\n'
        f'[output]\npackage = "{package}"\nskeletons = "{skeletons}"\ntarget = "openrtm"\n'
    )
    before = Path.cwd()
    os.chdir(folder)
    try:
        return run(["generate", "-q", "--no-cache"])
    finally:
        os.chdir(before)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("component", "package", "skeletons", "module"),
    [
        ("lamp", "robots", "src", "lamp_behaviour"),
        ("lamp", "robots", "src/nodes", "nodes.lamp"),
        ("Rover", "rover", "src", "rover_"),
        ("Select", "robots", "src", "select_"),
        ("Rtgen", "robots", "src", "rtgen_"),
        ("Msgspec", "acme.rover", "src", "msgspec_"),
        ("Acme", "acme.rover", "src", "acme_"),
        ("rover", "acme.rover", "src", "rover_behaviour"),
    ],
)
def test_a_manager_imports_the_module(
    component: str,
    package: str,
    skeletons: str,
    module: str,
    tmp_path: Path,
    rtm_folders: list[Path],
    rtm_environment: dict[str, str],
) -> None:
    assert generated(tmp_path, component, package, skeletons) == 0
    folder = tmp_path / "generated/openrtm" / component
    hosting.compile_stubs(folder, rtm_folders)
    done = subprocess.run(
        [sys.executable, "-c", AS_A_MANAGER_DOES, str(folder), component],
        env=rtm_environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [module, component]


def test_names_that_differ_in_case_only_are_compiled(
    tmp_path: Path, rtm_folders: list[Path]
) -> None:
    (tmp_path / "robot.idl").write_text(
        "struct Path { long n; };\nstruct Plan { Path path; long x; double X; };\n"
        "component Drive { consumes Plan plan; };\n"
    )
    (tmp_path / "rtgen.toml").write_text(
        '[sources]\npaths = ["robot.idl"]\n[idl]\ncase = "dds"\n'
        '[output]\ntarget = "openrtm"\n'
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        assert run(["generate", "-q", "--no-cache"]) == 0
    folder = tmp_path / "generated/openrtm/Drive"
    hosting.compile_stubs(folder, rtm_folders)
    assert (folder / "stubs/robot_idl.py").is_file()


@pytest.mark.parametrize(
    ("component", "package", "skeletons", "code"),
    [
        ("robots", "robots", "src", "RTC0566"),
        ("nodes", "robots", "src/nodes", "RTC0566"),
        ("msgspec", "robots", "src", "RTC0566"),
        ("Lamp", "mm", "src", "RTC0572"),
        ("Lamp", "mm.rover", "src", "RTC0572"),
        ("acme", "acme.rover", "src", "RTC0566"),
        ("Lamp", "robots", "src/mm", "RTC0572"),
    ],
)
def test_what_cannot_be_imported_is_refused(
    component: str,
    package: str,
    skeletons: str,
    code: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert generated(tmp_path, component, package, skeletons) == 2
    assert code in capfd.readouterr().err


def test_a_behaviour_that_is_missing(tmp_path: Path) -> None:
    from rtgen.runtime.openrtm import behaviour_module

    with pytest.raises(ImportError, match=r"there is no behaviour .*lamp\.py"):
        behaviour_module(tmp_path / "lamp.py")
    (tmp_path / "lamp.py").write_text("raise OSError('no lamp')\n")
    for _ in range(2):
        with pytest.raises(OSError, match="no lamp"):
            behaviour_module(tmp_path / "lamp.py")
