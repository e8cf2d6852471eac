"""Octets of ROS 2 messages: wide strings, octets behind a message, the formats of other types."""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from seeds import cases

from rtgen import api
from rtgen.ros2.rosidl import load
from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, CdrError
from rtgen.runtime.marshalling.descriptors import StructDescriptor
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.runtime.xcdr import decode, encode
from rtgen.tools.recording.schema_types import message_classes

WIDE = """
wstring text
wstring<=3 few
wstring[2] pair
wstring[<=3] some
uint8 last
"""
OTHERS = {
    "Fixed": "float64[3] a\nint8 b\nint16 c\n",
    "Numbers": "float32[] a\nint16[] b\nuint8 c\n",
    "Texts": "string a\nstring[] b\nbool c\n",
    "Records": "Fixed[] a\nFixed[2] b\nbyte[] c\n",
    "Empty": "",
}


@pytest.fixture(scope="module")
def classes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("messages")
    paths = []
    for name, text in {"Wide": WIDE, **OTHERS}.items():
        path = folder / "lab" / "msg" / f"{name}.msg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        paths.append(path)
    result = load(paths, root=folder)
    assert not result.diagnostics
    found = message_classes(result.model)
    return {name.rpartition("/")[2]: type_ for name, type_ in found.items()}


def words(text: str) -> bytes:
    """Return a wide string as rmw_fastrtps, rmw_cyclonedds and rmw_zenoh write it."""
    units = text.encode("utf-16-le")
    count = len(units) // 2
    return struct.pack(f"<{count + 1}I", count, *struct.unpack(f"<{count}H", units))


def test_wide_strings(classes: dict[str, Any]) -> None:
    value = classes["Wide"]("aé表😀", "abc", ["", "x"], ["ü"], 7)
    expected = words("aé表😀") + words("abc") + words("") + words("x")
    expected += struct.pack("<I", 1) + words("ü") + b"\x07"
    assert value.to_cdr() == expected
    assert encoded(value) == b"\x00\x01\x00\x00" + expected
    assert classes["Wide"].from_cdr(expected) == value
    big = value.to_cdr(little_endian=False)
    assert big[:8] == struct.pack(">II", 5, ord("a"))
    assert classes["Wide"].from_cdr(big, little_endian=False) == value


@given(st.lists(st.text(st.characters(exclude_characters="\0")), max_size=3))
def test_any_wide_strings(texts: list[str]) -> None:
    class Some(Aggregated):
        _descriptor_ = idl.struct(
            "lab::msg::Some", texts=idl.sequence(idl.WSTRING), last=idl.OCTET
        )
        texts: list[str]
        last: int

    value = Some(texts, 1)
    try:
        expected = struct.pack("<I", len(texts)) + b"".join(map(words, texts))
    except UnicodeEncodeError:
        with pytest.raises(CdrError, match=r"Some.texts\[\d\]"):
            value.to_cdr()
        return
    assert value.to_cdr() == expected + b"\x01"
    assert Some.from_cdr(value.to_cdr()) == value


@pytest.mark.parametrize(
    ("octets", "why"),
    [
        (struct.pack("<II", 1, 0xD83D), "Wide.text: .*surrogate|unexpected end"),
        (struct.pack("<II", 1, 0x10000), "Wide.text: 0x10000 is not a unit of UTF-16"),
        (struct.pack("<II", 1, 0), "Wide.text: a wstring cannot hold NUL"),
        (struct.pack("<I", 9), "Wide.text: a length of 9, and 0 octets are left"),
        (words("") + words("abcd"), "Wide.few: 4 items, and 3 are the most"),
        (b"\x00", "Wide.text: "),
    ],
)
def test_damaged_wide_strings(classes: dict[str, Any], octets: bytes, why: str) -> None:
    for decoding in (
        lambda: classes["Wide"].from_cdr(octets),
        lambda: decoded(classes["Wide"], b"\x00\x01\x00\x00" + octets),
    ):
        with pytest.raises(CdrError, match=why):
            decoding()


def test_values_that_have_no_octets(classes: dict[str, Any]) -> None:
    for text, few in (("a\0", ""), ("\ud800", ""), ("", "abcd")):
        with pytest.raises(CdrError, match="Wide.few" if few else "Wide.text"):
            classes["Wide"](text, few, ["", ""], [], 0).to_cdr()


def test_wide_strings_of_other_types_are_those_of_corba() -> None:
    """Also of a message in another type, and of a message that CORBA transports."""
    text = """
    module lab { module msg { struct Text { wstring text; }; };
    struct Other { wstring text; msg::Text message; }; };
    """
    found = message_classes(api.read(text).model)
    message, other = found["lab/msg/Text"], found["lab/Other"]
    corba = b"\x04\x00\x00\x00\xff\xfea\x00"
    assert other("a", message("a")).to_cdr() == corba + corba
    assert other.from_cdr(corba + corba) == other("a", message("a"))
    assert encode(message, message("a"), 0, True) == corba
    assert decode(message, corba, 0, True) == message("a")


def random_value(drawn: random.Random, descriptor: StructDescriptor) -> Any:
    """Return a value with sequences of up to 3 elements, of few shapes."""
    texts = ("", "a", "表b")

    def of(type_: Any) -> Any:
        kind = type(type_).__name__
        if kind == "StructDescriptor":
            return random_value(drawn, type_)
        if kind in ("ArrayDescriptor", "SequenceDescriptor"):
            many = kind == "SequenceDescriptor"
            bound = getattr(type_, "bound", None) or 3
            count = drawn.randint(0, bound) if many else type_.dimensions[0]
            values = [of(type_.element) for _ in range(count)]
            return bytes(values) if str(type_.element) == "octet" else values
        if kind == "StringDescriptor":
            return drawn.choice(texts)
        return drawn.random() < 0.5 if str(type_) == "boolean" else drawn.randint(0, 9)

    values = {m.attribute: of(m.type) for m in descriptor.members}
    return descriptor.class_(**values)


@pytest.mark.parametrize("name", ["Wide", *OTHERS])
def test_what_follows_a_message_is_ignored(name: str, classes: dict[str, Any]) -> None:
    """In any order of lengths: decoders learn the sizes of shapes that recur."""
    type_ = classes[name]
    for number in cases(200):
        drawn = random.Random(number)
        value = random_value(drawn, type_._descriptor_)
        little = drawn.random() < 0.7
        octets = bytes((0, little, 0, 0)) + value.to_cdr(little)
        more = drawn.randbytes(drawn.choice((0, 0, 1, 4, 8, 24)))
        assert decoded(type_, octets + more) == value
        cut = octets[: drawn.randrange(len(octets))]
        with pytest.raises(CdrError):
            decoded(type_, cut)


def test_other_representations(classes: dict[str, Any]) -> None:
    """A message is classic CDR, whatever the project's types are written in."""

    class Xcdr2(Aggregated):
        _descriptor_ = idl.struct(
            "lab::msg::Xcdr2", idl.traits(representation=2), a=idl.OCTET, b=idl.DOUBLE
        )
        a: int
        b: float

    value = Xcdr2(1, 2.5)
    assert len(value.to_cdr()) == 12
    assert encoded(value) == b"\x00\x01\x00\x00\x01" + bytes(7) + struct.pack("<d", 2.5)
    assert decoded(Xcdr2, encoded(value)) == value
