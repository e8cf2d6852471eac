"""Signatures: functions, parameters, directions, sizes."""

import pytest
from cdl_stages import analysed

from rtgen.compiler.model.tecs import Signature, TecsDirection


def test_functions_and_directions() -> None:
    table, found = analysed(
        "signature s { int32_t f([in] int32_t a, [out] int32_t *b); void g(void); };"
    )
    assert not found
    (signature,) = table.model()
    assert isinstance(signature, Signature)
    first, second = signature.functions
    assert [(p.name, p.direction) for p in first.parameters] == [
        ("a", TecsDirection.IN),
        ("b", TecsDirection.OUT),
    ]
    assert (first.name, second.name, second.parameters) == ("f", "g", ())


@pytest.mark.parametrize(
    "text",
    [
        "signature s { void f(int32_t a); };",
        "signature s { void f([out] int32_t a); };",
        "signature s { void f([in, size_is(n)] const int32_t *a); };",
        "signature s { void f(void); void f(void); };",
    ],
)
def test_mistakes(text: str) -> None:
    assert analysed(text)[1]
