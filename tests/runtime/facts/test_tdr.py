"""The letters and widths of C's basic types for compiler and runtime."""

import struct

import pytest

from rtgen.facts.tdr import (
    BITS,
    INTEGERS,
    LETTERS,
    STRUCT_CODES,
    UNSIGNED,
    WIDTH_NAMES,
    Scalar,
)
from rtgen.runtime.opaque_rpc.tdr import Items, Tdr, make_tdr


def test_every_type_but_void_has_a_letter() -> None:
    assert set(LETTERS) == set(Scalar) - {Scalar.VOID}


def test_widths_are_those_of_struct() -> None:
    for letter, bits in BITS.items():
        assert letter == "w" or struct.calcsize(f"<{letter}") * 8 == bits
    for bits, code in STRUCT_CODES.items():
        assert struct.calcsize(f"<{code}") * 8 == bits


def test_a_tdr_has_the_widths_that_letters_name() -> None:
    assert set(WIDTH_NAMES.values()) <= {*Tdr.__struct_fields__}


@pytest.mark.parametrize("scalar", sorted(INTEGERS))
@pytest.mark.parametrize("order", ["network", "little"])
def test_the_runtime_packs_the_whole_range_of_each_integer(
    scalar: Scalar, order: str
) -> None:
    letter = LETTERS[scalar]
    tdr = make_tdr("network" if order == "network" else "little")
    lower = letter.lower()
    bits = BITS[lower] if lower in BITS else getattr(tdr, WIDTH_NAMES[lower])
    items = Items(tdr, letter)
    assert items.width * 8 == bits
    full = letter.isupper()
    ends = [0, (1 << bits) - 1] if full else [-(1 << bits - 1), (1 << bits - 1) - 1]
    if letter != "b":
        assert items.integers(items.pack(ends), 2) == ends
    assert full is (scalar in UNSIGNED or scalar is Scalar.CHAR)
