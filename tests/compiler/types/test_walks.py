"""Marshalling along descriptors, without compiled codecs: octets of each kind of type, and rejected
values with their paths.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from decimal import Decimal
from types import SimpleNamespace
from typing import Any

import pytest

from rtgen.runtime import idl
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    Descriptor,
    EnumDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    PrimitiveDescriptor,
)
from rtgen.runtime.marshalling.dynamic.octet_reader import Input, OctetReader
from rtgen.runtime.marshalling.dynamic.reader import Reader, read_dynamic
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer, write_dynamic
from rtgen.runtime.marshalling.errors import LOCATED, Fault
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.values import AnyValue, DynamicUnion, DynamicValue


def basic(name: str) -> PrimitiveDescriptor:
    return PrimitiveDescriptor(name)


OCTET, LONG, DOUBLE = basic("octet"), basic("long"), basic("double")
COLOUR = EnumDescriptor("IDL:C:1.0", "W::Colour", (("RED", 0), ("GREEN", 5)))
FLAGS = FlagsDescriptor("IDL:F:1.0", "W::Flags", (("A", 0), ("B", 11)), 12)
BITS = idl.bitset(
    "W::Bits",
    20,
    low=idl.bits(3, 0),
    high=idl.bits(2, 18, signed=True),
)
PAIR = idl.struct("W::Pair", first=OCTET, second=LONG)
BAD = idl.exception("W::Bad", why=idl.STRING)
CHOICE = idl.union(
    "W::Choice",
    LONG,
    number=idl.case(DOUBLE, 1, 2),
    text=idl.case(idl.string(3), 3),
)
THING = InterfaceDescriptor("IDL:W/Thing:1.0", "W::Thing")
ABSTRACT = InterfaceDescriptor("IDL:W/Abstract:1.0", "W::Abstract", abstract=True)
REFERENCE = ObjectReference("IDL:W/Thing:1.0", ((7, b"abc"), (8, b"")))
REFERRED = ("I 16s I I I 3s x I I", (16, b"IDL:W/Thing:1.0\0", 2, 7, 3, b"abc", 8, 0))
LINK = idl.link("W::Pair", lambda: PAIR)
ALIAS = idl.alias("W::Number", LONG)


def pair(first: Any, second: Any) -> DynamicValue:
    return DynamicValue(PAIR, {"first": first, "second": second})


def choice(discriminator: Any, value: Any) -> DynamicUnion:
    return DynamicUnion(CHOICE, discriminator, value)


def bits(low: int, high: int) -> SimpleNamespace:
    return SimpleNamespace(low=low, high=high)


Case = tuple[Descriptor, Any, str, tuple[Any, ...]]
"""A type, a value, and its octets after one other octet: a format of `struct`, and its values."""

NUMBERS = {
    "short": ("x h", -2),
    "unsigned short": ("x H", 0xFFFF),
    "long": ("3x i", -3),
    "unsigned long": ("3x I", 0xFFFFFFFF),
    "long long": ("7x q", -4),
    "unsigned long long": ("7x Q", 1 << 63),
    "int8": ("b", -5),
    "uint8": ("B", 255),
    "octet": ("B", 128),
    "float": ("3x f", 0.5),
    "double": ("7x d", 0.1),
}
CASES: list[Case] = [
    *((basic(n), value, form, (value,)) for n, (form, value) in NUMBERS.items()),
    (basic("boolean"), True, "B", (1,)),
    (basic("boolean"), False, "B", (0,)),
    (basic("char"), "é", "B", (0xE9,)),
    (basic("wchar"), "あ", "3s", (b"\x02\x30\x42",)),
    (idl.STRING, "", "3x I x", (1,)),
    (idl.STRING, "aé", "3x I 3s x", (4, b"a\xc3\xa9")),
    (idl.string(2), "ab", "3x I 2s x", (3, b"ab")),
    (idl.WSTRING, "", "3x I", (0,)),
    (idl.wstring(2), "ab", "3x I 6s", (6, b"\xff\xfea\0b\0")),
    (idl.fixed(4, 2), Decimal("-12.34"), "3s", (bytes.fromhex("01234d"),)),
    (COLOUR, 5, "3x I", (5,)),
    (FLAGS, 0x801, "x H", (0x801,)),
    (idl.sequence(LONG), [], "3x I", (0,)),
    (idl.sequence(LONG, 2), [7, -8], "3x I 2i", (2, 7, -8)),
    (idl.sequence(DOUBLE), [0.5], "3x I d", (1, 0.5)),
    (idl.sequence(OCTET, 3), b"\1\2\3", "3x I 3s", (3, b"\1\2\3")),
    (idl.sequence(basic("char")), "aé", "3x I 2s", (2, b"a\xe9")),
    (idl.sequence(idl.sequence(LONG)), [[1], []], "3x I I i I", (2, 1, 1, 0)),
    (idl.array(LONG, 2), [1, 2], "3x 2i", (1, 2)),
    (idl.array(LONG, 2, 2), [[1, 2], [3, 4]], "3x 4i", (1, 2, 3, 4)),
    (idl.array(OCTET, 2), b"\1\2", "2s", (b"\1\2",)),
    (idl.array(basic("char"), 2, 1), ["a", "b"], "2s", (b"ab",)),
    (idl.array(basic("null"), 2), [None, None], "", ()),
    (idl.map_(LONG, OCTET), {}, "3x I", (0,)),
    (idl.map_(LONG, OCTET, 2), {1: 2, 3: 4}, "3x I i B 3x i B", (2, 1, 2, 3, 4)),
    (PAIR, pair(1, 2), "B 2x i", (1, 2)),
    (LINK, pair(1, 2), "B 2x i", (1, 2)),
    (ALIAS, 5, "3x i", (5,)),
    (CHOICE, choice(2, 0.5), "3x i d", (2, 0.5)),
    (CHOICE, choice(3, "abc"), "3x i I 3s x", (3, 4, b"abc")),
    (CHOICE, choice(9, None), "3x i", (9,)),
    (basic("Object"), None, "3x I x 3x I", (1, 0)),
    (THING, REFERENCE, f"3x {REFERRED[0]}", REFERRED[1]),
    (ABSTRACT, REFERENCE, f"B 2x {REFERRED[0]}", (1, *REFERRED[1])),
    (ABSTRACT, None, "B 2x I", (0, 0)),
    (basic("ValueBase"), None, "3x I", (0,)),
    (basic("null"), None, "", ()),
    (basic("void"), None, "", ()),
    (ANY, AnyValue(LONG, 5), "3x I i", (3, 5)),
    (basic("CORBA::TypeCode"), DOUBLE, "3x I", (7,)),
]
ORDERS = pytest.mark.parametrize("little", [True, False], ids=["little", "big"])


def packed(form: str, numbers: tuple[Any, ...], *, little: bool) -> bytes:
    return struct.pack(f"{'<' if little else '>'} {form}", *numbers)


@ORDERS
@pytest.mark.parametrize(("type_", "value", "form", "numbers"), CASES)
def test_octets(
    type_: Descriptor, value: Any, form: str, numbers: tuple[Any, ...], little: bool
) -> None:
    expected = b"\7" + packed(f"x {form}", numbers, little=little)[1:]
    for write in (
        lambda out: Writer(out, little).value(type_, value),
        lambda out: Writer(out, little, walking=True).value(type_, value),
        lambda out: write_dynamic(out, value, type_, little),
    ):
        out = bytearray(b"\7")
        write(out)
        assert bytes(out) == expected
    for walking in (False, True):
        reader = Reader(expected, little, 1, walking)
        assert same(reader.value(type_), value)
        assert reader.offset == len(expected)
        reader.end()
    found, end = read_dynamic(expected, 1, type_, little)
    assert same(found, value)
    assert end == len(expected)


def same(found: Any, value: Any) -> bool:
    if isinstance(value, DynamicValue):
        return (found.first, found.second) == (value.first, value.second)
    if isinstance(value, DynamicUnion):
        return (found.discriminator, found.value) == (value.discriminator, value.value)
    return bool(found == value)


@ORDERS
@pytest.mark.parametrize(("type_", "value", "form", "numbers"), CASES)
def test_octets_that_end_early(
    type_: Descriptor, value: Any, form: str, numbers: tuple[Any, ...], little: bool
) -> None:
    whole = packed(f"x {form}", numbers, little=little)
    for end in range(1, len(whole)):
        with pytest.raises(LOCATED):
            Reader(whole[:end], little, 1).value(type_)
    reader = Reader(whole + b"\0\0", little, 1)
    reader.value(type_)
    with pytest.raises(Fault, match=r"^2 octets too many$"):
        reader.end()


@ORDERS
def test_bitsets(little: bool) -> None:
    expected = packed("4x I", (5 | 2 << 18,), little=little)
    out = bytearray(1)
    Writer(out, little).value(BITS, bits(5, -2))
    assert bytes(out) == expected
    assert Reader(expected, little, 1).value(BITS) == 5 | 2 << 18


@ORDERS
def test_an_exception_in_an_any_has_its_id(little: bool) -> None:
    bad = DynamicValue(BAD, {"why": "no"})
    out = Output()
    Writer(out, little).value(ANY, AnyValue(BAD, bad))
    head = out.index(b"IDL:W/Bad:1.0\0", out.index(b"IDL:W/Bad:1.0\0") + 1)
    assert bytes(out[head - 4 :]) == packed(
        "I 14s 2x I 3s", (14, b"IDL:W/Bad:1.0\0", 3, b"no\0"), little=little
    )
    found = Reader(bytes(out), little).value(ANY)
    assert found.value.why == "no"
    other = bytes(out[:head]) + bytes(out[head:]).replace(b"Bad", b"Mad")
    fault = refused(lambda: Reader(other, little).value(ANY))
    assert fault == (".value", "IDL:W/Mad:1.0 instead of IDL:W/Bad:1.0")


def refused(call: Callable[[], object]) -> tuple[str, str]:
    """Return the path and the message of a fault."""
    with pytest.raises(LOCATED) as caught:
        call()
    if isinstance(caught.value, Fault):
        error = caught.value.error("")
        return error.path, error.message
    return "", str(caught.value)


WRONG_VALUES: list[tuple[Descriptor, Any, str, str]] = [
    (basic("boolean"), 2, "", "a bool is needed, not 2"),
    (basic("char"), "あ", "", "one character of ISO 8859-1 is needed, not 'あ'"),
    (basic("char"), "ab", "", "one character of ISO 8859-1 is needed, not 'ab'"),
    (basic("char"), 5, "", "one character of ISO 8859-1 is needed, not 5"),
    (basic("null"), 5, "", "null has no value, so not 5"),
    (basic("void"), 5, "", "void has no value, so not 5"),
    (basic("octet"), 256, "", "256 is out of the range of octet"),
    (basic("long"), "x", "", "a value of long is needed, not 'x'"),
    (basic("float"), 1e39, "", "1e+39 is out of the range of float"),
    (idl.STRING, 5, "", "a str is needed, not int"),
    (idl.string(2), "abc", "", "3 octets of UTF-8, and 2 are the most"),
    (idl.wstring(2), "abc", "", "3 UTF-16 units, and 2 are the most"),
    (COLOUR, 1, "", "1 is not a member of W::Colour"),
    (FLAGS, 0x1000, "", "4096 is not a value of W::Flags"),
    (FLAGS, -1, "", "-1 is not a value of W::Flags"),
    (FLAGS, "x", "", "'x' is not a value of W::Flags"),
    (BITS, bits(8, 0), ".low", "8 does not fit into 3 bits"),
    (BITS, bits(0, 2), ".high", "2 does not fit into 2 bits"),
    (BITS, 5, "", "a value of W::Bits is needed, not int"),
    (idl.sequence(LONG, 2), [1, 2, 3], "", "3 items, and 2 are the most"),
    (idl.sequence(LONG, 1), [1, "x"], "[1]", "a value of long is needed, not 'x'"),
    (idl.sequence(LONG), [1, "x"], "[1]", "a value of long is needed, not 'x'"),
    (idl.sequence(LONG), 5, "", "a list is needed, not int"),
    (idl.sequence(LONG), "ab", "", "a list is needed, not str"),
    (idl.sequence(LONG), {1: 2}, "", "a list is needed, not dict"),
    (idl.sequence(OCTET), [1], "", "bytes are needed, not list"),
    (idl.sequence(OCTET, 1), b"ab", "", "2 items, and 1 are the most"),
    (idl.sequence(basic("char")), b"a", "", "str are needed, not bytes"),
    (idl.sequence(basic("char")), "aあ", "[1]", "'あ' is not in ISO 8859-1"),
    (idl.array(LONG, 2), [1], "", "1 items instead of 2"),
    (idl.array(LONG, 2), ["x"], "[0]", "a value of long is needed, not 'x'"),
    (idl.array(LONG, 2, 2), [[1, 2]], "", "1 items instead of 2"),
    (idl.array(LONG, 2, 2), [[1, 2], [3]], "[1]", "1 items instead of 2"),
    (idl.array(OCTET, 2), b"a", "", "1 items instead of 2"),
    (idl.map_(LONG, OCTET), [1], "", "a dict is needed, not list"),
    (idl.map_(LONG, OCTET, 1), {1: 2, 3: 4}, "", "2 items, and 1 are the most"),
    (
        idl.map_(LONG, OCTET),
        {1: 2, "k": 3},
        "['k']",
        "a value of long is needed, not 'k'",
    ),
    (idl.map_(LONG, OCTET), {1: 256}, "[1]", "256 is out of the range of octet"),
    (PAIR, pair(1, "x"), ".second", "a value of long is needed, not 'x'"),
    (PAIR, 5, "", "a value of W::Pair is needed, not int"),
    (CHOICE, choice(1, "x"), ".number", "a value of double is needed, not 'x'"),
    (CHOICE, choice("x", 1), ".discriminator", "a value of long is needed, not 'x'"),
    (CHOICE, choice(9, 5), "", "no branch has the discriminator 9"),
    (CHOICE, 5, "", "a value of W::Choice is needed, not int"),
    (THING, 5, "", "an object reference is needed, not int"),
    (ANY, 5, "", "an AnyValue is needed, not int"),
    (ANY, AnyValue(LONG, "x"), ".value", "a value of long is needed, not 'x'"),
    (basic("ValueBase"), 5, "", "a value is needed, not int"),
]


@ORDERS
@pytest.mark.parametrize(("type_", "value", "path", "message"), WRONG_VALUES)
def test_wrong_values(
    type_: Descriptor, value: Any, path: str, message: str, little: bool
) -> None:
    found = refused(lambda: Writer(Output(), little, True).value(type_, value))
    assert found == (path, message)


WRONG_OCTETS: list[tuple[Descriptor, str, tuple[Any, ...], str, str]] = [
    (basic("boolean"), "B", (2,), "", "2 is not a boolean"),
    (basic("wchar"), "3s", (b"\4\0\0",), "", "a wchar of 4 octets"),
    (COLOUR, "I", (1,), "", "1 is not a member of W::Colour"),
    (FLAGS, "H", (0x1000,), "", "4096 has more than 12 bits"),
    (BITS, "I", (1 << 20,), "", "1048576 has more than 20 bits"),
    (idl.STRING, "I 2s", (3, b"a\0"), "", "a length of 3, and 2 octets are left"),
    (idl.string(1), "I 3s", (3, b"ab\0"), "", "2 octets of UTF-8, and 1 are the most"),
    (
        idl.wstring(1),
        "I 6s",
        (6, b"\xff\xfea\0b\0"),
        "",
        "2 UTF-16 units, and 1 are the most",
    ),
    (idl.sequence(LONG), "I i", (2, 0), "", "a length of 2, and 4 octets are left"),
    (idl.sequence(LONG, 1), "I 2i", (2, 0, 0), "", "2 items, and 1 are the most"),
    (idl.sequence(DOUBLE), "I d", (2, 0), "", "a length of 2, and 8 octets are left"),
    (
        idl.sequence(basic("boolean")),
        "I BB",
        (2, 1, 7),
        "[1]",
        "7 is not a boolean",
    ),
    (
        idl.array(basic("boolean"), 2, 2),
        "4s",
        (b"\1\1\1\7",),
        "[1][1]",
        "7 is not a boolean",
    ),
    (
        idl.map_(OCTET, OCTET),
        "I BB",
        (3, 1, 1),
        "",
        "a length of 3, and 2 octets are left",
    ),
    (
        idl.map_(OCTET, OCTET, 1),
        "I 4B",
        (2, 1, 1, 2, 2),
        "",
        "2 items, and 1 are the most",
    ),
    (idl.map_(OCTET, OCTET), "I 4B", (2, 1, 1, 1, 2), "", "a key that is there twice"),
    (
        idl.map_(OCTET, basic("boolean")),
        "I 4B",
        (2, 1, 1, 2, 7),
        "[1]",
        "7 is not a boolean",
    ),
    (PAIR, "B", (1,), ".second", "truncated: 4 octets are needed, 0 are left"),
    (
        CHOICE,
        "i I 5s",
        (3, 5, b"abcd\0"),
        ".text",
        "4 octets of UTF-8, and 3 are the most",
    ),
    (CHOICE, "2x", (), ".discriminator", "truncated: 4 octets are needed, 2 are left"),
    (THING, "I x 3x I 7x", (1, 1), "", "a length of 1, and 7 octets are left"),
    (basic("ValueBase"), "I", (5,), "", "0x5 does not begin a value"),
    (basic("ValueBase"), "I", (0x7FFFFEFF,), "", "0x7ffffeff does not begin a value"),
    (basic("ValueBase"), "I", (0x80000000,), "", "0x80000000 does not begin a value"),
    (
        basic("ValueBase"),
        "I",
        (0x7FFFFF00,),
        "",
        "a value without its type",
    ),
    (basic("ValueBase"), "I i", (0xFFFFFFFF, -4), "", "an indirection to no value"),
    (
        basic("ValueBase"),
        "I I 4s",
        (0x7FFFFF02, 4, b"IDL\0"),
        "",
        "IDL is not known",
    ),
    (
        basic("ValueBase"),
        "I I i",
        (0x7FFFFF02, 0xFFFFFFFF, -9),
        "",
        "an indirection to no repository id",
    ),
    (
        basic("ValueBase"),
        "I I i",
        (0x7FFFFF02, 0xFFFFFFFF, -4),
        "",
        "an indirection to no repository id",
    ),
    (
        basic("ValueBase"),
        "I I 404x",
        (0x7FFFFF06, 101),
        "",
        "101 repository ids, and 100 are the most",
    ),
    (
        idl.array(basic("null"), 1 << 30),
        "",
        (),
        "[0]",
        "more values than the octets account for",
    ),
]


@ORDERS
@pytest.mark.parametrize(("type_", "form", "numbers", "path", "message"), WRONG_OCTETS)
def test_wrong_octets(
    type_: Descriptor,
    form: str,
    numbers: tuple[Any, ...],
    path: str,
    message: str,
    little: bool,
) -> None:
    data = packed(form, numbers, little=little)
    found = refused(lambda: Reader(data, little, walking=True).value(type_))
    assert found == (path, message)


# Octets in chunks, as inside of values.


def chunked(data: bytes, *, little: bool = False) -> OctetReader:
    """Return a reader inside of a value, before its first chunk."""
    reader = OctetReader(data, little)
    reader._level = 1
    return reader


def test_octets_of_several_chunks() -> None:
    data = struct.pack(">i 2s 2x i 5s 3x i 4s", 2, b"ab", 5, b"cdefg", 4, b"hijk")
    reader = chunked(data)
    assert reader._octets(9) == b"abcdefghi"
    assert reader._octets(2) == b"jk"
    assert reader.offset == len(data)
    assert chunked(data)._octets(0) == b""
    assert OctetReader(data, False)._octets(3) == b"\0\0\0"


def test_numbers_are_in_one_chunk() -> None:
    data = struct.pack(">i B 3x I i H", 8, 1, 7, 2, 9)
    reader = chunked(data)
    assert reader._number("B") == 1
    assert reader._number("I") == 7
    assert reader._number("H") == 9
    reader = chunked(struct.pack(">i 2x 2x i I", 2, 4, 7))
    with pytest.raises(Fault, match=r"^truncated: 4 octets are needed, 2 are left$"):
        reader._number("I")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (struct.pack(">i", 0), "a value ends before its state does"),
        (struct.pack(">i", -1), "a value ends before its state does"),
        (struct.pack(">i", 0x7FFFFF00), "a value ends before its state does"),
        (struct.pack(">i 3x", 4), "a chunk is longer than the remaining octets"),
        (b"\0\0\0", "truncated: 4 octets are needed, 3 are left"),
        (b"", "truncated: 4 octets are needed, 0 are left"),
    ],
)
def test_what_is_no_chunk(data: bytes, message: str) -> None:
    with pytest.raises(Fault) as caught:
        chunked(data)._octets(1)
    assert str(caught.value) == message


def test_a_chunk_behind_the_end_of_its_value() -> None:
    reader = chunked(struct.pack(">i B", 1, 5))
    reader._closed = 1
    with pytest.raises(Fault, match=r"^a value ends before its state does$"):
        reader._octets(1)


def test_chunks_begin_at_multiples_of_four() -> None:
    reader = OctetReader(struct.pack("<4x i", 7), True, 1)
    assert reader._between("i") == 7
    assert reader.offset == 8


def test_skipped_octets() -> None:
    reader = OctetReader(b"abcdef", False, 2)
    reader._skip(3)
    assert reader.offset == 5
    reader._skip(1)
    assert reader.offset == 6
    with pytest.raises(Fault, match=r"^a chunk is longer than the remaining octets$"):
        reader._skip(1)


def test_the_work_for_an_input_is_bounded_by_its_size() -> None:
    data = Input(b"abcd")
    assert data.work == 100_000 + 16 * 4
    assert data.values == {}
    assert data == b"abcd"
    kept = OctetReader(data, True)
    assert kept._data is data
