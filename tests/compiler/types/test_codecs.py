"""Codecs of every kind of layout: round trips, zero padding, faults with their positions."""

from __future__ import annotations

import struct
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from types import ModuleType
from typing import Any

import emitted
import pytest
import samples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.marshalling.compiler import compiled_in_python
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    InterfaceDescriptor,
    MemberDescriptor,
    SequenceDescriptor,
    StructDescriptor,
)
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.values import encoded
from rtgen.runtime.marshalling.layouts.shapes import SHAPES_KEPT
from rtgen.runtime.values import AnyValue

CASE = Path(__file__).with_name("constructs.idl")


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    return emitted.emit(tmp_path_factory.mktemp("constructs"), [CASE])


@pytest.fixture(scope="module")
def test(package: ModuleType) -> Any:
    return package.test


@pytest.fixture(scope="module")
def types(package: ModuleType) -> dict[str, type[Any]]:
    found = {t._descriptor_.repository_id: t for t in emitted.classes(package)}
    return {
        name: t
        for name, t in found.items()
        if not isinstance(t._descriptor_, AliasDescriptor)
    }


def marshalled(types: dict[str, type[Any]]) -> list[type[Any]]:
    return [t for t in types.values() if hasattr(t, "to_cdr")]


def examples(number: int) -> Callable[[Any], Any]:
    return settings(
        max_examples=number,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


def test_round_trips(types: dict[str, type[Any]]) -> None:
    for type_ in marshalled(types):
        round_trip(type_, types)


def round_trip(type_: type[Any], types: dict[str, type[Any]]) -> None:
    descriptor = type_._descriptor_

    @examples(25)
    @given(samples.values(descriptor), st.booleans())
    def check(tree: Any, little_endian: bool) -> None:
        value = samples.build(descriptor, tree, types)
        octets = value.to_cdr(little_endian)
        assert type_.from_cdr(octets, little_endian) == value
        assert type_.from_cdr(memoryview(bytearray(octets)), little_endian) == value
        reader = Reader(octets, little_endian)
        assert reader.value(descriptor) == value
        reader.end()
        assert encoded(descriptor, value, little_endian) == octets
        if hasattr(value, "_snapshot_"):
            assert value._snapshot_() == value

    check()


@pytest.mark.sampled(0)
def test_any_octets_give_a_value_or_a_located_error(
    types: dict[str, type[Any]],
) -> None:
    for type_ in marshalled(types):
        survive(type_, types)


def survive(type_: type[Any], types: dict[str, type[Any]]) -> None:
    descriptor = type_._descriptor_
    root = descriptor.name.rpartition("::")[2]

    def decode(octets: bytes) -> None:
        fault = None
        try:
            value = type_.from_cdr(octets)
        except CdrError as error:
            fault = error
        if fault is None:
            assert type_.from_cdr(value.to_cdr()) == value or "nan" in repr(value)
        else:
            assert fault.path.startswith(root)
            assert "unpack" not in fault.message

    @examples(20)
    @given(st.binary(max_size=40), samples.values(descriptor), st.data())
    def check(noise: bytes, tree: Any, data: st.DataObject) -> None:
        decode(noise)
        octets = samples.build(descriptor, tree, types).to_cdr()
        if octets:
            cut = data.draw(st.integers(0, len(octets) - 1))
            with pytest.raises(CdrError):
                type_.from_cdr(octets[:cut])
            changed = bytearray(octets)
            changed[cut] = data.draw(st.integers(0, 255))
            decode(bytes(changed))
        with pytest.raises(CdrError):
            type_.from_cdr(octets + b"\0")

    check()


def test_aliases_have_codecs(test: Any) -> None:
    assert test.LongsCodec.to_cdr([1, 2], False).hex() == "000000020000000100000002"
    assert test.LongsCodec.from_cdr(test.LongsCodec.to_cdr([1, -2])) == [1, -2]
    matrix = [[1.0, 2.0, 3.0, 4.0] for _ in range(3)]
    assert test.MatrixCodec.from_cdr(test.MatrixCodec.to_cdr(matrix)) == matrix
    assert test.NamesCodec.from_cdr(test.NamesCodec.to_cdr(["a", "é"])) == ["a", "é"]
    nodes = [test.Node(1, [test.Node(2)])]
    assert test.NodesCodec.from_cdr(test.NodesCodec.to_cdr(nodes)) == nodes
    with pytest.raises(CdrError) as caught:
        test.LongsCodec.to_cdr([1, 1 << 40])
    assert caught.value.path == "Longs[1]"


def test_bitsets_are_one_number(test: Any) -> None:
    value = test.MoreBits(5, True, -2, 0xFFFFF)
    # 5, flag at 3, four bits unused, -2 in four bits at 8, twenty bits at 12.
    assert value.to_cdr(False).hex() == "fffffe0d"
    assert test.MoreBits.from_cdr(value.to_cdr()) == value
    assert test.Bits(1).to_cdr().hex() == "0100"
    assert {value: 1}[test.MoreBits(5, True, -2, 0xFFFFF)] == 1
    with pytest.raises(CdrError) as caught:
        test.BitStruct(bits1=test.Bits(8)).to_cdr()
    assert caught.value.path == "BitStruct.bits1.low"
    with pytest.raises(CdrError):
        test.Bits.from_cdr(b"\0\xf0")


def test_bitmasks_and_enums_have_codecs(test: Any) -> None:
    assert test.Mode(17).to_cdr(False).hex() == "00000011"
    assert test.Small.from_cdr(b"\2") is test.Small.HIGH
    with pytest.raises(CdrError):
        test.Small.from_cdr(b"")
    assert test.Kind.from_cdr(b"\0\0\0\1", False) is test.Kind.SQUARE


def test_rows_of_octets_and_characters(test: Any) -> None:
    rows = test.Rows()
    assert (rows.a, rows.b) == ([bytes(3)] * 2, ["\0\0"] * 2)
    assert rows.c == [[b"\0\0"], [b"\0\0"]]
    rows.a[1] = b"abc"
    assert test.Rows().a == [bytes(3)] * 2
    assert test.RasterCodec.to_cdr([b"ab", b"cd"]) == b"abcd"
    assert test.GridCodec.from_cdr(b"abcd") == ["ab", "cd"]


def test_codecs_of_an_interface_s_typedefs(test: Any) -> None:
    inners = [test.Service.Inner(test.Service.State.OFF)]
    codec = test.Service.InnersCodec
    assert codec.from_cdr(codec.to_cdr(inners)) == inners
    assert test.Service.RouteCodec.to_cdr([]) == bytes(4)
    assert test.Ahead.LaterListCodec.from_cdr(bytes(4)) == []


def test_the_bound_of_a_wide_string_without_a_mark(test: Any) -> None:
    octets = bytearray(test.Texts(d="abcde").to_cdr())
    place = octets.index(b"\xff\xfe")
    octets[place] = 0
    with pytest.raises(CdrError) as caught:
        test.Texts.from_cdr(octets)
    assert caught.value.path == "Texts.d"


def changed(value: Any, path: str, wrong: Any) -> Any:
    *parents, last = path.split(".")
    target = value
    for name in parents:
        target = getattr(target, name)
    setattr(target, last, wrong)
    return value


BASICS = [
    ("c", "ab", "c"),
    ("c", "Ā", "c"),
    ("c", b"a", "c"),
    ("w", "", "w"),
    ("w", "\U0001f600", "w"),
    ("w", "\ud800", "w"),
    ("b", 2, "b"),
    ("b", "yes", "b"),
    ("b", [], "b"),
    ("o", 256, "o"),
    ("o", -1, "o"),
    ("s", 1 << 15, "s"),
    ("l", 1.5, "l"),
    ("ul", -1, "ul"),
    ("ull", 1 << 64, "ull"),
    ("f", 1e39, "f"),
    ("f", "1", "f"),
    ("d", None, "d"),
    ("d", 10**400, "d"),
    ("ld", "x", "ld"),
    ("k", 7, "k"),
    ("k", None, "k"),
    ("price1", Decimal("1000"), "price1"),
    ("price1", Decimal("1.234"), "price1"),
    ("price1", 1.5, "price1"),
    ("price1", Decimal("NaN"), "price1"),
    ("even1", Decimal("12345"), "even1"),
]


@pytest.mark.parametrize(("path", "wrong", "place"), BASICS)
def test_wrong_basics_are_named(test: Any, path: str, wrong: Any, place: str) -> None:
    value = changed(test.Basics(), path, wrong)
    with pytest.raises(CdrError) as caught:
        value.to_cdr()
    assert caught.value.path == f"Basics.{place}"


OTHERS = [
    ("Texts", "a", "a\0b", "a"),
    ("Texts", "a", "\ud800", "a"),
    ("Texts", "a", b"a", "a"),
    ("Texts", "c", "123456", "c"),
    ("Texts", "c", "ééé", "c"),
    ("Texts", "d", "123456", "d"),
    ("Texts", "d", "\U0001f600" * 3, "d"),
    ("Texts", "b", "\0", "b"),
    ("Arrays", "one", [[1.0] * 4] * 2, "one"),
    ("Arrays", "one", [[1.0] * 3, [1.0] * 4, [1.0] * 5], "one[0]"),
    ("Arrays", "octets", b"123", "octets"),
    ("Arrays", "chars", "12", "chars"),
    ("Arrays", "flags", [True], "flags"),
    ("Arrays", "flags", [True, "no"], "flags[1]"),
    ("Arrays", "points1", [None, None], "points1[0]"),
    ("Arrays", "names1", ["a"], "names1"),
    ("Arrays", "table", [b"123", b"12"], "table[1]"),
    ("TwoArrays", "a", [1.0] * 2, "a"),
    ("Sequences", "a", [1, 2], "a"),
    ("Sequences", "b", ["a"], "b"),
    ("Sequences", "b", "aĀ", "b[1]"),
    ("Sequences", "c", [0, 3], "c[1]"),
    ("Sequences", "e", [0, 9], "e[1]"),
    ("Sequences", "f", ["a", 1], "f[1]"),
    ("Sequences", "h", [None], "h[0]"),
    ("Sequences", "j", [[1], [1 << 33]], "j[1][0]"),
    ("Sequences", "l", [1.0, 1e300], "l[1]"),
    ("Sequences", "l", 5, "l"),
    ("Sequences", "o", b"1234", "o"),
    ("Sequences", "p", [1, 2, 3], "p"),
    ("Sequences", "t", ["12345"], "t[0]"),
    ("Mixed", "one.ids", [1, None], "one.ids[1]"),
    ("Mixed", "one", None, "one"),
    ("Mixed", "many", [5], "many[0]"),
    ("Masks", "small1", 256, "small1"),
    ("Masks", "mode1", 1 << 32, "mode1"),
    ("Maps", "a", {"k": "v"}, "a['k']"),
    ("Maps", "a", [1], "a"),
    ("References", "s", "IOR:", "s"),
    ("Unions", "a", None, "a"),
]


@pytest.mark.parametrize(("name", "path", "wrong", "place"), OTHERS)
def test_wrong_values_are_named(
    test: Any, name: str, path: str, wrong: Any, place: str
) -> None:
    value = changed(getattr(test, name)(), path, wrong)
    with pytest.raises(CdrError) as caught:
        value.to_cdr()
    assert caught.value.path == f"{name}.{place}"


def test_a_value_in_itself_is_refused(test: Any) -> None:
    node = test.Node()
    node.children.append(node)
    with pytest.raises(CdrError, match="contains itself"):
        node.to_cdr()


def test_deep_nesting_is_refused_not_crashed(test: Any) -> None:
    octets = struct.pack("<2I", 0, 1) * 100_000
    with pytest.raises(CdrError):
        test.Node.from_cdr(octets)


@pytest.mark.parametrize(
    ("name", "octets"),
    [
        ("Named", struct.pack("<II", 1 << 31, 0)),
        ("Mixed", struct.pack("<II", 1, 0xFFFFFFFF) + bytes(64)),
        ("Sequences", struct.pack("<I", 0xFFFFFFFF) + bytes(64)),
        ("Maps", struct.pack("<I", 0xFFFFFFFF) + bytes(64)),
        ("References", struct.pack("<II", 0, 0xFFFFFFFF) + bytes(64)),
    ],
)
def test_lengths_are_checked_before_anything_is_allocated(
    test: Any, name: str, octets: bytes
) -> None:
    import tracemalloc

    with pytest.raises(CdrError):
        getattr(test, name).from_cdr(octets)
    tracemalloc.start()
    try:
        with pytest.raises(CdrError, match=r"left|octets"):
            getattr(test, name).from_cdr(octets)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_tables_of_shapes_stay_small(test: Any) -> None:
    descriptor = test.Named._descriptor_
    encode = compiled_in_python("to_cdr", descriptor)
    decode = compiled_in_python("from_cdr", descriptor)
    for length in range(2 * SHAPES_KEPT):
        value = test.Named("x", [0] * length)
        assert decode(test.Named, encode(value)) == value
    packers = encode.__globals__["pack_all_little"]
    readers = decode.__globals__["readers_1_little"]
    tables = [packers, *(t for t in readers if isinstance(t, dict))]
    assert len(tables) > 1
    assert all(0 < len(table) <= SHAPES_KEPT for table in tables)


def test_booleans_and_strings_from_the_wire(test: Any) -> None:
    octets = bytearray(test.Basics().to_cdr())
    octets[4] = 2
    with pytest.raises(CdrError) as caught:
        test.Basics.from_cdr(octets)
    assert caught.value.path == "Basics.b"
    for text in (b"ab", b"a\0", b"\xff\0"):
        wrong = struct.pack("<I", 3)[: 4 * (len(text) == 3)] or struct.pack(
            "<I", len(text)
        )
        with pytest.raises(CdrError) as caught:
            test.Named.from_cdr(wrong + text[:-1] + b"a" * 2 + struct.pack("<I", 0))
        assert caught.value.path.startswith("Named")
    assert test.Named.from_cdr(bytes(8)) == test.Named()


def test_defaults(test: Any) -> None:
    basics = test.Basics()
    assert (basics.c, basics.w, basics.b, basics.d) == ("\0", "\0", False, 0.0)
    assert basics.k is test.Kind.CIRCLE
    assert basics.price1 == Decimal("0")
    arrays = test.Arrays()
    assert arrays.one == [[0.0] * 4] * 3
    assert arrays.one[0] is not arrays.one[1]
    assert (arrays.octets, arrays.chars) == (bytes(4), "\0\0\0")
    assert len(arrays.points1) == 2
    assert arrays.points1[0] is not arrays.points1[1]


def test_names(test: Any) -> None:
    shadows = test.Shadows()
    assert (shadows.from_, shadows.to_cdr_, shadows.list) == (0, 0, [])
    assert test.Shadows.from_cdr(shadows.to_cdr()) == shadows
    assert test.Kind.real_ == 2
    assert test.CIRCLE is test.Kind.CIRCLE
    assert (test.MAX, test.PI, test.NAME) == (5, 3.14, 'it\'s "x"')
    assert test.FAVOURITE is test.Kind.SQUARE
    assert test.Derived("n", [1], 2.0).extra == 2.0
    assert issubclass(test.Derived, test.Named)


def test_unions(test: Any) -> None:
    circle = test.ByEnum.of_radius(2.5)
    assert (circle.discriminator, circle.radius) == (test.Kind.CIRCLE, 2.5)
    with pytest.raises(AttributeError, match="does not select"):
        _ = circle.other
    assert test.ByEnum.of_other(3).discriminator == test.Kind.real_
    assert test.ByLong.of_text("x", 2).discriminator == 2
    assert test.ByEnum.of_value_(test.Named()).value_ == test.Named()
    nothing = test.ByLong(77, None)
    assert test.ByLong.from_cdr(nothing.to_cdr()) == nothing
    with pytest.raises(CdrError):
        test.ByLong(77, "x").to_cdr()
    with pytest.raises(CdrError) as caught:
        test.ByLong(-5, test.Point(1.0, None)).to_cdr()
    assert caught.value.path == "ByLong.at.y"


def test_snapshots_share_nothing(test: Any) -> None:
    value = test.Mixed(1, [test.Named("a", [1])], test.Named("b", [2]), 1.0, [3.0])
    copy = value._snapshot_()
    value.many[0].ids.append(5)
    value.one.name = "c"
    value.tail.append(1.0)
    assert copy == test.Mixed(
        1, [test.Named("a", [1])], test.Named("b", [2]), 1.0, [3.0]
    )
    union = test.ByEnum.of_value_(test.Named("a", [1]))
    held = union._snapshot_()
    union.value.ids.append(2)
    assert held.value_.ids == [1]


def test_exceptions(test: Any) -> None:
    error = test.Bad("why", 3)
    assert (error.reason, error.args_) == ("why", 3)
    assert error == test.Bad("why", 3)
    assert error != test.Bad("why", 4)
    assert len({error, test.Bad("why", 3)}) == 1
    assert repr(error) == "Bad(reason='why', args_=3)"
    assert str(error) == "reason='why', args_=3"
    assert test.Bad.from_cdr(error.to_cdr()) == error
    assert test.Nothing().to_cdr() == b""
    with pytest.raises(test.Bad):
        raise error


def test_differences_are_shown() -> None:
    a = StructDescriptor(
        "IDL:A:1.0",
        "A",
        (MemberDescriptor("x", SequenceDescriptor(InterfaceDescriptor("", "I"))),),
    )
    b = StructDescriptor(
        "IDL:A:1.0",
        "A",
        (MemberDescriptor("y", SequenceDescriptor(InterfaceDescriptor("", "I"))),),
    )
    assert difference(a, a) is None
    shown = difference(a, b)
    assert shown is not None
    assert "! " in shown
    assert "sequence<I> x" in shown
    assert "sequence<I> y" in shown


def test_negative_enumerators_are_in_twos_complement(tmp_path: Path) -> None:
    package = emitted.emit_text(
        tmp_path,
        """
        enum Outcome { @value(-3) LOST, @value(-1) LATE, @value(4) GOOD };
        @bit_bound(8) enum Small { @value(-2) LOW, HIGH };
        union Report switch (Outcome) {
            case LOST: long since;
            case GOOD: string text;
        };
        struct Sample {
            @key Outcome first;
            sequence<Outcome> all;
            Small tiny;
            Report last;
            any other;
        };
        """,
    )
    outcome, report = package.Outcome, package.Report
    assert outcome.LOST.to_cdr() == bytes.fromhex("fdffffff")
    assert outcome.from_cdr(b"\xff\xff\xff\xfd", little_endian=False) is outcome.LOST
    with pytest.raises(CdrError):
        outcome.from_cdr(bytes.fromhex("fcffffff"))
    for described in (AnyValue(outcome, outcome.LATE), AnyValue(report, report())):
        sample = package.Sample(
            outcome.LATE,
            [outcome.GOOD, outcome.LOST],
            package.Small.LOW,
            report(outcome.LOST, 7),
            described,
        )
        for little in (True, False):
            octets = sample.to_cdr(little)
            again = package.Sample.from_cdr(octets, little)
            assert again.to_cdr(little) == octets
            assert (again.first, again.all) == (sample.first, sample.all)
            assert (again.tiny, again.last) == (sample.tiny, sample.last)
    assert report(outcome.LOST, 7).to_xcdr2(False).hex() == "fffffffd00000007"
    assert package.Small.LOW.to_xcdr2() == b"\xfe"
    assert package.Small.from_xcdr2(b"\xff") is package.Small.HIGH


def test_enumerators_in_a_struct_called_like_what_its_class_needs(
    tmp_path: Path,
) -> None:
    package = emitted.emit_text(
        tmp_path,
        "struct S { enum E { K, field, int, bytes, Decimal, list } m; sequence<long> a;"
        " sequence<octet> b; fixed<3,1> c; };",
    )
    value = package.S()
    assert (value.a, value.b, value.c) == ([], b"", Decimal(0))
    assert package.S.from_cdr(value.to_cdr()) == value
    assert package.S.int is package.S.E.int


def test_the_fields_of_a_union_hide_no_type(tmp_path: Path) -> None:
    package: Any = emitted.emit_text(
        tmp_path,
        """
        enum value { one, two };
        enum discriminator { three, four };
        union U switch (value) { case one: discriminator a; default: value b; };
        """,
    )
    union = package.U.of_a(package.discriminator.four)
    assert package.U.from_cdr(union.to_cdr()) == union
    assert package.U.of_b(package.value.two).discriminator == package.value.two
