"""Properties of types in CDR: least sizes, types without a layout, recursion, headers."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.compiler.frontends.idl import load
from rtgen.compiler.layouts.cdr_types import (
    MAX_LOOPS,
    CdrTypes,
    NotMarshalledError,
    bit_count,
    enum_code,
)
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import Bitset, Enum, Member, Model, Struct, Type

TEXT = """
module c {
  enum Colour { RED, GREEN };
  @bit_bound(8) bitmask Flags { A, B };
  bitset Low { bitfield<3> a; bitfield<4> b; };
  bitset High : Low { bitfield<9> c; };
  bitset Higher : High { bitfield<5> d; };
  native Handle;
  struct Empty {};
  struct Pair { double a; octet b; };
  union Choice switch (short) { case 1: double a; };
  interface Remote { };
  local interface Local { };
  abstract interface Either { };
  valuetype Value { public long a; };
  custom valuetype Custom { public long a; };
  valuetype Box long;
  exception Bad { long a; };
  struct Tree;
  typedef sequence<Tree> Trees;
  struct Tree { octet a; Trees below; };
  struct Link { long a; @external @optional Link next; };
  struct Optional { octet a; @optional long b; };
  @mutable struct Tagged { octet a; };
  struct Dynamic { octet a; any b; };
  typedef long Row[3];
  typedef Row Rows[2];
  struct Holds {
    octet an_octet; double a_double; long double a_long_double; wchar a_wchar;
    any an_any; Object an_object; string a_string; wstring a_wstring; fixed<5,2> a_fixed;
    Colour an_enum; Flags a_bitmask; Low a_bitset; Pair a_struct; Choice a_union;
    Remote an_interface; Either an_abstract; Value a_value; Box a_box; Tree a_tree;
    Rows rows; sequence<Pair> a_sequence; map<string, Pair> a_map; Pair pairs[2][3];
  };
  struct HoldsOptional { Optional a; };
  struct HoldsTagged { sequence<Tagged> a; };
  struct HoldsTaggedKey { map<long, Tagged> a; };
  struct HoldsDynamic { map<long, Dynamic> a; };
  struct HoldsDynamicElements { Dynamic a[2]; };
  struct HoldsNothing { sequence<Empty> a; };
  struct HoldsLocal { sequence<Local> a; };
  struct HoldsLocalKey { map<Local, long> a; };
  struct HoldsLocalValue { map<long, Local> a; };
  struct HoldsLocalElement { Local a[2]; };
  struct HoldsCustom { Custom a; };
  struct HoldsHandle { Handle a; };
  struct HoldsVoid { void a; };
  struct Later;
  struct Early { @external Later a; @external Pair b; @external long c; Pair d; };
  struct Later { octet a; };
};
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    return loaded(tmp_path_factory.mktemp("cdr_types"), TEXT)


def loaded(folder: Path, text: str) -> Model:
    path = folder / "case.idl"
    path.write_text(text, encoding="utf-8")
    return load([path], root=folder).model


def types_of(model: Model) -> CdrTypes:
    return CdrTypes(model, Representations(model))


def struct_of(model: Model, name: str) -> Struct:
    found = model.find(("c", name))
    assert isinstance(found, Struct)
    return found


def member_of(model: Model, holder: str, name: str) -> Member:
    return next(m for m in struct_of(model, holder).members if m.name == name)


def type_of(model: Model, holder: str, name: str = "a") -> Type:
    return member_of(model, holder, name).type


MIN_SIZES = {
    "an_octet": 1,
    "a_double": 8,
    "a_long_double": 16,
    "a_wchar": 3,
    "an_any": 4,
    "an_object": 8,
    "a_string": 4,
    "a_wstring": 4,
    "a_fixed": 3,
    "an_enum": 4,
    "a_bitmask": 1,
    "a_bitset": 1,
    "a_struct": 9,
    "a_union": 2,
    "an_interface": 8,
    "an_abstract": 5,
    "a_value": 4,
    "a_box": 4,
    "a_tree": 1,
    "rows": 24,
    "a_sequence": 4,
    "a_map": 4,
    "pairs": 54,
}


def test_least_octets(model: Model) -> None:
    types = types_of(model)
    members = struct_of(model, "Holds").members
    for _ in range(2):
        assert {m.name: types.check(m.type) for m in members} == MIN_SIZES


@pytest.mark.parametrize(
    ("holder", "reason"),
    [
        ("HoldsNothing", "a sequence of empty elements: its count cannot be checked"),
        ("HoldsLocal", "`c::Local` is local: it does not leave its process"),
        ("HoldsLocalKey", "`c::Local` is local: it does not leave its process"),
        ("HoldsLocalValue", "`c::Local` is local: it does not leave its process"),
        ("HoldsLocalElement", "`c::Local` is local: it does not leave its process"),
        ("HoldsCustom", "`c::Custom` is custom: its user marshals its state"),
        (
            "HoldsHandle",
            "`c::Handle` (native) is not marshalled by CDR codecs here",
        ),
        ("HoldsVoid", "`void` has no representation in CDR"),
    ],
)
def test_what_is_not_marshalled(holder: str, reason: str, model: Model) -> None:
    with pytest.raises(NotMarshalledError) as caught:
        types_of(model).check(type_of(model, holder))
    assert str(caught.value) == reason


def loops(element: str, depth: int) -> str:
    return "sequence<" * depth + element + ">" * depth


@pytest.mark.parametrize(
    ("type_", "passes"),
    [
        (loops("string", MAX_LOOPS), True),
        (loops("string", MAX_LOOPS + 1), False),
        (loops("long", MAX_LOOPS + 1), True),
        (loops("long", MAX_LOOPS + 2), False),
        *(
            (loops(fixed, MAX_LOOPS + 1), True)
            for fixed in ("wchar", "fixed<5,2>", "Colour", "Flags", "Bits", "Row")
        ),
        *(
            (loops(varying, MAX_LOOPS + 1), False)
            for varying in ("any", "Pair", "Texts", "Object")
        ),
        (loops("Table", MAX_LOOPS - 2), True),
        (loops("Table", MAX_LOOPS - 1), False),
        (loops("Lists", MAX_LOOPS - 2), True),
        (loops("Lists", MAX_LOOPS - 1), False),
        (f"map<long, {loops('string', MAX_LOOPS - 1)}>", True),
        (f"map<long, {loops('string', MAX_LOOPS)}>", False),
    ],
)
def test_loops_in_loops(type_: str, passes: bool, tmp_path: Path) -> None:
    """Values of fixed size need none, an array one for each dimension."""
    model = loaded(
        tmp_path,
        "module c { enum Colour { RED }; bitmask Flags { A }; bitset Bits { bitfield<3> a; };"
        "struct Pair { long a; }; typedef long Row[3]; typedef string Texts[3];"
        "typedef sequence<string> Strings; typedef Strings Lists[3];"
        f"typedef Pair Table[2][2]; struct Holds {{ {type_} a; }}; }};",
    )
    checked = types_of(model)
    if passes:
        assert checked.check(type_of(model, "Holds")) == 4
        return
    with pytest.raises(NotMarshalledError) as caught:
        checked.check(type_of(model, "Holds"))
    reason = f"sequences are nested more than {MAX_LOOPS} deep: put a struct between"
    assert str(caught.value) == reason


def test_arrays_of_loops(tmp_path: Path) -> None:
    text = f"typedef {loops('string', MAX_LOOPS)} Deepest; typedef Deepest Row[2];"
    model = loaded(
        tmp_path, f"module c {{ {text} struct Holds {{ Deepest a; Row b; }}; }};"
    )
    checked = types_of(model)
    assert checked.check(type_of(model, "Holds", "a")) == 4
    with pytest.raises(NotMarshalledError, match="nested more than 12 deep"):
        checked.check(type_of(model, "Holds", "b"))


def test_each_type_is_checked_once(tmp_path: Path) -> None:
    """The number of values doubles with each level; the time does not."""
    structs = [f"struct S{n} {{ S{n - 1} a; S{n - 1} b; }};" for n in range(1, 60)]
    text = f"module c {{ struct S0 {{ octet a; }}; {' '.join(structs)} }};"
    model = loaded(tmp_path, text)
    assert types_of(model).check(type_of(model, "S59")) == 1 << 58


def test_recursion(model: Model) -> None:
    types = types_of(model)
    found = {
        name
        for name in ("Tree", "Link", "Pair", "Holds")
        if types.is_recursive(("c", name))
    }
    assert found == {"Tree", "Link"}


def test_unset_members(model: Model) -> None:
    """External members of a recursive type, or of one that is defined later."""
    types = types_of(model)
    early, link = struct_of(model, "Early"), struct_of(model, "Link")
    found = [m.name for m in early.members if types.is_unset(early, m)]
    assert found == ["a"]
    assert types.is_unset(link, member_of(model, "Link", "next"))
    assert not types.is_unset(link, member_of(model, "Link", "a"))


def test_headers(model: Model, tmp_path: Path) -> None:
    """Headers of optional members and of mutable types, at any depth."""
    types = types_of(model)
    for holder in ("HoldsOptional", "HoldsTagged", "HoldsTaggedKey"):
        for _ in range(2):
            assert types.has_headers(type_of(model, holder)), holder
    plain = loaded(tmp_path, "module c { struct Holds { long a; }; };")
    assert not types_of(plain).has_headers(type_of(plain, "Holds"))
    for name in ("a_struct", "rows", "a_map", "a_union", "an_octet"):
        assert not types.has_headers(type_of(model, "Holds", name)), name


def test_dynamic_types(model: Model) -> None:
    types = types_of(model)
    holders = ("Dynamic", "HoldsDynamic", "HoldsDynamicElements", "Holds")
    for name in (*holders, "HoldsCustom"):
        assert types.holds_dynamic(("c", name)), name
    for name in ("Pair", "Tree", "HoldsOptional"):
        assert not types.holds_dynamic(("c", name)), name
    members = struct_of(model, "Holds").members
    found = {m.name for m in members if types.is_dynamic(m.type)}
    assert found == {"an_any", "an_abstract", "a_value", "a_box"}
    for holder in holders[1:3]:
        for _ in range(2):
            assert types.is_dynamic(type_of(model, holder)), holder


def test_counts_of_bits(model: Model) -> None:
    for name, bits in (("Low", 7), ("High", 16), ("Higher", 21)):
        bitset = model.find(("c", name))
        assert isinstance(bitset, Bitset)
        assert bit_count(model, bitset) == bits


def test_codes_of_enums(model: Model, tmp_path: Path) -> None:
    colour = model.find(("c", "Colour"))
    assert isinstance(colour, Enum)
    assert enum_code(colour) == "I"
    below = loaded(tmp_path, "enum E { @value(-1) LESS, @value(0) ZERO };").find(("E",))
    assert isinstance(below, Enum)
    assert enum_code(below) == "i"


@pytest.mark.parametrize("type_", ["any", "CORBA::TypeCode", "ValueBase"])
def test_types_that_are_known_at_run_time_alone(type_: str, tmp_path: Path) -> None:
    text = f"#include <orb.idl>\nmodule c {{ struct Holds {{ {type_} a; }}; }};"
    model = loaded(tmp_path, text)
    types = types_of(model)
    assert types.is_dynamic(type_of(model, "Holds"))
    assert types.holds_dynamic(("c", "Holds"))


def test_the_limit_of_nested_sequences() -> None:
    assert MAX_LOOPS == 12
