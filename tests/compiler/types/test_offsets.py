"""Offsets and sizes of members: a changed member changes exactly its octets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.compiler.frontends.idl import load
from rtgen.compiler.layouts.offsets import Layouts, StructLayout
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import Model, Struct

TEXT = """
module o {
  enum Colour { RED, GREEN };
  @bit_bound(8) enum Small { ONE, TWO };
  @bit_bound(12) bitmask Flags { A, B };
  bitset Fields { bitfield<3> low; bitfield<9> high; };
  struct Inner { octet first; double second; };
  struct Late { double first; octet second; };
  struct Plain { octet a; double b; short c; long d; boolean e; long long f; };
  struct Enums { octet a; Colour b; octet c; Small d; octet e; Flags f; octet g; Fields h; };
  struct Nested { octet a; Inner b; octet c; Late d; octet e; };
  struct Arrays { octet a; short b[3]; octet c; double d[2]; octet e; Inner f[2]; octet g; };
  struct Base { octet a; long b; };
  struct Derived : Base { octet c; double d; };
  struct Open { octet a; double b; sequence<long> c; long d; };
  @bit_bound(8) bitmask Mask8 { M8 };
  @bit_bound(16) bitmask Mask16 { M16 };
  @bit_bound(17) bitmask Mask17 { M17 };
  @bit_bound(32) bitmask Mask32 { M32 };
  @bit_bound(33) bitmask Mask33 { M33 };
  bitset Bits8 { bitfield<8> all; };
  bitset Bits9 : Bits8 { bitfield<1> more; };
  bitset Bits33 { bitfield<33> all; };
  struct Masks {
    octet a; Mask8 b; Mask16 c; octet d; Mask17 e; octet f; Mask32 g; octet h; Mask33 i;
  };
  struct Sets { octet a; Bits8 b; Bits9 c; octet d; Bits33 e; };
  struct Decimal { octet a; fixed<5,2> b; fixed<4,1> c; long d; };
  struct Wide { octet a; wchar b; long c; };
  struct Wides { octet a; wchar b[2]; long c; };
  struct Empty {};
  struct Empties { octet a; Empty b; octet c; };
  struct Extended { octet a; long double b; octet c; };
  struct Optionals { octet a; @optional long b; long c; @external double d; };
  struct OptionalFirst { @optional double a; };
  struct HoldsOptionals { octet a; Optionals b; long c; };
  struct HoldsOptionalFirst { octet a; OptionalFirst b; long c; };
  struct After17 { octet a[17]; double b; };
  struct After3 { octet a[3]; double b; };
  struct Phases { After17 a; After3 b; };
  struct Single { double a; };
  struct EmptyLast { octet a; Empty b; };
  interface Remote {};
  struct Calls { octet a; Remote b; octet c; };
  struct Ring { @external Ring next; octet a; };
  struct HoldsRing { octet a; Ring b; };
  struct HoldsDecimals { octet a; fixed<5,2> b[2]; octet c; };
  struct Elsewhere { octet a; @external double b; };
  struct HoldsElsewhere { octet a; Elsewhere b; octet c; };
  @mutable struct Tagged { double a; };
  struct HoldsTagged { octet a; Tagged b; octet c; };
  struct Most { Inner a[4096]; octet b; };
  struct TooMany { Inner a[4097]; octet b; };
  struct Texts { octet a; string b[2]; octet c; };
  @appendable struct Grown0 {};
  union Choice switch (boolean) { case TRUE: octet one; case FALSE: long two; };
  struct Chosen { octet a; Choice b; };
  @appendable union Grown switch (boolean) { case TRUE: octet one; };
  @data_representation(XCDR2) struct Chosen2 { octet a; Choice b; };
  @data_representation(XCDR2) struct ChosenGrown2 { octet a; Grown b; };
  @data_representation(XCDR2) struct Masks2 {
    octet a; Mask33 b; octet c; Bits33 d; octet e; Mask16 f;
  };
  @data_representation(XCDR2) struct Enums2 {
    octet a; Small b; octet c; Colour d; Small e[2]; octet f;
  };
  @data_representation(XCDR2) struct Wide2 {
    octet a; wchar b; wchar c[2]; octet d[3]; long double e;
  };
  @data_representation(XCDR2) struct Plain2 { octet a; double b; short c; long long d; };
  @data_representation(XCDR2) struct Octets2 { octet a; octet b[3]; octet c; };
  @data_representation(XCDR2) struct HoldsOptionalFirst2 { octet a; OptionalFirst b; };
  @data_representation(XCDR2) struct HoldsEmpty2 { octet a; Grown0 b; Grown0 c; octet d; };
  @data_representation(XCDR2) @appendable struct Grows { octet a; double b; short c; };
  @data_representation(XCDR2) struct Holds { octet a; Grows b; octet c; Inner d[2]; octet e; };
};
"""
HEADER = 4
"""Octets of the encapsulation before the value."""

CHANGED = {"bool": True, "int": 1, "float": 1.5}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("offsets"), TEXT).o


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    path = tmp_path_factory.mktemp("model") / "case.idl"
    path.write_text(TEXT, encoding="utf-8")
    return load([path], root=path.parent).model


def laid_out(model: Model, name: str) -> StructLayout:
    struct = model.find(("o", name))
    assert isinstance(struct, Struct)
    return Layouts(model, Representations(model)).of(struct)


def test_layouts_do_not_depend_on_those_before(model: Model) -> None:
    structs = [each for each in model.declarations if isinstance(each, Struct)]
    for order in (structs, structs[::-1]):
        layouts = Layouts(model, Representations(model))
        for struct in order:
            assert layouts.of(struct) == laid_out(model, struct.name[-1])


def octets(value: Any) -> bytes:
    made: bytes = value.to_cdr()
    return made


def changed(value: Any) -> Any:
    """Return another value of the same type."""
    name = type(value).__name__
    if name in CHANGED:
        return CHANGED[name]
    if hasattr(value, "__members__") or hasattr(type(value), "__members__"):
        return list(type(value))[-1]
    return None


@pytest.mark.parametrize(
    "name",
    [
        *("Plain", "Enums", "Nested", "Arrays", "Derived", "Plain2", "Grows", "Holds"),
        *(
            "Masks",
            "Sets",
            "Decimal",
            "Empties",
            "Extended",
            "Masks2",
            "Enums2",
            "Wide2",
        ),
    ],
)
def test_a_member_changes_the_octets_of_its_place(
    name: str, package: Any, model: Model
) -> None:
    laid = laid_out(model, name)
    type_ = getattr(package, name)
    before = octets(type_())
    assert laid.size == len(before)
    for place in laid.members:
        assert place.offset is not None
        assert place.size is not None
        value = type_()
        other = changed(getattr(value, place.member.name))
        if other is None or other == getattr(value, place.member.name):
            continue
        setattr(value, place.member.name, other)
        after = octets(value)
        different = [
            i for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b
        ]
        assert different
        assert place.offset <= different[0]
        assert different[-1] < place.offset + place.size


def test_places_follow_each_other(model: Model) -> None:
    for declaration in model.declarations:
        if isinstance(declaration, Struct):
            end = 0
            for place in laid_out(model, declaration.name[-1]).members:
                if place.offset is None:
                    break
                assert place.offset >= end
                end = place.offset + (place.size or 0)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("Plain", [(0, 1), (8, 8), (16, 2), (20, 4), (24, 1), (32, 8)]),
        ("Plain2", [(0, 1), (4, 8), (12, 2), (16, 8)]),
        ("Grows", [(4, 1), (8, 8), (16, 2)]),
        ("Open", [(0, 1), (8, 8), (16, None), (None, 4)]),
        ("Derived", [(0, 1), (4, 4), (8, 1), (16, 8)]),
        (
            "Masks",
            [
                *((0, 1), (1, 1), (2, 2), (4, 1), (8, 4)),
                *((12, 1), (16, 4), (20, 1), (24, 8)),
            ],
        ),
        ("Sets", [(0, 1), (1, 1), (2, 2), (4, 1), (8, 8)]),
        ("Decimal", [(0, 1), (1, 3), (4, 3), (8, 4)]),
        ("Wide", [(0, 1), (1, None), (None, 4)]),
        ("Wides", [(0, 1), (1, None), (None, 4)]),
        ("Empties", [(0, 1), (1, 0), (1, 1)]),
        ("Extended", [(0, 1), (8, 16), (24, 1)]),
        ("Optionals", [(0, 1), (None, 4), (None, 4), (None, 8)]),
        ("HoldsOptionals", [(0, 1), (1, None), (None, 4)]),
        ("HoldsOptionalFirst", [(0, 1), (4, None), (None, 4)]),
        ("HoldsOptionalFirst2", [(0, 1), (1, None)]),
        ("Phases", [(0, 32), (32, 16)]),
        ("Single", [(0, 8)]),
        ("EmptyLast", [(0, 1), (1, 0)]),
        ("Calls", [(0, 1), (4, None), (None, 1)]),
        ("HoldsRing", [(0, 1), (1, None)]),
        ("HoldsDecimals", [(0, 1), (1, 6), (7, 1)]),
        ("Octets2", [(0, 1), (1, 3), (4, 1)]),
        ("HoldsEmpty2", [(0, 1), (4, 4), (8, 4), (12, 1)]),
        ("Nested", [(0, 1), (1, 15), (16, 1), (24, 9), (33, 1)]),
        (
            "Arrays",
            [(0, 1), (2, 6), (8, 1), (16, 16), (32, 1), (33, 31), (64, 1)],
        ),
        ("Holds", [(0, 1), (4, 18), (22, 1), (24, 28), (52, 1)]),
        ("HoldsElsewhere", [(0, 1), (1, None), (None, 1)]),
        ("Tagged", [(None, 8)]),
        ("HoldsTagged", [(0, 1), (4, None), (None, 1)]),
        ("Most", [(0, 65536), (65536, 1)]),
        ("TooMany", [(0, None), (None, 1)]),
        ("Texts", [(0, 1), (4, None), (None, 1)]),
        ("Chosen", [(0, 1), (1, None)]),
        ("Chosen2", [(0, 1), (1, None)]),
        ("ChosenGrown2", [(0, 1), (4, None)]),
        ("Masks2", [(0, 1), (4, 8), (12, 1), (16, 8), (24, 1), (26, 2)]),
        ("Enums2", [(0, 1), (1, 1), (2, 1), (4, 4), (8, 6), (14, 1)]),
        ("Wide2", [(0, 1), (2, 2), (4, 4), (8, 3), (12, 16)]),
    ],
)
def test_places(
    name: str, wanted: list[tuple[int | None, int | None]], model: Model
) -> None:
    laid = laid_out(model, name)
    assert [(p.offset, p.size) for p in laid.members] == wanted
    struct = model.find(("o", name))
    assert isinstance(struct, Struct)
    offset, size = wanted[-1]
    varies = offset is None or size is None
    assert laid.size == (None if varies else (offset or 0) + (size or 0))
    assert laid.xcdr2 == (struct.annotation("data_representation") is not None)


def test_an_empty_struct_has_no_octets(model: Model) -> None:
    assert laid_out(model, "Empty") == StructLayout((), 0, False)


def test_members_name_the_struct_that_declares_them(model: Model) -> None:
    for name in ("Derived", "Optionals"):
        for place in laid_out(model, name).members:
            assert place.member in place.holder.members


def test_a_union_begins_with_its_discriminator(package: Any) -> None:
    """No padding precedes a boolean, for any content of the cases."""
    chosen = package.Chosen(7, package.Choice(True, 9))
    assert octets(chosen) == bytes((7, 1, 9))


def chain(folder: Path, first: str, following: str, levels: int) -> Model:
    """Return structs S0, S1 and so on; {0} is the number of one, {1} that of the one before."""
    lines = [first, *(following.format(n, n - 1) for n in range(1, levels))]
    path = folder / "chain.idl"
    path.write_text("\n".join(lines), encoding="utf-8")
    return load([path], root=folder).model


def sizes(model: Model) -> list[int | None]:
    found = [d for d in model.declarations if isinstance(d, Struct)]
    return [Layouts(model, Representations(model)).of(struct).size for struct in found]


def test_structs_in_structs(tmp_path: Path) -> None:
    first, following = "octet a; double b;", "struct S{0} {{ octet a; S{1} b; }};"
    model = chain(tmp_path, f"struct S0 {{ {first} }};", following, 80)
    assert sizes(model) == [n + 1 + -(n + 1) % 8 + 8 for n in range(80)]


def test_each_type_is_measured_once(tmp_path: Path) -> None:
    """The number of values doubles with each level; the time does not."""
    following = "struct S{0} {{ S{1} a; S{1} b; }};"
    model = chain(tmp_path, "struct S0 { octet a; double b; };", following, 40)
    assert sizes(model) == [16 << n for n in range(40)]


def test_bases_of_bases(tmp_path: Path) -> None:
    model = chain(
        tmp_path, "struct S0 {};", "struct S{0} : S{1} {{ octet a{0}; }};", 80
    )
    assert sizes(model) == list(range(80))


def test_a_struct_begins_with_the_first_octet_of_its_first_member(
    tmp_path: Path,
) -> None:
    following = "struct S{0} {{ S{1} a; }};"
    model = chain(tmp_path, "struct S0 { double a; };", following, 80)
    holder = "struct S{0} {{ octet a; S79 b; }};"
    text = (tmp_path / "chain.idl").read_text() + holder.format(80)
    (tmp_path / "chain.idl").write_text(text)
    model = load([tmp_path / "chain.idl"], root=tmp_path).model
    struct = model.find(("S80",))
    assert isinstance(struct, Struct)
    places = Layouts(model, Representations(model)).of(struct).members
    assert [(place.offset, place.size) for place in places] == [(0, 1), (8, 8)]


def test_a_bitset_with_too_many_bits_has_eight_octets(tmp_path: Path) -> None:
    """IDL0312 reports it; a language server shows the offsets nevertheless."""
    path = tmp_path / "case.idl"
    path.write_text("bitset B { bitfield<64> x; bitfield<3> y; }; struct S { B b; };")
    assert sizes(load([path], root=tmp_path).model) == [8]
