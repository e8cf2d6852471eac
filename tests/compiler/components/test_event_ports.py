"""EventPorts of RtcProfile 0.3: from IDL to a profile and back."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree

from rtgen.cli import run

IDL = """\
#include "BasicDataType.idl"

@rtc(category="Test", vendor="Lab", activity="EVENTDRIVEN")
component Lamp {
    @event_port
    @event(name="press", source="Off", target="On", condition="x < 1", type="RTC::TimedLong")
    @event(name="release", source="On", target="Off")
    consumes RTC::TimedLong buttons;
    @event_port
    consumes RTC::TimedLong plain;
    publishes RTC::TimedLong light;
};
"""
RTC = "{http://www.openrtp.org/namespaces/rtc}"
SPECS = Path(__file__).resolve().parents[3] / "specs/idl"


def converted(
    file: Path, to: str, capfd: pytest.CaptureFixture[str], name: str
) -> Path:
    assert run(["convert", str(file), "--to", to, "-I", str(SPECS), "-q"]) == 0
    out = file.with_name(name)
    out.write_text(capfd.readouterr().out, encoding="utf-8")
    return out


def test_there_and_back(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "Lamp.idl"
    file.write_text(IDL, encoding="utf-8")
    profile = converted(file, "rtc-xml", capfd, "RTC.xml")
    ports = etree.parse(profile).getroot().findall(f"{RTC}DataPorts")
    kinds = [(p.get(f"{RTC}name"), p.get(f"{RTC}portType")) for p in ports]
    assert kinds == [
        ("buttons", "EventPort"),
        ("plain", "EventPort"),
        ("light", "DataOutPort"),
    ]
    events = [
        {key.removeprefix(RTC): text for key, text in event.attrib.items()}
        for event in ports[0].findall(f"{RTC}Event")
    ]
    assert events == [
        {
            "name": "press",
            "source": "Off",
            "target": "On",
            "condition": "x < 1",
            "type": "RTC::TimedLong",
        },
        {
            "name": "release",
            "source": "On",
            "target": "Off",
            "condition": "",
            "type": "",
        },
    ]
    idl = converted(profile, "idl", capfd, "Again.idl")
    again = converted(idl, "rtc-xml", capfd, "Again.xml")
    without_header = [
        etree.tostring(etree.parse(p).getroot(), method="c14n")
        for p in (profile, again)
    ]
    assert without_header[0] == without_header[1]
    yaml = converted(profile, "rtc-yaml", capfd, "Lamp.yaml")
    from_yaml = converted(yaml, "rtc-xml", capfd, "Yaml.xml")
    assert [
        dict(e.attrib) for e in etree.parse(from_yaml).getroot().iter(f"{RTC}Event")
    ] == [dict(e.attrib) for e in etree.parse(profile).getroot().iter(f"{RTC}Event")]


@pytest.mark.sampled(6)
@pytest.mark.parametrize("word", ["Any", "any", "CORBA::Any"])
@pytest.mark.parametrize(
    ("events", "type_"),
    [
        (["RTC::TimedLong", ""], "RTC::TimedLong"),
        (["TimedLong", "TimedLong"], "RTC::TimedLong"),
        (["mine::Event"], "mine::Event"),
        (["RTC::TimedLong", "RTC::TimedDouble"], "_Any"),
        (["", ""], "_Any"),
        ([], "_Any"),
    ],
)
def test_a_port_of_any_has_the_type_of_its_events(
    word: str,
    events: list[str],
    type_: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "idl").mkdir()
    (tmp_path / "idl/mine.idl").write_text("module mine { struct Event { long n; }; };")
    file = tmp_path / "Lamp.idl"
    file.write_text(IDL, encoding="utf-8")
    profile = converted(file, "rtc-xml", capfd, "RTC.xml")
    tree = etree.parse(profile)
    [port, *_] = tree.getroot().findall(f"{RTC}DataPorts")
    port.set(f"{RTC}type", word)
    port.set(f"{RTC}idlFile", "")
    for event in port.findall(f"{RTC}Event"):
        port.remove(event)
    for number, each in enumerate(events):
        made = etree.SubElement(port, f"{RTC}Event")
        made.set(f"{RTC}name", f"e{number}")
        made.set(f"{RTC}type", each)
    tree.write(profile)
    assert run(["convert", str(profile), "--to", "idl"]) == 0
    out, err = capfd.readouterr()
    assert f"consumes {type_} buttons;" in out
    assert not err


def test_the_type_of_events_that_is_not_found_is_named(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "Lamp.idl"
    file.write_text(IDL, encoding="utf-8")
    profile = converted(file, "rtc-xml", capfd, "RTC.xml")
    text = profile.read_text(encoding="utf-8").replace("RTC::TimedLong", "Any", 1)
    first, rest = text.split("<rtc:Event ", 1)
    rest = rest.replace("RTC::TimedLong", "gone::Event", 1)
    profile.write_text(f"{first}<rtc:Event {rest}", encoding="utf-8")
    assert run(["convert", str(profile), "--to", "idl"]) == 0
    assert (
        "gone::Event, which BasicDataType.idl declares, is not found"
        in capfd.readouterr().err
    )
