"""Bounds of values marshalled along their descriptors: chunks, tags, lengths, paths of errors.

Values that are cut into chunks, end within others, or are truncated; hostile tags; messages.
"""

from __future__ import annotations

import re
import struct
from decimal import Decimal
from typing import Any

import emitted
import pytest

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.descriptors import (
    MapDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
)
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.values import decoded, encoded
from rtgen.runtime.marshalling.dynamic.writer import ID_LIST
from rtgen.runtime.marshalling.errors import Fault
from rtgen.runtime.marshalling.octets import (
    ObjectReference,
    fixed_octets,
    fixed_value,
)
from rtgen.runtime.values import AnyValue, DynamicValue

IDL = """
module Dyn {
  enum K { k0, k1, k2 };
  struct A { long x; };
  valuetype V { public long x; private V next; };
  valuetype Text string;
  valuetype Other { public long y; };
  abstract valuetype AV { void g(); };
  custom valuetype C { public long x; };
  interface I { void f(); };
  valuetype Octets { public octet a; public octet b[3]; public char c[2]; public long d; };
  valuetype Holds { public ::Dyn::Text a; public ::Dyn::A b; public I f; };
  struct Anything { ValueBase a; ValueBase b; };
  struct Particular { ValueBase a; V b; };
  valuetype Base { public long x; };
  valuetype Far : truncatable Base { public V one; public V two; public long after; };
  struct Both { Base a; Base b; long c; };
  struct Labelled { string label; ValueBase value; };
};
"""
OCTET = PrimitiveDescriptor("octet")
CHAR = PrimitiveDescriptor("char")
NOTHING = StructDescriptor("IDL:Nothing:1.0", "Nothing", ())


@pytest.fixture(scope="module")
def dyn(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("bounds"), IDL).dyn


def refused(type_: Any, text: str, message: str) -> None:
    """Check the end of the message for octets in hexadecimal."""
    with pytest.raises(CdrError, match=f": {re.escape(message)}$"):
        type_.from_cdr(bytes.fromhex(text))


# Basic types and collections.


@pytest.mark.parametrize("little_endian", [True, False])
def test_a_long_double_in_an_any(little_endian: bool) -> None:
    value = AnyValue(PrimitiveDescriptor("long double"), -1.5)
    octets = value.to_cdr(little_endian)
    quad = bytes.fromhex("bfff8000000000000000000000000000")
    # The kind, then alignment to 8.
    assert octets[4:] == bytes(4) + (quad[::-1] if little_endian else quad)
    again = AnyValue.from_cdr(octets, little_endian)
    assert again.value == -1.5
    with pytest.raises(CdrError, match="16 octets are needed, 15 are left"):
        AnyValue.from_cdr(octets[:-1], little_endian)


def test_an_enumerator_of_a_known_type_is_a_member(dyn: Any) -> None:
    again = AnyValue.from_cdr(AnyValue(dyn.K, dyn.K.k1).to_cdr())
    assert again.value is dyn.K.k1


def test_an_object_reference_in_an_any() -> None:
    object_ = PrimitiveDescriptor("Object")
    reference = ObjectReference("IDL:X:1.0", ((0xFFFFFFFF, b"x"), (0, b"")))
    for sent in (reference, ObjectReference("IDL:X:1.0", ((0, b""),))):
        again = AnyValue.from_cdr(AnyValue(object_, sent).to_cdr())
        assert again.value == sent


def test_items_without_octets(dyn: Any) -> None:
    nothings = SequenceDescriptor(NOTHING)
    members = (MemberDescriptor("a", nothings), MemberDescriptor("b", OCTET))
    holder = StructDescriptor("IDL:Holder:1.0", "Holder", members)
    value = DynamicValue(holder, {"a": [DynamicValue(NOTHING, {})], "b": 7})
    octets = encoded(holder, value, True)
    assert octets == bytes.fromhex("01000000 07")
    again = decoded(holder, octets, True)
    assert (len(again.a), again.b) == (1, 7)
    assert again.a[0].described() is NOTHING
    entries = MapDescriptor(OCTET, NOTHING)
    made = decoded(entries, bytes.fromhex("01000000 09"), True)
    assert list(made) == [9]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("more", "accepted"), [(62, True), (63, False)])
def test_values_without_octets_are_counted(more: int, accepted: bool) -> None:
    """There may be 100,000 values, and 16 for each octet."""
    octets = struct.pack("<I", 1000) + bytes(1000)
    element = StructDescriptor("IDL:E:1.0", "E", _members(115, NOTHING))
    members = (MemberDescriptor("all", SequenceDescriptor(element)),)
    members += _members(more, NOTHING)
    reader = Reader(octets, True)
    descriptor = StructDescriptor("IDL:S:1.0", "S", members)
    if accepted:
        assert len(reader.value(descriptor).all) == 1000
    else:
        with pytest.raises(Fault, match="more values than the octets account for"):
            reader.value(descriptor)


def _members(count: int, type_: Any) -> tuple[MemberDescriptor, ...]:
    return tuple(MemberDescriptor(f"m{number}", type_) for number in range(count))


def test_the_last_character_of_iso_8859_1() -> None:
    text = SequenceDescriptor(CHAR)
    assert decoded(text, encoded(text, "\xff", True), True) == "\xff"
    with pytest.raises(CdrError, match=r"\[1\].*not in ISO 8859-1"):
        AnyValue(text, "a\u0100").to_cdr()
    assert encoded(CHAR, "\xff", True) == b"\xff"
    with pytest.raises(CdrError, match="of ISO 8859-1 is needed, not '\u0100'"):
        encoded(CHAR, "\u0100", True)


def test_the_fault_of_an_item_precedes_that_of_its_sequence(dyn: Any) -> None:
    few = AnyValue(SequenceDescriptor(dyn.A._descriptor_, 1), [dyn.A(1), dyn.A("x")])
    with pytest.raises(CdrError) as caught:
        few.to_cdr()
    assert caught.value.path.endswith(".value[1].x")


def test_a_list_that_cannot_be_iterated() -> None:
    class Sized:
        def __len__(self) -> int:
            return 1

    with pytest.raises(CdrError, match="a list is needed, not Sized"):
        AnyValue(SequenceDescriptor(PrimitiveDescriptor("long")), Sized()).to_cdr()


def test_an_unknown_kind_of_type_code() -> None:
    with pytest.raises(CdrError, match="a type code of kind 4294967294"):
        AnyValue.from_cdr(b"\xfe" + b"\xff" * 3)


@pytest.mark.parametrize("zeros", [1, 2, 5])
def test_zeros_after_the_digits_of_a_fixed(zeros: int) -> None:
    value = Decimal("1.2" + "0" * zeros)
    assert fixed_octets(value, 3, 1) == bytes.fromhex("012c")
    with pytest.raises(ValueError, match="more than 0 digits after the point"):
        fixed_octets(value, 3, 0)


def test_a_fixed_of_an_even_number_of_digits_has_a_zero_before_them() -> None:
    assert fixed_value(bytes.fromhex("09999c"), 4, 0) == 9999
    with pytest.raises(ValueError, match="not a fixed"):
        fixed_value(bytes.fromhex("10000c"), 4, 0)


# Chunks.


@pytest.mark.parametrize("little_endian", [True, False])
def test_arrays_of_octets_inside_of_a_value(dyn: Any, little_endian: bool) -> None:
    value = dyn.Octets(1, b"\2\3\4", "ab", 5)
    octets = value.to_cdr(little_endian)
    assert octets[8:14] == b"\1\2\3\4ab"
    again = dyn.Octets.from_cdr(octets, little_endian)
    assert (again.a, again.b, again.c, again.d) == (1, b"\2\3\4", "ab", 5)


def test_a_reference_inside_of_a_value(dyn: Any) -> None:
    reference = ObjectReference("IDL:X:1.0", ((0xFFFFFFFF, b"x"), (0, b"")))
    value = dyn.Holds(dyn.Text("t"), dyn.A(1), reference)
    for little_endian in (True, False):
        octets = value.to_cdr(little_endian)
        assert dyn.Holds.from_cdr(octets, little_endian).f == reference


@pytest.mark.parametrize(
    ("text", "message"),
    [
        # One more chunk, and octets after the state within its chunk.
        (
            "08ffff7f 08000000 01000000 00000000 04000000 00000000 ffffffff",
            "a value continues after the end of its state",
        ),
        (
            "08ffff7f 08000000 01000000 00000000 00000000 ffffffff",
            "a value continues after the end of its state",
        ),
        (
            "08ffff7f 0c000000 01000000 00000000 00000000 ffffffff",
            "4 octets too many in a chunk",
        ),
        (
            "08ffff7f 08000000 01000000 00000000 feffffff",
            "an end tag -2 at level 1",
        ),
        (
            "08ffff7f 04000000 01000000 00ffff7f 04000000 02000000 ffffffff",
            "a value without chunks inside of one that has them",
        ),
        # The header of a value inside of a chunk, or a tag that is none.
        (
            "08ffff7f 08000000 01000000 08ffff7f 08000000 02000000 00000000 ffffffff",
            "0x7fffff08 does not begin a value",
        ),
        (
            "08ffff7f 04000000 01000000 00000080 ffffffff",
            "a value ends before its state does",
        ),
        ("08ffff7f 0400", "truncated: 4 octets are needed, 2 are left"),
        ("08ffff7f 05000000 01000000", "a chunk is longer than the remaining octets"),
    ],
)
def test_damaged_chunks(dyn: Any, text: str, message: str) -> None:
    refused(dyn.V, text, message)


def tagged(tag: int, *ids: str, state: bytes = b"") -> bytes:
    """Return a value with that tag, the texts after it, and its state; several have a count."""
    octets = struct.pack("<I", tag)
    if tag & ID_LIST == ID_LIST:
        octets += struct.pack("<I", len(ids))
    for each in ids:
        text = each.encode() + b"\0"
        octets += bytes(-len(octets) % 4) + struct.pack("<I", len(text)) + text
    return octets + bytes(-len(octets) % 4) + state


def test_values_that_cannot_be_read(dyn: Any) -> None:
    ids = ("IDL:Dyn/Unknown:1.0", "IDL:Dyn/V:1.0")
    unknown = tagged(0x7FFFFF06, *ids, state=bytes(8)).hex()
    refused(dyn.V, unknown, "IDL:Dyn/Unknown:1.0 is not known, and has no chunks")
    abstract = tagged(0x7FFFFF0A, "IDL:Dyn/AV:1.0", state=bytes(4)).hex()
    refused(dyn.Anything, abstract, "Dyn::AV is abstract: it has no state here")
    custom = tagged(0x7FFFFF0A, "IDL:Dyn/C:1.0", state=bytes(4)).hex()
    refused(dyn.Anything, custom, "Dyn::C is custom: it has no state here")
    other = tagged(0x7FFFFF0A, "IDL:Dyn/Other:1.0", state=bytes(4)).hex()
    refused(dyn.V, other, "a Dyn::V is needed, not a Dyn::Other")
    with pytest.raises(CdrError, match="C is custom: it has no state that is known"):
        dyn.C(1).to_cdr()


def test_the_tag_of_a_value(dyn: Any) -> None:
    """A value may have the place of its implementation, and up to 100 repository ids."""
    state = bytes.fromhex("08000000 05000000 00000000 ffffffff")
    own, place = "IDL:Dyn/V:1.0", "http://example.org/"
    for octets in (
        tagged(0x7FFFFF08, state=state),
        tagged(0x7FFFFF09, place, state=state),
        tagged(0x7FFFFF0A, own, state=state),
        tagged(0x7FFFFF0B, place, own, state=state),
        tagged(0x7FFFFF0E, *["IDL:Unknown:1.0"] * 99, own, state=state),
    ):
        assert dyn.V.from_cdr(octets).x == 5
    many = tagged(0x7FFFFF0E, *["IDL:Unknown:1.0"] * 100, own, state=state)
    refused(dyn.V, many.hex(), "101 repository ids, and 100 are the most")


def test_a_repository_id_at_the_start_of_a_body(dyn: Any) -> None:
    text = "IDL:Dyn/V:1.0"
    octets = struct.pack("<I16s", 14, text.encode())
    octets += struct.pack("<IIi", 0x7FFFFF0A, 0xFFFFFFFF, -28)
    octets += bytes.fromhex("08000000 05000000 00000000 ffffffff")
    again = dyn.Labelled.from_cdr(octets)
    assert (again.label, type(again.value), again.value.x) == (text, dyn.V, 5)


def test_the_end_of_a_value_in_the_rest_of_a_truncated_one(dyn: Any) -> None:
    ids = ("IDL:Unknown:1.0", "IDL:Dyn/Base:1.0")
    state = bytes.fromhex("04000000 01000000 08ffff7f 04000000 02000000")
    octets = tagged(0x7FFFFF0E, *ids, state=state)
    for end in ("feffffff ffffffff", "ffffffff"):
        assert dyn.Base.from_cdr(octets + bytes.fromhex(end)).x == 1
    refused(dyn.Base, octets.hex() + "fdffffff", "an end tag -3 at level 2")
    for tag in ("00ffff7f", "02ffff7f"):
        without = octets.hex().replace("08ffff7f", tag) + "feffffff ffffffff"
        message = "a value without chunks inside of one that has them"
        refused(dyn.Base, without, message)


def test_an_indirection_leads_to_a_value_of_the_needed_type(dyn: Any) -> None:
    value = dyn.V(1)
    octets = dyn.Anything(value, value).to_cdr()
    again = dyn.Particular.from_cdr(octets)
    assert again.b is again.a
    other = dyn.Other(1)
    octets = dyn.Anything(other, other).to_cdr()
    refused(dyn.Particular, octets.hex(), "a Dyn::V is needed, not a Dyn::Other")


@pytest.mark.parametrize("little_endian", [True, False])
def test_a_truncated_value_ends_after_the_values_inside(
    dyn: Any, little_endian: bool
) -> None:
    """The rest of its state has chunks, nested values of two levels, and ends of both."""
    deep = dyn.V(1, dyn.V(2, dyn.V(3)))
    for one, two in ((deep, dyn.V(4)), (dyn.V(4), deep), (None, deep), (deep, None)):
        value = dyn.Both(dyn.Far(5, one, two, 6), dyn.Base(7), 8)
        octets = value.to_cdr(little_endian)
        again = dyn.Both.from_cdr(octets, little_endian)
        assert (type(again.a), again.a.after) == (dyn.Far, 6)
        unknown = octets.replace(b"IDL:Dyn/Far:1.0", b"IDL:Dyn/Fax:1.0")
        again = dyn.Both.from_cdr(unknown, little_endian)
        assert (type(again.a), again.a.x) == (dyn.Base, 5)
        assert (again.b.x, again.c) == (7, 8)
        for end in range(0, len(unknown), 4):
            with pytest.raises(CdrError):
                dyn.Both.from_cdr(unknown[:end], little_endian)


# Paths.


def test_paths_in_values(dyn: Any) -> None:
    for value, path in (
        (dyn.Holds(dyn.Text(5)), "Holds.a.value"),
        (dyn.Holds(b=dyn.A("x")), "Holds.b.x"),
        (dyn.Both(dyn.Far(1, dyn.V("x"))), "Both.a.one.x"),
    ):
        with pytest.raises(CdrError) as caught:
            value.to_cdr()
        assert caught.value.path == path
    octets = dyn.Holds(dyn.Text("text")).to_cdr()
    damaged = octets.replace(b"text", b"te\0t").hex()
    refused(dyn.Holds, damaged, "a string has to end with its only NUL")
    with pytest.raises(CdrError) as caught:
        dyn.Holds.from_cdr(bytes.fromhex(damaged))
    assert caught.value.path == "Holds.a.value"
    octets = dyn.Both(dyn.Far(1, dyn.V(0x01020304))).to_cdr()
    with pytest.raises(CdrError) as caught:
        dyn.Both.from_cdr(octets.replace(b"\x08\0\0\0\4", b"\x09\0\0\0\4"))
    assert caught.value.path == "Both.a.one"
    with pytest.raises(CdrError) as caught:
        dyn.Both.from_cdr(octets[:-8])
    assert caught.value.path == "Both.b"


def test_the_message_for_the_value_in_a_box(dyn: Any) -> None:
    with pytest.raises(CdrError, match=r"^Holds\.a\.value: a str is needed, not int$"):
        dyn.Holds(dyn.Text(5)).to_cdr()


def test_a_value_without_a_member(dyn: Any) -> None:
    value = dyn.V(1)
    del value.x
    with pytest.raises(CdrError, match=r"^V\.x: a value of Dyn::V is needed, not V$"):
        value.to_cdr()
