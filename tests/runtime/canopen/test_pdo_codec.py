"""PDO codecs: generated from random mappings, compared with a plain writer and `canopen`."""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import black
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from type_checkers import check_by_mypy

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.pdo_codec import Codecs, PdoCodec
from rtgen.compiler.backends.kit.python_module import python_module
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.pdo import (
    Kind,
    Mapped,
    Part,
    PdoField,
    PdoLayout,
    PdoLayoutError,
    Slot,
    layout,
)
from rtgen.compiler.model.canopen import BITS, SIGNED, UNSIGNED, DataType
from rtgen.runtime.canopen.pdo import PdoError

QUICK = settings(max_examples=150, deadline=None)
OPTIONS = Options("codec", "codec", "1")
INTEGERS = {**SIGNED, **UNSIGNED}


def module_text(codecs: Sequence[PdoCodec]) -> str:
    """Return a module with both functions of each codec."""
    body = render("canopen/pdo_codecs.py.j2", codecs=Codecs(codecs, codecs))
    return python_module("codec.py", OPTIONS, (), "Codecs.", body=body).text


def compiled(mapped: Sequence[Mapped], name: str = "tpdo1") -> ModuleType:
    """Return the module with the codec of a mapping."""
    module = ModuleType("codec")
    text = module_text([PdoCodec(name, name.upper(), layout(mapped))])
    exec(compile(text, "codec", "exec"), module.__dict__)
    return module


def codec(mapped: Sequence[Mapped]) -> tuple[Callable[..., bytes], Callable[..., Any]]:
    """Return the two functions of a mapping's codec."""
    module = compiled(mapped)
    return module.encode_tpdo1, module.decode_tpdo1


def bits_of(entry: Mapped, value: Any) -> int:
    """Return the bits of a value, by the definition of its type."""
    if entry.data_type == DataType.REAL32:
        return int.from_bytes(struct.pack("<f", value), "little")
    if entry.data_type == DataType.REAL64:
        return int.from_bytes(struct.pack("<d", value), "little")
    if entry.data_type == DataType.VISIBLE_CHAR:
        return ord(value)
    if entry.data_type == DataType.VISIBLE_STRING:
        return int.from_bytes(value.encode("latin-1"), "little")
    if isinstance(value, bytes):
        return int.from_bytes(value, "little")
    return int(value) & (1 << entry.bits) - 1


def written(mapped: Sequence[Mapped], values: Sequence[Any]) -> bytes:
    """Return the data of a PDO, bit after bit."""
    number, at, left = 0, 0, list(values)
    for entry in mapped:
        if entry.name is not None:
            number |= bits_of(entry, left.pop(0)) << at
        at += entry.bits
    return number.to_bytes((at + 7) // 8, "little")


def values_of(entry: Mapped) -> st.SearchStrategy[Any]:
    """Return values of a field, including its limits."""
    code, bits = entry.data_type, entry.bits
    if code in SIGNED:
        half = 1 << bits - 1
        return st.sampled_from([-half, half - 1, -1, 0]) | st.integers(-half, half - 1)
    if code in UNSIGNED:
        return st.sampled_from([0, (1 << bits) - 1]) | st.integers(0, (1 << bits) - 1)
    match code:
        case DataType.BOOLEAN:
            return st.booleans()
        case DataType.REAL32:
            return st.floats(width=32, allow_nan=False)
        case DataType.REAL64:
            return st.floats(allow_nan=False)
        case DataType.VISIBLE_CHAR:
            return st.characters(max_codepoint=255)
        case DataType.VISIBLE_STRING:
            text = st.text(st.characters(min_codepoint=1, max_codepoint=255))
            return text.map(lambda t: t[: bits // 8]).filter(is_latin)
    return st.binary(min_size=bits // 8, max_size=bits // 8)


def is_latin(text: str) -> bool:
    """Return whether text in Latin-1 is not UTF-8, too: ASCII is both."""
    try:
        return text.isascii() or not text.encode("latin-1").decode("utf-8")
    except UnicodeDecodeError:
        return True


@st.composite
def mappings(draw: st.DrawFn, aligned: bool = False) -> list[Mapped]:
    """Draw mappings of up to 64 bits, with gaps."""
    found: list[Mapped] = []
    left = 64
    while left and draw(st.integers(0, 9)):
        code = draw(
            st.sampled_from([*BITS, DataType.VISIBLE_STRING, DataType.OCTET_STRING])
        )
        at = 64 - left
        if code in INTEGERS and not aligned:
            bits = draw(st.integers(1, INTEGERS[code]))
        elif code in BITS:
            bits = 8 if aligned and code == DataType.BOOLEAN else BITS[code]
        else:
            bits = 8 * draw(st.integers(1, 8))
            if at % 8:
                continue
        gap = draw(st.integers(0, 6)) == 0
        if bits <= left and code not in (
            DataType.TIME_OF_DAY,
            DataType.TIME_DIFFERENCE,
        ):
            found.append(Mapped(None if gap else f"f{len(found)}", code, bits))
            left -= bits
        else:
            break
    return found


@pytest.mark.sampled(0)
@QUICK
@given(st.data())
def test_random_mappings(data: st.DataObject) -> None:
    mapped = data.draw(mappings())
    fields = [entry for entry in mapped if entry.name is not None]
    encode, decode = codec(mapped)
    values = [data.draw(values_of(entry)) for entry in fields]
    expected = written(mapped, values)
    assert encode(*values) == expected
    assert decode(expected) == tuple(values)
    assert decode(expected + b"\xff") == tuple(values)
    if expected:
        with pytest.raises(PdoError):
            decode(expected[:-1])


@QUICK
@given(st.data())
def test_gaps_are_not_read(data: st.DataObject) -> None:
    mapped = data.draw(mappings())
    encode, decode = codec(mapped)
    fields = [entry for entry in mapped if entry.name is not None]
    values = [data.draw(values_of(entry)) for entry in fields]
    noise, at = 0, 0
    for entry in mapped:
        if entry.name is None:
            noise |= ((1 << entry.bits) - 1) << at
        at += entry.bits
    noisy = int.from_bytes(encode(*values), "little") | noise
    assert decode(noisy.to_bytes((at + 7) // 8, "little")) == tuple(values)


@pytest.mark.nightly
@pytest.mark.peer
@QUICK
@given(st.data())
def test_black_leaves_it(data: st.DataObject) -> None:
    mapped = data.draw(mappings())
    length = data.draw(st.integers(1, 120))
    named = [
        Mapped(e.name and (e.name + "x" * length), e.data_type, e.bits) for e in mapped
    ]
    text = module_text([PdoCodec("rpdo512", "RPDO 512", layout(named))])
    assert black.format_str(text, mode=black.Mode()) == text


@QUICK
@given(st.data())
def test_as_canopen_packs_octets(data: st.DataObject) -> None:
    """If every field begins and ends at an octet, the package's own coding is right."""
    canopen = pytest.importorskip(
        "canopen", reason="the package canopen is not installed"
    )
    logging.getLogger("canopen").setLevel(logging.ERROR)
    mapped = [e for e in data.draw(mappings(aligned=True)) if e.data_type in INTEGERS]
    mapped = [Mapped(f"f{n}", e.data_type, e.bits) for n, e in enumerate(mapped)]
    values = [data.draw(values_of(entry)) for entry in mapped]
    node = canopen.RemoteNode(1, canopen.ObjectDictionary())
    canopen.Network().add_node(node)
    pdo = canopen.pdo.base.PdoMap(node.tpdo, None, None)
    for number, entry in enumerate(mapped):
        variable = canopen.objectdictionary.ODVariable(entry.name, 0x2000 + number)
        variable.data_type = int(entry.data_type)
        node.object_dictionary.add_object(variable)
        pdo.add_variable(0x2000 + number, 0, entry.bits)
    for field, value in zip(pdo.map, values, strict=True):
        field.raw = value
    encode, decode = codec(mapped)
    assert encode(*values) == bytes(pdo.data)
    assert decode(bytes(pdo.data)) == tuple(field.raw for field in pdo.map)


@pytest.mark.parametrize(("code", "bits"), INTEGERS.items())
@pytest.mark.parametrize("before", [0, 1])
def test_limits(code: DataType, bits: int, before: int) -> None:
    mapped = [Mapped(None, DataType.BOOLEAN, before)] * before
    width = bits - before
    mapped.append(Mapped("f", code, width))
    encode, decode = codec(mapped)
    low = -(1 << width - 1) if code in SIGNED else 0
    high = (1 << width - 1) - 1 if code in SIGNED else (1 << width) - 1
    for value in (low, high):
        assert decode(encode(value)) == (value,)
    for value in (low - 1, high + 1, 1 << 80):
        with pytest.raises(PdoError):
            encode(value)
    for other in ("1", None, 0.5):
        with pytest.raises(PdoError):
            encode(other)


def test_one_call_for_octets() -> None:
    """The format of four INTEGER16, of widths without a letter, and of shared octets."""
    words = [Mapped(f"f{n}", DataType.INTEGER16, 16) for n in range(4)]
    assert layout(words).format == "<hhhh"
    odd = [Mapped("a", DataType.INTEGER24, 24), Mapped("b", DataType.UNSIGNED40, 40)]
    assert layout(odd).format == "<HbIB"
    shared = [Mapped(f"b{n}", DataType.BOOLEAN, 1) for n in range(8)]
    shared.append(Mapped("w", DataType.INTEGER16, 16))
    assert layout(shared).format == "<Bh"
    crossing = [Mapped("a", DataType.UNSIGNED8, 4), Mapped("b", DataType.UNSIGNED8, 8)]
    assert (layout(crossing).format, layout(crossing).size) == ("<H", 2)
    gap = [Mapped(None, DataType.UNSIGNED16, 16), Mapped("a", DataType.UNSIGNED8, 8)]
    assert layout(gap).format == "<2xB"
    bits = [Mapped(None, 0, 3), Mapped(None, 0, 5), *gap[1:], Mapped(None, 0, 12)]
    assert (layout(bits).format, layout(bits).size) == ("<1xB2x", 4)


def test_slots() -> None:
    """A gap of any type, a shared slot that ends inside an octet, and its size."""
    mapped = [
        Mapped(None, DataType.REAL32, 16),
        Mapped("level", DataType.INTEGER16, 16),
        Mapped(None, DataType.BOOLEAN, 1),
        Mapped("on", DataType.BOOLEAN, 1),
        Mapped("speed", DataType.INTEGER8, 7),
    ]
    level = PdoField("level", Kind.SIGNED, 16)
    on = PdoField("on", Kind.BOOLEAN, 1, 1)
    speed = PdoField("speed", Kind.SIGNED, 7, 2)
    slots = (
        Slot((Part("2x", 16),), (), whole=True),
        Slot((Part("h", 16),), (level,), whole=True),
        Slot((Part("H", 16),), (on, speed), whole=False),
    )
    assert layout(mapped) == PdoLayout(slots, 6)
    assert layout(mapped).fields == (level, on, speed)
    assert layout(mapped[:2]) == PdoLayout(slots[:2], 4)
    assert layout([]) == PdoLayout((), 0)
    assert layout([Mapped(None, 0, 64)]).size == 8


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("é", b"\xe9"),
        ("漢", b"\xe6\xbc\xa2"),
        ("Ã©", b"\xc3\x83\xc2\xa9"),
        ("a\0b", b"a\0b"),
    ],
)
def test_texts_are_those_of_objects(text: str, data: bytes) -> None:
    encode, decode = codec([Mapped("t", DataType.VISIBLE_STRING, 64)])
    assert encode(text) == data.ljust(8, b"\0")
    assert decode(data.ljust(8, b"\0")) == (text.partition("\0")[0],)


def test_values_that_do_not_fit() -> None:
    encode, _ = codec([Mapped("t", DataType.VISIBLE_STRING, 32)])
    assert encode("ab") == b"ab\0\0"
    for value in ("abcde", "漢字", "\ud800"):
        with pytest.raises(PdoError):
            encode(value)
    encode, _ = codec([Mapped("o", DataType.OCTET_STRING, 16)])
    with pytest.raises(PdoError):
        encode(b"abc")
    encode, _ = codec([Mapped("r", DataType.REAL32, 32)])
    with pytest.raises(PdoError):
        encode(1e39)


@pytest.mark.parametrize(
    ("mapped", "reason"),
    [
        (
            [Mapped("a", DataType.UNSIGNED64, 64), Mapped("b", DataType.BOOLEAN, 1)],
            "65 bits; a PDO has up to 64",
        ),
        (
            [Mapped("a", DataType.BOOLEAN, 1), Mapped("b", DataType.VISIBLE_STRING, 8)],
            "b does not begin and end at an octet",
        ),
        ([Mapped("a", DataType.REAL32, 16)], "a has 16 bits, not 32"),
        ([Mapped("a", DataType.REAL64, 32)], "a has 32 bits, not 64"),
        ([Mapped("a", DataType.VISIBLE_CHAR, 7)], "a has 7 bits, not 8"),
        ([Mapped("a", DataType.UNSIGNED8, 0)], "a has no bits"),
        ([Mapped(None, DataType.UNSIGNED8, 0)], "a gap has no bits"),
        (
            [Mapped("a", DataType.OCTET_STRING, 12)],
            "a does not begin and end at an octet",
        ),
    ],
)
def test_what_cannot_be_laid_out(mapped: list[Mapped], reason: str) -> None:
    with pytest.raises(PdoLayoutError, match=f"^{reason}$"):
        layout(mapped)


@pytest.mark.slow
def test_types(tmp_path: Path) -> None:
    """A module with every kind of field is right by mypy --strict."""
    kinds = [
        Mapped("on", DataType.BOOLEAN, 1),
        Mapped("level", DataType.INTEGER8, 5),
        Mapped("error", DataType.REAL32, 32),
    ]
    whole = [
        Mapped("ok", DataType.BOOLEAN, 8),
        Mapped("text", DataType.VISIBLE_STRING, 16),
        Mapped("raw", DataType.OCTET_STRING, 8),
        Mapped("chr", DataType.VISIBLE_CHAR, 8),
        Mapped("wide", DataType.INTEGER24, 24),
    ]
    codecs = [
        PdoCodec("tpdo1", "TPDO 1", layout(kinds)),
        PdoCodec("rpdo1", "RPDO 1", layout(whole)),
        PdoCodec("rpdo2", "RPDO 2", layout([])),
    ]
    file = tmp_path / "codec.py"
    file.write_text(module_text(codecs), encoding="utf-8")
    check_by_mypy([file], [tmp_path])
