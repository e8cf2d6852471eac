"""Content of a system's file outside of the model is kept when the system is saved."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree
from msgspec.structs import replace
from rts_rules import broken_rules

from rtgen.compiler.backends.profiles.rts_profile import InstancePorts, system_text
from rtgen.compiler.frontends.profiles import rts_profile
from rtgen.compiler.model import System

ROOT = Path(__file__).resolve().parents[3]
SYSTEMS = sorted(
    path
    for path in ROOT.glob("specs/**/*.xml")
    if b"RtsProfile" in path.read_bytes()[:2000]
)
RECORDED = ROOT.parent / "shared/golden/rtc_profiles/rts"
REFERENCES = ("inport_ior", "outport_ior", "inport_ref", "outport_ref")

HEAD = """<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<rts:RtsProfile xsi:type="rtsExt:rts_profile_ext" rts:id="RTSystem:Lab:Drive:1.0.0" \
rts:version="0.2" rts:abstract="Drive" rts:creationDate="2026-01-01T00:00:00" \
rts:updateDate="2026-01-02T00:00:00" rtsExt:comment="by hand" \
xmlns:rts="http://www.openrtp.org/namespaces/rts" \
xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
"""


def component(name: str, more: str = "", rate: str = "1000") -> str:
    return f"""<rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:Lab:Move:{name}:1.0.0"
        rts:instanceName="{name}0" rts:pathUri="robot.host_cxt/{name}0.rtc"
        rts:compositeType="PeriodicECShared" rts:isRequired="true"
        rts:activeConfigurationSet="default" rtsExt:visible="false" rtsExt:comment="old">
      <rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="{name}0.x" rtsExt:visible="false">
        <rtsExt:Properties rtsExt:name="port.port_type" rtsExt:value="DataInPort"/>
      </rts:DataPorts>
      <rts:ConfigurationSets rts:id="default">
        <rts:ConfigurationData rts:name="a" rts:data="1"/>
      </rts:ConfigurationSets>
      <rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" rts:kind="OTHER"
          rts:rate="{rate}">
        <rtsExt:Properties rtsExt:name="cpu" rtsExt:value="2"/>
      </rts:ExecutionContexts>
      <rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="1000"
          rts:kind="PERIODIC" rts:rate="2.0"/>
      <rtsExt:Location rtsExt:x="4" rtsExt:y="5" rtsExt:width="-1" rtsExt:height="-1"
          rtsExt:direction="LEFT"/>
      {more}<rtsExt:Properties rtsExt:name="vendor.colour" rtsExt:value="#0f0"/>
    </rts:Components>
"""


def reference(tag: str, name: str, more: str = "") -> str:
    kind = ' xsi:type="rtsExt:target_port_ext"' if tag.endswith("Port") else ""
    return (
        f'<rts:{tag}{kind} rts:componentId="RTC:Lab:Move:{name}:1.0.0" rts:instanceName="{name}0" '
        f"{more}/>"
    )


GROUP = f"""<rts:Groups rts:groupId="left">{reference("Members", "B")}</rts:Groups>
<rts:Groups rts:groupId="both">{reference("Members", "A")}{reference("Members", "B")}</rts:Groups>
"""
JOINED = f"""<rts:DataPortConnectors xsi:type="rtsExt:dataport_connector_ext"
      rts:connectorId="c-1" rts:name="c" rts:dataType="IDL:RTC/TimedLong:1.0"
      rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush"
      rts:pushInterval="5.0" rtsExt:visible="false">
    {reference("sourceDataPort", "A", 'rts:portName="A0.x"')}
    {reference("targetDataPort", "B", 'rts:portName="B0.x"')}
    <rtsExt:Properties rtsExt:name="dataport.interface_type" rtsExt:value="corba_cdr"/>
    <rtsExt:Properties rtsExt:name="dataport.corba_cdr.inport_ior" rtsExt:value="IOR:0"/>
    <rtsExt:Properties rtsExt:name="vendor.route" rtsExt:value="10,20"/>
  </rts:DataPortConnectors>
"""
STEPS = f"""<rts:Deactivation><rts:targets xsi:type="rtsExt:condition_ext" rts:sequence="1">
    <rts:WaitTime rts:waitTime="250"/>{reference("TargetComponent", "B", 'rts:id="1000"')}
  </rts:targets></rts:Deactivation>
"""
REST = """<rtsExt:VersionUpLogs>first</rtsExt:VersionUpLogs>
<rtsExt:VersionUpLogs>second</rtsExt:VersionUpLogs>
<rtsExt:Properties rtsExt:name="vendor.grid" rtsExt:value="8"/>
</rts:RtsProfile>
"""
WHOLE = HEAD + component("A") + component("B") + GROUP + JOINED + STEPS + REST


def read(text: str | bytes, file: str = "s.xml") -> System:
    data = text.encode() if isinstance(text, str) else text
    result = rts_profile.load_bytes(data, file)
    assert result.system is not None
    return result.system


def content(text: str | bytes) -> list[str]:
    """Return a line for each element, attribute and text, with its path from the root."""
    found: list[str] = []

    def add(element: etree._Element, way: str) -> None:
        name = etree.QName(element).localname
        # An element is identified by its names, so that siblings need no order.
        marks = ("id", "instanceName", "connectorId", "name", "groupId", "portName")
        given = {etree.QName(k).localname: v for k, v in element.attrib.items()}
        mark = next((given[key] for key in marks if key in given), "")
        here = f"{way}/{name}[{mark}]"
        found.append(here)
        found.extend(f"{here}@{key}={value}" for key, value in given.items())
        if (element.text or "").strip():
            found.append(f"{here}={element.text}")
        for child in element:
            if isinstance(child.tag, str):
                add(child, here)

    add(etree.fromstring(text.encode() if isinstance(text, str) else text), "")
    return sorted(line for line in found if not any(r in line for r in REFERENCES))


def lost(before: str | bytes, after: str) -> set[str]:
    return set(content(before)) - set(content(after))


def test_a_system_of_an_editor_is_the_same_after_any_number_of_saves() -> None:
    assert broken_rules(WHOLE) == []
    once = system_text(read(WHOLE))
    assert content(once) == content(WHOLE)
    assert broken_rules(once) == []
    assert system_text(read(once)) == once


def test_a_context_without_a_rate_may_say_zero() -> None:
    [a] = read(HEAD + component("A", rate="0.0") + REST).components
    assert a.rate is None


@pytest.mark.parametrize(
    "path", SYSTEMS, ids=lambda path: path.relative_to(ROOT / "specs").as_posix()
)
def test_systems_of_the_specs_lose_nothing(path: Path) -> None:
    before = path.read_bytes()
    after = system_text(read(before))
    assert lost(before, after) == set()
    assert broken_rules(after) == []


def recorded() -> list[Path]:
    return sorted(RECORDED.glob("*.xml"))


@pytest.mark.skipif(not recorded(), reason=f"{RECORDED} is missing")
def test_recorded_systems_lose_nothing() -> None:
    for path in recorded():
        before = path.read_bytes()
        once = system_text(read(before))
        assert lost(before, once) == set(), path.name
        assert broken_rules(once) == []
        assert system_text(read(once)) == once


def test_what_names_a_removed_component_goes_with_it() -> None:
    system = read(WHOLE)
    [a, _] = system.components
    smaller = replace(system, components=(a,), connections=())
    smaller = replace(smaller, activation=system.activation[:1])
    text = system_text(smaller)
    assert "B0" not in text
    assert 'groupId="both"' in text
    assert 'groupId="left"' not in text
    assert "Deactivation" not in text
    assert broken_rules(text) == []


def test_what_changed_is_written_and_the_rest_is_kept() -> None:
    system = read(WHOLE)
    [a, b] = system.components
    [joined] = system.connections
    values = (("default", (("a", "2"), ("b", "3"))),)
    moved = replace(a, location=(7, 8, -1, -1), configuration=values, rate=50.0)
    properties = dict(joined.properties) | {"dataport.subscription_type": "new"}
    del properties["vendor.route"]
    changed = replace(
        system,
        components=(moved, b),
        connections=(replace(joined, properties=tuple(properties.items())),),
        properties=(),
    )
    text = system_text(changed, {"A0": InstancePorts(("y",)), "B0": InstancePorts()})
    here = "/RtsProfile[RTSystem:Lab:Drive:1.0.0]"
    gone = "\n".join(sorted(lost(WHOLE, text)))
    assert "vendor.grid" in gone
    assert "vendor.route" in gone
    assert "A0.x]" in gone  # a port that the component no longer has
    assert "vendor.colour" not in gone
    lines = content(text)
    assert f"{here}/Components[RTC:Lab:Move:A:1.0.0]/Location[]@x=7" in lines
    assert f"{here}/Components[RTC:Lab:Move:A:1.0.0]/Location[]@direction=LEFT" in lines
    assert any(line.endswith("@rate=50.0") for line in lines)
    assert any(line.endswith("ConfigurationData[b]@data=3") for line in lines)
    assert any(line.endswith("@subscriptionType=new") for line in lines)
    assert broken_rules(text) == []


def test_elements_of_other_namespaces_are_kept() -> None:
    part = '<v:Note xmlns:v="urn:vendor" v:by="me">a &lt; b</v:Note>'
    text = HEAD + component("A", part) + REST
    once = system_text(read(text))
    assert content(once) == content(text)
    assert system_text(read(once)) == once
