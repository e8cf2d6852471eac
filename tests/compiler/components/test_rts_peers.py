"""Systems survive a round trip through rtsprofile, the library of rtshell."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace
from rts_rules import broken_rules
from test_rts_keeping import RECORDED, ROOT, SYSTEMS, lost, read, recorded

from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml
from rtgen.compiler.model import System

RtsProfile = pytest.importorskip(
    "rtsprofile.rts_profile", reason="rtsprofile-aist is not installed"
).RtsProfile


def meaning(system: System) -> tuple[object, ...]:
    """Return the content of a system without positions."""
    return (
        *(system.id, system.abstract, system.created, system.updated),
        [
            (c.instance, c.id, c.path_uri, c.rate, c.active_set, c.location, c.required)
            for c in system.components
        ],
        [
            sorted((name, sorted(values)) for name, values in c.configuration)
            for c in system.components
        ],
        sorted(
            (c.name, c.id, str(c.source), str(c.target), sorted(c.properties))
            for c in system.connections
        ),
        [replace(step, sequence=0) for step in system.activation],
        sorted(system.properties),
    )


def through_xml(text: str) -> str:
    return str(RtsProfile(xml_spec=text).save_to_xml())


def to_yaml(text: str) -> str:
    return str(RtsProfile(xml_spec=text).save_to_yaml())


def of_yaml(text: str) -> str:
    return str(RtsProfile(yaml_spec=text).save_to_xml())


def check(source: bytes) -> None:
    ours = system_text(read(source))
    expected = meaning(read(ours))
    theirs = through_xml(ours)
    assert meaning(read(theirs)) == expected
    again = system_text(read(theirs))
    assert broken_rules(again) == []
    assert {x for x in lost(theirs, again) if "@direction=" not in x} == set()
    yaml = to_yaml(ours)
    assert meaning(read(yaml, "s.yaml")) == expected
    made = profile_yaml.to_yaml(located_xml.parse(ours, "s.xml"))
    assert meaning(read(of_yaml(made))) == expected


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "path", SYSTEMS, ids=lambda path: path.relative_to(ROOT / "specs").as_posix()
)
def test_systems_of_the_specs(path: Path) -> None:
    check(path.read_bytes())


@pytest.mark.skipif(not recorded(), reason=f"{RECORDED} is missing")
def test_recorded_systems() -> None:
    for path in recorded():
        data = path.read_bytes()
        # rtsprofile 4.1.6 cannot read YAML with a version log: it calls append of a str.
        if b"VersionUpLogs" not in data:
            check(data)
