"""Any, type codes and values: octets, sharing, cycles, truncation, faults, hostile input."""

from __future__ import annotations

import pickle
import struct
from pathlib import Path
from types import ModuleType
from typing import Any

import emitted
import pytest

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    NULL,
    AliasDescriptor,
    ArrayDescriptor,
    FixedDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.direct import compiled_class
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.values import decoded, encoded
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.system.json_printers import plain as plain_sample
from rtgen.runtime.values import (
    AnyValue,
    Box,
    DynamicState,
    DynamicUnion,
    DynamicValue,
    Value,
    implementation,
)

CASE = Path(__file__).with_name("dynamic.idl")
LONG = PrimitiveDescriptor("long")
TYPE_CODE = PrimitiveDescriptor("CORBA::TypeCode")


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    return emitted.emit(tmp_path_factory.mktemp("dynamic"), [CASE])


@pytest.fixture(scope="module")
def dyn(package: ModuleType) -> Any:
    return package.dyn


def words(octets: bytes) -> str:
    """Return octets in hexadecimal, four at a time."""
    return " ".join(octets[i : i + 4].hex() for i in range(0, len(octets), 4))


def type_code(descriptor: Any, little_endian: bool = True) -> bytes:
    described = getattr(descriptor, "_descriptor_", descriptor)
    return encoded(TYPE_CODE, described, little_endian)


def every_truncation_is_reported(type_: Any, octets: bytes) -> None:
    for end in range(len(octets)):
        with pytest.raises(CdrError):
            type_.from_cdr(octets[:end])
    with pytest.raises(CdrError):
        type_.from_cdr(octets + b"\0")


# Type codes.


def test_a_type_code_of_a_struct(dyn: Any) -> None:
    assert words(type_code(dyn.A, False)) == (
        "0000000f 00000030 01000000 0e000000 49444c3a 44796e2f 413a312e 30000000"
        " 02000000 41000000 01000000 02000000 78000000 03000000"
    )


def test_what_was_written_is_referred_to(dyn: Any) -> None:
    octets = type_code(dyn.B)
    assert octets.count(b"IDL:Dyn/A:1.0") == 1
    place = octets.index(b"\xff" * 4)
    (back,) = struct.unpack_from("<i", octets, place + 4)
    assert struct.unpack_from("<I", octets, place + 4 + back) == (15,)
    assert decoded(TYPE_CODE, octets, True) is dyn.B._descriptor_


@pytest.mark.parametrize("little_endian", [True, False])
def test_type_codes_of_generated_types_come_back_as_these(
    dyn: Any, little_endian: bool
) -> None:
    for name in ("A", "B", "N", "K", "U", "W", "UK", "X", "V", "T", "TT", "D", "AV"):
        descriptor = getattr(dyn, name)._descriptor_
        octets = type_code(descriptor, little_endian)
        assert decoded(TYPE_CODE, octets, little_endian) is descriptor, name
    for name in ("Text", "Points", "Holds", "I", "AI", "Tree", "Failed"):
        descriptor = getattr(dyn, name)._descriptor_
        octets = type_code(descriptor, little_endian)
        again = decoded(TYPE_CODE, octets, little_endian)
        assert again.repository_id == descriptor.repository_id


def test_type_codes_without_names_of_their_own(dyn: Any) -> None:
    for descriptor in (
        *(LONG, ANY, NULL, TYPE_CODE, PrimitiveDescriptor("Object")),
        *(PrimitiveDescriptor("ValueBase"), PrimitiveDescriptor("long double")),
        *(StringDescriptor(), StringDescriptor(True, 7), FixedDescriptor(5, 2)),
        *(SequenceDescriptor(LONG, 3), ArrayDescriptor(LONG, (2, 3))),
    ):
        assert decoded(TYPE_CODE, type_code(descriptor), True) == descriptor
    alias = dyn.ArrCodec._descriptor_
    again = decoded(TYPE_CODE, type_code(alias), True)
    assert isinstance(again, AliasDescriptor)
    assert (again.name, difference(again, alias)) == ("Arr", None)


@pytest.mark.parametrize("name", ["A", "B", "N", "U", "X", "T"])
@pytest.mark.parametrize("flip", [0x01, 0xFF])
def test_a_type_code_read_before_changes_no_later_one(
    dyn: Any, name: str, flip: int
) -> None:
    """An element of a sequence is read anew each time; a type by itself is remembered."""
    octets = type_code(getattr(dyn, name))
    sequence = type_code(SequenceDescriptor(getattr(dyn, name)._descriptor_))
    begin = sequence.index(octets[8:]) - 8
    differ = 0
    for place in range(8, len(octets)):
        read: list[Any] = []
        for whole, at in ((octets, place), (sequence, begin + place)):
            changed = whole[:at] + bytes([whole[at] ^ flip]) + whole[at + 1 :]
            decoded(TYPE_CODE, octets, True)
            try:
                read.append(decoded(TYPE_CODE, changed, True))
            except CdrError:
                read.append(None)
        alone, element = read[0], getattr(read[1], "element", None)
        assert repr(alone) == repr(element)
        differ += alone is not getattr(dyn, name)._descriptor_
    assert 0 < differ < len(octets) - 8


def test_a_type_that_is_generated_later_is_found(tmp_path: Path) -> None:
    text = "module {0} {{ struct Found {{ long x; }}; }};"
    (tmp_path / "a").mkdir()
    early = emitted.emit_text(tmp_path / "a", text.format("Early")).early
    octets = type_code(early.Found).replace(b"Early", b"Later")
    assert decoded(TYPE_CODE, octets, True).repository_id == "IDL:Later/Found:1.0"
    (tmp_path / "b").mkdir()
    later = emitted.emit_text(tmp_path / "b", text.format("Later")).later
    assert decoded(TYPE_CODE, octets, True) is later.Found._descriptor_


def test_what_has_no_type_code(dyn: Any) -> None:
    for descriptor in (PrimitiveDescriptor("int8"), dyn.Opt._descriptor_, "long"):
        with pytest.raises(CdrError, match="type code"):
            encoded(TYPE_CODE, descriptor, True)


def test_hostile_type_codes() -> None:
    sequence = struct.pack("<I", 3) + struct.pack("<I", 0)
    for _ in range(120):
        inner = b"\1\0\0\0" + sequence + struct.pack("<I", 0)
        sequence = struct.pack("<II", 19, len(inner)) + inner
    with pytest.raises(CdrError, match="deep"):
        decoded(TYPE_CODE, sequence, True)
    for text in (
        "13000000 0c000000 01000000 ffffffff 00000000",
        "13000000 ffffff7f 01000000",
        "0f000000 10000000 01000000 01000000 00000000 00000000",
        "14000000 0c000000 01000000 03000000 00000000",
        "63000000",
        "1c000000 63000200",
        "ffffffff fcffffff",
    ):
        with pytest.raises(CdrError):
            decoded(TYPE_CODE, bytes.fromhex(text), True)


def test_a_type_code_cannot_ask_for_work_without_end(dyn: Any) -> None:
    """Arrays of empty arrays: few octets, many values."""
    nothing: Any = StructDescriptor("IDL:None:1.0", "None", ())
    for number in range(4):
        array = ArrayDescriptor(nothing, (60000,))
        nothing = AliasDescriptor(f"IDL:A{number}:1.0", "A", array)
    octets = type_code(nothing)
    with pytest.raises(CdrError, match="octets account for"):
        decoded(ANY, octets, True)


# Any.


def test_any(dyn: Any) -> None:
    value = AnyValue(dyn.A, dyn.A(5))
    octets = value.to_cdr(False)
    assert words(octets[-4:]) == "00000005"
    again = AnyValue.from_cdr(octets, False)
    assert again == value
    assert type(again.value) is dyn.A
    every_truncation_is_reported(AnyValue, value.to_cdr())
    assert AnyValue().to_cdr() == bytes(4)
    assert pickle.loads(pickle.dumps(value)) == value


def test_anys_of_every_kind(dyn: Any) -> None:
    node = dyn.N(1, [dyn.N(2)])
    for value in (
        AnyValue(dyn.N, node),
        AnyValue(dyn.WordsCodec, ["a", "bb"]),
        AnyValue(dyn.K, dyn.K.k1),
        AnyValue(dyn.U, dyn.U.of_q("abc")),
        AnyValue(dyn.X, dyn.X("bye")),
        AnyValue(ANY, AnyValue(LONG, 3)),
        AnyValue(SequenceDescriptor(PrimitiveDescriptor("octet")), b"abc"),
        AnyValue(ArrayDescriptor(PrimitiveDescriptor("char"), (2, 2)), ["ab", "cd"]),
        AnyValue(TYPE_CODE, LONG),
        AnyValue(dyn.I, ObjectReference("IDL:X:1.0", ((0, b"x"),))),
        AnyValue(dyn.I, None),
        AnyValue(dyn.V, None),
    ):
        for little_endian in (True, False):
            again = AnyValue.from_cdr(value.to_cdr(little_endian), little_endian)
            assert again.value == value.value
            assert (
                difference(again.type, value.type) is None
                or plain(again.type).repository_id == value.type.repository_id
            )


def test_an_exception_in_an_any_says_what_it_is(dyn: Any) -> None:
    octets = AnyValue(dyn.X, dyn.X("bye")).to_cdr()
    assert octets.count(b"IDL:Dyn/X:1.0") == 2
    with pytest.raises(CdrError, match="instead of"):
        AnyValue.from_cdr(octets[::-1].replace(b"0.1:X", b"0.1:Y", 1)[::-1])


def test_values_of_types_that_are_not_known(dyn: Any, tmp_path: Path) -> None:
    text = (
        "module Far { struct P { long x; sequence<long> y; }; enum E { a, b };"
        " union Q switch (E) { case a: P inner; case b: long z; };"
        " exception O { P p1; }; valuetype F { public P p1; public F more; };"
        " valuetype G long; };"
    )
    far = emitted.emit_text(tmp_path, text).far
    point = far.P(1, [2, 3])
    value = far.F(point)
    value.more = value
    made = [
        AnyValue(far.P, point),
        AnyValue(far.Q, far.Q.of_inner(point)),
        AnyValue(far.O, far.O(point)),
        AnyValue(far.F, value),
        AnyValue(far.G, far.G(7)),
    ]
    octets = [item.to_cdr().replace(b"Far", b"Fat") for item in made]
    struct_, union, error, state, box = (AnyValue.from_cdr(o) for o in octets)
    assert isinstance(struct_.value, DynamicValue)
    assert (struct_.value.x, struct_.value.y) == (1, [2, 3])
    assert not hasattr(struct_.value, "z")
    assert isinstance(union.value, DynamicUnion)
    assert (union.value.discriminator, union.value.value.x) == (0, 1)
    assert union.value.described().name == "Q"
    assert error.value.p1.y == [2, 3]
    assert isinstance(state.value, DynamicState)
    assert state.value.more is state.value
    assert isinstance(box.value, Box)
    assert box.value.value == 7
    for item, same in zip((struct_, union, error, state, box), octets, strict=True):
        assert item.to_cdr() == same
        assert item._snapshot_().to_cdr() == same


def test_members_of_type_any(dyn: Any) -> None:
    anys = dyn.Anys(
        1, AnyValue(LONG, 2), [AnyValue()], [AnyValue(dyn.A, dyn.A(3)), AnyValue()]
    )
    anys.d = {4: AnyValue(StringDescriptor(), "x")}
    anys.e = dyn.K._descriptor_
    both = dyn.Both(dyn.Chosen.of_a(AnyValue(LONG, 5)), [], anys)
    for little_endian in (True, False):
        assert dyn.Anys.from_cdr(anys.to_cdr(little_endian), little_endian) == anys
        assert dyn.Both.from_cdr(both.to_cdr(little_endian), little_endian) == both
    every_truncation_is_reported(dyn.Anys, anys.to_cdr())
    copy = both._snapshot_()
    copy.c.c[0].value.x = 9
    assert anys.c[0].value.x == 3
    assert copy.c.e is anys.e
    tree = dyn.Tree(AnyValue(LONG, 1), [dyn.Tree(AnyValue(dyn.A, dyn.A(2)))])
    assert dyn.Tree.from_cdr(tree.to_cdr()) == tree
    items = [AnyValue(LONG, 1), AnyValue()]
    assert dyn.AnySeqCodec.from_cdr(dyn.AnySeqCodec.to_cdr(items)) == items
    failed = dyn.Failed(AnyValue(LONG, 1))
    assert dyn.Failed.from_cdr(failed.to_cdr()) == failed


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        (AnyValue(LONG, "x"), "Anys.a.value"),
        (5, "Anys.a"),
        (AnyValue(SequenceDescriptor(LONG), [1, None]), "Anys.a.value[1]"),
    ],
)
def test_wrong_anys_are_named(dyn: Any, wrong: Any, place: str) -> None:
    with pytest.raises(CdrError) as caught:
        dyn.Anys(a=wrong).to_cdr()
    assert caught.value.path == place


# Values. The octets are those that omniORB 4.3 sends.


def test_a_value_of_the_expected_type(dyn: Any) -> None:
    value = dyn.V(1)
    assert words(value.to_cdr()) == "08ffff7f 08000000 01000000 00000000 ffffffff"
    value.next = value
    assert words(value.to_cdr()) == (
        "08ffff7f 0c000000 01000000 ffffffff f0ffffff ffffffff"
    )
    again = dyn.V.from_cdr(value.to_cdr())
    assert again.next is again
    value.next = dyn.V(2)
    assert words(value.to_cdr()) == (
        "08ffff7f 04000000 01000000 08ffff7f 08000000 02000000 00000000 ffffffff"
    )
    every_truncation_is_reported(dyn.V, value.to_cdr())


def test_shared_values_and_null(dyn: Any) -> None:
    shared = dyn.V(7)
    text = dyn.Text("aa")
    value = dyn.Values(1, shared, shared, text, text, [shared, None], [None, shared])
    for little_endian in (True, False):
        octets = value.to_cdr(little_endian)
        again = dyn.Values.from_cdr(octets, little_endian)
        assert again.a is again.b is again.e[0] is again.f[1]
        assert again.c is again.d
        assert (again.a.x, again.d.value, again.e[1]) == (7, "aa", None)
        assert again.to_cdr(little_endian) == octets
    every_truncation_is_reported(dyn.Values, octets)
    copy = value._snapshot_()
    assert copy.a is copy.b
    assert copy.a is not shared


def test_derived_and_truncatable_values(dyn: Any) -> None:
    truncatable = dyn.TT(1, None, "x", 2.5, dyn.T(3, None, "y"))
    other = dyn.D(5, None, 6)
    value = dyn.Values(
        a=truncatable, b=other, c=truncatable.inner, e=[dyn.T(), dyn.T()]
    )
    octets = value.to_cdr()
    again = dyn.Values.from_cdr(octets)
    assert [type(v) for v in (again.a, again.b, again.c)] == [dyn.TT, dyn.D, dyn.T]
    assert again.a.inner is again.c
    assert again.to_cdr() == octets
    assert octets.count(b"IDL:Dyn/T:1.0") == 1  # the second is an indirection
    with pytest.raises(CdrError, match="needed"):
        dyn.TT(inner=dyn.WithAbstract()).to_cdr()


def test_a_value_is_truncated_to_what_is_known(dyn: Any) -> None:
    inner = dyn.TT(9, None, "in", 0.5, dyn.V(8))
    outer = dyn.TT(1, None, "x", 2.5, inner)
    body = dyn.VsCodec.to_cdr([outer, dyn.V(4)])
    unknown = body.replace(b"IDL:Dyn/TT:1.0", b"IDL:Dyn/TX:1.0")
    first, second = dyn.VsCodec.from_cdr(unknown)
    assert type(first) is dyn.T
    assert (first.x, first.s, second.x) == (1, "x", 4)
    gone = dyn.VsCodec.to_cdr([dyn.D(1)]).replace(b"Dyn/D", b"Dyn/Q")
    with pytest.raises(CdrError, match="not known"):
        dyn.VsCodec.from_cdr(gone)


def test_chunks_may_end_anywhere(dyn: Any) -> None:
    one = "08ffff7f 08000000 01000000 00000000 ffffffff"
    two = "08ffff7f 04000000 01000000 04000000 00000000 ffffffff"
    for text in (one, two):
        value = dyn.V.from_cdr(bytes.fromhex(text))
        assert (value.x, value.next) == (1, None)
    split = "08ffff7f 08000000 01000000 00000000 05000000 04000000 61000000 03000000 62630000"
    # `s` is "abc", in two chunks; the second one is padded and closed.
    value = dyn.T.from_cdr(bytes.fromhex(split + " ffffffff"))
    assert value.s == "abc"


@pytest.mark.parametrize(
    "text",
    [
        "08ffff7f 08000000 01000000 00000000 feffffff",
        "08ffff7f 08000000 01000000 00000000 00000000",
        "08ffff7f 0c000000 01000000 00000000 00000000 ffffffff",
        "08ffff7f ffffff00 01000000 00000000 ffffffff",
        "08ffff7f ffffffff",
        "08ffff7f 0c000000 01000000 ffffffff f4ffffff ffffffff",
        "0affff7f ffffffff fcffffff",
        "0effff7f ffffff7f",
        "00ffff7f 01000000 0affff7f",
        "05000000",
    ],
)
def test_damaged_values(dyn: Any, text: str) -> None:
    with pytest.raises(CdrError):
        dyn.V.from_cdr(bytes.fromhex(text))


def test_boxes_abstract_bases_and_anys_inside_of_values(dyn: Any) -> None:
    text = dyn.Text("t")
    reference = ObjectReference("IDL:X:1.0", ((0, b"x"),))
    held = dyn.WithAbstract(b"abc")
    value = dyn.Holds(
        *(text, text, AnyValue(dyn.Points, dyn.Points([dyn.A(1)]))),
        *(dyn.U.of_p(3), held, reference, dyn.B(dyn.A(1), dyn.A(2))),
    )
    for little_endian in (True, False):
        octets = value.to_cdr(little_endian)
        again = dyn.Holds.from_cdr(octets, little_endian)
        assert again.a is again.b
        assert again.c.value.value == [dyn.A(1)]
        assert (again.d, again.e.data, again.f) == (value.d, b"abc", reference)
        assert again.to_cdr(little_endian) == octets
    every_truncation_is_reported(dyn.Holds, octets)
    value.e = reference
    assert dyn.Holds.from_cdr(value.to_cdr()).e == reference
    with pytest.raises(CdrError) as caught:
        dyn.Holds(g=dyn.B(dyn.A("x"))).to_cdr()
    assert caught.value.path == "Holds.g.first.x"
    with pytest.raises(CdrError):
        dyn.C(1).to_cdr()


def test_values_are_made_as_their_implementation(tmp_path: Path) -> None:
    text = "valuetype Counter { private long n; long next(); attribute long step; };"
    package = emitted.emit_text(tmp_path, text)
    with pytest.raises(NotImplementedError, match="Counter::next"):
        package.Counter().next()
    with pytest.raises(NotImplementedError):
        package.Counter().step = 1

    @implementation
    class Counting(package.Counter):  # type: ignore[misc, name-defined]
        __slots__ = ()

        def next(self) -> int:
            self.n += 1
            return int(self.n)

    made = package.Counter.from_cdr(package.Counter(4).to_cdr())
    assert isinstance(made, Counting)
    assert isinstance(made, Value)
    assert made.next() == 5


def test_a_long_chain_of_values_does_not_fit(dyn: Any) -> None:
    value = None
    for number in range(5000):
        value = dyn.V(number, value)
    with pytest.raises(CdrError, match="nested too deeply"):
        value.to_cdr()


# Optional members.


def test_optional_members_have_headers(dyn: Any) -> None:
    absent = dyn.Opt(1, end=2)
    assert absent.a is None
    present = dyn.Opt(1, 5, "x", dyn.A(3), 2)
    for value in (absent, present):
        for little_endian in (True, False):
            octets = value.to_cdr(little_endian)
            assert dyn.Opt.from_cdr(octets, little_endian) == value
        every_truncation_is_reported(dyn.Opt, octets)
        both = dyn.HasOpt(value, [value, absent])
        assert dyn.HasOpt.from_cdr(both.to_cdr()) == both
        assert both._snapshot_() == both
        assert dyn.OptsCodec.from_cdr(dyn.OptsCodec.to_cdr([value])) == [value]
        chosen = dyn.UOpt.of_a(value)
        assert dyn.UOpt.from_cdr(chosen.to_cdr()) == chosen
    with pytest.raises(CdrError) as caught:
        dyn.Opt(a="x").to_cdr()
    assert caught.value.path == "Opt.a"


def test_samples_in_logs(dyn: Any) -> None:
    value = dyn.V(1)
    value.next = value
    anys = dyn.Anys(1, AnyValue(dyn.A, dyn.A(2)), e=dyn.A._descriptor_)
    assert plain_sample(value) == {"x": 1, "next": "Dyn::V"}
    plain = plain_sample(anys)
    assert (plain["a"], plain["e"]) == ({"x": 2}, "Dyn::A")
    assert plain_sample(dyn.Text("t")) == {"value": "t"}
    assert plain_sample(dyn.U.of_p(3)) == {"discriminator": 1, "value": 3}


def test_links_are_looked_through(dyn: Any) -> None:
    member = dyn.V._descriptor_.members[1]
    assert isinstance(member.type, LinkDescriptor)
    assert plain(member.type) is dyn.V._descriptor_


def test_generated_types_in_an_any_use_their_codecs(tmp_path: Path) -> None:
    """Octets and positions of faults equal those of the codec along the descriptor."""
    p = emitted.emit_text(
        tmp_path,
        """
        struct Point { short x; double y; };
        struct Path { string name; sequence<Point> points; };
        union Choice switch (short) { case 1: Path all; case 2: Point one; };
        struct Nothing {};
        struct Many { Nothing none[1000]; long number; };
        struct Maybe { @optional long number; };
        struct Holder { octet before; any what; };
        """,
    )
    for class_ in (p.Point, p.Path, p.Choice):
        assert compiled_class(class_._descriptor_) is class_
    for class_ in (p.Many, p.Maybe):
        assert compiled_class(class_._descriptor_) is None
    path = p.Path("a", [p.Point(1, 2.0), p.Point(3, 4.0)])
    for value in (path, p.Choice.of_all(path), p.Many(number=3)):
        holder = p.Holder(1, AnyValue(type(value), value))
        for little in (True, False):
            octets = holder.to_cdr(little)
            walked = Output()
            Writer(walked, little, walking=True).value(p.Holder._descriptor_, holder)
            assert octets == walked
            assert p.Holder.from_cdr(octets, little) == holder
            reader = Reader(octets, little, walking=True)
            assert reader.value(p.Holder._descriptor_) == holder
    path.points[1].x = 1 << 15
    holder = p.Holder(1, AnyValue(p.Path, path))
    with pytest.raises(CdrError, match=r"^Holder\.what\.value\.points\[1\]\.x: 32768 "):
        holder.to_cdr()
    path.points[1].x = 3
    octets = holder.to_cdr()
    with pytest.raises(CdrError, match=r"^Holder\.what\.value\.points\[1\]\.y: trunc"):
        p.Holder.from_cdr(octets[:-1])
