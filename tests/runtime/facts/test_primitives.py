"""The table of primitive types compared with `struct`, which packs them."""

import struct

import pytest

from rtgen.facts.primitives import (
    FLOAT_LIMITS,
    INTEGER_RANGES,
    INTEGERS,
    SCALARS,
    TYPE_CODE_KINDS,
    Primitive,
)


@pytest.mark.parametrize("name", SCALARS)
def test_sizes_are_those_of_struct(name: str) -> None:
    scalar = SCALARS[name]
    assert struct.calcsize(f"<{scalar.code}") == scalar.size
    assert scalar.align == min(scalar.size, 8)


@pytest.mark.parametrize("name", INTEGERS)
def test_ranges_are_what_struct_packs(name: str) -> None:
    low, high = INTEGER_RANGES[name]
    code = f"<{INTEGERS[name].code}"
    for end in (low, high):
        assert struct.unpack(code, struct.pack(code, end)) == (end,)
    for beyond in (low - 1, high + 1):
        with pytest.raises(struct.error):
            struct.pack(code, beyond)


def test_the_greatest_float() -> None:
    assert struct.pack("<f", FLOAT_LIMITS["float"]) == bytes.fromhex("ffff7f7f")


def test_every_type_of_idl_is_in_a_table() -> None:
    without_kind = {Primitive.INT8, Primitive.UINT8}
    with_parameters = {Primitive.OBJECT, Primitive.VALUE_BASE}
    assert set(TYPE_CODE_KINDS) == {"null", *Primitive} - without_kind - with_parameters
    assert len(set(TYPE_CODE_KINDS.values())) == len(TYPE_CODE_KINDS)
