"""Values of objects: boundaries of every kind, compared with `struct` and own arithmetic."""

from __future__ import annotations

import math
import struct
from datetime import UTC, datetime

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtgen.facts.canopen import KIND_BITS, SIGNED_KINDS, UNSIGNED_KINDS
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import Kind, ObjectValue
from rtgen.runtime.canopen.values import ObjectValueError, decode, encode
from rtgen.runtime.canopen.wire import sdo

BOUNDARIES: list[tuple[Kind, ObjectValue, str]] = [
    ("bool", False, "00"),
    ("bool", True, "01"),
    ("i8", -128, "80"),
    ("i8", 127, "7f"),
    ("i16", -32768, "0080"),
    ("i16", 32767, "ff7f"),
    ("i24", -(2**23), "000080"),
    ("i24", 2**23 - 1, "ffff7f"),
    ("i32", -(2**31), "00000080"),
    ("i32", 2**31 - 1, "ffffff7f"),
    ("i40", -(2**39), "0000000080"),
    ("i48", -1, "ffffffffffff"),
    ("i56", 2**55 - 1, "ffffffffffff7f"),
    ("i64", -(2**63), "0000000000000080"),
    ("u8", 255, "ff"),
    ("u16", 0x1234, "3412"),
    ("u24", 0xFFFFFE, "feffff"),
    ("u32", 2**32 - 1, "ffffffff"),
    ("u40", 1, "0100000000"),
    ("u48", 2**48 - 1, "ffffffffffff"),
    ("u56", 2**56 - 1, "ffffffffffffff"),
    ("u64", 2**64 - 1, "ffffffffffffffff"),
    ("r32", 1.5, "0000c03f"),
    ("r64", -0.0, "0000000000000080"),
    ("char", "\xff", "ff"),
    ("string", "", ""),
    ("string", "Grüße", "4772fcdf65"),
    ("wstring", "A€", "4100ac20"),
    ("wstring", "\U0001f916", "3ed816dd"),
    ("octets", b"\0\1", "0001"),
    ("time_of_day", 441763200 * 10**9, "000000000000"),
    ("time_of_day", 441763200 * 10**9 + 86_399_999 * 10**6, "ff5b26050000"),
    ("time_difference", 86_400_001 * 10**6, "010000000100"),
]


@pytest.mark.parametrize(("kind", "value", "octets"), BOUNDARIES)
def test_boundaries(kind: Kind, value: ObjectValue, octets: str) -> None:
    assert encode(kind, value).hex() == octets
    back = decode(kind, bytes.fromhex(octets))
    assert back == value
    assert type(back) is type(value)


@pytest.mark.parametrize("kind", [*SIGNED_KINDS, *UNSIGNED_KINDS])
def test_integers_end_at_their_limits(kind: Kind) -> None:
    own = values.limits(kind)
    assert own is not None
    for value in own:
        assert decode(kind, encode(kind, value)) == value
    with pytest.raises(ObjectValueError) as caught:
        encode(kind, own[1] + 1)
    assert caught.value.code == sdo.VALUE_TOO_HIGH
    with pytest.raises(ObjectValueError) as caught:
        encode(kind, own[0] - 1)
    assert caught.value.code == sdo.VALUE_TOO_LOW


@pytest.mark.parametrize("kind", KIND_BITS)
def test_lengths(kind: Kind) -> None:
    wanted = values.size(kind)
    assert wanted is not None
    decode(kind, bytes(wanted))
    with pytest.raises(ObjectValueError) as caught:
        decode(kind, bytes(wanted + 1))
    assert caught.value.code == sdo.LENGTH_TOO_HIGH
    with pytest.raises(ObjectValueError) as caught:
        decode(kind, bytes(wanted - 1))
    assert caught.value.code == sdo.LENGTH_TOO_LOW


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("u8", True),
        ("u8", "1"),
        ("u8", 1.0),
        ("bool", 2),
        ("bool", "yes"),
        ("char", "ab"),
        ("char", "€"),
        ("char", 65),
        ("string", "\ud800"),
        ("string", b"abc"),
        ("wstring", "\ud800"),
        ("octets", "abc"),
        ("r32", "1.0"),
        ("r64", True),
        ("time_of_day", 1.5),
    ],
)
def test_values_of_another_kind(kind: Kind, value: ObjectValue) -> None:
    with pytest.raises(ObjectValueError) as caught:
        encode(kind, value)
    assert caught.value.code == sdo.VALUE_INVALID


@pytest.mark.parametrize(
    ("kind", "value", "code"),
    [
        ("r32", 1e39, sdo.VALUE_TOO_HIGH),
        ("r32", -1e39, sdo.VALUE_TOO_LOW),
        ("r64", 10**310, sdo.VALUE_TOO_HIGH),
        ("time_of_day", 0, sdo.VALUE_TOO_LOW),
        ("time_difference", -1, sdo.VALUE_TOO_LOW),
        ("time_difference", 65536 * 86400 * 10**9, sdo.VALUE_TOO_HIGH),
    ],
    ids=str,
)
def test_out_of_range(kind: Kind, value: ObjectValue, code: int) -> None:
    with pytest.raises(ObjectValueError) as caught:
        encode(kind, value)
    assert caught.value.code == code


def test_infinities_and_nan_are_reals() -> None:
    assert decode("r32", encode("r32", math.inf)) == math.inf
    assert math.isnan(float(decode("r64", encode("r64", math.nan))))


def test_half_a_character_is_refused() -> None:
    with pytest.raises(ObjectValueError) as caught:
        decode("wstring", b"abc")
    assert caught.value.code == sdo.LENGTH_MISMATCH
    with pytest.raises(ObjectValueError) as caught:
        decode("wstring", b"\0\xd8")
    assert caught.value.code == sdo.VALUE_INVALID


def test_text_ends_before_the_zeros_that_fill_it_up() -> None:
    assert decode("string", b"ab\0\0") == "ab"
    assert decode("wstring", b"a\0\0\0") == "a"


def test_every_octet_but_zero_is_true() -> None:
    assert decode("bool", b"\xfe") is True


def test_time_of_day_is_utc() -> None:
    moment = datetime(2026, 11, 21, 16, 5, 1, 250_000, tzinfo=UTC)
    days = (moment.date() - datetime(1984, 1, 1).date()).days
    milliseconds = ((16 * 60 + 5) * 60 + 1) * 1000 + 250
    wire = struct.pack("<IH", milliseconds, days)
    nanoseconds = int(moment.timestamp() * 1000) * 10**6
    assert encode("time_of_day", nanoseconds) == wire
    assert decode("time_of_day", wire) == nanoseconds
    reserved = bytes((*wire[:3], wire[3] | 0xF0, *wire[4:]))
    assert decode("time_of_day", reserved) == nanoseconds


@pytest.mark.parametrize("kind", KIND_BITS)
def test_zero_is_a_value(kind: Kind) -> None:
    assert decode(kind, bytes(values.size(kind) or 0)) == values.zero(kind)


@settings(deadline=None)
@given(
    st.sampled_from([*SIGNED_KINDS, *UNSIGNED_KINDS]),
    st.integers(-(2**63), 2**64 - 1),
    st.integers(-(2**63), 2**64 - 1),
    st.integers(-(2**63), 2**64 - 1),
)
def test_limits_of_an_object(kind: Kind, value: int, low: int, high: int) -> None:
    own = values.limits(kind)
    assert own is not None
    if max(low, own[0]) <= value <= min(high, own[1]):
        assert values.checked(kind, value, low, high) == value
    else:
        with pytest.raises(ObjectValueError):
            values.checked(kind, value, low, high)


@settings(deadline=None)
@given(st.sampled_from([*SIGNED_KINDS]), st.integers(1, 64), st.data())
def test_fields_narrower_and_wider_than_their_object(
    kind: Kind, bits: int, data: st.DataObject
) -> None:
    width = min(bits, SIGNED_KINDS[kind])
    value = data.draw(st.integers(-(2 ** (width - 1)), 2 ** (width - 1) - 1))
    raw = values.to_bits(kind, value, bits)
    assert raw == value % 2**bits
    assert values.from_bits(kind, raw, bits) == value


def test_a_field_may_hold_more_than_its_object() -> None:
    for kind, raw in (("u8", 0x100), ("i8", 0x80), ("r32", 1 << 32)):
        with pytest.raises(ObjectValueError):
            values.from_bits(kind, raw, 40)  # type: ignore[arg-type]
    assert values.from_bits("octets", 0x0201, 16) == b"\1\2"
    assert values.from_bits("string", 0x41, 16) == "A"
    assert values.from_bits("bool", 1, 1) is True


@settings(deadline=None)
@given(st.floats(width=32, allow_nan=False), st.floats(allow_nan=False))
def test_reals(single: float, double: float) -> None:
    assert encode("r32", single) == struct.pack("<f", single)
    assert decode("r32", encode("r32", single)) == single
    assert decode("r64", encode("r64", double)) == double


@settings(deadline=None)
@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_wide_text(text: str) -> None:
    assert decode("wstring", encode("wstring", text)) == text.rstrip("\0")


@pytest.mark.parametrize(
    ("octets", "text"),
    [
        (b"drive", "drive"),
        ("Antriebsgröße".encode(), "Antriebsgröße"),
        ("左 wheel".encode(), "左 wheel"),
        (b"20 \xb0C", "20 °C"),
        (b"padded\0\0", "padded"),
    ],
)
def test_strings_of_devices(octets: bytes, text: str) -> None:
    """UTF-8 if valid, else Latin-1."""
    assert decode("string", octets) == text


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_every_text_comes_back(text: str) -> None:
    text = text.rstrip("\0")
    assert decode("string", encode("string", text)) == text
