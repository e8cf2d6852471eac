"""Values of constant expressions and initialisers, and sizes that refer to parameters."""

from __future__ import annotations

import math

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.model.c_types import Literal
from rtgen.compiler.model.tecs import Signature, TecsConst

VALUES: dict[str, bool | int | float] = {
    "const int32_t A = -(3) + ~4;": -8,
    "const int32_t A = (-7) / 2;": -4,  # as in Ruby
    "const int32_t A = (-7) % 4;": 1,
    "const int32_t A = (7 & 6 | 8) ^ 1;": 15,
    "const int32_t A = 3 << 4;": 48,
    "const int32_t A = 48 >> 4;": 3,
    "const int32_t A = 1 ? 2 : 3;": 2,
    "const int32_t A = 1 > 2 ? 2 : 3;": 3,
    "const bool_t A = !0;": True,
    "const bool_t A = 3 >= 3 && 1 != 1;": False,
    "const bool_t A = 3 < 3 || 1 == 1;": True,
    "const int16_t A = 'a';": 97,
    "const double64_t A = 3;": 3.0,
    "const double64_t A = 1 / 4.0;": 0.25,
    "const int8_t A = (int8_t)200;": -56,
    "const uint8_t A = (uint8_t)-1;": 255,
    "const int32_t A = (int32_t)2.9;": 2,
    "const int16_t A = (int16_t)9999999999.9;": 32767,
    "const uint16_t A = (uint16_t)-9.9;": 0,
    "const int32_t A = (int32_t)(1.e200 * 1.e300);": 2147483647,
    "const bool_t A = (bool_t)3;": True,
    "const bool_t A = 0.5;": True,
    'const bool_t A = "";': True,
    "const int32_t A = 1 + true;": 2,
    "const bool_t A = 1 != true;": False,
    "const float32_t A = 5.5 % 2;": 1.5,
    "const float32_t A = (float32_t)1;": 1.0,
    "const double64_t A = (double64_t)(1 << 2000);": math.inf,
    "const int32_t B = 7; const int32_t A = B * B;": 49,
}


@pytest.mark.parametrize("text", VALUES)
def test_values(text: str) -> None:
    unit, findings = read_text(text)
    assert not findings
    declared = unit.declarations[-1]
    assert isinstance(declared, TecsConst)
    assert declared.value == VALUES[text]
    assert type(declared.value) is type(VALUES[text])


MISTAKES = {
    'const int32_t A = -"a";': "'-' cannot be used on a string",
    "const int32_t A = ~1.5;": "'~' cannot be used on a floating-point number",
    "const int32_t A = *1;": "'*' cannot be used on an integer",
    "const int32_t A = 1 << -1;": "a shift by -1 has no value",
    "const int32_t A = 1 << 4095 << 4095;": "this value is too large to be computed",
    'const int32_t A = (int32_t)"a";': "a string cannot be cast to int32_t",
}

INITIALISERS = {
    "int8_t a[2] = { 1, 2 };": None,
    "int8_t a[2] = { 1, 2, 3 };": "3 values for an array of 2",
    "int8_t a[2] = { 1, 200 };": "200 does not fit int8_t: -128 to 127",
    'char_t a[3] = "ab";': "an array requires its values in braces",
    'int16_t a[3] = "ab";': "an array requires its values in braces",
    "struct t a = { 1, { 2, 3 } };": None,
    "struct t a = { 1, 2 };": "an array requires its values in braces",
    "struct t a = { 1, { 2, 3 }, 4 };": None,
    "struct t a = 1;": "struct t requires its values in braces",
    "int32_t a = { 1 };": "int32_t requires a single value, without braces",
    'int32_t a = "x";': "a string cannot be int32_t",
    "bool_t a = 1.5;": None,
    'bool_t a = "x";': None,
    "float32_t a = true;": "a truth value cannot be float32_t",
    "uint_t a = -1;": "-1 does not fit uint_t, it is below zero",
    "int8_t *a = 0;": None,
    "int8_t *a = (int8_t *)1;": None,
    "int8_t *a = 1;": "an integer cannot be int8_t*",
    'char_t *a = "x";': None,
    'int16_t *a = "x";': "a string cannot be int16_t*",
}

SIZES = {
    "[in] struct p p, [in, size_is( p.n * 2 )] const int8_t *a": None,
    "[in] struct p p, [in, size_is( p.m )] const int8_t *a": "struct p has no member 'm'",
    "[in] struct p p, [in, size_is( p )] const int8_t *a": "not a struct",
    "[in] const int32_t *n, [in, size_is( *n + 1 )] const int8_t *a": None,
    "[in] const int32_t *n, [in, size_is( n )] const int8_t *a": "not a pointer",
    "[in] int32_t n, [in, size_is( n ? n : 1 )] const int8_t *a": None,
    "[in] int32_t n, [in, size_is( n.x )] const int8_t *a": "'.x' has no value",
    "[in] int32_t n, [in, size_is( n[0] )] const int8_t *a": "a subscript has no value",
    "[in, size_is( 3 )] const int32_t *n, [in, size_is( n[1] )] const int8_t *a": None,
    "[in, size_is( 3 )] const int32_t *n, [in, size_is( n[1.5] )] const int8_t *a": (
        "'[]' cannot be used on a floating-point number"
    ),
}


def mistake(text: str) -> str | None:
    """Return the only error of a text, or None."""
    _, findings = read_text(text)
    errors = [d.message for d in findings if d.severity is Severity.ERROR]
    assert len(errors) < 2
    return errors[0] if errors else None


@pytest.mark.parametrize("text", MISTAKES)
def test_mistakes(text: str) -> None:
    assert mistake(text) == MISTAKES[text]


@pytest.mark.parametrize("attribute", INITIALISERS)
def test_initialisers(attribute: str) -> None:
    found = mistake(
        "struct t { int8_t a; int8_t b[2]; };"
        f"[active] celltype c {{ attr {{ {attribute} }}; }};"
    )
    assert found == INITIALISERS[attribute]


@pytest.mark.parametrize("parameters", SIZES)
def test_sizes_that_refer_to_parameters(parameters: str) -> None:
    found = mistake(
        f"struct p {{ int32_t n; }}; signature s {{ void f( {parameters} ); }};"
    )
    expected = SIZES[parameters]
    assert found is None if expected is None else expected in (found or "")


def test_a_constant_stands_for_its_value_in_a_size() -> None:
    unit, findings = read_text(
        "const int32_t N = 2; signature s { void f( [in, size_is( N )] const int8_t *a ); };"
    )
    assert not findings
    signature = unit.declarations[-1]
    assert isinstance(signature, Signature)
    assert signature.functions[0].parameters[0].sizes.size_is == Literal(2)
