"""Types and names of CANopen objects in IDL."""

from __future__ import annotations

import pytest

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.canopen import Access, DataType, Variable
from rtgen.compiler.typemap.canopen.idl import ROWS, Source, limits, row
from rtgen.compiler.typemap.canopen.names import field_names, identifier

NOWHERE = Span("a.eds", 1, 1, 1, 1)

TABLE_4 = {
    0x01: ("boolean", "TimedBoolean"),
    0x03: ("short", "TimedShort"),
    0x04: ("long", "TimedLong"),
    0x05: ("octet", "TimedOctet"),
    0x06: ("unsigned short", "TimedUShort"),
    0x07: ("unsigned long", "TimedULong"),
    0x08: ("float", "TimedFloat"),
    0x09: ("string", "TimedString"),
    0x0B: ("wstring", "TimedWString"),
    0x11: ("double", "TimedDouble"),
    0x1B: ("unsigned long long", None),
    0xA0: ("char", "TimedChar"),
}
"""The rows of the published table by type index."""


def test_table_4() -> None:
    found = {
        int(code): (str(r.type), r.timed)
        for code, r in ROWS.items()
        if r.source is Source.TABLE_4
    }
    assert found == TABLE_4


def test_every_type_has_a_row() -> None:
    assert set(ROWS) == set(DataType)
    assert str(row(DataType.TIME_OF_DAY).type) == "RTC::Time"
    assert str(row(DataType.DOMAIN).type) == "sequence<octet>"
    assert str(row(0x40).type) == "sequence<octet>"


@pytest.mark.parametrize(
    ("code", "type_", "expected"),
    [
        (DataType.INTEGER8, "short", (-128, 127)),
        (DataType.INTEGER24, "long", (-(1 << 23), (1 << 23) - 1)),
        (DataType.UNSIGNED24, "unsigned long", (0, (1 << 24) - 1)),
        (DataType.INTEGER56, "long long", (-(1 << 55), (1 << 55) - 1)),
        (DataType.UNSIGNED40, "unsigned long long", (0, (1 << 40) - 1)),
        (DataType.INTEGER64, "long long", None),
        (DataType.INTEGER16, "short", None),
        (DataType.REAL32, "float", None),
    ],
)
def test_wider_types(
    code: DataType, type_: str, expected: tuple[int, int] | None
) -> None:
    assert str(row(code).type) == type_
    assert limits(code) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Controlword", "Controlword"),
        ("Velocity actual value", "Velocity_actual_value"),
        ("Temperature [°C]", "Temperature_C_"),
        ("6040 word", "o_6040_word"),
        ("Größe", "Gro_e"),
        ("(hidden)", "o_hidden_"),
        ("漢字", "o_"),
        ("", "o_"),
        ("__x", "o_x"),
    ],
)
def test_identifiers(name: str, expected: str) -> None:
    assert identifier(name) == expected


def variable(index: int, subindex: int, name: str) -> Variable:
    return Variable(
        index=index,
        subindex=subindex,
        name=name,
        data_type=DataType.UNSIGNED8,
        access=Access.RW,
        written_access="rw",
        span=NOWHERE,
        value_span=NOWHERE,
    )


def test_names_of_a_device() -> None:
    found = field_names(
        [
            variable(0x6401, 1, "Analogue Input"),
            variable(0x6401, 2, "analogue input"),
            variable(0x2000, 0, "Speed"),
            variable(0x2001, 0, "boolean"),
            variable(0x2002, 0, "lambda"),
            variable(0x2003, 0, "Long"),
            variable(0x2004, 0, "Speed_2000_00"),
        ]
    )
    assert found == {
        (0x6401, 1): "Analogue_Input_6401_01",
        (0x6401, 2): "analogue_input_6401_02",
        (0x2000, 0): "Speed",
        (0x2001, 0): "boolean_2001_00",
        (0x2002, 0): "lambda_2002_00",
        (0x2003, 0): "Long_2003_00",
        (0x2004, 0): "Speed_2000_00",
    }


def test_a_name_that_looks_like_a_number() -> None:
    found = field_names(
        [
            variable(0x2000, 0, "Speed"),
            variable(0x2001, 0, "speed"),
            variable(0x2002, 0, "Speed_2000_00"),
        ]
    )
    assert found[0x2000, 0] == "Speed_2000_00"
    assert found[0x2002, 0] == "Speed_2000_00_2002_00"
