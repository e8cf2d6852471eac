"""Constants: the value of an expression for the type of the constant."""

from decimal import Decimal

import pytest
from idl_stages import lowered

from rtgen.compiler.model import Const, ConstantValue, EnumeratorName


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("const long T = 1 + 2 * 3;", 7),
        ("const long T = (1 + 2) * 3;", 9),
        ("const long T = -7 / 2;", -3),
        ("const long T = 0x10 | 010;", 24),
        ("const octet T = ~0x0f;", 0xF0),
        ("const unsigned short T = ~0;", 0xFFFF),
        ("const long T = 1 << 4 >> 2;", 4),
        ("const long long T = 9223372036854775807;", 2**63 - 1),
        ("const double T = 3.0 / 2.0;", 1.5),
        ("const fixed T = 1.50d + 0.25d;", Decimal("1.75")),
        ("const boolean T = TRUE;", True),
        ("const char T = '\\x41';", "A"),
        ('const string T = "a" "b\\n";', "ab\n"),
        ("const long A = 2; const long T = A * A;", 4),
        ("module M { const long A = 3; }; const long T = M::A + 1;", 4),
        ("enum E { A, B }; const E T = B;", EnumeratorName(("B",))),
    ],
)
def test_values(text: str, value: ConstantValue) -> None:
    declarations, messages = lowered(text)
    assert not messages
    const = declarations["T"]
    assert isinstance(const, Const)
    assert const.value == value
    assert type(const.value) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("const octet T = 256;", "256 is out of the range of octet: 0 to 255"),
        (
            "const unsigned long T = -1;",
            "-1 is out of the range of unsigned long: 0 to 4294967295",
        ),
        ("const long T = 1 / 0;", "division by zero"),
        (
            "const long T = 1.5;",
            "an integer is expected here, not a floating-point number",
        ),
        ('const long T = "a";', "an integer is expected here, not a string"),
        ("const long T = 1 << 64;", "a shift by 64 is not from 0 to 31"),
        ('const string<2> T = "abc";', "3 characters do not fit into string<2>"),
        ("enum E { A }; enum F { B }; const E T = B;", "B is not an enumerator of E"),
        ("const boolean T = 1;", "a boolean is expected here, not an integer"),
    ],
)
def test_what_has_no_value_is_reported_and_left_out(text: str, message: str) -> None:
    declarations, messages = lowered(text)
    assert messages == [message]
    assert "T" not in declarations


def test_the_sign_of_a_remainder_is_named() -> None:
    declarations, messages = lowered("const long T = -7 % 3;")
    assert messages == ["the remainder has the sign of the left operand"]
    const = declarations["T"]
    assert isinstance(const, Const)
    assert const.value == -1


def test_an_error_in_a_constant_is_not_repeated_where_it_is_used() -> None:
    declarations, messages = lowered("const octet A = 256; const long T = A + 1;")
    assert len(messages) == 1
    assert not declarations
