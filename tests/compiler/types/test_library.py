"""The types of rtgen's own IDL files, which are in the runtime and which projects use."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import chdir
from importlib import import_module
from pathlib import Path

import pytest
from generated_projects import modules, project

from rtgen import api
from rtgen.compiler.backends import Options
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.kit.resources import IDL_FILES, idl_file
from rtgen.compiler.lowering.library import PACKAGE, classes_of, digest
from rtgen.compiler.model import ExceptionDecl, Interface, Model
from rtgen.compiler.project.output import component_types
from rtgen.facts.version import __version__
from rtgen.runtime.library import canopen, rtc
from rtgen.runtime.services.calls import Client, Server, calls_of

ROOT = Path(__file__).resolve().parents[3]


def read() -> Model:
    """Return the model of the files, read as those of a project with default settings."""
    folders = [Path("src/rtgen/compiler/kit/idl"), Path("specs/idl")]
    with chdir(ROOT):
        named = [folder / name for name in IDL_FILES for folder in folders]
        paths = [path for path in named if path.is_file()]
        result = api.read(paths, lowered=True)
    assert not has_errors(result.diagnostics)
    return result.model


def made(model: Model) -> dict[Path, str]:
    """Return the files that belong into the repository, with their texts."""
    options = Options(PACKAGE, "", __version__, lazy=True)
    emission = api.emit(model, "types", options=options)
    assert not emission.diagnostics
    found = {
        ROOT / "runtime" / "src" / each.path: each.text
        for each in emission.artifacts
        if each.path.count("/") > 3  # the package itself has a docstring of its own
    }
    digests = {
        Path(file.name).name: digest(classes)
        for file in model.files
        if (classes := classes_of(model, file.name))
    }
    text = json.dumps(digests, indent=2, sort_keys=True) + "\n"
    return {**found, ROOT / "src/rtgen/compiler/kit/idl/implemented.json": text}


def test_the_runtime_has_what_rtgen_makes_of_its_files(
    update_golden: bool,
) -> None:
    files = made(read())
    assert len(files) > 7
    for path, text in files.items():
        if update_golden:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        assert path.read_text(encoding="utf-8") == text, path


MOVED = """\
#include "BasicDataType.idl"
module Pose { struct Moved { RTC::Time tm; double x; }; };
"""
SAFE = (
    '#include "Canopen.idl"\n'
    "module Safe {\n"
    "  exception Stuck { long where; };\n"
    "  interface Drive : CANopen::ObjectDictionary {\n"
    "    CANopen::ObjectValue move(in long steps) raises (CANopen::SdoAbort, Stuck);\n"
    "  };\n"
    "};\n"
)
PROFILE = """\
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:me:Test:Meter:1.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" rtc:name="Meter" rtc:componentType="STATIC"
      rtc:activityType="PERIODIC" rtc:componentKind="DataFlowComponent" rtc:category="Test"
      rtc:description="" rtc:executionRate="1.0" rtc:executionType="PeriodicExecutionContext"
      rtc:maxInstances="1" rtc:vendor="me" rtc:version="1.0"
      rtc:creationDate="1970-01-01T00:00:00+00:00" rtc:updateDate="1970-01-01T00:00:00+00:00"/>
  <rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="DataOutPort" rtc:name="value"
      rtc:type="RTC::TimedLong" rtcExt:variableName="value"/>
  <rtc:Language xsi:type="rtcExt:language_ext" rtc:kind="Python"/>
</rtc:RtcProfile>
"""
EDS = (ROOT / "specs/canopen/epos_drive.eds").read_text(encoding="utf-8")
BUS = """\
[bus]
name = "line"
bit_rate = 500
[device.drive]
eds = "epos_drive.eds"
name = "Drive"
operations = ["6040"]
[node.one]
device = "drive"
id = 5
"""


def names_in(file: str) -> list[str]:
    return sorted(d.name[-1] for d in read().declarations if d.file.endswith(file))


def test_every_exception_is_raised_by_an_interface_of_its_file() -> None:
    """So the module of calls has the reply for it, which interfaces of projects use, too."""
    model = read()
    for exception in model.declarations:
        if isinstance(exception, ExceptionDecl):
            assert any(
                exception.name in operation.raises
                for each in model.declarations
                if isinstance(each, Interface) and each.file == exception.file
                for operation in each.operations
            ), exception.scoped


def test_a_project_has_the_classes_of_the_runtime(tmp_path: Path) -> None:
    with project(tmp_path, {"pose.idl": MOVED}) as generated:
        assert modules(generated) == {
            *("mine/_idl/pose.py", "mine/pose/__init__.py", "mine/rtc/__init__.py")
        }
        assert import_module("mine.rtc").Time is rtc.Time
        with_names = import_module("mine.rtc").__all__
        assert with_names == names_in("BasicDataType.idl")
        made = import_module("mine.pose").Moved(rtc.Time(1, 2), 3.0)
        assert type(made).from_cdr(made.to_cdr()) == made


def test_two_packages_share_them(tmp_path: Path) -> None:
    with (
        project(tmp_path / "a", {"pose.idl": MOVED}, "one"),
        project(tmp_path / "b", {"pose.idl": MOVED}, "two"),
    ):
        one, two = import_module("one.rtc"), import_module("two.rtc")
        assert one.TimedLong is two.TimedLong is rtc.TimedLong


@pytest.mark.parametrize(
    "settings",
    [
        {"python": 'numeric = "list"'},
        {"python": 'numeric = "numpy"'},
        {"output": 'representation = "xcdr2"'},
        {"output": 'extensibility = "appendable"'},
        {"sources": 'define = { TimedDouble = "TimedReal" }'},
    ],
)
def test_other_settings_give_a_project_classes_of_its_own(
    tmp_path: Path, settings: dict[str, str]
) -> None:
    with project(tmp_path, {"pose.idl": MOVED}, **settings) as generated:
        assert "mine/_idl/basic_data_type.py" in modules(generated)
        own = import_module("mine.rtc")
        assert own.Time is not rtc.Time
        assert own.Time._descriptor_ == rtc.Time._descriptor_ or "output" in settings


def test_a_file_of_the_project_takes_the_place_of_that_of_rtgen(tmp_path: Path) -> None:
    """The project generates the files that include it, too."""
    text = idl_file("BasicDataType.idl").read_text(encoding="utf-8")
    files = {"BasicDataType.idl": text, "safe.idl": SAFE}
    with project(tmp_path, files) as generated:
        assert {
            *("mine/_idl/basic_data_type.py", "mine/_idl/canopen.py"),
            "mine/_idl/canopen_calls.py",
        } <= modules(generated)
        assert import_module("mine.rtc").Time is not rtc.Time
        assert import_module("mine.canopen").SdoAbort is not canopen.SdoAbort


def test_an_included_file_inside_a_module_is_part_of_it(tmp_path: Path) -> None:
    text = 'module Mine {\n#include "BasicDataType.idl"\n};\n'
    with project(tmp_path, {"inside.idl": text}) as generated:
        assert modules(generated) == {
            *("mine/_idl/inside.py", "mine/mine/rtc/__init__.py")
        }


def test_a_reopened_module_has_both(tmp_path: Path) -> None:
    text = "module RTC { struct Extra { long a; }; };\n"
    files = {"extra.idl": text, "epos_drive.eds": EDS}
    with project(tmp_path, files) as generated:
        assert "mine/rtc/__init__.py" in modules(generated)
        assert import_module("mine.rtc").Time is rtc.Time
        assert import_module("mine.rtc").Extra(1).a == 1
        assert import_module("mine.components.epos_drive_proxy")


def test_files_of_lowerings_have_no_package(tmp_path: Path) -> None:
    with project(tmp_path, {"epos_drive.eds": EDS}) as generated:
        assert not (generated / "mine/rtc").exists()
        target = component_types(generated).factories["EposDriveProxy"]
        module, _, name = target.partition(":")
        proxy = getattr(import_module(module), name)("Proxy0")
        assert proxy.sdo.interface is canopen.ObjectDictionary


def test_a_profile_knows_the_types_that_it_names(tmp_path: Path) -> None:
    with project(tmp_path, {"RTC.xml": PROFILE}) as generated:
        assert modules(generated) == {"mine/rtc/__init__.py"}
        assert import_module("mine.rtc").TimedLong is rtc.TimedLong


def test_calls_of_an_interface_with_a_base_of_the_runtime(tmp_path: Path) -> None:
    """Requests, replies and exceptions are those of the runtime where these declare them."""
    with project(tmp_path, {"safe.idl": SAFE}):
        safe = import_module("mine.safe")

        class Servant(safe.Drive):  # type: ignore[misc, name-defined]
            def read(self, index: int, subindex: int) -> bytes:
                raise canopen.SdoAbort(0x06020000, "no such object")

            def write(self, index: int, subindex: int, value: bytes) -> None: ...

            def get(self, index: int, subindex: int) -> canopen.ObjectValue:
                return canopen.ObjectValue.of_number(index)

            def set(
                self, index: int, subindex: int, value: canopen.ObjectValue
            ) -> None: ...

            def move(self, steps: int) -> canopen.ObjectValue:
                if steps > 9:
                    raise canopen.SdoAbort(steps, "too far")
                if steps > 5:
                    raise safe.Stuck(steps)
                return canopen.ObjectValue.of_count(steps)

        server = Server(safe.Drive, Servant())
        client = Client(safe.Drive, lambda name, body, _: server.handle(name, body))
        stub = safe.DriveStub(client)
        assert stub.move(3) == canopen.ObjectValue.of_count(3)
        assert stub.get(7, 0) == canopen.ObjectValue.of_number(7)
        with pytest.raises(canopen.SdoAbort) as aborted:
            stub.read(1, 2)
        assert aborted.value.code == 0x06020000
        with pytest.raises(canopen.SdoAbort):
            stub.move(10)
        with pytest.raises(safe.Stuck):
            stub.move(6)


def test_a_device_with_operations(tmp_path: Path) -> None:
    files = {"epos_drive.eds": EDS, "line.toml": BUS}
    with project(tmp_path, files) as generated:
        assert "mine/canopen/manager.py" in modules(generated)
        assert "mine/canopen/__init__.py" not in modules(generated)
        access = import_module("mine.drive").ObjectAccess
        assert issubclass(access, canopen.ObjectDictionary)
        assert {"read", "get_Controlword"} <= calls_of(access).keys()
        assert import_module("mine.canopen.manager").CanopenManager


def test_the_runtime_is_imported_without_them() -> None:
    code = "import rtgen.runtime, sys; print('rtgen.runtime.library' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"


def test_a_package_of_the_runtime_loads_what_is_looked_up() -> None:
    code = (
        "import sys\n"
        "from rtgen.runtime.library import rtc\n"
        "home = 'rtgen.runtime.library._idl.'\n"
        "assert not [m for m in sys.modules if m.startswith(home)]\n"
        "rtc.Time\n"
        "assert [m for m in sys.modules if m.startswith(home)] == [f'{home}basic_data_type']\n"
        "assert vars(rtc)['Time'] is rtc.Time\n"
        "rtc.Covariance2D\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
