"""Types: from the tree to the model, aliases, enumerators."""

import pytest
from idl_stages import entity, typed

from rtgen.compiler.model import (
    ArrayType,
    FixedType,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)

LONG = PrimitiveType(Primitive.LONG)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("typedef long T;", LONG),
        ("typedef string T;", StringType()),
        ("typedef string<2 + 3> T;", StringType(bound=5)),
        ("typedef wstring<4> T;", StringType(bound=4, wide=True)),
        ("typedef sequence<long> T;", SequenceType(LONG)),
        ("typedef sequence<sequence<long>, 7> T;", SequenceType(SequenceType(LONG), 7)),
        ("typedef long T[2][3];", ArrayType(LONG, (2, 3))),
        ("typedef fixed<5, 2> T;", FixedType(5, 2)),
        ("typedef map<long, string> T;", MapType(LONG, StringType())),
        ("const long N = 4; typedef long T[N];", ArrayType(LONG, (4,))),
        ("struct S { long a; }; typedef S T;", NamedType(("S",))),
    ],
)
def test_types(text: str, expected: Type) -> None:
    types, found = typed(text)
    assert types.of_entity(entity(types.tables, "T")) == expected
    assert not found


def test_the_type_behind_aliases() -> None:
    types, _ = typed("typedef long A; typedef A B; typedef B C[2];")
    assert types.unaliased(NamedType(("B",))) == LONG
    assert types.unaliased(NamedType(("C",))) == ArrayType(NamedType(("B",)), (2,))


@pytest.mark.parametrize(
    ("text", "can"),
    [
        ("typedef long T;", True),
        ("typedef boolean T;", True),
        ("typedef char T;", True),
        ("enum E { A, B }; typedef E T;", True),
        ("typedef float T;", False),
        ("typedef string T;", False),
        ("struct S { long a; }; typedef S T;", False),
    ],
)
def test_switches_of_unions(text: str, can: bool) -> None:
    types, _ = typed(text)
    assert types.can_switch(NamedType(("T",))) is can


def test_enumerators_know_their_enum() -> None:
    types, _ = typed("module M { enum E { A, B }; };")
    assert types.is_enum(("M", "E"))
    assert types.enum_of(("M", "B")) == ("M", "E")
    assert types.enum_of(("B",)) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("typedef long T[0];", "0 is not from 1 to 4294967295"),
        ("typedef sequence<long, -1> T;", "-1 is not from 1 to 4294967295"),
        ("typedef fixed<32, 2> T;", "fixed<32,2> is not possible"),
    ],
)
def test_what_has_no_type_is_reported_once(text: str, message: str) -> None:
    types, found = typed(text)
    target = entity(types.tables, "T")
    assert types.of_entity(target) is None
    assert types.of_entity(target) is None
    assert [diagnostic.message for diagnostic in found] == [message]
