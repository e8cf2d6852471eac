"""The emitted `RTC.xml` by the rules of the RtcProfile schema, version 0.3."""

import re
from pathlib import Path

import pytest
from component_models import (
    BOOLEAN,
    DOUBLE,
    DOUBLES,
    LONG,
    MODE,
    OPTIONS,
    STRING,
    component,
    model,
    parameter,
    port,
)
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree
from profile_rules import NAMESPACES, check_schema

from rtgen.compiler.backends.profiles.rtc_profile import BACKEND
from rtgen.compiler.model import (
    Component,
    EnumeratorName,
    Primitive,
    PrimitiveType,
    SequenceType,
    Type,
)

GOLDEN = Path(__file__).resolve().parents[4] / "shared/golden/rtc_profiles/rtc"


def text_of(item: Component) -> str:
    emission = BACKEND.emit(model(item), OPTIONS)
    assert not emission.diagnostics
    (artifact,) = emission.artifacts
    return artifact.text


def profile(item: Component) -> etree._Element:
    root = etree.fromstring(text_of(item).encode())
    check_schema(root)
    return root


def local(element: etree._Element) -> str:
    return etree.QName(element).localname


def one(root: etree._Element, path: str) -> etree._Element:
    (found,) = root.findall(path, NAMESPACES)
    return found


def attributes(element: etree._Element) -> dict[str, str]:
    return {key.rpartition("}")[2]: value for key, value in element.attrib.items()}


def test_basic_info() -> None:
    root = profile(
        component(
            doc='Stops <it> & "goes".\nSecond line.',
            description="A brake",
            rate=50.0,
            max_instances=0,
            version="1.2.0",
            created="2025-01-10T09:00:00+00:00",
            updated="2025-02-11T10:30:00.250+00:00",
        )
    )
    assert attributes(root)["id"] == "RTC:Lab:Move:Limiter:1.2.0"
    info = one(root, "rtc:BasicInfo")
    found = attributes(info)
    assert found["executionRate"] == "50.0"
    assert found["maxInstances"] == "0"
    assert found["description"] == "A brake"
    assert found["creationDate"] == "2025-01-10T09:00:00+00:00"
    assert found["updateDate"] == "2025-02-11T10:30:00.250+00:00"
    documented = attributes(one(info, "rtcDoc:Doc"))
    assert documented["description"] == 'Stops <it> & "goes".<br/>Second line.'
    assert attributes(one(root, "rtc:Language"))["kind"] == "Python"


def test_actions_are_those_of_the_skeleton() -> None:
    actions = one(profile(component()), "rtc:Actions")
    implemented = {local(a) for a in actions if attributes(a)["implemented"] == "true"}
    assert implemented == {"OnInitialize", "OnActivated", "OnDeactivated", "OnExecute"}
    assert len(actions) == 12


@pytest.mark.parametrize(
    ("type_", "default", "word", "text"),
    [
        (DOUBLE, 0.5, "double", "0.5"),
        (PrimitiveType(Primitive.FLOAT), None, "float", "0.0"),
        (LONG, 7, "int", "7"),
        (PrimitiveType(Primitive.SHORT), None, "short", "0"),
        (PrimitiveType(Primitive.UNSIGNED_SHORT), 1, "unsigned short int", "1"),
        (PrimitiveType(Primitive.UNSIGNED_LONG), 1, "unsigned int", "1"),
        (BOOLEAN, True, "bool", "1"),
        (BOOLEAN, None, "bool", "0"),
        (STRING, "a<b", "string", "a<b"),
        (DOUBLES, "1, 2", "std::vector<double>", "1, 2"),
        (SequenceType(LONG), None, "std::vector<int>", ""),
        (SequenceType(STRING), "a,b", "std::vector<std::string>", "a,b"),
        (MODE, EnumeratorName(("Safety", "DROP")), "string", "DROP"),
        (MODE, None, "string", "CLIP"),
    ],
)
def test_configuration_types(
    type_: Type, default: object, word: str, text: str
) -> None:
    root = profile(component(parameter("01_x", type_, default, identifier="x")))
    found = attributes(one(root, "rtc:ConfigurationSet/rtc:Configuration"))
    assert (found["name"], found["variableName"]) == ("01_x", "x")
    assert (found["type"], found["defaultValue"]) == (word, text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("100", "U(EqualTo 100)"),
        ("x>=5", "U(GreaterThanOrEqualTo 5)"),
        ("0<=x<=10", "U(Between(0 10))"),
        ("0<x<=10", "U(And(U(GreaterThan 0) U(LessThanOrEqualTo 10)))"),
        ("(1,2)", "U(Or(U(EqualTo 1) U(EqualTo 2)))"),
        ("x<1,x>=2", "List(U(LessThan 1) U(GreaterThanOrEqualTo 2))"),
        ("{k:x<1,j:3}", "Hash(U[k](LessThan 1) U[j](EqualTo 3))"),
    ],
)
def test_constraint_trees(text: str, expected: str) -> None:
    type_ = DOUBLES if text.startswith(("x<1,", "{")) else LONG
    item = parameter("a", type_, None, constraint=text)
    if type_ is LONG:
        item = parameter(
            "a", type_, {"100": 100, "x>=5": 5}.get(text, 1), constraint=text
        )
    root = profile(component(item))
    configuration = one(root, "rtc:ConfigurationSet/rtc:Configuration")
    assert short_form(one(configuration, "rtc:Constraint")) == expected
    assert attributes(one(configuration, "rtcDoc:Doc"))["constraint"] == text


def short_form(constraint: etree._Element) -> str:
    (kind,) = constraint
    if local(kind) != "ConstraintUnitType":
        name = local(kind).removeprefix("Constraint").removesuffix("Type")
        return f"{name}({' '.join(map(short_form, kind))})"
    (unit,) = kind
    key = attributes(kind).get("key")
    head = "U" if key is None else f"U[{key}]"
    name = local(unit).removeprefix("propertyIs")
    if local(unit) in ("And", "Or"):
        inner = f"{name}({' '.join(map(short_form, unit))})"
    elif name == "Between":
        inner = f"{name}({' '.join(str(end.text) for end in unit)})"
    else:
        inner = f"{name} {unit[0].text}"
    return f"{head}({inner})"


def test_bounds_and_enums_give_constraints_too() -> None:
    root = profile(
        component(
            parameter("low", DOUBLE, minimum=0.0),
            parameter("both", LONG, minimum=0, maximum=3),
            parameter("mode", MODE),
            parameter("free", LONG),
        )
    )
    found = {
        attributes(c)["name"]: [
            short_form(e) for e in c.findall("rtc:Constraint", NAMESPACES)
        ]
        for c in one(root, "rtc:ConfigurationSet")
    }
    assert found == {
        "low": ["U(GreaterThanOrEqualTo 0.0)"],
        "both": ["U(Between(0 3))"],
        "mode": ["U(Or(U(EqualTo CLIP) U(EqualTo DROP)))"],
        "free": [],
    }


def test_widget() -> None:
    root = profile(
        component(
            parameter("a", DOUBLE, minimum=0.0, maximum=1.0, widget="slider.0.05"),
            parameter("b", DOUBLE),
        )
    )
    found = [attributes(p) for p in root.iter("{*}Properties")]
    assert [each for each in found if each["name"] == "__widget__"] == [
        {"name": "__widget__", "value": "slider.0.05"},
        {"name": "__widget__", "value": "text"},
    ]


def test_data_ports() -> None:
    root = profile(
        component(
            port("inport", ".positon", identifier="positon", unit="m", doc="Where."),
            port("outport", "status", identifier="status_out"),
            port("inport", "status", identifier="status_in"),
        )
    )
    found = [attributes(p) for p in root.findall("rtc:DataPorts", NAMESPACES)]
    kinds = [
        (p["name"], p["variableName"], p["portType"], p["position"]) for p in found
    ]
    assert kinds == [
        (".positon", "positon", "DataInPort", "LEFT"),
        ("status", "status_out", "DataOutPort", "RIGHT"),
        ("status", "status_in", "DataInPort", "LEFT"),
    ]
    assert {(p["type"], p["idlFile"]) for p in found} == {
        ("RTC::TimedLong", "Types.idl")
    }
    assert [p["unit"] for p in found] == ["m", "", ""]
    assert (
        attributes(root.findall("rtc:DataPorts/rtcDoc:Doc", NAMESPACES)[0])[
            "description"
        ]
        == "Where."
    )


def test_interfaces_are_grouped_by_service_port() -> None:
    root = profile(
        component(
            port("provider", "brake", "Safety::Brake", port="Safety", instance="brake"),
            port("consumer", "alone", "Component"),
            port("consumer", "log", "Component", port="Safety"),
        )
    )
    ports = root.findall("rtc:ServicePorts", NAMESPACES)
    assert [attributes(p)["name"] for p in ports] == ["Safety", "alone"]
    assert [attributes(p)["position"] for p in ports] == ["LEFT", "RIGHT"]
    inner = [
        attributes(i) for i in ports[0].findall("rtc:ServiceInterface", NAMESPACES)
    ]
    assert [(i["name"], i["direction"], i["type"]) for i in inner] == [
        ("brake", "Provided", "Safety::Brake"),
        ("Component", "Required", "Component"),
    ]
    assert {i["idlFile"] for i in inner} == {"Safety.idl"}


def test_header_comes_after_the_declaration() -> None:
    text = text_of(component())
    assert text.startswith(
        '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n<!--\n'
    )
    assert "0.1.0 from specs/Limiter.idl.\n" in text


TEXT = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Cn", "Co"])
    | st.sampled_from("\t\n<>&\"'")
)


@given(TEXT, TEXT, TEXT)
def test_any_text_survives(description: str, unit: str, default: str) -> None:
    item = component(
        port("inport", "a", unit=unit),
        parameter("s", STRING, default),
        description=description or "x",
    )
    root = profile(item)
    assert attributes(one(root, "rtc:BasicInfo"))["description"] == (description or "x")
    assert attributes(one(root, "rtc:DataPorts"))["unit"] == unit
    (configuration,) = one(root, "rtc:ConfigurationSet")
    assert attributes(configuration)["defaultValue"] == default


def test_ids() -> None:
    assert re.fullmatch(r"RTC:Lab:Move:Limiter:1\.0\.0", component().profile_id)


def test_nothing_is_written_that_real_profiles_do_not_have() -> None:
    if not GOLDEN.is_dir():
        pytest.skip(f"no real profiles at {GOLDEN}")
    known: set[tuple[str, str]] = set()
    for path in sorted(GOLDEN.glob("*.xml")):
        root = etree.parse(path, etree.XMLParser(resolve_entities=False)).getroot()
        known |= {(str(e.tag), str(key)) for e in root.iter("{*}*") for key in e.attrib}
    ours = profile(
        component(
            port("inport", "a", unit="m"),
            port("provider", "b", "Safety::Brake", port="P"),
            parameter("c", DOUBLE, 1.0, constraint="0<=x<=2", widget="slider.1"),
        )
    )
    written = {(str(e.tag), str(key)) for e in ours.iter("{*}*") for key in e.attrib}
    assert written - known == set()
