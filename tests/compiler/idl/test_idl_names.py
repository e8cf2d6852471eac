"""Name resolution: scopes, references, forward declarations, repository ids."""

import pytest
from idl_stages import entity, resolved

from rtgen.compiler.frontends.idl.names.scopes import Kind
from rtgen.compiler.model import Primitive


def test_declarations_in_the_order_of_the_text() -> None:
    tables, messages = resolved("struct A { long x; }; module M { typedef A B; };")
    assert not messages
    assert [(e.scoped, e.kind) for e in tables.declared] == [
        ("A", Kind.STRUCT),
        ("M::B", Kind.TYPEDEF),
    ]


@pytest.mark.parametrize(
    ("text", "name", "target"),
    [
        ("typedef long T; module M { typedef T U; };", "T", "T"),
        ("typedef long T; module M { typedef short T; typedef T U; };", "T", "M::T"),
        ("typedef long T; module M { typedef short T; typedef ::T U; };", "::T", "T"),
        ("module M { typedef long T; }; module M { typedef T U; };", "T", "M::T"),
        (
            "interface A { typedef long T; }; interface B : A { typedef T U; };",
            "T",
            "A::T",
        ),
    ],
)
def test_a_name_is_looked_up_from_the_inside_out(
    text: str, name: str, target: str
) -> None:
    tables, messages = resolved(text)
    assert not messages
    found = {str(k): v for k, v in tables.references.items()}[name]
    assert found is entity(tables, target)


def test_integers_of_idl_4_are_names_that_a_declaration_takes() -> None:
    tables, _ = resolved("typedef int32 T;")
    assert list(tables.references.values()) == [Primitive.LONG]
    tables, _ = resolved("typedef float int32; typedef int32 T;")
    assert list(tables.references.values()) == [entity(tables, "int32")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("typedef Gone T;", "Gone is unknown"),
        ("typedef T U; typedef long T;", "T is unknown"),
        ("const long A = 1; const long A = 2;", "A is declared twice"),
        ("const long A = 1; const long a = 2;", "a and A differ in case only"),
        (
            "struct S; typedef sequence<S> T;",
            "the struct S is declared, but never defined",
        ),
    ],
)
def test_messages(text: str, message: str) -> None:
    assert resolved(text)[1] == [message]


def test_a_name_that_was_reported_refers_to_nothing() -> None:
    tables, _ = resolved("typedef Gone T;")
    assert list(tables.references.values()) == [None]


def test_a_forward_declaration_and_its_definition_are_one() -> None:
    tables, messages = resolved("interface I; typedef I J; interface I { void f(); };")
    assert not messages
    assert sorted(e.scoped for e in tables.declared) == ["I", "J"]
    assert entity(tables, "I").node is not None


def test_an_interface_that_another_file_may_define_is_noted() -> None:
    tables, messages = resolved("interface I; typedef I J;")
    assert not messages
    assert list(tables.undefined) == [("I",)]


@pytest.mark.parametrize(
    ("text", "repository_id"),
    [
        ("module M { struct S { long a; }; };", "IDL:M/S:1.0"),
        (
            '#pragma prefix "org"\nmodule M { struct S { long a; }; };',
            "IDL:org/M/S:1.0",
        ),
        ("module M { struct S { long a; };\n#pragma version S 2.1\n};", "IDL:M/S:2.1"),
        (
            'module M { struct S { long a; };\n#pragma ID S "LOCAL:s"\n};',
            "LOCAL:s",
        ),
    ],
)
def test_repository_ids(text: str, repository_id: str) -> None:
    tables, messages = resolved(text)
    assert not messages
    assert entity(tables, "M::S").repository_id == repository_id
