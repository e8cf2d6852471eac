"""The IDL files of a profile are found by the names in it, else by the types of its ports."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rtgen.cli import run as rtgen
from rtgen.compiler.frontends.idl.text import installed
from rtgen.compiler.kit.resources import idl_source

PROFILE = """\
<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:me:Test:Arm:1.0.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="Arm" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="Test" rtc:description=""
      rtc:executionRate="100.0" rtc:executionType="PeriodicExecutionContext"
      rtc:maxInstances="1" rtc:vendor="me" rtc:version="1.0.0"
      rtc:creationDate="2025-01-01T00:00:00.000+09:00"
      rtc:updateDate="2025-01-01T00:00:00.000+09:00"/>
  <rtc:DataPorts rtc:portType="DataInPort" rtc:name="joint" rtc:type="{type}"
      rtc:idlFile="{file}" rtc:interfaceType="" rtc:dataflowType="" rtc:subscriptionType=""
      rtc:unit=""/>
  <rtc:DataPorts rtc:portType="DataOutPort" rtc:name="count" rtc:type="RTC::TimedLong"
      rtc:idlFile="{file}" rtc:interfaceType="" rtc:dataflowType="" rtc:subscriptionType=""
      rtc:unit=""/>
  <rtc:ServicePorts rtc:name="solving">
    <rtc:ServiceInterface rtc:name="solver" rtc:direction="Provided" rtc:type="{service}"
        rtc:idlFile="{file}" rtc:path="" rtc:varname="" rtc:instanceName=""/>
  </rtc:ServicePorts>
</rtc:RtcProfile>
"""
KIN = """\
#include "BasicDataType.idl"
module Kin {
    struct TimedJoint { RTC::Time tm; double angle; };
    interface Solver { double solve(in TimedJoint given); };
};
"""
OTHER = """\
module Other {
    struct TimedJoint { long x; };
    interface Solver { void other(); };
};
"""
NAMES = ("", "Kin.idl", "C:\\\\rtc\\\\idl\\\\Lost.idl", "/home/somebody/idl/Lost.idl")


@pytest.fixture(autouse=True)
def nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """OpenRTM is not installed; the working folder is a project."""
    installed._folder.cache_clear()
    for name in ("RTM_IDL", "RTM_ROOT"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    project = tmp_path / "project"
    (project / "profiles").mkdir(parents=True)
    monkeypatch.chdir(project)


def profile(
    file: str, type_: str = "Kin::TimedJoint", service: str = "Kin::Solver"
) -> None:
    text = PROFILE.format(type=type_, file=file, service=service)
    Path("profiles/RTC.xml").write_text(text)
    settings = '[sources]\npaths = ["profiles"]\n[output]\npackage = "arms"\n'
    Path("rtgen.toml").write_text(settings)


def generated(*options: str) -> str:
    """Generate; return the module of the component's base."""
    assert rtgen(["generate", *options]) == 0
    return Path("generated/arms/components/arm/__init__.py").read_text()


def is_complete(text: str) -> bool:
    return "kin.TimedJoint)" in text and "provider(kin.Solver" in text and kin_is_read()


def kin_is_read() -> bool:
    """Return whether the types are those of the IDL file, not opaque ones."""
    file = Path("generated/arms/_idl/kin.py")
    return file.exists() and "angle" in file.read_text()


def in_idl() -> list[str]:
    Path("idl").mkdir()
    Path("idl/Kin.idl").write_text(KIN)
    return []


def beside() -> list[str]:
    Path("profiles/Kin.idl").write_text(KIN)
    return []


def in_idl_beside() -> list[str]:
    Path("profiles/idl").mkdir()
    Path("profiles/idl/Kin.idl").write_text(KIN)
    return []


def in_an_include_folder() -> list[str]:
    Path("further").mkdir()
    Path("further/Kin.idl").write_text(KIN)
    return ["-I", "further"]


def among_the_sources() -> list[str]:
    Path("mine").mkdir()
    Path("mine/Kin.idl").write_text(KIN)
    text = Path("rtgen.toml").read_text().replace('"profiles"', '"profiles", "mine"')
    Path("rtgen.toml").write_text(text)
    return []


PLACES = [in_idl, beside, in_idl_beside, in_an_include_folder, among_the_sources]


@pytest.mark.sampled(7)
@pytest.mark.parametrize("file", NAMES)
@pytest.mark.parametrize("place", PLACES)
def test_each_place(
    place: Callable[[], list[str]], file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    profile(file)
    options = place()
    assert is_complete(generated(*options))
    assert "opaque" not in capsys.readouterr().err


def test_a_file_of_another_name_and_scope() -> None:
    profile("")
    in_idl()
    Path("idl/Kin.idl").rename("idl/Arms.idl")
    Path("idl/A.idl").write_text(OTHER)
    assert "kin.TimedJoint)" in generated()
    assert "angle" in Path("generated/arms/_idl/arms.py").read_text()


@pytest.mark.parametrize(
    ("type_", "service"), [("TimedJoint", "Solver"), ("Kin.TimedJoint", "Kin.Solver")]
)
def test_names_without_their_scope(type_: str, service: str) -> None:
    profile("", type_, service)
    in_idl()
    assert is_complete(generated())


def test_a_folder_of_openrtm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "rtm"
    folder.mkdir()
    (folder / "BasicDataType.idl").write_text(idl_source("BasicDataType.idl"))
    (folder / "Kin.idl").write_text(KIN)
    monkeypatch.setenv("RTM_IDL", str(folder))
    for file in NAMES:
        profile(file)
        assert is_complete(generated())


def test_sources_come_before_folders(capsys: pytest.CaptureFixture[str]) -> None:
    profile("")
    among_the_sources()
    in_idl()
    # Read as well, it would declare the types a second time, differently.
    Path("idl/Kin.idl").write_text(KIN.replace("double angle", "long angle"))
    assert is_complete(generated())
    assert "error" not in capsys.readouterr().err


def test_a_file_that_comes_later_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    profile("")
    assert not is_complete(generated())
    assert "warning[RTC0537]" in capsys.readouterr().err
    in_idl()
    assert is_complete(generated())


def test_files_without_the_types_are_not_read(
    capsys: pytest.CaptureFixture[str],
) -> None:
    profile("")
    in_idl()
    Path("idl/Broken.idl").write_text("module Broken { struct { ;\n")
    assert is_complete(generated())
    assert "error" not in capsys.readouterr().err
