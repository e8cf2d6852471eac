"""A profile of rtgen that was edited in RTCBuilder: edits are adopted, the rest is unchanged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from lxml import etree
from profile_rules import NAMESPACES, RULES, broken_rules
from random_components import FILES
from test_profile_round_trip import SPECS, Folder, declaration, told_of_profiles

from rtgen.compiler.model import Struct
from rtgen.tools.components.component_text import component_idl

ARM = """\
#include "BasicDataType.idl"
#include "Types.idl"
#include "Base.idl"
module Made {
/** Moves an arm. */
@rtc(category="Arms", vendor="Lab", version="1.2.0", rate=100.0, created="2024-01-02T03:04:05Z")
component Arm : Ancestor supports Lab::Log {
    /** Where it is. */
    @acme(1) @unit("rad")
    publishes RTC::TimedDouble angle;
    @port("Safety") @name("stop it") @acme
    provides Lab::Brake brake;
    @acme(x=2) @default(4) @range(min=1, max=9) @widget("slider.1") @unit("m")
    attribute octet steps;
    @default(Lab::DROP)
    attribute Lab::Mode mode;
    /** Four of them.
     *    indented
     */
    attribute Lab::Gains gains;
};
};
"""
Edit = Callable[[etree._Element], None]


@pytest.fixture(scope="module")
def folder() -> Iterator[Folder]:
    with TemporaryDirectory() as name:
        made = Folder(Path(name), (Path(name), SPECS / "idl"))
        for file, text in FILES.items():
            made.write(file, text)
        yield made


def key(name: str) -> str:
    prefix, _, local = name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def named(root: etree._Element, name: str) -> etree._Element:
    """Return the part of that name."""
    found = [e for e in root.iter("{*}*") if e.get(key("rtc:name")) == name]
    return found[-1]


def put(part: str, attribute: str, value: str) -> Edit:
    def edit(root: etree._Element) -> None:
        named(root, part).set(key(attribute), value)

    return edit


def document(part: str, value: str) -> Edit:
    def edit(root: etree._Element) -> None:
        doc = named(root, part).find("rtcDoc:Doc", NAMESPACES)
        assert doc is not None
        doc.set(key("rtcDoc:description"), value)

    return edit


def remove(part: str) -> Edit:
    def edit(root: etree._Element) -> None:
        element = named(root, part)
        parent = element.getparent()
        assert parent is not None
        parent.remove(element)

    return edit


def widget(part: str, value: str) -> Edit:
    def edit(root: etree._Element) -> None:
        for item in named(root, part).iterfind("rtcExt:Properties", NAMESPACES):
            if item.get(key("rtcExt:name")) == "__widget__":
                item.set(key("rtcExt:value"), value)

    return edit


def upper_bound(part: str, value: str) -> Edit:
    def edit(root: etree._Element) -> None:
        [bound] = named(root, part).iter(key("rtc:UpperBoundary"))
        bound.text = value

    return edit


def configuration(found: dict[str, Any], name: str) -> dict[str, Any]:
    [item] = [c for c in found["configuration"] if c["name"] == name]
    assert isinstance(item, dict)
    return item


def port(found: dict[str, Any], name: str) -> dict[str, Any]:
    [item] = [p for p in found["ports"] if p["name"] == name]
    assert isinstance(item, dict)
    return item


def argument(item: dict[str, Any], name: str) -> Any:
    """Return the argument of an annotation, None without it."""
    found = [a["arguments"] for a in item["annotations"] if a["name"] == name]
    return found[0].get("value", found[0]) if found else None


def edited(
    folder: Folder, edit: Edit
) -> tuple[dict[str, Any], dict[str, Any], list[str]]:
    """Return the declaration before and after an edit, and the diagnostics of reading."""
    model, component, _ = folder.read(folder.write("Arm.idl", ARM))
    root = etree.fromstring(folder.profile(model, component).encode())
    edit(root)
    text = etree.tostring(root, encoding="unicode")
    read, made, found = folder.read(folder.write("out/Arm.xml", text))
    after = declaration(read, made)
    again = folder.write("out/Arm.idl", component_idl(read, made))
    assert declaration(*folder.read(again)[:2]) == after
    return declaration(model, component), after, told_of_profiles(found)


def test_nothing_edited(folder: Folder) -> None:
    before, after, messages = edited(folder, lambda root: None)
    assert after == before
    assert messages == []


def same_but(before: dict[str, Any], after: dict[str, Any], *keys: str) -> bool:
    return all(before[k] == after[k] for k in before if k not in keys)


@pytest.mark.parametrize(
    ("edit", "field", "value", "annotation"),
    [
        (put("steps", "rtc:defaultValue", "7"), "default", 7, "default"),
        (put("steps", "rtc:unit", "cm"), "unit", "cm", "unit"),
        (document("steps", "So many.<br/>Or more."), "doc", "So many.\nOr more.", ""),
    ],
)
def test_a_parameter(
    folder: Folder, edit: Edit, field: str, value: object, annotation: str
) -> None:
    before, after, messages = edited(folder, edit)
    one, other = (configuration(found, "steps") for found in (before, after))
    assert other[field] == value
    assert same_but(one, other, field, "annotations")
    if annotation:
        assert argument(other, annotation) == value
    assert argument(other, "acme") == {"x": 2}
    assert argument(other, "range") == {"min": 1, "max": 9}
    assert same_but(before, after, "configuration")
    assert messages == []


def test_bounds(folder: Folder) -> None:
    _, after, messages = edited(folder, upper_bound("steps", "20"))
    found = configuration(after, "steps")
    assert (found["min"], found["max"]) == (None, None)
    assert found["constraint"] == argument(found, "constraint") == "1<=x<=20"
    assert argument(found, "range") is None
    assert found["type"] == "octet"
    assert messages == []


def test_the_type_of_a_parameter(folder: Folder) -> None:
    _, after, messages = edited(folder, put("steps", "rtc:type", "double"))
    found = configuration(after, "steps")
    assert (found["type"], found["default"]) == ("double", 4.0)
    assert messages == []


def test_an_enumeration(folder: Folder) -> None:
    _, after, _ = edited(folder, put("mode", "rtc:defaultValue", "KEEP"))
    found = configuration(after, "mode")
    assert (found["type"], found["default"]) == ("Lab::Mode", "Lab::KEEP")
    assert argument(found, "default") == "Lab::KEEP"
    _, after, messages = edited(folder, put("mode", "rtc:defaultValue", "GONE"))
    assert configuration(after, "mode")["default"] is None
    assert any("GONE" in message for message in messages)


def test_the_widget(folder: Folder) -> None:
    _, after, _ = edited(folder, widget("steps", "spin"))
    assert argument(configuration(after, "steps"), "widget") == "spin"


def test_names(folder: Folder) -> None:
    _, after, _ = edited(folder, put("steps", "rtc:name", "paces"))
    found = configuration(after, "paces")
    assert found["python_name"] == "steps"
    assert argument(found, "name") == "paces"
    _, after, _ = edited(folder, put("angle", "rtc:name", ".angle"))
    assert argument(port(after, ".angle"), "unit") == "rad"
    _, after, _ = edited(folder, put("Safety", "rtc:name", "Halt"))
    assert argument(port(after, "stop it"), "port") == "Halt"
    _, after, _ = edited(folder, put("Arm", "rtc:name", "Leg"))
    assert after["name"] == "Made::Leg"
    assert after["repository_id"] == "IDL:Made/Leg:1.0"


def test_a_port(folder: Folder) -> None:
    before, after, _ = edited(folder, put("angle", "rtc:type", "RTC::TimedFloat"))
    assert port(after, "angle")["type"] == "RTC::TimedFloat"
    assert argument(port(after, "angle"), "acme") == 1
    _, after, _ = edited(folder, put("angle", "rtc:portType", "DataInPort"))
    assert port(after, "angle")["kind"] == "inport"
    _, after, _ = edited(folder, remove("angle"))
    rest = [p for p in before["ports"] if p["name"] != "angle"]
    assert after["ports"] == rest


def test_the_component(folder: Folder) -> None:
    before, after, _ = edited(folder, put("Arm", "rtc:executionRate", "20.0"))
    rtc = argument(after, "rtc")
    assert rtc["rate"] == 20.0
    assert list(rtc) == list(argument(before, "rtc"))
    assert same_but(before, after, "annotations")
    _, after, _ = edited(folder, put("Arm", "rtc:description", "An arm"))
    assert argument(after, "rtc")["description"] == "An arm"
    _, after, _ = edited(folder, put("Arm", "rtc:abstract", "Other.<br/>Lines."))
    assert after["doc"] == "Other.\nLines."


def test_what_is_inherited(folder: Folder) -> None:
    edit = put("inherited_time", "rtc:defaultValue", "2.5")
    before, after, messages = edited(folder, edit)
    assert before["base"] == "Ancestor"
    assert after["base"] is None
    assert [p["name"] for p in after["ports"]] == [p["name"] for p in before["ports"]]
    assert configuration(after, "inherited_time")["default"] == 2.5
    assert any("Ancestor" in message for message in messages)


# The checker of the rules.


def broken(root: etree._Element) -> list[str]:
    return list(broken_rules(root))


def test_each_rule_can_be_broken(folder: Folder) -> None:
    model, component, _ = folder.read(folder.write("Arm.idl", ARM))
    root = etree.fromstring(folder.profile(model, component).encode())
    assert broken(root) == []
    count = 0
    for place, element in enumerate(root.iter("{*}*")):
        for attribute in element.attrib:
            changed = deepcopy(root)
            victim = list(changed.iter("{*}*"))[place]
            del victim.attrib[attribute]
            name = str(attribute).rpartition("}")[2]
            prefix = next(p for p, uri in NAMESPACES.items() if uri in str(attribute))
            local = etree.QName(element).localname
            rule = RULES.get(f"rtc:{local}") or RULES.get(f"rtcExt:{local}")
            needed = prefix == "xsi" or (
                rule is not None and f"!{prefix}:{name}" in rule.attributes
            )
            if needed:
                assert broken(changed), (local, attribute)
                count += 1
        if len(element) > 1 and element[0].tag != element[-1].tag:
            changed = deepcopy(root)
            victim = list(changed.iter("{*}*"))[place]
            victim.append(victim[0])
            assert broken(changed), element.tag
            count += 1
    assert count > 50
    for attribute, value in (
        ("rtc:componentType", "BIG"),
        ("rtc:activityType", "EVENT_DRIVEN"),
        ("rtc:creationDate", "2024-01-02"),
        ("rtc:executionRate", "fast"),
        ("rtc:maxInstances", "-1"),
        ("rtc:vendor", "Other"),
        ("rtc:colour", "red"),
    ):
        changed = deepcopy(root)
        put("Arm", attribute, value)(changed)
        assert broken(changed), attribute


def test_types_are_not_compared_with_each_other(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Thousands of unknown types take no longer than their text."""
    model, component, _ = folder.read(folder.write("Arm.idl", ARM))
    root = etree.fromstring(folder.profile(model, component).encode())
    port = named(root, "angle")
    for n in range(9):
        other = deepcopy(port)
        other.set(key("rtc:name"), f"p{n}")
        other.set(key("rtc:type"), f"Lab::Unknown{n}")
        port.addnext(other)
    many = folder.write("many/Arm.xml", etree.tostring(root, encoding="unicode"))
    model, component, _ = folder.read(many)

    def compared(one: object, other: object) -> bool:
        raise AssertionError("a declaration is compared as a whole")

    monkeypatch.setattr(Struct, "__eq__", compared)
    assert component_idl(model, component).count("@opaque") == 9
