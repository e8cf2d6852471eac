"""Types: typedefs, structs, enums, arrays."""

import pytest
from cdl_stages import analysed

from rtgen.compiler.model.tecs import TecsStruct, TecsTypedef


@pytest.mark.parametrize(
    ("text", "type_"),
    [
        ("typedef int32_t A;", "int32_t"),
        ("typedef const char_t *A;", "const char_t *"),
        ("typedef int8_t A[2][3];", "int8_t[2][3]"),
        ("typedef unsigned long A;", "unsigned long"),
    ],
)
def test_typedefs(text: str, type_: str) -> None:
    table, found = analysed(text)
    assert not found
    (declaration,) = table.model()
    assert isinstance(declaration, TecsTypedef)
    assert str(declaration.type).replace(" *", "*") == type_.replace(" *", "*")


def test_members_of_a_struct() -> None:
    table, found = analysed("struct tagS { int32_t x; double64_t y; };")
    assert not found
    (declaration,) = table.model()
    assert isinstance(declaration, TecsStruct)
    assert [(m.name, str(m.type)) for m in declaration.members] == [
        ("x", "int32_t"),
        ("y", "double64_t"),
    ]
    assert table.tag(("tagS",)) is table.declarations[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("typedef int32_t A[0];", "the size of an array is positive, not 0"),
        (
            "typedef int32_t A[2][];",
            "only the first dimension of an array may be left out",
        ),
        ("struct tagS { struct tagS inner; };", "struct tagS cannot hold itself"),
    ],
)
def test_mistakes(text: str, message: str) -> None:
    assert analysed(text)[1] == [message]
