"""Types of interfaces are registered by their original names."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from rtgen.cli import run

SERVICE = (
    "module SimpleService { interface MyService { void set(in float value); }; };\n"
)
COMPONENTS = """\
#include "services.idl"
@rtc(category="Lab", vendor="me") component Server {
    @port("serves") @instance("s") provides SimpleService::MyService mine;
};
@rtc(category="Lab", vendor="me") component Asker {
    @port("asks") @instance("s") @type_name("MyService") uses SimpleService::MyService yours;
};
"""
SYSTEM = """\
<rts:RtsProfile rts:id="RTSystem:me:pair:1" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
  <rts:Components rts:id="RTC:me:Lab:Server:1.0.0" rts:instanceName="Server0"/>
  <rts:Components rts:id="RTC:me:Lab:Asker:1.0.0" rts:instanceName="Asker0"/>
  <rts:ServicePortConnectors>
    <rts:sourceServicePort rts:instanceName="Asker0" rts:portName="Asker0.asks"/>
    <rts:targetServicePort rts:instanceName="Server0" rts:portName="Server0.serves"/>
    <rtsExt:Properties rtsExt:name="Asker0.port.asks.required.MyService.s"
        rtsExt:value="Server0.port.serves.provided.SimpleService::MyService.s"/>
  </rts:ServicePortConnectors>
</rts:RtsProfile>
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with the definitions of two components and a system."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "services.idl").write_text(SERVICE)
    (tmp_path / "parts.idl").write_text(COMPONENTS)
    (tmp_path / "pair.xml").write_text(SYSTEM)
    return tmp_path


def converted(
    capsys: pytest.CaptureFixture[str], file: str, component: str, form: str
) -> str:
    capsys.readouterr()
    assert run(["convert", file, "--component", component, "--to", form, "-q"]) == 0
    return capsys.readouterr().out


def registered(kind: str, module: str) -> list[str]:
    """Return instance name and type name of a module's only interface of a kind."""
    [found] = re.findall(rf'register{kind}\(\s*"(.*?)",\s*"(.*?)"', module)
    return list(found)


def test_a_profile_keeps_the_name(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = converted(capsys, "parts.idl", "Server", "rtc-xml")
    scoped = 'rtc:type="SimpleService::MyService"'
    assert scoped in profile
    # As the author of a component without rtgen has written it.
    foreign = profile.replace(scoped, 'rtc:type="MyService"')
    (folder / "foreign.xml").write_text(foreign, encoding="utf-8")
    idl = converted(capsys, "foreign.xml", "Server", "idl")
    assert '@type_name("MyService")' in idl
    assert "provides SimpleService::MyService mine;" in idl
    (folder / "again.idl").write_text(idl, encoding="utf-8")
    again = converted(capsys, "again.idl", "Server", "rtc-xml")
    assert 'rtc:type="MyService"' in again
    (folder / "again.xml").write_text(again, encoding="utf-8")
    assert converted(capsys, "again.xml", "Server", "idl") == idl


def test_an_edited_type_wins(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "services.idl").write_text(SERVICE + "interface Other { void f(); };\n")
    profile = converted(capsys, "parts.idl", "Asker", "rtc-xml")
    assert 'rtc:type="MyService"' in profile
    edited = profile.replace('rtc:type="MyService"', 'rtc:type="Other"')
    (folder / "edited.xml").write_text(edited, encoding="utf-8")
    assert "uses Other yours;" in converted(capsys, "edited.xml", "Asker", "idl")


def test_modules_and_systems_use_the_name(folder: Path) -> None:
    arguments = ["generate", "parts.idl", "pair.xml", "--target", "openrtm", "-q"]
    assert run(arguments) == 0
    made = folder / "generated/openrtm"
    server = (made / "Server/Server.py").read_text(encoding="utf-8")
    asker = (made / "Asker/Asker.py").read_text(encoding="utf-8")
    assert registered("Provider", server) == ["s", "SimpleService::MyService"]
    assert registered("Consumer", asker) == ["s", "MyService"]
    [connection] = runpy.run_path(str(made / "pair/connect.py"))["SYSTEM"].connections
    assert connection.properties == {
        "port.connection.strictness": "strict",
        "Asker0.port.asks.required.MyService.s": (
            "Server0.port.serves.provided.SimpleService::MyService.s"
        ),
    }
