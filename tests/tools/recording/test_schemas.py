"""Schemas: IDL of every type, read by rtgen and by independent parsers."""

from __future__ import annotations

import importlib
import json
import pkgutil
from pathlib import Path
from typing import Any

import pytest
from node import node
from rosbags.typesys import Stores, get_types_from_idl, get_typestore

import refrobots
from rtgen.compiler.typemap.idl_keywords import CORBA_3, RESERVED
from rtgen.runtime.marshalling.descriptors import (
    Descriptor,
    EnumDescriptor,
    PrimitiveDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.layouts.trees import parts
from rtgen.tools.recording.errors import SchemaError
from rtgen.tools.recording.schema_types import type_of
from rtgen.tools.recording.schemas import ENCODING, Schema, schema_of

EVERYTHING = """
module M {
    @bit_bound(8) enum E { A, @value(5) B };
    bitmask F { @position(2) x, y };
    bitset G { bitfield<3> a; bitfield<2>; bitfield<4,short> b; bitfield<1,boolean> c;
               bitfield<6>; };
    struct Node;
    typedef sequence<Node> Nodes;
    typedef long Grid[3][2];
    @mutable struct S {
        @id(3) @key long a; @optional string b; sequence<E,3> c; @external E z;
        map<string,G> m; Grid g; Grid h[2]; wstring<4> w;
    };
    @appendable union U switch (E) { case A: long n; default: S s; };
    struct Node { Nodes kids; U u; F f; long _struct; wchar wc; char ch; };
    union V switch (char) { case 'a': case 'b': octet x; default: boolean y; };
    @nested struct Top : Node { V v; long double ld; sequence<V> vs; };
};
"""


def port_types() -> list[Any]:
    """Return every struct and union of the reference build."""
    found = {}
    for module in pkgutil.walk_packages(refrobots.__path__, "refrobots."):
        for value in vars(importlib.import_module(module.name)).values():
            described = getattr(value, "_descriptor_", None)
            if (
                isinstance(described, StructDescriptor | UnionDescriptor)
                and "." not in described.name
            ):
                found[described.name] = value
    return list(found.values())


@pytest.mark.sampled(0)
def test_our_front_end_reads_every_schema_and_finds_the_same_type() -> None:
    types = port_types()
    assert len(types) > 150
    for type_ in types:
        schema = schema_of(type_._descriptor_)
        read = type_of(schema)
        assert schema_of(read._descriptor_) == schema
        assert read.from_cdr(type_().to_cdr()).to_cdr() == type_().to_cdr()


def test_a_type_with_everything_that_idl_has() -> None:
    type_ = type_of(Schema("M::Top", EVERYTHING))
    schema = schema_of(type_._descriptor_)
    assert schema_of(type_of(schema)._descriptor_) == schema
    for line in ("struct Node;", "@bit_bound(8)", "@id(3)", "bitfield<4,int8> b;"):
        assert line in schema.text
    assert "#" not in schema.text


def lacks(part: Descriptor) -> bool:
    """Return whether messages of ROS 2 cannot have it, or rosbags has no codec for it."""
    wide = PrimitiveDescriptor("wchar"), StringDescriptor(wide=True)
    return isinstance(part, EnumDescriptor) or part in wide


@pytest.mark.nightly
def test_rosbags_reads_every_schema_and_decodes_the_same_octets() -> None:
    decoded = 0
    for type_ in port_types():
        schema = schema_of(type_._descriptor_)
        if any(isinstance(p, UnionDescriptor) for p in parts(type_._descriptor_)):
            continue  # ROS 2 has no unions.
        found = get_types_from_idl(schema.text)
        name = schema.name.replace("::", "/")
        assert name in found or any(name.endswith(key) for key in found)
        if any(map(lacks, parts(type_._descriptor_))):
            continue
        store = get_typestore(Stores.EMPTY)
        store.register(found)
        octets = b"\0\1\0\0" + type_().to_xcdr1()
        message = store.deserialize_cdr(octets, name)
        assert bytes(store.serialize_cdr(message, name)[4:]) == octets[4:]
        decoded += 1
    assert decoded > 100


def by_foxglove(schemas: list[Schema]) -> list[dict[str, list[str]]]:
    """Return the names of types and members that Foxglove's parser finds in each schema."""
    package = Path(__file__).parents[3] / "ui" / "package.json"
    if not (package.parent / "node_modules" / "@foxglove").exists():
        pytest.skip("no @foxglove/omgidl-parser (`make page` installs it)")
    script = Path(__file__).with_name("foxglove_names.mjs")
    texts = json.dumps([schema.text for schema in schemas])
    found: list[dict[str, list[str]]] = json.loads(node(script, texts, str(package)))
    return found


def test_foxglove_reads_every_schema_and_finds_its_type() -> None:
    schemas = [schema_of(type_._descriptor_) for type_ in port_types()]
    schemas = [schema for schema in schemas if schema.encoding == ENCODING]
    assert len(schemas) > 100
    for schema, names in zip(schemas, by_foxglove(schemas), strict=True):
        assert schema.name in names


KEYWORDS = sorted(RESERVED | CORBA_3 | {"port", "connector", "bitset", "Component"})


def test_types_and_members_that_are_called_like_keywords_of_idl() -> None:
    schemas = []
    for word in KEYWORDS:
        text = (
            f"module M {{ struct _{word} {{ long a; }}; enum E {{ X, _{word}_x }};\n"
            f"struct User {{ _{word} one; double _{word}_; sequence<_{word}> two; E e; }};\n"
            f"union V switch (E) {{ case X: User _{word}; default: long y; }}; }};"
        )
        schema = schema_of(type_of(Schema("M::V", text))._descriptor_)
        assert schema_of(type_of(schema)._descriptor_) == schema
        schemas.append(schema)
    for word, names in zip(KEYWORDS, by_foxglove(schemas), strict=True):
        assert not {f"M::{word}", f"M::{word}_"}.isdisjoint(names)
        assert "M::V" in names
    assert schema_of(type_of(Schema("A", WORDS))._descriptor_).text.count("_") == 0


WORDS = (
    'struct A { @unit("in") long _context; long _attribute, _Object, _in, component; };'
)


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("A", "struct B { long x; };", "declares no A"),
        ("A", "struct A { long x }", "line 1 of the schema"),
        ("A", "typedef long A;", "is neither a struct nor a union"),
        ("A", "enum A { X };", "is neither a struct nor a union"),
        ("A", "struct A { long x; };" + " " * (1 << 20), "has over"),
        ("A", '#include "/etc/passwd"\nstruct A { long x; };', "of the schema"),
    ],
)
def test_a_wrong_schema_is_an_error(name: str, text: str, what: str) -> None:
    with pytest.raises(SchemaError, match=what):
        type_of(Schema(name, text))
