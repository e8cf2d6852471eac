"""The model as JSON and as text, from a model made by hand."""

from __future__ import annotations

import json
from decimal import Decimal
from typing import Any

import pytest

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.inspection import indented_json
from rtgen.compiler.inspection.models import inspect, tree
from rtgen.compiler.model import (
    VOID,
    Annotation,
    ArrayType,
    Attribute,
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    Component,
    ConfigurationParameter,
    Connection,
    Const,
    Direction,
    Enum,
    Enumerator,
    EnumeratorName,
    ExceptionDecl,
    FixedType,
    Home,
    Interface,
    Member,
    Model,
    NamedType,
    Native,
    Operation,
    Parameter,
    Port,
    PortKind,
    PortReference,
    Primitive,
    PrimitiveType,
    SequenceType,
    SourceFile,
    StateMember,
    StringType,
    Struct,
    System,
    SystemComponent,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)

DOUBLE = PrimitiveType(Primitive.DOUBLE)
LONG = PrimitiveType(Primitive.LONG)


def at(line: int) -> dict[str, Any]:
    return {"span": Span("a.idl", line, 1, line, 2)}


def named(name: str, line: int) -> dict[str, Any]:
    parts = tuple(name.split("::"))
    return {
        **at(line),
        "name": parts,
        "repository_id": f"IDL:{'/'.join(parts)}:1.0",
        "file": "a.idl",
    }


COLOUR = NamedType(("M", "Colour"))
MEMBER = Member(
    **at(2),
    name="x",
    type=ArrayType(DOUBLE, (3, 4)),
    id=7,
    key=True,
    optional=True,
    doc="How far.",
)
OPERATION = Operation(
    **at(3),
    name="move",
    returns=VOID,
    parameters=(
        Parameter(**at(3), direction=Direction.INOUT, name="far", type=DOUBLE),
    ),
    raises=(("M", "Bad"),),
    oneway=True,
    context=("c",),
)
ATTRIBUTE = Attribute(
    **at(4), name="speed", type=DOUBLE, readonly=True, get_raises=(("M", "Bad"),)
)
PROFILE = System(
    name="Drive",
    id="RTSystem:v:Drive:1",
    file="s.xml",
    abstract="Drives.",
    components=(
        SystemComponent(
            **at(1),
            instance="A0",
            type="A",
            id="RTC:v:c:A:1",
            path_uri="",
            configuration=(("default", (("gain", "2"),)),),
        ),
    ),
    connections=(
        Connection(
            **at(1),
            name="wire",
            source=PortReference(instance="A0", port="out"),
            target=PortReference(instance="A0", port=".positon"),
            service=False,
            properties=(("dataport.dataflow_type", "push"),),
        ),
    ),
)
MODEL = Model(
    files=(SourceFile(name="a.idl", key="a.idl", sha256="0", main=True),),
    declarations=(
        Struct(**named("M::S", 1), members=(MEMBER,), base=("M", "Base")),
        ExceptionDecl(**named("M::Bad", 2), members=()),
        Enum(
            **named("M::Colour", 3), members=(Enumerator(**at(3), name="RED", value=0),)
        ),
        Union(
            **named("M::U", 4),
            switch=COLOUR,
            cases=(
                Case(
                    **at(4),
                    labels=(EnumeratorName(("M", "RED")),),
                    default=True,
                    name="r",
                    type=StringType(bound=16),
                ),
            ),
        ),
        Union(
            **named("M::C", 5),
            switch=PrimitiveType(Primitive.CHAR),
            cases=(
                Case(
                    **at(5),
                    labels=("a", "'", "\n", "é"),
                    default=False,
                    name="c",
                    type=LONG,
                ),
            ),
        ),
        Union(
            **named("M::B", 6),
            switch=PrimitiveType(Primitive.BOOLEAN),
            cases=(
                Case(**at(6), labels=(True, False), default=False, name="b", type=LONG),
            ),
        ),
        Union(
            **named("M::L", 6),
            switch=LONG,
            cases=(Case(**at(6), labels=(-3,), default=False, name="b", type=LONG),),
        ),
        Typedef(**named("M::T", 7), type=ArrayType(SequenceType(DOUBLE, 8), (3, 4))),
        Const(**named("M::INF", 8), type=DOUBLE, value=float("-inf")),
        Const(**named("M::F", 9), type=FixedType(5, 2), value=Decimal("1.50")),
        Const(**named("M::E", 9), type=COLOUR, value=EnumeratorName(("M", "RED"))),
        Const(**named("M::Y", 9), type=PrimitiveType(Primitive.BOOLEAN), value=True),
        Interface(
            **named("M::I", 10),
            bases=(("M", "J"),),
            operations=(OPERATION,),
            attributes=(ATTRIBUTE,),
        ),
        Valuetype(
            **named("M::V", 11),
            state=(StateMember(**at(11), name="s", type=LONG, public=True),),
            supports=(("M", "I"),),
            truncatable=True,
        ),
        Valuetype(**named("M::Happened", 12), eventtype=True),
        ValueBox(**named("M::Box", 13), type=LONG),
        Native(**named("M::N", 14)),
        Home(**named("M::H", 15), manages=("K",)),
        Bitset(
            **named("M::Bits", 16),
            members=(Bitfield(**at(16), name=None, bits=3, type=None),),
        ),
        Bitmask(
            **named("M::Mask", 17), members=(Enumerator(**at(17), name="f", value=4),)
        ),
        Component(
            **named("K", 18),
            annotations=(Annotation("rtc", (("rate", 100.0),)),),
            ports=(
                Port(
                    **at(19),
                    kind=PortKind.INPORT,
                    name=".positon",
                    identifier="from",
                    type=NamedType(("M", "S")),
                    doc="Where.",
                ),
            ),
            configuration=(
                ConfigurationParameter(
                    **at(20),
                    name="01_x",
                    identifier="x",
                    type=DOUBLE,
                    default=1.5,
                    minimum=0.0,
                    unit="m",
                    constraint="0.0<=x",
                ),
            ),
        ),
    ),
    systems=(PROFILE,),
)

SHOWN: dict[str, Any] = inspect(MODEL, [])
BY_NAME: dict[str, Any] = {d["name"]: d for d in SHOWN["declarations"]}


def test_the_whole_is_json_of_the_documented_form() -> None:
    assert list(SHOWN) == ["format", "files", "declarations", "diagnostics"]
    assert (SHOWN["format"], SHOWN["files"]) == ("rtgen-inspect/1", ["a.idl", "s.xml"])
    assert json.loads(json.dumps(SHOWN)) == SHOWN
    for d in SHOWN["declarations"]:
        assert {"kind", "name", "file", "line", "doc", "annotations"} <= set(d)


def test_struct() -> None:
    assert BY_NAME["M::S"] == {
        "kind": "struct",
        "name": "M::S",
        "file": "a.idl",
        "line": 1,
        "repository_id": "IDL:M/S:1.0",
        "base": "M::Base",
        "members": [
            {
                "name": "x",
                "type": "double[3][4]",
                "optional": True,
                "key": True,
                "id": 7,
                "initial": None,
                "doc": "How far.",
                "annotations": [],
            }
        ],
        "doc": "",
        "annotations": [],
    }
    assert BY_NAME["M::Bad"]["kind"] == "exception"


def test_union_labels() -> None:
    labels = {
        n: BY_NAME[n]["cases"][0]["labels"] for n in ("M::U", "M::C", "M::B", "M::L")
    }
    assert labels == {
        "M::U": ["M::RED", "default"],
        "M::C": ["'a'", r"'\''", r"'\n'", r"'\xe9'"],
        "M::B": ["TRUE", "FALSE"],
        "M::L": ["-3"],
    }
    assert BY_NAME["M::U"]["switch"] == "M::Colour"
    assert BY_NAME["M::U"]["cases"][0]["type"] == "string<16>"


def test_values_and_aliases() -> None:
    assert BY_NAME["M::T"]["type"] == "sequence<double,8>[3][4]"
    values = {n: BY_NAME[n]["value"] for n in ("M::INF", "M::F", "M::E", "M::Y")}
    assert values == {"M::INF": "-inf", "M::F": "1.50", "M::E": "M::RED", "M::Y": True}
    assert BY_NAME["M::Colour"]["members"] == ["RED"]


def test_interface_and_valuetypes() -> None:
    shown = BY_NAME["M::I"]
    assert (shown["bases"], shown["abstract"], shown["local"]) == (
        ["M::J"],
        False,
        False,
    )
    [operation] = shown["operations"]
    assert operation["returns"] == "void"
    assert operation["oneway"] is True
    assert operation["raises"] == ["M::Bad"]
    assert operation["context"] == ["c"]
    assert operation["parameters"][0]["direction"] == "inout"
    [attribute] = shown["attributes"]
    assert attribute["readonly"] is True
    assert attribute["get_raises"] == ["M::Bad"]
    value = BY_NAME["M::V"]
    assert (value["truncatable"], value["supports"]) == (True, ["M::I"])
    assert value["state"][0]["public"] is True
    assert value["factories"] == []
    assert BY_NAME["M::Happened"]["kind"] == "eventtype"
    assert BY_NAME["M::Box"]["type"] == "long"
    assert BY_NAME["M::N"]["kind"] == "native"
    assert BY_NAME["M::H"]["kind"] == "home"


def test_bits() -> None:
    assert BY_NAME["M::Bits"]["members"][0] == {
        "name": None,
        "bits": 3,
        "type": None,
        "initial": None,
        "doc": "",
        "annotations": [],
    }
    assert BY_NAME["M::Mask"]["members"][0]["position"] == 4


def test_component_and_system() -> None:
    shown = BY_NAME["K"]
    assert shown["repository_id"] == "IDL:K:1.0"
    assert (shown["base"], shown["supports"]) == (None, [])
    assert shown["annotations"] == [{"name": "rtc", "arguments": {"rate": 100.0}}]
    assert shown["ports"] == [
        {
            "kind": "inport",
            "name": ".positon",
            "type": "M::S",
            "python_name": "from_",
            "port": ".positon",
            "doc": "Where.",
            "annotations": [],
        }
    ]
    [parameter] = shown["configuration"]
    assert parameter["name"] == "01_x"
    assert parameter["python_name"] == "x"
    assert (parameter["default"], parameter["min"], parameter["max"]) == (
        1.5,
        0.0,
        None,
    )
    assert (parameter["unit"], parameter["constraint"]) == ("m", "0.0<=x")
    system = BY_NAME["Drive"]
    assert system["kind"] == "system"
    assert system["components"] == [
        {"instance": "A0", "type": "A", "configuration": {"default": {"gain": "2"}}}
    ]
    assert system["connections"] == [
        {
            "from": "A0.out",
            "to": "A0..positon",
            "properties": {"dataport.dataflow_type": "push"},
        }
    ]


def test_tree() -> None:
    text = tree(MODEL)
    assert text.startswith("a.idl\n  struct M::S: M::Base\n    x: double[3][4]\n")
    assert (
        "  union M::U switch (M::Colour)\n    M::RED, default: string<16> r\n" in text
    )
    assert "    oneway move(inout far: double): void\n" in text
    assert "    inport .positon: M::S\n    parameter 01_x: double = 1.5 [m]\n" in text
    assert text.endswith(
        "s.xml\n  system Drive\n    A0: A\n    A0.out -> A0..positon\n"
    )


@pytest.mark.parametrize(
    "value",
    [
        *(
            [],
            {},
            'a"\u00e9\n',
            1.5,
            None,
            [1, [], {}],
            {"a": {}},
            [[1], [[2]], {"b": [3]}],
        ),
        {"a": 1, "b": [], "c": [{"d": None, "e": [True]}, {}], "f": {"g": "\ud800"}},
    ],
)
def test_json_is_indented_as_the_standard_library_does(value: object) -> None:
    assert indented_json.dumps(value) == json.dumps(value, indent=2, ensure_ascii=False)
