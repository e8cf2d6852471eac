"""Conversions for which `struct` has no code: their limits, and values that they reject."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from decimal import Decimal
from typing import Any

import pytest

from rtgen.runtime.marshalling import octets
from rtgen.runtime.marshalling.octets import ObjectReference

MIN_SUBNORMAL = 5e-324
NOT_A_NUMBER = struct.unpack(">d", bytes.fromhex("7ff8000000000001"))[0]

GIVEN: list[tuple[Callable[..., Any], tuple[Any, ...], Any]] = [
    (octets.text_octets, ("",), b""),
    (octets.text_octets, ("aé",), b"a\xc3\xa9"),
    (octets.text_value, (b"\0",), ""),
    (octets.text_value, (b"a\xc3\xa9\0",), "aé"),
    (octets.text_value, (b"",), ""),
    (octets.wide_octets, ("",), b""),
    (octets.wide_octets, ("aあ",), b"\xff\xfea\0\x42\x30"),
    (octets.wide_value, (b"",), ""),
    (octets.wide_value, (b"\xff\xfea\0",), "a"),
    (octets.wide_value, (b"\xfe\xff\0a",), "a"),
    (octets.wide_value, (b"\x30\x42\0a",), "あa"),
    (octets.wide_value, (b"\0a\0b", 2), "ab"),
    (octets.wide_value, (b"\xff\xfea\0b\0", 2), "ab"),
    (octets.unit_octets, ("aあ", True), b"a\0\x42\x30"),
    (octets.unit_octets, ("aあ", False), b"\0a\x30\x42"),
    (octets.unit_text, (b"a\0\x42\x30", True), "aあ"),
    (octets.unit_text, (b"\0a\x30\x42", False), "aあ"),
    *((octets.unit_number, (chr(n),), n) for n in (0, 0x3042, 0xD7FF, 0xE000, 0xFFFF)),
    *((octets.unit_character, (n,), chr(n)) for n in (0, 0xD7FF, 0xE000, 0xFFFF)),
    (octets.wide_character, ("あ",), b"\x02\x30\x42"),
    (octets.wide_character_value, (b"\x02\x30\x42",), "あ"),
    (octets.fixed_octets, (Decimal("12.34"), 5, 2), bytes.fromhex("01234c")),
    (octets.fixed_octets, (Decimal("-12.34"), 4, 2), bytes.fromhex("01234d")),
    (octets.fixed_octets, (Decimal("99.99"), 4, 2), bytes.fromhex("09999c")),
    (octets.fixed_octets, (Decimal("12e1"), 4, 1), bytes.fromhex("01200c")),
    (octets.fixed_octets, (Decimal("1e2"), 3, 0), bytes.fromhex("100c")),
    (octets.fixed_octets, (Decimal("1.20"), 3, 1), bytes.fromhex("012c")),
    (octets.fixed_octets, (Decimal("-0"), 1, 0), bytes.fromhex("0c")),
    (octets.fixed_octets, (Decimal("0e999"), 3, 0), bytes.fromhex("000c")),
    (octets.fixed_octets, (Decimal("0e-999"), 3, 0), bytes.fromhex("000c")),
    (octets.fixed_octets, (Decimal("10e-98") * 0, 3, 0), bytes.fromhex("000c")),
    (octets.fixed_value, (bytes.fromhex("01234d"), 4, 2), Decimal("-12.34")),
    (octets.fixed_value, (bytes.fromhex("12345c"), 5, 0), Decimal(12345)),
    (octets.fixed_value, (bytes.fromhex("000c"), 3, 1), Decimal("0.0")),
    (octets.exact, ([1, 2], 2), [1, 2]),
    (octets.flat, ([1, 2], (2,)), [1, 2]),
    (octets.flat, ([[1, 2], [3, 4], [5, 6]], (3, 2)), [1, 2, 3, 4, 5, 6]),
    (octets.flat, ([[[1], [2]], [[3], [4]]], (2, 2, 1)), [1, 2, 3, 4]),
    (octets.nested, ([1, 2], (2,)), [1, 2]),
    (octets.nested, ([1, 2, 3, 4, 5, 6], (3, 2)), [[1, 2], [3, 4], [5, 6]]),
    (octets.nested, ([1, 2, 3, 4], (2, 2, 1)), [[[1], [2]], [[3], [4]]]),
    *((octets.flags_number, (n, 3), n) for n in (0, 1, 7)),
]
REFUSED: list[tuple[Callable[..., Any], tuple[Any, ...], str]] = [
    (octets.text_octets, ("a\0",), "a string cannot hold NUL"),
    (octets.text_value, (b"a",), "a string has to end with its only NUL"),
    (octets.text_value, (b"a\0b\0",), "a string has to end with its only NUL"),
    (octets.wide_octets, ("a\0",), "a wstring cannot hold NUL"),
    (octets.wide_value, (b"\0a\0\0",), "a wstring cannot hold NUL"),
    (octets.wide_value, (b"\0a\0b\0c", 2), "wrong length"),
    (octets.wide_value, (b"\xfe\xff\0a\0b\0c", 2), "wrong length"),
    (octets.unit_octets, ("\0", True), "a wstring cannot hold NUL"),
    (octets.unit_text, (b"\0\0", True), "a wstring cannot hold NUL"),
    *(
        (
            octets.unit_number,
            (chr(n),),
            "a wchar is one character of the basic multilingual plane",
        )
        for n in (0xD800, 0xDFFF, 0x10000)
    ),
    (octets.unit_character, (0xD800,), "a wchar cannot be the surrogate 0xd800"),
    (octets.unit_character, (0xDFFF,), "a wchar cannot be the surrogate 0xdfff"),
    (
        octets.wide_character,
        ("\U00010000",),
        "a wchar is one character of the basic multilingual plane",
    ),
    (
        octets.wide_character,
        ("ab",),
        "a wchar is one character of the basic multilingual plane",
    ),
    (octets.wide_character_value, (b"\x04\0\0\0\0",), "a wchar of 4 octets"),
    (octets.fixed_octets, (1.5, 3, 1), "a fixed is a finite Decimal"),
    (octets.fixed_octets, (Decimal("nan"), 3, 1), "a fixed is a finite Decimal"),
    (
        octets.fixed_octets,
        (Decimal("1.25"), 3, 1),
        "more than 1 digits after the point",
    ),
    (octets.fixed_octets, (Decimal("1e-99"), 3, 1), "more than 1 digits after"),
    (octets.fixed_octets, (Decimal("1e-101"), 3, 0), "more than 0 digits after"),
    (octets.fixed_octets, (Decimal("100"), 4, 2), "more than 4 digits"),
    (octets.fixed_octets, (Decimal("1000"), 3, 0), "more than 3 digits"),
    (octets.fixed_octets, (Decimal("1e3"), 3, 0), "more than 3 digits"),
    (octets.fixed_octets, (Decimal("1e9999"), 3, 0), "more than 3 digits"),
    *(
        (octets.fixed_value, (bytes.fromhex(text), 4, 2), "not a fixed")
        for text in ("01234e", "01234b", "0a234c", "12345c")
    ),
    (octets.exact, ([1], 2), "1 items instead of 2"),
    (octets.flat, ([[1, 2]], (2, 2)), "1 items instead of 2"),
    (octets.flat, ([[1, 2], [3]], (2, 2)), "1 items instead of 2"),
    (octets.flat, ([1, 2, 3], (2,)), "3 items instead of 2"),
    (octets.flags_number, (8, 3), "8 has more than 3 bits"),
    (octets.flags_number, (-1, 3), "-1 has more than 3 bits"),
]


@pytest.mark.parametrize(("convert", "given", "result"), GIVEN)
def test_conversions(
    convert: Callable[..., Any], given: tuple[Any, ...], result: Any
) -> None:
    found = convert(*given)
    assert found == result
    assert type(found) is type(result)
    if isinstance(result, Decimal):
        assert found.as_tuple() == result.as_tuple()


@pytest.mark.parametrize(("convert", "given", "message"), REFUSED)
def test_refusals(
    convert: Callable[..., Any], given: tuple[Any, ...], message: str
) -> None:
    with pytest.raises((ValueError, TypeError)) as caught:
        convert(*given)
    assert str(caught.value).startswith(message)


QUADS = [
    (0.0, "0000" + "0" * 28),
    (-0.0, "8000" + "0" * 28),
    (1.0, "3fff" + "0" * 28),
    (-1.5, "bfff8" + "0" * 27),
    (2.0**1023, "43fe" + "0" * 28),
    (2.0**-1022, "3c01" + "0" * 28),
    (1.0000000000000002, "3fff0000000000001" + "0" * 15),
    (MIN_SUBNORMAL, "3bcd" + "0" * 28),
    (3 * MIN_SUBNORMAL, "3bce8" + "0" * 27),
    (math.inf, "7fff" + "0" * 28),
    (-math.inf, "ffff" + "0" * 28),
]
"""Floats and their exact representations in IEEE 754 binary128."""


@pytest.mark.parametrize(("number", "text"), QUADS)
def test_long_doubles(number: float, text: str) -> None:
    expected = bytes.fromhex(text)
    assert octets.quad_octets(number, False) == expected
    assert octets.quad_octets(number, True) == expected[::-1]
    for little_endian in (False, True):
        data = octets.quad_octets(number, little_endian)
        found = octets.quad_value(data, little_endian)
        assert struct.pack(">d", found) == struct.pack(">d", number)


def test_long_doubles_that_are_no_numbers() -> None:
    data = octets.quad_octets(NOT_A_NUMBER, False)
    assert data.hex() == "7fff8000000000001" + "0" * 15
    assert struct.pack(">d", octets.quad_value(data, False)).hex() == "7ff8000000000001"
    # A payload in low bits alone is still not a number.
    low = bytes.fromhex("7fff" + "0" * 27 + "1")
    assert math.isnan(octets.quad_value(low, False))


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("3fff00000000000008" + "0" * 14, 1.0),  # A tie goes to even,
        ("3fff00000000000018" + "0" * 14, 1.0 + 2**-51),  # in either direction;
        ("3fff00000000000008" + "0" * 13 + "1", 1.0 + 2**-52),  # beyond it upwards.
        ("43fe" + "f" * 12 + "e" + "0" * 15, math.ldexp(1 - 2**-52, 1024)),
        ("3b00" + "0" * 28, 0.0),
        ("0000" + "0" * 27 + "1", 0.0),
        ("4070" + "0" * 28, 2.0**113),
        ("406f" + "0" * 28, 2.0**112),
        ("406e" + "0" * 28, 2.0**111),
    ],
)
def test_the_nearest_float(text: str, number: float) -> None:
    assert octets.quad_value(bytes.fromhex(text), False) == number


def test_a_long_double_beyond_a_float() -> None:
    with pytest.raises(OverflowError):
        octets.quad_value(bytes.fromhex("43ff" + "0" * 28), False)


REFERENCES = {
    None: (">4x I x 3x I", (1, 0)),
    ObjectReference("IDL:A:1.0", ()): (">4x I 10s 2x I", (10, b"IDL:A:1.0", 0)),
    ObjectReference("ab", ((7, b"xyz"), (8, b""))): (
        ">4x I 3s x I I I 3s x I I",
        (3, b"ab", 2, 7, 3, b"xyz", 8, 0),
    ),
}


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("order", ["<", ">"])
def test_references(reference: ObjectReference | None, order: str) -> None:
    form, numbers = REFERENCES[reference]
    expected = struct.pack(form.replace(">", order), *numbers)
    out = bytearray(b"\0")
    octets.write_reference(out, reference, order == "<")
    assert bytes(out) == expected
    found, end = octets.read_reference(expected, 1, order == "<")
    nil = reference is None or not reference.profiles
    assert found == (None if nil else reference)
    assert end == len(expected)


@pytest.mark.parametrize(
    ("form", "numbers", "message"),
    [
        (">I 2s", (3, b"a\0"), "3 octets, and 2 are left"),
        (">I x 3x I 7x", (1, 1), "1 profiles, and 7 octets are left"),
        (">I x 3x I I I x", (1, 1, 0, 2), "2 octets, and 1 are left"),
        (">I 2s", (2, b"ab"), "a string has to end with its only NUL"),
    ],
)
def test_references_that_are_none(
    form: str, numbers: tuple[Any, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        octets.read_reference(struct.pack(form, *numbers), 0, False)


def test_a_reference_of_as_many_octets_as_there_are() -> None:
    data = struct.pack(">I x 3x I I I", 1, 1, 5, 0)
    assert octets.read_reference(data, 0, False) == (
        ObjectReference("", ((5, b""),)),
        len(data),
    )
