"""The package of a device: its types and tables, and what definitions add to its IDL module."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from generated_projects import modules, project

from rtgen.cli import run
from rtgen.compiler.project.output import component_types
from rtgen.runtime.library import rtc
from rtgen.runtime.services.calls import calls_of

EDS = Path(__file__).parents[3] / "specs/canopen/epos_drive.eds"
DRIVE = EDS.read_text(encoding="utf-8")
USING = """\
#include "Drive.idl"
module Mine { struct Pair { Drive::Tpdo1 left; Drive::Tpdo1 right; }; };
component Watch { consumes Drive::Tpdo1 wheel; };
"""
REOPENED = """\
#include "Drive.idl"
module Drive {
    enum Colour { RED, GREEN };
    typedef sequence<Tpdo1, 2> Both;
    struct Extra { Tpdo1 first; Colour shade; Both wheels; };
    module Inner { struct Deep { Extra more; }; };
};
module Other { struct Outer { Drive::Extra more; }; };
"""
APART = "module Drive { struct Alone { long a; }; };\n"
BOUND = """\
#include "Drive.idl"
module Drive {
    struct Time { long a; };
    struct Objects { long a; };
    struct Aggregated { long a; };
    struct Write { Tpdo1 one; Time two; };
    enum Kind { idl, TYPE_CHECKING, lazy_names };
};
"""
BUS = """\
[bus]
name = "line"
bit_rate = 500
[device.wheel]
eds = "drive.eds"
name = "Drive"
operations = ["6040"]
[node.one]
device = "wheel"
id = 5
"""


def imported_alone(generated: Path, *statements: str) -> str:
    """Return what a new process prints that runs the statements."""
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(statements)],
        cwd=generated,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_device_is_one_package(tmp_path: Path) -> None:
    with project(tmp_path, {"drive.eds": DRIVE}) as generated:
        assert modules(generated) == {"mine/drive/__init__.py"}
        drive = import_module("mine.drive")
        assert drive.Tpdo1(rtc.Time(1, 2), 3, 4)._descriptor_.name == "Drive::Tpdo1"
        assert drive.DESCRIPTION.name == "Drive"
        assert (generated / "mine/drive/Drive.idl").is_file()
        assert (generated / "mine/drive/DriveProxy.eds").is_file()
        public = {name for name in vars(drive) if not name.startswith("_")}
        assert {"Tpdo1", "Rpdo4", "DriveObjects", "DESCRIPTION"} <= public
        assert not public & {"Objects", "descriptions", "Integer", "DeviceDescription"}


def test_a_proxy_does_not_import_the_slave(tmp_path: Path) -> None:
    with project(tmp_path, {"drive.eds": DRIVE}) as generated:
        loaded = imported_alone(
            generated,
            "import sys, mine.components.drive_proxy",
            "print(*(m for m in sys.modules if 'canopen.node.' in m or 'drive' in m))",
        ).split()
        assert sorted(loaded) == ["mine.components.drive_proxy", "mine.drive"]
        targets = component_types(generated).factories
        assert targets["DriveProxy"] == "mine.components.drive_proxy:DriveProxy"


def test_definitions_use_the_types_of_a_device(tmp_path: Path) -> None:
    with project(tmp_path, {"drive.eds": DRIVE, "using.idl": USING}) as generated:
        assert "mine/_idl/using.py" in modules(generated)
        assert not (generated / "mine/_idl/drive.py").exists()
        drive, mine = import_module("mine.drive"), import_module("mine.mine")
        assert type(mine.Pair().left) is drive.Tpdo1
        assert (
            import_module("mine.rtc").Time is rtc.Time
        ), "the device's IDL includes it"
        base = import_module("mine.components.watch").WatchBase
        assert base("W0").wheel.type is drive.Tpdo1


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "first",
    [
        "import mine.drive",
        "import mine._idl.reopened",
        "import mine.other",
        "import mine.drive.inner",
        "from mine.drive import Extra",
        "from mine.drive import RED",
        "from mine.drive import Tpdo1",
        "import mine.components.drive_proxy",
        "import mine.components.drive_device",
    ],
)
def test_a_reopened_module_is_imported_from_any_end(first: str, reopened: Path) -> None:
    says = imported_alone(
        reopened,
        first,
        "from mine import drive, other",
        "from mine.drive import Both, BothCodec, Colour, Extra, GREEN",
        "from mine.drive.inner import Deep",
        "outer = other.Outer(Extra(drive.Tpdo1(), GREEN, [drive.Tpdo1()]))",
        "assert type(outer).from_cdr(outer.to_cdr()) == outer",
        "assert type(Deep().more) is Extra is type(outer.more)",
        "print(drive.RED is Colour.RED, Extra.__module__, drive.Tpdo1.__module__)",
    )
    assert says == "True mine._idl.reopened mine.drive"


@pytest.fixture(scope="module")
def reopened(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reopened")
    files = {"drive.eds": DRIVE, "reopened.idl": REOPENED}
    with project(folder, files) as generated:
        return generated


def test_a_module_is_reopened_without_the_devices_file(tmp_path: Path) -> None:
    with project(tmp_path, {"drive.eds": DRIVE, "apart.idl": APART}):
        drive = import_module("mine.drive")
        assert drive.Alone(3).a == 3
        assert drive.Tpdo1()


def test_names_that_the_package_imports_are_free_for_definitions(
    tmp_path: Path,
) -> None:
    with project(tmp_path, {"drive.eds": DRIVE, "bound.idl": BOUND}):
        drive = import_module("mine.drive")
        for name in ("Time", "Objects", "Aggregated", "Write"):
            assert getattr(drive, name)._descriptor_.name == f"Drive::{name}"
        for name in ("idl", "TYPE_CHECKING_", "lazy_names"):
            assert getattr(drive, name) is drive.Kind[name]
        write = drive.Write(drive.Tpdo1(rtc.Time(1, 2)), drive.Time(5))
        assert drive.Write.from_cdr(write.to_cdr()) == write


@pytest.mark.parametrize("name", ["DESCRIPTION", "DriveObjects", "REMAPPED"])
def test_names_of_tables_are_the_devices(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "drive.eds").write_text(DRIVE, encoding="utf-8")
    (tmp_path / "taken.idl").write_text(
        f"module Drive {{ struct {name} {{ long a; }}; }};"
    )
    monkeypatch.chdir(tmp_path)
    assert run(["generate", "--no-cache", "drive.eds", "taken.idl"]) == 2
    assert "error[EDS0806]" in capfd.readouterr().err


def test_calls_of_a_device_stand_beside_it(tmp_path: Path) -> None:
    with project(tmp_path, {"drive.eds": DRIVE, "line.toml": BUS}) as generated:
        assert (generated / "mine/drive/_calls.py").is_file()
        access = import_module("mine.drive").ObjectAccess
        assert "get_Controlword" in calls_of(access)
