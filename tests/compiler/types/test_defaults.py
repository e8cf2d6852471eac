"""The values with which members start: `@default`, `@default_literal`, typedefs, unions."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from generated_projects import project

from rtgen import api
from rtgen.compiler.diagnostics import InputError
from rtgen.runtime.marshalling.dynamic.initial import initial_value

IDL = """
module D {
  enum Colour { RED, @default_literal GREEN, BLUE };
  @bit_bound(8) bitmask Marks { FIRST, @position(4) SECOND };
  bitset Bits { @default(3) bitfield<4> low; @default(TRUE) bitfield<1> on;
                @default(-2) bitfield<3, short> signed_; bitfield<2> plain; };
  typedef sequence<long> Longs;
  @default(7) typedef long Seven;
  @default("1, 2") typedef sequence<Seven> Two;
  typedef Two AlsoTwo;
  struct Base { @default(5) long x; };
  struct Derived : Base { @default(6) long y; };
  struct Holder {
    Derived inner; Derived inners[2]; sequence<Derived> none;
    Seven usual; @default(8) Seven eight; Seven sevens[2][2];
    Two pair; AlsoTwo also; Two twos[2];
    Colour hue; Colour colours[2]; @default(BLUE) Colour blue;
    Marks no_marks; @default(SECOND) Marks mark; @default(FIRST | SECOND) Marks both;
    Bits fields;
    @default("RED, D::BLUE") Colour listed[2];
    @default("FIRST|SECOND, 1") Marks sets[2];
    @default(0.1) float tenth;
    @default("0.1, 2") float tenths[2];
    @default("inf, -inf") double infinite[2];
    @default("(1, 2, 3)") long tuple_[3];
    @default("[4, 0x20]") octet octets[2];
    @default("1,2,3,4") octet table[2][2];
    @default("abcd") char table_of_text[2][2];
    @default("abc") sequence<char> characters;
    @default("('a', \\"b, c\\", 'd\\\\n', e f)") sequence<string> texts;
    @default("[True, false, 1]") sequence<boolean> booleans;
    @default('c') char letter; @default(L"w") wstring wide; @default("t") string one, other;
    @optional long absent;
    @default(TRUE) boolean yes; map<long, long> nothing;
  };
  struct Money {
    @default(1.5d) fixed<4,2> amount;
    @default("1.5, 2.25") sequence<fixed<4,2>, 2> amounts;
  };
  union ByColour switch (Colour) { case GREEN: @default(3) long number; default: string text; };
  union Gap switch (long) { case 1: long number; };
  union Flag switch (boolean) {
    case TRUE: string text;
    case FALSE: @default("1,2") sequence<octet> octets;
  };
  @default(2) typedef short Second;
  union Numbered switch (Second) { case 1: string text; case 2: Seven sevens[2]; };
  exception Lost { @default("1,2") sequence<long> at; @default("where") string reason; };
  valuetype Kept { @default("1,2") public sequence<long> at; public Derived inner; };
};
"""


@pytest.fixture(scope="module")
def d(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Yield the generated module of the IDL."""
    with project(tmp_path_factory.mktemp("defaults"), {"d.idl": IDL}, "started"):
        import started.d as module

        yield module


def test_members_start_with_their_defaults(d: Any) -> None:
    found = d.Holder()
    bits = (found.fields.low, found.fields.on, found.fields.signed_, found.fields.plain)
    assert bits == (3, True, -2, 0)
    assert (found.inner.x, found.inner.y) == (5, 6)
    assert [(each.x, each.y) for each in found.inners] == [(5, 6), (5, 6)]
    expected = {
        "none": [],
        "usual": 7,
        "eight": 8,
        "sevens": [[7, 7], [7, 7]],
        "pair": [1, 2],
        "also": [1, 2],
        "twos": [[1, 2], [1, 2]],
        "hue": d.GREEN,
        "colours": [d.GREEN, d.GREEN],
        "blue": d.BLUE,
        "no_marks": 0,
        "mark": 16,
        "both": 17,
        "listed": [d.RED, d.BLUE],
        "sets": [17, 1],
        "tenth": 0.1,
        "tenths": [0.1, 2.0],
        "tuple_": [1, 2, 3],
        "infinite": [float("inf"), float("-inf")],
        "octets": b"\x04\x20",
        "table": [b"\x01\x02", b"\x03\x04"],
        "table_of_text": ["ab", "cd"],
        "characters": "abc",
        "texts": ["a", "b, c", "d\n", "e f"],
        "booleans": [True, False, True],
        "letter": "c",
        "wide": "w",
        "one": "t",
        "other": "t",
        "absent": None,
        "yes": True,
        "nothing": {},
    }
    assert {name: getattr(found, name) for name in expected} == expected
    assert isinstance(found.both, d.Marks)
    assert set(expected) | {"inner", "inners", "fields"} == {*d.Holder.__match_args__}


def test_fixed_point_numbers(d: Any) -> None:
    found = d.Money()
    assert (found.amount, found.amounts) == (
        Decimal("1.5"),
        [Decimal("1.5"), Decimal("2.25")],
    )


def test_each_object_has_its_own(d: Any) -> None:
    one, other = d.Holder(), d.Holder()
    one.pair.append(3)
    one.inners[0].x = 0
    one.sevens[0][0] = 0
    assert other == d.Holder()


def test_a_union_starts_with_its_discriminator(d: Any) -> None:
    assert (d.ByColour().discriminator, d.ByColour().number) == (d.GREEN, 3)
    assert (d.Gap().discriminator, d.Gap().value) == (0, None)
    assert (d.Flag().discriminator, d.Flag().octets) == (False, b"\x01\x02")
    assert (d.Numbered().discriminator, d.Numbered().sevens) == (2, [7, 7])
    for union in (d.ByColour, d.Gap, d.Flag, d.Numbered):
        assert union.from_cdr(union().to_cdr()) == union()


def test_exceptions_and_valuetypes(d: Any) -> None:
    assert (d.Lost().at, d.Lost().reason) == ([1, 2], "where")
    assert (d.Kept().at, d.Kept().inner.y) == ([1, 2], 6)


def test_descriptors_know_them(d: Any) -> None:
    """Types without a class of their own start as members of these types do."""
    found = d.Holder()
    own = {"eight", "blue", "mark", "both", "listed", "sets"}
    own |= {"tenth", "tenths", "infinite", "tuple_", "octets", "table", "table_of_text"}
    own |= {"characters", "texts", "booleans", "letter", "wide", "one", "other", "yes"}
    for member in d.Holder._descriptor_.members:
        if member.attribute not in own and not member.optional:
            wanted = getattr(found, member.attribute)
            assert initial_value(member.type) == wanted, member.name
    branches = d.Flag._descriptor_.branches
    assert [initial_value(b.type, b.initial) for b in branches] == ["", b"\x01\x02"]


def test_numpy(tmp_path: Path) -> None:
    numpy = pytest.importorskip("numpy")
    text = """
    @default(7) typedef long Seven;
    struct Point { @default(1.0) double x; double y; };
    struct Zero { double x; };
    struct Arrays {
      @default("1.5, 2") double given[2]; double zeros[2][2]; Seven sevens[2][2];
      @default("1, 2, 3") sequence<float> several; Point points[2]; Zero zeroes[2];
    };
    """
    with project(tmp_path, {"a.idl": text}, "as_numpy", python='numeric = "numpy"'):
        import as_numpy

        found = as_numpy.Arrays()
        assert found.given.dtype == numpy.float64
        assert found.given.tolist() == [1.5, 2.0]
        assert found.zeros.tolist() == [[0.0, 0.0]] * 2
        assert found.sevens.tolist() == [[7, 7]] * 2
        assert found.sevens.dtype == numpy.int32
        assert found.several.tolist() == [1.0, 2.0, 3.0]
        assert found.several.dtype == numpy.float32
        again = as_numpy.Arrays.from_cdr(found.to_cdr())
        assert again == found


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("@default(Nope) long x", "Nope is unknown"),
        ("@default(Nope + 1) long x", "Nope is unknown"),
        ("@default(Nope) Colour x", "Nope is unknown"),
        ("@default(FIRST) long x", "FIRST is unknown"),
        ("@default(Nope) Marks x", "Marks has no flag Nope"),
        ("@default(1.5) Marks x", "Marks has no flag 1.5"),
        ("@default('a') Marks x", "this is not a set of flags"),
        ("@default(3) Five x", "the default 3 is below the minimum 5"),
        ("@min(6) Five x", "the default 5 is below the minimum 6"),
        ("@default(300) octet x", "300 is out of the range of octet: 0 to 255"),
        ('@default("1,2,x") sequence<long> x', "x is not a whole number"),
        ('@default("1,2,") sequence<long> x', "an empty item is not a whole number"),
        ('@default("1,2") long x[3]', "2 items do not fill long[3], which has 3"),
        ('@default("1,2,3") long x[2]', "3 items do not fill long[2], which has 2"),
        ('@default("1,2,3") sequence<long,2> x', "3 items do not fit"),
        ('@default("1,300") octet x[2]', "300 is out of the range of octet"),
        ("@default(\"'1'\") sequence<long> x", "'1' is not a value of long"),
        ('@default("1e40") float x[1]', "1e40 is beyond the range of a float"),
        ('@default("maybe") boolean x[1]', "maybe is neither true nor false"),
        ('@default("RED,PINK") Colour x[2]', "PINK is not an enumerator of Colour"),
        ('@default("1.234") fixed<4,2> x[1]', "1.234 does not fit into fixed<4,2>"),
        ('@default("ああ") string<5> x', "the default has 6 octets of UTF-8"),
        ('@default("abc") sequence<string<2>> x', "'abc' does not fit into string<2>"),
        ('@default("abcd") sequence<char,3> x', "4 items do not fit"),
        ('@default("あ") char x[1]', "あ is not a character of ISO 8859-1"),
        ('@default("\'a") sequence<string> x', "a quote is not where an item"),
        ('@default("(1") sequence<long> x', "'(' is not closed"),
        ('@default("1") Plain x[1]', "no default can be given for items of Plain"),
        ('@default("1") sequence<long> x[1]', "no default can be given for items of"),
        ("@default(1) Plain x", "no argument can be of type Plain"),
        ("@default(1) any x", "no argument can be of type any"),
        ("@default(1) map<long, long> x", "no argument can be of type map"),
    ],
)
def test_a_default_must_fit(member: str, message: str) -> None:
    types = (
        "enum Colour { RED, GREEN }; bitmask Marks { FIRST, SECOND };"
        "@default(5) @min(5) typedef long Five; struct Plain { long y; };"
    )
    for declared in (
        f"struct S {{ {member}; }};",
        f"exception S {{ {member}; }};",
        f"union S switch (long) {{ case 1: {member}; }};",
        f"valuetype S {{ {member.replace(') ', ') public ', 1)}; }};",
    ):
        with pytest.raises(InputError) as error:
            api.compile(types + declared)
        found = error.value.diagnostics
        assert any(message in each.message for each in found), found
        assert all(each.span is not None for each in found)


def test_bits_and_typedefs_must_fit() -> None:
    for text, message in (
        ("bitset B { @default(16) bitfield<4> x; };", "16 does not fit into 4 bits"),
        ("bitset B { @default(4) bitfield<3, short> x; };", "4 does not fit"),
        ("@default(3) @min(4) typedef long L;", "3 is below the minimum 4"),
    ):
        with pytest.raises(InputError, match=message):
            api.compile(text)


def test_an_optional_member_starts_absent() -> None:
    found = api.read("struct S { @optional @default(3) long x; };")
    assert [(d.code, d.message) for d in found.diagnostics] == [
        ("IDL0801", "@default means nothing for x, which is optional")
    ]


def test_parameters_start_as_members_do() -> None:
    model = api.compile("""
        enum Colour { RED, @default_literal GREEN };
        @default(7) typedef long Seven;
        @default("(1, 2)") typedef sequence<long> Two;
        component C { attribute Seven p; @default(8) attribute Seven q; attribute Two r; };
        """)
    [component] = [d for d in model.declarations if d.name == ("C",)]
    assert [p.default for p in component.configuration] == [7, 8, "1,2"]
