"""Values, formulas and types in EDS files."""

from __future__ import annotations

import math

import pytest

from rtgen.compiler.frontends.eds import numbers
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.ini import Entry
from rtgen.compiler.model.canopen import DataType, NodeRelative, Value, resolved

U8, I16, U32 = DataType.UNSIGNED8, DataType.INTEGER16, DataType.UNSIGNED32


def value(text: str, type_: int) -> tuple[Value | None, list[str]]:
    """Return the value of a text, and the codes of findings."""
    findings = Findings()
    entry = Entry("a.eds", 1, 1, "DefaultValue", text, 14)
    return numbers.value(entry, type_, findings), [d.code for d in findings.diagnostics]


@pytest.mark.parametrize(
    ("text", "type_", "expected"),
    [
        ("12", U8, 12),
        ("0xfF", U8, 255),
        ("0", U8, 0),
        ("00", U8, 0),
        ("-1", I16, -1),
        ("0xFFFF", I16, -1),
        ("0x8000", I16, -32768),
        ("32767", I16, 32767),
        ("0xFFFFFF", DataType.INTEGER24, -1),
        ("-549755813888", DataType.INTEGER40, -(1 << 39)),
        ("0x7FFFFFFFFFFF", DataType.INTEGER48, (1 << 47) - 1),
        ("0xFFFFFFFFFFFFFFFF", DataType.UNSIGNED64, (1 << 64) - 1),
        ("1", DataType.BOOLEAN, 1),
        ("-1.5", DataType.REAL32, -1.5),
        ("1e300", DataType.REAL64, 1e300),
        (".5", DataType.REAL64, 0.5),
        ("text ; and more", DataType.VISIBLE_STRING, "text ; and more"),
        ("0102 aB", DataType.OCTET_STRING, b"\x01\x02\xab"),
        ("", DataType.DOMAIN, b""),
        ("01", 0x40, b"\x01"),
        ("A", DataType.VISIBLE_CHAR, "A"),
        ("65", DataType.VISIBLE_CHAR, 65),
        ("$NODEID+0x180", U32, NodeRelative(0x180)),
        ("$NODEID", U32, NodeRelative(0)),
        ("$NODEID+384", U32, NodeRelative(384)),
    ],
)
def test_values(text: str, type_: int, expected: Value) -> None:
    assert value(text, type_) == (expected, [])


@pytest.mark.parametrize(
    ("text", "type_", "expected", "code"),
    [
        ("010", U8, 10, "EDS0401"),
        ("12 ; twelve", U8, 12, "EDS0105"),
        ("12 # twelve", U8, 12, "EDS0105"),
        ("0Ch", U8, 12, "EDS0407"),
        ("yes", DataType.BOOLEAN, 1, "EDS0407"),
        ("1e3", U32, 1000, "EDS0407"),
        ("12.", U8, 12, "EDS0407"),
        ("2.50e1", U8, 25, "EDS0407"),
        ("-1.0", DataType.INTEGER8, -1, "EDS0407"),
        ("-0.0", DataType.INTEGER16, 0, "EDS0407"),
        ("2.5F", DataType.REAL32, 2.5, "EDS0407"),
        ("0x40200000", DataType.REAL32, 2.5, "EDS0407"),
        ("0x0102", DataType.OCTET_STRING, b"\x01\x02", "EDS0407"),
        ("0x180+$NODEID", U32, NodeRelative(0x180), "EDS0402"),
        ("$NodeId + 0x180", U32, NodeRelative(0x180), "EDS0402"),
        ("0x100+$NODEID+0x80", U32, NodeRelative(0x180), "EDS0402"),
        ("$NODEID-1", U32, NodeRelative(-1), "EDS0402"),
    ],
)
def test_sloppy_values(text: str, type_: int, expected: Value, code: str) -> None:
    assert value(text, type_) == (expected, [code])


@pytest.mark.parametrize(
    ("text", "type_", "code"),
    [
        ("256", U8, "EDS0403"),
        ("-129", DataType.INTEGER8, "EDS0403"),
        ("2", DataType.BOOLEAN, "EDS0403"),
        ("1e39", DataType.REAL32, "EDS0403"),
        ("0x10000000000000000", DataType.UNSIGNED64, "EDS0403"),
        ("1e3", U8, "EDS0403"),
        ("-1.5e2", DataType.INTEGER8, "EDS0403"),
        ("2.5", U8, "EDS0400"),
        ("1e-3", U32, "EDS0400"),
        ("1e999999999", U32, "EDS0400"),
        ("1e999", U32, "EDS0400"),
        ("fast", U8, "EDS0400"),
        ("\\+384", U32, "EDS0400"),
        ("$NODEID+$NODEID", U32, "EDS0400"),
        ("-$NODEID", U32, "EDS0400"),
        ("$NODEID+", U32, "EDS0400"),
        ("$NODE+1", U32, "EDS0400"),
        ("123", DataType.OCTET_STRING, "EDS0400"),
        ("nan", DataType.REAL64, "EDS0400"),
        ("1" * 100, U32, "EDS0400"),
        ("٣", U8, "EDS0400"),
    ],
)
def test_no_values(text: str, type_: int, code: str) -> None:
    assert value(text, type_) == (None, [code])


def test_formula_of_a_node() -> None:
    assert resolved(NodeRelative(0x40000180), 5) == 0x40000185
    assert resolved(NodeRelative(0x180), None) == NodeRelative(0x180)
    assert str(NodeRelative(0x180)) == "$NODEID+0x180"
    assert str(NodeRelative(0xC0000180)) == "$NODEID+0xC0000180"
    assert str(NodeRelative(0)) == "$NODEID"
    assert str(NodeRelative(-1)) == "$NODEID-0x1"


def test_limits_of_reals() -> None:
    findings = Findings()
    entry = Entry("a.eds", 1, 1, "HighLimit", "3.402823e+38", 11)
    found = numbers.limit(entry, DataType.REAL32, findings)
    assert isinstance(found, float)
    assert math.isclose(found, 3.402823e38)
    assert not findings.diagnostics
