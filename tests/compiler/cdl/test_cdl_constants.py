"""Expressions and constants: operators, casts, ranges."""

import pytest
from cdl_stages import analysed

from rtgen.compiler.model.tecs import TecsConst


@pytest.mark.parametrize(
    ("type_", "expression", "value"),
    [
        ("int32_t", "1 + 2 * 3", 7),
        ("int32_t", "(1 + 2) * 3", 9),
        ("int32_t", "7 / 2", 3),
        ("int32_t", "1 << 4 | 1", 17),
        ("uint8_t", "(uint8_t)258", 2),
        ("int8_t", "(int8_t)255", -1),
        ("double64_t", "1.5 * 2", 3.0),
    ],
)
def test_values(type_: str, expression: str, value: float) -> None:
    table, found = analysed(f"const {type_} A = {expression};")
    assert not found
    (constant,) = table.model()
    assert isinstance(constant, TecsConst)
    assert constant.value == value


def test_a_constant_is_known_behind_it() -> None:
    table, _ = analysed("const int32_t A = 2; const int32_t B = A * A;")
    constant = table.model()[1]
    assert isinstance(constant, TecsConst)
    assert constant.value == 4


@pytest.mark.parametrize(
    "text",
    [
        "const uint8_t A = 256;",
        "const int32_t A = 1 / 0;",
        "const int32_t A = B;",
        "int32_t A = 1;",
        'const int32_t A = "a";',
    ],
)
def test_mistakes(text: str) -> None:
    table, found = analysed(text)
    assert found
    assert not table.model()
