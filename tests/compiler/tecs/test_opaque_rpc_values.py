"""Basic values, error codes and texts on the wire, by `opaque-rpc-wire`."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import pytest

from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_MAGIC,
    E_NOMEM,
    E_PAR,
    E_RPC,
    ERCD,
    MERCD,
    NETWORK,
    SERCD,
    ProtocolError,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.channel import More
from rtgen.runtime.opaque_rpc.tdr import BIG, INT8, LITTLE, UINT8, Items, Order, Tdr
from rtgen.runtime.opaque_rpc.values import (
    ByteBudget,
    Text,
    WideText,
    cast,
    element,
    exactly,
    is_rpc_error,
    leading,
    present,
    quotient,
    remainder,
    shifted_left,
    shifted_right,
    size_error,
)


def test_composite_codes_are_those_that_c_clients_return() -> None:
    assert ERCD(E_RPC, E_MAGIC) == -25924
    assert ERCD(E_RPC, E_BOVR) == -14660
    assert (MERCD(-25924), SERCD(-25924)) == (E_RPC, E_MAGIC)
    assert (MERCD(E_RPC), SERCD(E_RPC)) == (E_RPC, -1)
    assert ProtocolError(E_MAGIC, "bad SOP").code == -25924


@pytest.mark.parametrize(
    ("code", "expected"),
    [(188, True), (-68, True), (-4420, True), (-67, False), (-17, False), (0, False)],
)
def test_the_low_byte_tells_that_outs_are_left_out(code: int, expected: bool) -> None:
    assert is_rpc_error(code) is expected


@pytest.mark.parametrize(
    ("order", "widths"),
    [("network", (2, 4, 4, 4)), ("little", (2, 4, 8, 8)), ("big", (2, 4, 8, 8))],
)
def test_widths_of_c_types(order: Order, widths: tuple[int, ...]) -> None:
    tdr = make_tdr(order)
    assert tuple(tdr.struct(kind).size for kind in "knlp") == widths
    assert tuple(tdr.struct(kind).size for kind in "KNLP") == widths


def test_widths_can_be_told() -> None:
    tdr = make_tdr("network", short_bits=32, int_bits=16, long_bits=64, intptr_bits=16)
    assert tdr.struct("knlp").format == ">ihqh"
    assert tdr.struct("2KN3LP").format == ">2IH3QH"
    with pytest.raises(ValueError, match="24 bits"):
        make_tdr("little", long_bits=24)
    unknown: Any = "middle"
    with pytest.raises(ValueError, match="'middle' is not a TDR"):
        make_tdr(unknown)


def test_128_bits_have_their_words_swapped_in_network_order_only() -> None:
    value = 0x0102030405060708_1112131415161718
    low_first = "11121314151617180102030405060708"
    high_first = "01020304050607081112131415161718"
    assert NETWORK.wide(value, True).hex() == low_first
    assert make_tdr(low_word_first=False).wide(value, True).hex() == high_first
    assert make_tdr("big").wide(value, True).hex() == high_first
    assert LITTLE.wide(value, True) == bytes.fromhex(high_first)[::-1]
    for tdr in (NETWORK, LITTLE):
        assert tdr.from_wide(tdr.wide(-5, True), True) == -5
        assert Items(tdr, "w").integers(Items(tdr, "w").pack([-1, 7]), 2) == [-1, 7]


@pytest.mark.parametrize(
    ("tdr", "kind", "values", "octets"),
    [
        (NETWORK, "b", [-1, 200], "ffc8"),
        (NETWORK, "h", [1, -2], "0001fffe"),
        (LITTLE, "h", [1, -2], "0100feff"),
        (BIG, "H", [0xFFFE], "fffe"),
        (LITTLE, "i", [1], "01000000"),
        (NETWORK, "W", [2**128 - 2], "fffffffffffffffeffffffffffffffff"),
        (LITTLE, "W", [2**128 - 2, 1], "fe" + "ff" * 15 + "01" + "00" * 15),
        (LITTLE, "w", [-2], "fe" + "ff" * 15),
    ],
)
def test_items_of_arrays(tdr: Tdr, kind: str, values: list[int], octets: str) -> None:
    items = Items(tdr, kind)
    data = items.pack(values)
    assert data.hex() == octets
    assert items.width * len(values) == len(data)
    read = items.integers(data, len(values))
    assert read == ([-1, -56] if kind == "b" else values)
    assert items.integers(b"\x12\x34\x56" + data + b"\x78", len(values), 3) == read
    assert items.integers(data, 0) == []


def test_arrays_of_many_128_bit_integers() -> None:
    items = Items(LITTLE, "w")
    values = list(range(-20, 20))
    assert items.integers(items.pack(values) + bytes(160), len(values)) == values


def test_the_order_of_octets_of_a_number() -> None:
    assert NETWORK.int16(0x672A) == BIG.int16(0x672A) == b"\x67\x2a"
    assert LITTLE.int16(0x672A) == b"\x2a\x67"


def test_items_that_are_no_integers() -> None:
    assert Items(LITTLE, "?").pack([True, False]) == b"\1\0"
    assert Items(LITTLE, "?").booleans(b"\1\0\2\1\0", 3) == [True, False, True]
    assert Items(LITTLE, "?").booleans(b"\1\0\2\1\0", 3, 2) == [True, True, False]
    data = Items(BIG, "d").pack([0.5, -2.0])
    assert data.hex() == "3fe0000000000000c000000000000000"
    assert Items(BIG, "d").floats(b"\0" + data, 2, 1) == [0.5, -2.0]


def test_octets_are_taken_with_either_sign() -> None:
    assert (INT8[-1], INT8[255], INT8[-128], INT8[127]) == (-1, -1, -128, 127)
    assert (UINT8[-1], UINT8[255], UINT8[-128], UINT8[0]) == (255, 255, 128, 0)
    for value in (256, -129):
        assert value not in UINT8
        assert value not in INT8


@pytest.mark.parametrize(
    ("text", "most", "units"),
    [
        ("tecs", 16, "746563730000"),
        ("a" * 15, 16, "61" * 15 + "00"),
        ("a" * 16, 16, "61" * 16),
        ("a" * 14, 16, "61" * 14 + "0000"),
        ("", 1, "00"),
        ("", 16, "0000"),
        ("tecs", None, "7465637300"),
        ("", None, "00"),
    ],
)
def test_units_of_a_text(text: str, most: int | None, units: str) -> None:
    assert Text(NETWORK, "latin-1").units(text, most).hex() == units
    wide = WideText(NETWORK, "H")
    assert wide.units([ord(letter) for letter in text], most)[1::2].hex() == units


def test_texts_that_cannot_be_sent() -> None:
    text = Text(NETWORK, "latin-1")
    for wrong, most in (("a" * 17, 16), ("a\0b", None), ("\u3042", None)):
        with pytest.raises(ValueError, match=r"."):
            text.units(wrong, most)
    with pytest.raises(ValueError, match=r"^a NUL inside a text$"):
        text.units("a\0")
    with pytest.raises(ValueError, match=r"^a zero inside a text$"):
        WideText(NETWORK, "H").units([7, 0])
    with pytest.raises(ValueError, match=r"^a text of 3 units, at most 2 fit$"):
        WideText(NETWORK, "H").units([1, 1, 1], 2)


@pytest.mark.parametrize(
    ("tdr", "size"), [(NETWORK, "00000003"), (LITTLE, "03000000"), (BIG, "00000003")]
)
def test_a_text_has_its_length_before_it(tdr: Tdr, size: str) -> None:
    narrow, wide = Text(tdr, "latin-1"), WideText(tdr, "h")
    assert narrow.whole("ab").hex() == size + "616200"
    assert wide.whole([1, 1]) == bytes.fromhex(size) + Items(tdr, "h").pack([1, 1, 0])
    assert narrow.whole("a", 3).hex() == size + "610000"
    assert wide.whole([1], 3) == bytes.fromhex(size) + Items(tdr, "h").pack([1, 0, 0])
    assert narrow.read(octets(narrow.whole("ab")), ByteBudget(3), 3) == "ab"
    assert wide.read(octets(wide.whole([1, 1])), ByteBudget(6), 3) == [1, 1]
    for text in (narrow, wide):
        width = 1 if text is narrow else 2
        start = bytes.fromhex(size)
        with pytest.raises(
            ProtocolError, match=f"{3 * width} bytes, {3 * width - 1} are"
        ):
            text.read(octets(start), ByteBudget(3 * width - 1))
        with pytest.raises(ProtocolError, match=r"a size of 3, at most 2 allowed"):
            text.read(octets(start), ByteBudget(9), 2)
        with pytest.raises(ProtocolError, match=r"a size of -1 "):
            text.read(octets(b"\xff" * 4), ByteBudget(9))


def octets(data: bytes) -> More:
    """Return a reader of the next octets of a message; no more than there are."""
    stream = BytesIO(data)

    def more(count: int) -> bytes:
        found = stream.read(count)
        assert len(found) == count
        return found

    return more


def test_a_text_ends_at_the_first_zero_or_without_one() -> None:
    text = Text(NETWORK, "utf-8")
    assert [text.text(d) for d in (b"ab\0\x22", b"ab", b"")] == ["ab", "ab", ""]
    assert text.text(b"\xe3\x81") == "\ufffd"
    wide = WideText(LITTLE, "i")
    assert wide.text(bytes.fromhex("ffffffff0000000001")) == [-1]
    assert wide.text(bytes.fromhex("0100000002000000")) == [1, 2]


def test_sizes_are_checked_before_anything_is_read() -> None:
    budget = ByteBudget(10)
    assert budget.take(3, 2, 3) == 6
    for count, most, code in ((-1, None, E_PAR), (2, 1, E_PAR), (5, None, E_NOMEM)):
        with pytest.raises(ProtocolError) as caught:
            budget.take(count, 1, most)
        assert caught.value.sub == code
    assert budget.take(4, 1) == 4


def test_arithmetic_is_that_of_c() -> None:
    assert [quotient(a, b) for a, b in ((7, 2), (-7, 2), (7, -2), (-7, -2))] == [
        3,
        -3,
        -3,
        3,
    ]
    assert [remainder(a, b) for a, b in ((7, 2), (-7, 2), (7, -2))] == [1, -1, 1]
    assert [cast(300, 8, False), cast(200, 8, True), cast(-1, 16, False)] == [
        44,
        -56,
        65535,
    ]
    assert [quotient(0, -2), quotient(0, 2), remainder(0, -2)] == [0, 0, 0]
    for wrong in (lambda: quotient(1, 0), lambda: remainder(1, 0)):
        with pytest.raises(ZeroDivisionError):
            wrong()
    assert [cast(64, 8, True), cast(127, 8, True), cast(128, 8, True)] == [
        64,
        127,
        -128,
    ]
    assert [cast(-1.9, 8, True), cast(0, 8, True)] == [-1, 0]
    assert [shifted_left(1, 63), shifted_right(-4, 1)] == [1 << 63, -2]
    assert [shifted_left(3, 0), shifted_right(1 << 63, 63)] == [3, 1]
    for shifted in (shifted_left, shifted_right):
        for bits in (-1, 64, 1 << 40):
            with pytest.raises(
                ValueError, match=f"a size of {bits}, at most 63 allowed"
            ):
                shifted(1, bits)


def test_values_that_have_to_be_there() -> None:
    assert present(0) == 0
    with pytest.raises(ValueError, match=r"^NULL where a value is needed$"):
        present(None)
    assert [element([5, 6], 0), element([5, 6], 1)] == [5, 6]
    for index in (-1, 2, 3):
        with pytest.raises(ValueError, match=f"a size of {index}, at most 1 allowed"):
            element([5, 6], index)
    assert exactly([1, 2], 2) == [1, 2]
    with pytest.raises(ValueError, match=r"^1 elements, 2 are needed$"):
        exactly([1], 2)
    error = size_error("f", ZeroDivisionError("by zero"))
    assert (error.sub, str(error)) == (E_PAR, "f: by zero (E_PAR)")


def test_a_longer_array_is_cut_to_its_count_only_where_it_fits() -> None:
    assert leading([1, 2, 3], 2, 3) == [1, 2]
    assert leading([1, 2], 0, 2) == []
    assert leading([1, 2], 2, 2) == [1, 2]
    for values, count, most in (([1, 2, 3], 2, 2), ([1], 2, 3), ([1, 2], 2, 1)):
        with pytest.raises(ValueError, match="elements"):
            leading(values, count, most)
