"""Values as JSON: the form of recorded calls, and refusals."""

from __future__ import annotations

from typing import Any

import pytest
from random_signatures import (
    IN,
    INOUT,
    OUT,
    SPAN,
    STRUCTS,
    pointer,
    scalar,
)

from rtgen.compiler.model.c_types import CArrayType, CStructType, CType, Literal
from rtgen.compiler.model.tecs import (
    Signature,
    Sizes,
    TecsDirection,
    TecsFunction,
    TecsParameter,
    TecsUnit,
)
from rtgen.facts.tdr import Scalar
from rtgen.runtime.opaque_rpc import NETWORK, ArgumentError
from rtgen.tools.rpc.codecs import Function, Service
from rtgen.tools.rpc.values import JsonError


def function(*parameters: tuple[TecsDirection, CType, Sizes]) -> Function:
    """Return a function with parameters a, b, ... that returns a float."""
    declared = TecsFunction(
        id=1,
        name="f",
        returns=scalar(Scalar.FLOAT32),
        parameters=tuple(
            TecsParameter(
                name="abcdef"[i],
                type=type_,
                direction=direction,
                sizes=sizes,
                span=SPAN,
            )
            for i, (direction, type_, sizes) in enumerate(parameters)
        ),
        span=SPAN,
    )
    signature = Signature(name=("sF",), file="f.cdl", span=SPAN, functions=(declared,))
    unit = TecsUnit("f.cdl", "f.cdl", (*STRUCTS, signature))
    return Service(unit, signature, NETWORK).functions["f"]


def text(kind: Scalar, **sizes: Any) -> tuple[TecsDirection, CType, Sizes]:
    return IN, pointer(scalar(kind)), Sizes(**sizes)


def test_arguments_in_both_directions() -> None:
    called = function(
        (IN, CArrayType(scalar(Scalar.CHAR), 2), Sizes()),
        (INOUT, pointer(scalar(Scalar.DOUBLE64)), Sizes(nullable=True)),
        (OUT, pointer(scalar(Scalar.BOOL)), Sizes(nullable=True)),
        text(Scalar.INT16, unsized_string=True),
        (IN, scalar(Scalar.SCHAR), Sizes()),
        (IN, CStructType(("tagNote",)), Sizes()),
    )
    blob = {"kind": 65, "data": [], "len": 0}
    note = {"id": 1, "text": "\xff", "val": [2.5], "nick": "", "wide": "\u3042"}
    value = {
        "a": [0, 255],
        "b": "-inf",
        "c": {"want": True},
        "d": "\uffff",
        "e": -7,
        "f": {**note, "blob": [blob, blob]},
    }
    arguments = called.arguments_from_json(value)
    assert arguments[:5] == (b"\0\xff", float("-inf"), True, [-1], -7)
    assert called.arguments_to_json(arguments) == value
    request = called.encode_request(arguments)
    assert called.arguments_to_json(called.decode_request(request)) == value


def test_wide_units_that_are_no_characters_are_numbers() -> None:
    called = function(text(Scalar.UINT64, unsized_string=True))
    value = {"a": [1, 1 << 63]}
    assert called.arguments_to_json(called.arguments_from_json(value)) == value


def test_units_of_16_bits_are_those_of_utf_16() -> None:
    called = function(text(Scalar.UINT16, unsized_string=True))
    arguments = called.arguments_from_json({"a": "a\U0001f916"})
    assert arguments == ([0x61, 0xD83E, 0xDD16],)
    assert called.arguments_to_json(arguments) == {"a": "a\U0001f916"}
    single = {"a": "\ud83e"}
    assert called.arguments_to_json(called.arguments_from_json(single)) == single


@pytest.mark.parametrize(
    ("returned", "shown"), [(float("inf"), "inf"), (float("nan"), "nan"), (1.5, 1.5)]
)
def test_replies(returned: float, shown: object) -> None:
    called = function((OUT, pointer(scalar(Scalar.INT8)), Sizes()))
    value = {"return": shown, "outs": {"a": -1}}
    assert called.result_to_json(returned, (-1,)) == value
    assert called.result_to_json(*called.result_from_json(value)) == value


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([], "an object is needed"),
        ({}, "'a' is missing"),
        ({"a": 1, "b": "", "z": 0}, "'z' is unknown"),
        ({"a": True, "b": ""}, "a: an integer is needed"),
        ({"a": 1.5, "b": ""}, "a: an integer is needed"),
        ({"a": 1, "b": 5}, "b: a text is needed"),
    ],
)
def test_what_is_refused(value: Any, message: str) -> None:
    called = function(
        (IN, scalar(Scalar.INT32), Sizes()), text(Scalar.CHAR, string=Literal(4))
    )
    with pytest.raises(JsonError, match=message):
        called.arguments_from_json(value)


def test_values_that_do_not_fit_name_the_argument() -> None:
    called = function(
        (IN, scalar(Scalar.UINT16), Sizes()), text(Scalar.CHAR, string=Literal(4))
    )
    with pytest.raises(ArgumentError, match=r"sF.f\(a=65536, b='x'\)"):
        called.encode_request((65536, "x"))
    with pytest.raises(ArgumentError, match="a text of 5 units, at most 4 fit"):
        called.encode_request((1, "abcde"))
