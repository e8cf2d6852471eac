"""The emitted IDL: compiled by omniidl for the whole reference build, by the emitted script."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import middleware
import pytest
from wires import (
    Kind,
    Wires,
    emit,
    equal_type_codes,
    imported,
    type_codes,
    values_agree,
    wired,
    wired_text,
)

from rtgen.compiler.kit.resources import idl_file
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
from rtgen.runtime.openrtm.stubs import StubsMissingError
from rtgen.runtime.openrtm.wire_objects import class_of

SPECS = Path(__file__).parents[2] / "specs"
OF_DEVICES = {"canopen", "eposdrive", "fpalette", "ftmd", "motorcoreunit"}


@pytest.fixture(scope="module")
def packages(
    orb: Any, reference: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Wires]:
    """Return the packages of the reference build, under separate names, with all stubs loaded."""
    folder = tmp_path_factory.mktemp("packages")
    idl = {path.stem: path for path in reference.glob("openrtm/*/idl/*.idl")}
    idl |= {path.stem: path for path in (SPECS / "idl").glob("*.idl")}
    together, made = folder / "idl", folder / "stubs"
    together.mkdir()
    made.mkdir()
    for stem, path in idl.items():
        shutil.copy(path, together / f"{stem}.idl")
    middleware.compile_idl(made, sorted(together.iterdir()), [together])
    stubs.load(made, sorted(idl))
    shutil.copytree(reference / "refrobots", folder / "wired_refrobots")
    names = {"refrobots": "", "board": ".tecs.board"}
    return {
        given: imported(folder, f"wired_refrobots{name}")
        for given, name in names.items()
    }


@pytest.mark.sampled(0)
def test_types_of_devices_and_boards(packages: dict[str, Wires]) -> None:
    reference = packages["refrobots"]
    of_devices = [
        kind
        for kind in reference.kinds
        if kind.type.__module__.rpartition(".")[2] in OF_DEVICES
    ]
    assert len(of_devices) > 20
    for kind in of_devices:
        values_agree(kind, reference.types)
    assert packages["board"].kinds
    for kind in packages["board"].kinds:
        values_agree(kind, packages["board"].types)


@pytest.mark.usefixtures("packages")
def test_the_channel_of_boards_has_its_types_in_the_runtime() -> None:
    kind = Kind(OpaqueRpc.Failed)
    failed = OpaqueRpc.Failed(-50, "no answer")
    wire = kind.to(failed)
    assert (wire.code, wire.reason) == (-50, "no answer")
    assert kind.of(wire) == failed


def test_repository_ids_and_type_codes(packages: dict[str, Wires]) -> None:
    count = 0
    for wires in packages.values():
        for descriptor in type_codes(wires):
            assert equal_type_codes(descriptor), descriptor.name
            count += 1
    assert count > 200


CLASSIC = """
#pragma prefix "example.org"
module WiredIds {
    typedef sequence<octet> Raw;
    struct Renamed { Raw data; };
    #pragma ID Renamed "IDL:elsewhere/Renamed:2.3"
    enum Kind { kind_a, kind_b };
    typedef Renamed Several[2];
    union Either switch (Kind) { case kind_a: Several two; default: wstring<4> wide; };
    exception Fault { fixed<4,2> price; };
    interface Calls { struct Inner { char c; }; Inner get(in Kind which) raises (Fault); };
    const long _struct = 4;
    struct _module { long _interface; Kind _in; };
    valuetype Held { public Either one; private long count; };
    module WiredInner { struct Deep { Renamed one; }; };
};
#pragma prefix ""
struct WiredFlat { WiredIds::_module inner; };
"""


def test_ids_prefixes_and_reserved_words(orb: Any, tmp_path: Path) -> None:
    wires = wired_text(tmp_path, CLASSIC, "wired_ids")
    found = {descriptor.repository_id for descriptor in type_codes(wires)}
    assert {
        "IDL:elsewhere/Renamed:2.3",
        "IDL:example.org/WiredIds/Calls/Inner:1.0",
        "IDL:example.org/WiredIds/WiredInner/Deep:1.0",
        "IDL:WiredFlat:1.0",
    } <= found
    for descriptor in type_codes(wires):
        assert equal_type_codes(descriptor), descriptor.name
    for kind in wires.kinds:
        values_agree(kind, wires.types)


def test_files_that_include_each_other(orb: Any, tmp_path: Path) -> None:
    (tmp_path / "wired-base.idl").write_text(
        "module WiredFiles { struct A { long x; }; interface I; };"
    )
    (tmp_path / "wired_user.idl").write_text(
        '#include "wired-base.idl"\n'
        "module WiredFiles { interface I { A get(); }; struct B { A one; I who; }; };\n"
        "struct WiredOut { WiredFiles::B b; };"
    )
    wires = wired(tmp_path, sorted(tmp_path.glob("*.idl")))
    assert (tmp_path / "idl" / "wired_base.idl").is_file()
    assert {kind.descriptor.name for kind in wires.kinds} == {
        *("WiredFiles::A", "WiredFiles::B", "WiredOut")
    }


def test_what_classic_idl_has_not_is_left_out(orb: Any, tmp_path: Path) -> None:
    """The rest of the file is complete."""
    text = """
    module WiredNewer {
        struct Plain { long x; };
        struct Mapped { map<string, long> entries; };
        bitmask Flags { one, two };
        struct Flagged { Flags set; };
        struct Small { int8 tiny; };
        struct Maybe { @optional long x; };
        enum Gaps { @value(3) three, @value(5) five };
        struct Exact { long double x; };
        struct Itself { long self; };
        interface Asks { Mapped ask(); };
        interface Simple { Plain ask(); };
        struct Derived : Plain { long y; };
        @mutable struct Changing { long x; };
    };
    """
    wires = wired_text(tmp_path, text, "wired_newer")
    assert {kind.descriptor.name for kind in wires.kinds} == {
        *("WiredNewer::Plain", "WiredNewer::Derived", "WiredNewer::Changing")
    }
    skeletons = importlib.import_module("omniORB").skeletonMapping
    assert "IDL:WiredNewer/Simple:1.0" in skeletons
    assert "IDL:WiredNewer/Asks:1.0" not in skeletons


# The script.


def compiled(
    reference: Path, folder: Path, environment: dict[str, str], name: str = "Odometry"
) -> subprocess.CompletedProcess[str]:
    """Run the script of a component in a copy of its folder."""
    shutil.copytree(
        reference / "openrtm" / name,
        folder,
        ignore=shutil.ignore_patterns("stubs"),
    )
    return subprocess.run(
        ["sh", "idlcompile.sh"],
        cwd=folder,
        env={"PYTHON": sys.executable, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def programs(folder: Path, *names: str) -> str:
    """Return a search path with these programs, and those that a shell script needs."""
    folder.mkdir()
    for name in (*names, "dirname", "mkdir", "mv", "rm"):
        (folder / name).symlink_to(middleware.program(name))
    return str(folder)


def made_of(folder: Path, stem: str) -> str:
    """Return the file that a stub was compiled from."""
    first = (folder / "stubs" / f"{stem}_idl.py").read_text().splitlines()[0]
    return first.rpartition(" from ")[2]


WITHOUT = pytest.mark.skipif(middleware.REAL, reason="OpenRTM-aist-Python is installed")


@WITHOUT
def test_the_script_takes_rtgens_files_without_openrtm(
    reference: Path, tmp_path: Path
) -> None:
    environment = {"PATH": programs(tmp_path / "bin", "omniidl", "omnicpp", "sh")}
    run = compiled(reference, tmp_path / "component", environment)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    made = {path.name for path in (tmp_path / "component" / "stubs").glob("*_idl.py")}
    assert made == {
        *("BasicDataType_idl.py", "ExtendedDataTypes_idl.py", "intellirobot_idl.py")
    }
    shipped = str(idl_file("BasicDataType.idl"))
    assert made_of(tmp_path / "component", "BasicDataType") == shipped


def test_the_script_leaves_openrtms_stubs_to_openrtm(
    reference: Path, tmp_path: Path, rtm_environment: dict[str, str]
) -> None:
    path = {"PATH": programs(tmp_path / "bin", "omniidl", "omnicpp", "sh")}
    environment = {**rtm_environment, **path}
    run = compiled(reference, tmp_path / "component", environment)
    assert (run.returncode, run.stderr) == (0, "")
    made = [path.name for path in (tmp_path / "component" / "stubs").glob("*_idl.py")]
    assert made == ["intellirobot_idl.py"]


@pytest.mark.sampled(1)
@WITHOUT
@pytest.mark.parametrize("way", ["RTM_IDL", "RTM_ROOT", "rtm2-config"])
def test_the_script_finds_openrtms_idl(
    way: str, reference: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "rtm" / "idl"
    folder.mkdir(parents=True)
    for path in (SPECS / "idl").glob("*DataType*.idl"):
        shutil.copy(path, folder)
    environment = {"PATH": programs(tmp_path / "bin", "omniidl", "omnicpp", "sh")}
    if way == "RTM_IDL":
        environment[way] = str(folder)
    elif way == "RTM_ROOT":
        environment[way] = str(tmp_path)
    else:
        script = tmp_path / "bin" / way
        script.write_text(f"#!/bin/sh\n[ $1 = --rtm-idldir ] && echo {folder}\n")
        script.chmod(0o755)
    run = compiled(reference, tmp_path / "component", environment)
    assert (run.returncode, run.stderr) == (0, "")
    found = made_of(tmp_path / "component", "BasicDataType")
    assert found == str(folder / "BasicDataType.idl")


def test_the_script_without_omniidl(reference: Path, tmp_path: Path) -> None:
    environment = {"PATH": programs(tmp_path / "bin", "sh")}
    # Beside the interpreter itself there is one.
    alone = tmp_path / "bin" / "python"
    alone.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    alone.chmod(0o755)
    environment["PYTHON"] = "python"
    run = compiled(reference, tmp_path / "component", environment)
    assert run.returncode == 3
    assert run.stderr.startswith("idlcompile.sh: omniidl is missing; pip install")


def test_the_script_passes_omniidls_errors_on(reference: Path, tmp_path: Path) -> None:
    broken = tmp_path / "openrtm" / "Odometry"
    shutil.copytree(reference / "openrtm" / "Odometry", broken)
    (broken / "idl" / "intellirobot.idl").write_text("struct {")
    environment = {"PATH": programs(tmp_path / "bin", "omniidl", "omnicpp", "sh")}
    run = compiled(tmp_path, tmp_path / "component", environment)
    assert run.returncode == 1
    assert "intellirobot.idl:1: Syntax error" in run.stderr
    assert not list((tmp_path / "component").glob("stubs*"))


# Stubs beside OpenRTM's.


def python(text: str, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", text]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def reopening(
    reference: Path,
    rtm_environment: dict[str, str],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """Return stubs of an IDL file that reopens the module RTC."""
    folder = tmp_path_factory.mktemp("reopening") / "component"
    path = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    environment = {**rtm_environment, **path}
    run = compiled(reference, folder, environment, "RefHardControl")
    assert (run.returncode, run.stderr) == (0, "")
    return folder / "stubs"


def test_a_reopened_module_of_openrtm(
    reopening: Path, rtm_environment: dict[str, str]
) -> None:
    assert (reopening / "RTC" / "__init__.py").is_file()
    run = python(
        f"""
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
stubs.load({str(reopening)!r}, ["TimedVelocity", "intellirobot"])
import OpenRTM_aist, RTC, IIS
assert RTC.RTObject and RTC.TimedVelocity and RTC.TimedPose2D and IIS.TimedPose2D
assert not RTC.__file__.startswith({str(reopening)!r})
""",
        rtm_environment,
    )
    assert (run.returncode, run.stderr) == (0, "")


def test_what_would_happen_with_the_stubs_in_front(
    reopening: Path, rtm_environment: dict[str, str]
) -> None:
    """The folder of a started script comes first: it must not be that of the stubs."""
    environment = dict(rtm_environment)
    environment["PYTHONPATH"] = f"{reopening}:{environment.get('PYTHONPATH', '')}"
    run = python("import OpenRTM_aist; import RTC; RTC.RTObject", environment)
    assert run.returncode == 1
    assert "AttributeError" in run.stderr


def test_interfaces_outside_of_modules(
    reference: Path, tmp_path: Path, rtm_environment: dict[str, str]
) -> None:
    folder = tmp_path / "component"
    path = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    run = compiled(reference, folder, {**rtm_environment, **path}, "RefHardRh3")
    assert (run.returncode, run.stderr) == (0, "")
    made = folder / "stubs"
    assert (made / "_GlobalIDL" / "__init__.py").is_file()
    run = python(
        f"""
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
import _GlobalIDL
before = set(vars(_GlobalIDL))
stubs.load({str(made)!r}, ["intellirobot", "RefHardRh3Pro"])
import _GlobalIDL__POA
assert not _GlobalIDL.__file__.startswith({str(made)!r})
assert _GlobalIDL.RefHard and _GlobalIDL__POA.RefHard
assert before < set(vars(_GlobalIDL))
""",
        rtm_environment,
    )
    assert (run.returncode, run.stderr) == (0, "")


def test_modules_with_the_name_of_something_else(
    tmp_path: Path, rtm_environment: dict[str, str]
) -> None:
    """A component's own file is found before the stubs, and so are modules of Python."""
    (tmp_path / "ship.idl").write_text(
        "module Ship { interface Steer { void left(); }; };\n"
        "module calendar { struct Day { long number; }; interface Notes {}; };\n"
    )
    unit = emit(tmp_path, [tmp_path / "ship.idl"])
    made = tmp_path / "stubs"
    made.mkdir()
    middleware.compile_idl(made, [tmp_path / "idl" / "ship.idl"])
    (tmp_path / "Ship.py").write_text("raise SystemExit('the wrong one')\n")
    script = tmp_path / "start.py"
    script.write_text(f"""
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
stubs.load({str(made)!r}, ["ship"])
import Ship, Ship__POA, calendar, calendar__POA
assert Ship.Steer and Ship__POA.Steer and calendar.Day and calendar__POA.Notes
from rtgen.runtime.openrtm import wire
from {unit.options.package}._idl.ship import Day, Steer
assert wire.new(Day).number == 0 and wire.stub(Steer, lambda: None)
""")
    environment = {**rtm_environment, "PYTHONDONTWRITEBYTECODE": "1"}
    run = subprocess.run(
        [sys.executable, str(script)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")


def test_a_file_with_the_name_of_one_of_openrtms(
    tmp_path: Path, rtm_environment: dict[str, str]
) -> None:
    """Both are loaded: OpenRTM has files such as `Logger.idl`, too."""
    made = tmp_path / "made"
    made.mkdir()
    text = "module Harbour { struct Berth { long number; }; interface Crane { }; };"
    (tmp_path / "SDOPackage.idl").write_text(text)
    middleware.compile_idl(made, [tmp_path / "SDOPackage.idl"])
    code = f"""
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
stubs.load({str(made)!r}, ["SDOPackage"])
import Harbour, Harbour__POA, SDOPackage
assert Harbour.Berth(3).number == 3 and Harbour.Crane and Harbour__POA.Crane
assert SDOPackage.NameValue and not hasattr(SDOPackage, "Berth")
berth = Harbour.Berth
stubs.load({str(made)!r}, ["SDOPackage"])
assert Harbour.Berth is berth
"""
    run = python(code, rtm_environment)
    assert (run.returncode, run.stderr) == (0, "")


def test_text_beyond_latin_needs_the_orbs_code_set(
    reopening: Path, reference: Path, rtm_environment: dict[str, str]
) -> None:
    text = """
import sys
sys.path.insert(0, {out!r})
from omniORB import CORBA, cdrMarshal, findTypeCode
CORBA.ORB_init(["test", *{options!r}])
from rtgen.runtime.opaque_rpc import OpaqueRpc
from rtgen.runtime.openrtm import stubs
stubs.load({stubs!r}, ["BasicDataType"])
from rtgen.runtime.openrtm.conversions import conversions_of
from refrobots.rtc import TimedString
value = TimedString(data="ロボット")
conversions = conversions_of(TimedString._descriptor_)
sent = conversions.to(value)
assert cdrMarshal(findTypeCode("IDL:RTC/TimedString:1.0"), sent, 1) == value.to_cdr()
assert conversions.of(sent) == value
"""
    places = {"out": str(reference), "stubs": str(reopening)}
    with_utf_8 = ["-ORBnativeCharCodeSet", "UTF-8"]
    run = python(text.format(options=with_utf_8, **places), rtm_environment)
    assert (run.returncode, run.stderr) == (0, "")
    run = python(text.format(options=[], **places), rtm_environment)
    assert run.returncode == 1
    assert "DATA_CONVERSION" in run.stderr


def test_missing_stubs_are_reported(orb: Any, tmp_path: Path) -> None:
    with pytest.raises(
        StubsMissingError, match=r"no stub of never\.idl.*idlcompile\.sh"
    ):
        stubs.load(tmp_path, ["never"])
    with pytest.raises(StubsMissingError, match=r"no stub of IDL:Never:1\.0; run"):
        class_of("IDL:Never:1.0")
    (tmp_path / "faulty_idl.py").write_text("import something_else_that_is_missing\n")
    importlib.invalidate_caches()
    with pytest.raises(ModuleNotFoundError, match="something_else"):
        stubs.load(tmp_path, ["faulty"])
