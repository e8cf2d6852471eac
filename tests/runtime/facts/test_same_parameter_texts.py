"""Compiler and runtime read the same texts of values."""

from __future__ import annotations

import pytest

from rtgen.compiler.model import Model, Primitive, PrimitiveType, SequenceType, Type
from rtgen.compiler.typemap.components.parameters import Parameters, ValueMismatchError
from rtgen.facts.primitives import INTEGERS
from rtgen.runtime import ParameterProfile, ParameterValueError
from rtgen.runtime.rtc.parameter_values import Converter

PARAMETERS = Parameters(Model())
TEXTS = (
    *("", " ", "0", "1", "-1", "+5", " 5 ", "1.0", "1.", ".5", "1e3", "0x10", "1_0"),
    *("127", "128", "-129", "255", "256", "65536", "-2147483649", "9" * 41, "٣", "3٣"),
    *("true", "FALSE", "Yes", "no", "on", "off", "maybe", "1e39", "-1e39", "1e400", "x"),
)  # fmt: skip
KINDS = (*INTEGERS, Primitive.FLOAT, Primitive.DOUBLE, Primitive.BOOLEAN)


def compiled(type_: Type, text: str) -> object:
    """Return the value that the compiler reads, as text; None if it refuses."""
    try:
        if isinstance(type_, SequenceType):
            PARAMETERS.check_value(type_, text)
            return "a sequence"
        value = PARAMETERS.parse_item(type_, text)
        PARAMETERS.check_value(type_, value)
    except ValueMismatchError:
        return None
    return repr(value)


def run(type_: Type, text: str) -> object:
    """Return the value that the runtime reads, as text; None if it refuses."""
    example = [] if isinstance(type_, SequenceType) else None
    try:
        value = Converter(ParameterProfile("p", "", str(type_)), example)(text)
    except ParameterValueError:
        return None
    return "a sequence" if isinstance(type_, SequenceType) else repr(value)


@pytest.mark.parametrize("kind", KINDS)
def test_both_read_the_same_values(kind: str) -> None:
    type_ = PrimitiveType(Primitive(kind))
    read = 0
    for text in TEXTS:
        if text == "1e400":
            continue  # infinite: a value at run time, but not in a definition
        assert compiled(type_, text) == run(type_, text), text
        read += run(type_, text) is not None
    assert 5 <= read < len(TEXTS)


@pytest.mark.parametrize("kind", [Primitive.LONG, Primitive.DOUBLE, Primitive.BOOLEAN])
def test_both_read_the_same_sequences(kind: Primitive) -> None:
    type_ = SequenceType(PrimitiveType(kind), 3)
    for text in ("", " ", "1", "1, 0 ,1", "1,", ",", "1,0,1,0", "1;0", "x,1"):
        assert compiled(type_, text) == run(type_, text), text
