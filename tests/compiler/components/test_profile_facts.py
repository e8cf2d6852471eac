"""Properties `rtgen.definition` with values of a wrong kind: a warning, never a crash."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.profiles import rtc_profile
from rtgen.compiler.lowering.profiles.lower import lower
from rtgen.compiler.lowering.settings import Settings

KEYS = (
    *("name", "port", "instance", "identifier", "type", "constraint", "widget", "doc"),
    *("repository_id", "base", "description", "kind", "execution", "version", "vendor"),
    *("category", "supports", "files", "order", "annotations", "min", "max", "default"),
)
VALUES: tuple[Any, ...] = (
    *([], ["a"], [[]], {}, {"a": 1}, 5, 1.5, True, None, "", "x", [{"name": []}]),
)
PROFILE = """\
<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:Lab:Test:{name}:1.0.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="{name}" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="Test" rtc:vendor="Lab"
      rtc:version="1.0.0" rtc:executionType="PeriodicExecutionContext" rtc:executionRate="10.0"
      rtc:maxInstances="1">{facts}</rtc:BasicInfo>
  <rtc:ConfigurationSet>
    <rtc:Configuration rtc:name="a" rtc:type="int" rtc:defaultValue="1">{facts}</rtc:Configuration>
  </rtc:ConfigurationSet>
  <rtc:DataPorts rtc:name="in" rtc:portType="DataInPort" rtc:type="RTC::TimedLong">{facts}
  </rtc:DataPorts>
  <rtc:ServicePorts rtc:name="s">{interfaces}
    <rtc:ServiceInterface rtc:name="i" rtc:direction="Provided" rtc:type="I"
        rtcExt:variableName="i"/>
  </rtc:ServicePorts>
</rtc:RtcProfile>
"""


def written(facts: object) -> str:
    value = quoteattr(json.dumps(facts))
    return f'<rtcExt:Properties rtcExt:name="rtgen.definition" rtcExt:value={value}/>'


@pytest.mark.sampled(8)
@pytest.mark.parametrize("key", KEYS)
def test_kinds(key: str, tmp_path: Path) -> None:
    paths = []
    for number, value in enumerate(VALUES):
        facts = written({key: value})
        path = tmp_path / f"{number}.xml"
        text = PROFILE.format(
            name=f"Part{number}",
            facts=facts,
            interfaces=written({"i": {key: value}} if number % 2 else {"i": value}),
        )
        path.write_text(text)
        paths.append(path)
    read = rtc_profile.load(paths, root=tmp_path, include=())
    result = lower(read.model, Settings())
    found = (*read.diagnostics, *result.diagnostics)
    assert all(d.severity is not Severity.ERROR for d in found)
    diagnostics = [d for d in found if d.code == "RTC0546"]
    assert diagnostics
    assert all(d.span is not None for d in diagnostics)
    names = {d.name[-1] for d in result.model.declarations}
    assert {f"Part{number}" for number in range(len(VALUES))} <= names
