"""From texts to values: types, ranges and constraint texts."""

from __future__ import annotations

import math
from decimal import Decimal
from enum import IntEnum
from typing import Any

import pytest

from rtgen.runtime import ConfigurationError, ParameterProfile, ParameterValueError
from rtgen.runtime.rtc.parameter_values import Converter


class Mode(IntEnum):
    SLOW = 0
    FAST = 1


def convert(type_: str, text: str, example: object = None, **profile: Any) -> Any:
    return Converter(ParameterProfile("p", "p", type_, **profile), example)(text)


@pytest.mark.parametrize(
    ("type_", "text", "example", "value"),
    [
        ("boolean", "true", False, True),
        ("boolean", "TRUE", False, True),
        ("boolean", "1", False, True),
        ("boolean", " no ", False, False),
        ("short", "-32768", 0, -32768),
        ("unsigned long", "4294967295", 0, 4294967295),
        ("long long", " +5 ", 0, 5),
        ("octet", "255", 0, 255),
        ("int8", "-128", 0, -128),
        ("float", "1e38", 0.0, 1e38),
        ("double", "-1.57", 0.0, -1.57),
        ("double", "2", 0.0, 2.0),
        ("double", "inf", 0.0, math.inf),
        ("string", " /dev/ttyUSB0 ", "", "/dev/ttyUSB0"),
        ("string", "", "", ""),
        ("string<3>", "abc", "", "abc"),
        ("wstring", "é", "", "é"),
        ("char", "x", "", "x"),
        ("fixed<5,2>", "123.45", Decimal(0), Decimal("123.45")),
        ("sequence<double>", "1, 2.5 ,3", [], [1.0, 2.5, 3.0]),
        ("sequence<long>", "", [], []),
        ("sequence<string>", "a, b", [], ["a", "b"]),
        ("sequence<boolean>", "true,false", [], [True, False]),
        ("sequence<octet>", "1,2,255", b"", b"\x01\x02\xff"),
        ("sequence<char>", "a,b", "", "ab"),
        ("sequence<long,3>", "1,2,3", [], [1, 2, 3]),
        ("double[2]", "1,2", [0.0, 0.0], [1.0, 2.0]),
        ("Robot::Mode", "FAST", Mode.SLOW, Mode.FAST),
        ("Robot::Mode", "Robot::FAST", Mode.SLOW, Mode.FAST),
        ("sequence<Robot::Mode>", "FAST,SLOW", [Mode.SLOW], [Mode.FAST, Mode.SLOW]),
        ("Robot::Length", "1.5", 0.0, 1.5),
        ("Robot::Count", "7", 0, 7),
        ("Robot::Flag", "yes", False, True),
        ("Robot::Name", "x", "", "x"),
        ("Robot::Lengths", "1,2", [0.0], [1.0, 2.0]),
    ],
)
def test_values(type_: str, text: str, example: object, value: object) -> None:
    converted = convert(type_, text, example)
    assert converted == value
    assert type(converted) is type(value)


@pytest.mark.parametrize(
    ("type_", "text", "example", "reason"),
    [
        ("boolean", "maybe", False, "true or false"),
        ("boolean", "", False, "true or false"),
        ("short", "32768", 0, "between -32768 and 32767"),
        ("unsigned short", "-1", 0, "between 0 and 65535"),
        ("long", "1.0", 0, "a decimal integer"),
        ("long", "0x10", 0, "a decimal integer"),
        ("long", "1_000", 0, "a decimal integer"),
        ("long", "", 0, "a decimal integer"),
        ("unsigned long long", "9" * 5000, 0, "a decimal integer"),
        ("double", "fast", 0.0, "a number"),
        ("double", "1_0.0", 0.0, "a number"),
        ("double", "", 0.0, "a number"),
        ("float", "1e39", 0.0, "its size must be at most 3.4028235e+38"),
        ("string", "a\0b", "", "NUL"),
        ("string<2>", "éé", "", "at most 2 octets"),
        ("char", "ab", "", "one character"),
        ("fixed<5,2>", "1234", Decimal(0), "at most 3 digits before the point"),
        ("fixed<5,2>", "1.234", Decimal(0), "at most 2 digits after the point"),
        ("fixed<5,2>", "NaN", Decimal(0), "at most 3 digits"),
        ("fixed<5,2>", "x", Decimal(0), "a decimal number"),
        ("sequence<long>", "1,x", [], "element 2, 'x': it must be a decimal integer"),
        ("sequence<long,2>", "1,2,3", [], "at most 2 elements, not 3"),
        ("double[2]", "1", [0.0, 0.0], "2 elements, not 1"),
        ("Robot::Mode", "MEDIUM", Mode.SLOW, "one of SLOW, FAST"),
        ("Robot::Pose", "1", object(), "cannot be given as text"),
    ],
)
def test_refusals(type_: str, text: str, example: object, reason: str) -> None:
    with pytest.raises(ParameterValueError) as caught:
        convert(type_, text, example)
    message = str(caught.value)
    assert message.startswith(f"parameter 'p' cannot be {text.strip()!r}: ")
    assert reason in message


def test_range() -> None:
    limits = {"minimum": 0.0, "maximum": 2.0, "unit": "m/s"}
    assert convert("double", "2.0", 0.0, **limits) == 2.0
    for text, reason in (
        ("2.1", "at most 2.0 m/s"),
        ("-1", "at least 0.0 m/s"),
        ("nan", "at least 0.0"),
    ):
        with pytest.raises(ParameterValueError, match=reason):
            convert("double", text, 0.0, **limits)
    with pytest.raises(ParameterValueError, match=r"at most 2.0"):
        convert("sequence<double>", "1,3", [], **limits)


@pytest.mark.parametrize(
    ("constraint", "type_", "good", "bad"),
    [
        ("0.0<x<=2.0", "double", ["0.1", "2.0"], ["0.0", "2.1", "nan"]),
        (" 0 <= x < 10 ", "long", ["0", "9"], ["10", "-1"]),
        ("x>=5", "long", ["5"], ["4"]),
        ("x>5", "long", ["6"], ["5"]),
        ("x<=-1.5e1", "double", ["-15"], ["-14.9"]),
        ("x<5", "long", ["4"], ["5"]),
        ("5<=x", "long", ["5"], ["4"]),
        ("5<x", "long", ["6"], ["5"]),
        ("5>x", "long", ["4"], ["5"]),
        ("5>=x", "long", ["5"], ["6"]),
        ("(a,b,c)", "string", ["a", "c"], ["d", ""]),
        ("(1,2.0)", "double", ["1", "2"], ["3"]),
        ("(true)", "boolean", ["1"], ["0"]),
        ("100", "long", ["100"], ["99"]),
        ("x<1,x>=2", "sequence<long>", ["0,2", "0", "0,2,9"], ["1,2", "0,1"]),
        ("0<x<9", "sequence<long>", ["1,2,3", ""], ["1,9"]),
        ("(1,2),x>5", "sequence<long>", ["2,6"], ["3,6", "1,5"]),
        ("{k1:0<x<1,k2:x>=3}", "string", ["anything"], []),
        ("", "long", ["1"], []),
    ],
)
def test_constraints(
    constraint: str, type_: str, good: list[str], bad: list[str]
) -> None:
    examples = {"string": "", "boolean": False, "double": 0.0}
    for text in good:
        convert(type_, text, examples.get(type_), constraint=constraint)
    for text in bad:
        with pytest.raises(ParameterValueError, match="its constraint is "):
            convert(type_, text, examples.get(type_), constraint=constraint)


def test_a_constraint_on_an_enumeration() -> None:
    assert convert("Mode", "FAST", Mode.SLOW, constraint="(FAST)") is Mode.FAST
    with pytest.raises(ParameterValueError, match="its constraint is"):
        convert("Mode", "SLOW", Mode.SLOW, constraint="(FAST)")


@pytest.mark.parametrize("constraint", ["x<", "x<>5", "0<x<", "a<x", "(1,2"])
def test_a_constraint_that_cannot_be_understood(constraint: str) -> None:
    with pytest.raises(ConfigurationError, match="cannot be understood"):
        convert("double", "1", 0.0, constraint=constraint)
