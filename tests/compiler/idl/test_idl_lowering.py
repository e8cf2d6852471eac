"""Lowering of each kind of declaration to the model."""

from idl_stages import lowered

from rtgen.compiler.model import (
    Component,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Interface,
    Struct,
    Typedef,
    Union,
    Valuetype,
)


def test_a_struct_with_its_comments() -> None:
    declarations, messages = lowered(
        "/** A place. */\nstruct S {\n  long a; ///< along the lane\n  double b[2];\n};"
    )
    assert not messages
    struct = declarations["S"]
    assert isinstance(struct, Struct)
    assert struct.doc == "A place."
    assert [(m.name, str(m.type), m.doc) for m in struct.members] == [
        ("a", "long", "along the lane"),
        ("b", "double[2]", ""),
    ]


def test_a_union() -> None:
    declarations, _ = lowered(
        "enum E { A, B, C };"
        "union U switch (E) { case A: case B: long x; default: string y; };"
    )
    union = declarations["U"]
    assert isinstance(union, Union)
    assert [(c.labels, c.default, c.name) for c in union.cases] == [
        ((EnumeratorName(("A",)), EnumeratorName(("B",))), False, "x"),
        ((), True, "y"),
    ]


def test_an_enum_with_values() -> None:
    declarations, _ = lowered("enum E { A, @value(5) B, C };")
    enum = declarations["E"]
    assert isinstance(enum, Enum)
    assert [(m.name, m.value) for m in enum.members] == [("A", 0), ("B", 5), ("C", 6)]


def test_an_interface() -> None:
    declarations, _ = lowered(
        "exception Late { long by; };"
        "interface A { readonly attribute long size; };"
        "interface I : A { oneway void stop(); long f(in long a, inout short b) raises (Late); };"
    )
    assert isinstance(declarations["Late"], ExceptionDecl)
    base, interface = declarations["A"], declarations["I"]
    assert isinstance(base, Interface)
    assert isinstance(interface, Interface)
    assert [(a.name, a.readonly) for a in base.attributes] == [("size", True)]
    assert interface.bases == (("A",),)
    stop, f = interface.operations
    assert stop.oneway
    assert str(stop.returns) == "void"
    assert [(str(p.direction), p.name, str(p.type)) for p in f.parameters] == [
        ("in", "a", "long"),
        ("inout", "b", "short"),
    ]
    assert f.raises == (("Late",),)


def test_a_typedef_for_each_declarator() -> None:
    declarations, _ = lowered("typedef long A, B[2];")
    assert list(declarations) == ["A", "B"]
    assert all(isinstance(d, Typedef) for d in declarations.values())


def test_a_forward_declaration_without_a_definition() -> None:
    declarations, _ = lowered("interface I;")
    interface = declarations["I"]
    assert isinstance(interface, Interface)
    assert interface.forward


def test_a_valuetype() -> None:
    declarations, _ = lowered(
        "valuetype V { public long a; private short b; factory make(in long a); };"
    )
    value = declarations["V"]
    assert isinstance(value, Valuetype)
    assert [(m.name, m.public) for m in value.state] == [("a", True), ("b", False)]
    assert [f.name for f in value.factories] == ["make"]


def test_a_component() -> None:
    declarations, messages = lowered(
        "struct Time { long s; }; struct Pose { Time tm; double x; };"
        "interface Stop { void now(); };"
        "component Drive { publishes Pose pose; provides Stop stop; attribute double limit; };"
    )
    assert not messages
    component = declarations["Drive"]
    assert isinstance(component, Component)
    assert [(str(p.kind), p.name) for p in component.ports] == [
        ("outport", "pose"),
        ("provider", "stop"),
    ]
    assert [p.name for p in component.configuration] == ["limit"]


def test_a_declaration_with_an_error_is_left_out() -> None:
    declarations, messages = lowered("struct S { long a[0]; }; struct T { long b; };")
    assert len(messages) == 1
    assert list(declarations) == ["T"]
