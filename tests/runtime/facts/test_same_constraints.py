"""Compiler and runtime accept the same constraint texts, and allow the same values."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import pytest

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import ConfigurationParameter, Model, Primitive, PrimitiveType
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.facts.constraints import ConstraintError
from rtgen.runtime import ConfigurationError, ParameterProfile, ParameterValueError
from rtgen.runtime.rtc.parameter_values import Converter

NUMBERS = ("0", "10", "-1.5", "1e3", "nan", "inf", "1_0", "٣", "", "y")
RELATIONS = ("<", "<=", ">", ">=", "=", "==", "<>")
VALUES = (-2.0, -1.5, 0.0, 5.0, 10.0, 1000.0, 1e6)
FURTHER = (
    *("", " ", "()", "(0,10)", "(0,,10)", "(0", "0)", "((0))", "(0)(10)", "{}", "{", "}"),
    *("{k:x>0}", "{k:x>0,j:10}", "{x>0}", "{:x>0}", "{k:}", "{k:x>}", "{k:(0}", "0<x<10<20"),
    *("0,10", "x>0,x<10", "x>0,", ",x>0", "(0,10),x<5", "10 >= x >= 0", "x\t<\n10", "xx<1"),
)  # fmt: skip


def texts() -> Iterator[str]:
    yield from FURTHER
    for one, number in product(RELATIONS, NUMBERS):
        yield from (f"x{one}{number}", f"{number}{one}x", f"{number}{one}{number}")
    for low, one, other, high in product(NUMBERS, RELATIONS, RELATIONS, NUMBERS):
        yield f"{low}{one}x{other}{high}"


TEXTS = tuple(texts())
PARAMETERS = Parameters(Model())
SPAN = Span("some.idl", 1, 1, 1, 2)


def compiled(text: str, value: float) -> bool | None:
    """Return whether the compiler allows the default; None if it cannot read the text."""
    parameter = ConfigurationParameter(
        span=SPAN,
        name="p",
        identifier="p",
        type=PrimitiveType(Primitive.DOUBLE),
        default=value,
        constraint=text,
    )
    try:
        limit = PARAMETERS.constraint(parameter)
    except ConstraintError:
        return None
    return limit is None or PARAMETERS.is_default_allowed(parameter, limit)


def run(text: str, value: float) -> bool | None:
    """Return whether the runtime allows the value; None if it cannot read the text."""
    profile = ParameterProfile("p", str(value), "double", constraint=text)
    try:
        converter = Converter(profile, 0.0)
    except ConfigurationError:
        return None
    try:
        converter(str(value))
    except ParameterValueError:
        return False
    return True


def test_both_accept_the_same_texts_and_values() -> None:
    assert len(TEXTS) > 4_765
    accepted = 0
    for text in TEXTS:
        for value in VALUES:
            both = compiled(text, value), run(text, value)
            assert both[0] is both[1], (text, value, both)
        accepted += both[0] is not None
    assert 100 < accepted < len(TEXTS)


@pytest.mark.parametrize("text", ["10>=x>=0", "10>=x>0", "10>x>=0"])
def test_intervals_from_the_upper_end(text: str) -> None:
    assert compiled(text, 5.0) is run(text, 5.0) is True
    assert compiled(text, 11.0) is run(text, 11.0) is False
