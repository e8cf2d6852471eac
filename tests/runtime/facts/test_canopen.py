"""CANopen's tables, and their values through the compiler's writer and the runtime's reader."""

import struct
from datetime import UTC, datetime

import pytest

from rtgen.compiler.layouts.can_values import CanValueError, octets
from rtgen.compiler.model.canopen import Value
from rtgen.compiler.typemap.canopen.values import object_value
from rtgen.facts.canopen import (
    BITS,
    EPOCH,
    KIND_BITS,
    KINDS,
    REAL_CODES,
    SIGNED,
    UNSIGNED,
    DataType,
    can_id_of,
    visible_octets,
    visible_text,
)
from rtgen.runtime.canopen.values import ObjectValueError, decode, encode, size

RAW: tuple[Value, ...] = (0, 1, -1, 127, 128, -128, 255, 256, 1 << 31, 1 << 63, 1 << 64)
TEXTS = ("", "a", "ä", "Ã¤", "日本", "\ud800")


def test_every_data_type_has_a_kind_and_its_width() -> None:
    assert set(KINDS) == set(DataType)
    for type_, bits in {**SIGNED, **UNSIGNED}.items():
        assert type_.name.removeprefix("UNSIGNED").removeprefix("INTEGER") == str(bits)
    assert {KINDS[t]: bits for t, bits in BITS.items()} == KIND_BITS
    for kind, code in REAL_CODES.items():
        assert struct.calcsize(code) * 8 == KIND_BITS[kind]


def test_the_epoch() -> None:
    assert datetime(1984, 1, 1, tzinfo=UTC).timestamp() * 1000 == EPOCH


def test_identifiers_of_cob_ids() -> None:
    assert can_id_of(0xC0000181) == 0x181
    assert can_id_of(0xA0012345) == 0x12345


@pytest.mark.parametrize("data_type", [*SIGNED, *UNSIGNED])
def test_integers_that_a_file_gives_are_those_of_the_runtime(
    data_type: DataType,
) -> None:
    kind = KINDS[data_type]
    for raw in RAW:
        assert isinstance(raw, int)
        try:
            written: bytes | None = octets(data_type, raw)
        except CanValueError:
            written = None
        try:
            sent: bytes | None = encode(kind, raw)
        except ObjectValueError:
            sent = None
        assert written == sent, raw
        if written is not None:
            assert len(written) == size(kind)
            assert decode(kind, written) == raw


@pytest.mark.parametrize("data_type", [DataType.TIME_OF_DAY, DataType.TIME_DIFFERENCE])
@pytest.mark.parametrize("raw", [0, 1, 86_399_999, 5 << 32 | 1_000, 0xFFFF << 32])
def test_times_that_a_file_gives_are_those_of_the_runtime(
    data_type: DataType, raw: int
) -> None:
    value = object_value(data_type, raw)
    assert decode(KINDS[data_type], octets(data_type, raw)) == value


@pytest.mark.parametrize("text", TEXTS)
def test_visible_strings(text: str) -> None:
    try:
        written: bytes | None = octets(DataType.VISIBLE_STRING, text)
    except CanValueError:
        written = None
    try:
        sent: bytes | None = encode("string", text)
    except ObjectValueError:
        sent = None
    assert written == sent
    if written is not None:
        assert written == visible_octets(text)
        assert visible_text(written) == text
