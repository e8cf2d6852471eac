"""XCDR by hand-made octets for each rule of DDS-XTypes 1.3, 7.4.3; faults; key hashes; payloads."""

from __future__ import annotations

import hashlib
import random
import struct
from inspect import unwrap
from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.cli import run
from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.frontends.idl import load
from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, CdrError, field
from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.dynamic.fault_search import fault_in_body
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.xcdr import (
    Representation,
    decode,
    deserialize,
    encode,
    representation_of,
    serialize,
)


class Counted(Aggregated):
    """Two counts, and octets to pad."""

    _descriptor_ = idl.struct(
        "Counted", name=idl.STRING, numbers=idl.sequence(idl.DOUBLE), last=idl.OCTET
    )

    name: str = ""
    numbers: list[float] = field(default_factory=list)
    last: int = 0


class Empty(Aggregated):
    """A struct without members."""

    _descriptor_ = idl.struct("Empty")


class Items(Aggregated):
    """A sequence of items without octets, which generated types cannot have."""

    _descriptor_ = idl.struct("Items", items=idl.sequence(Empty), last=idl.OCTET)

    items: list[Empty] = field(default_factory=list)
    last: int = 0


def test_payloads_of_any_length_are_padded() -> None:
    for number in range(9):
        value = Counted("x" * number, [0.5] * (number % 3), 7)
        for version in (1, 2):
            for little_endian in (True, False):
                enveloped(value, version, little_endian)
    assert serialize(Empty(), Representation.CDR_LE) == b"\0\1\0\0"
    with pytest.raises(CdrError, match=r"Counted\.last: "):
        serialize(Counted("", [], 256), Representation.CDR_LE)
    with pytest.raises(CdrError, match=r"Counted\.numbers"):
        serialize(Counted("", ["a"]), Representation.CDR_BE)  # type: ignore[list-item]


@pytest.fixture(scope="module")
def x(tmp_path_factory: pytest.TempPathFactory) -> Any:
    file = Path(__file__).with_name("xcdr.idl")
    return emitted.emit(tmp_path_factory.mktemp("xcdr"), [file]).x


def both(value: Any, version: int, text: str) -> None:
    """Compare the little-endian octets of the value, after a round trip in both byte orders."""
    wanted = bytes.fromhex(text)
    type_ = type(value)
    assert encode(type_, value, version, True).hex(" ", -4) == wanted.hex(" ", -4)
    assert decode(type_, wanted, version, True) == value
    assert decode(type_, encode(type_, value, version, False), version, False) == value
    for little_endian in (True, False):
        enveloped(value, version, little_endian)


def enveloped(value: Any, version: int, little_endian: bool) -> None:
    """Check that the payload of the value is header, octets and padding."""
    type_ = type(value)
    form = representation_of(type_, version, little_endian)
    octets = encode(type_, value, version, little_endian)
    padding = -len(octets) % 4
    wanted = bytes((0, form, 0, padding)) + octets + bytes(padding)
    assert serialize(value, form).hex(" ", -4) == wanted.hex(" ", -4)


ONE = "000000000000f03f"


def test_alignment_is_4_at_most_in_version_2(x: Any) -> None:
    value = x.Plain(1, 1.0, 2, 3)
    both(value, 2, f"01000000 {ONE} 02000000 0300000000000000")
    both(value, 1, f"01000000 00000000 {ONE} 0200 000000000000 0300000000000000")


def test_enums_bitmasks_and_bitsets_take_what_their_bits_need(x: Any) -> None:
    value = x.Numbers(
        x.GREEN, x.T1, x.M1, x.Bits.LOW | x.Bits.HIGH, x.Fields(5, True, -1)
    )
    for version in (1, 2):
        both(value, version, "01000000 01 00 0100 0108 7d")
    assert x.Middle.M1.to_xcdr2(False) == b"\0\1"
    assert x.Bits.from_xcdr2(b"\x00\x08") is x.Bits.HIGH
    with pytest.raises(CdrError, match=r"Numbers\.twelve: 7 is not one of its values"):
        x.Numbers.from_xcdr2(bytes.fromhex("010000000100070000007d"))


def test_text(x: Any) -> None:
    value = x.Texts("ab", "\u00e9", "\u3042", 1.0)
    quad = "00" * 14 + "ff3f"
    both(value, 2, f"03000000 616200 00 02000000 e900 4230 {quad}")
    octets = value.to_xcdr2(False)
    assert octets[8:16].hex() == "0000000200e93042"


def test_collections_of_what_is_not_primitive_have_a_dheader(x: Any) -> None:
    value = x.Lists(
        [1, 2],
        ["a"],
        [x.RED, x.GREEN],
        {1: 2},
        {3: "b"},
        b"\7",
        [b"\1\2", b"\3\4"],
        [x.Point(1.0, 5)],
    )
    both(
        value,
        2,
        "02000000 01000000 02000000"
        "0a000000 01000000 02000000 6100 0000"
        "08000000 00000000 01000000"
        "01000000 01 000000 02000000"
        "0e000000 01000000 03000000 02000000 6200 0000"
        "01000000 07 01020304 000000"
        f"10000000 01000000 {ONE} 05000000",
    )
    both(
        value,
        1,
        "02000000 01000000 02000000"
        "01000000 02000000 6100 0000"
        "00000000 01000000"
        "01000000 01 000000 02000000"
        "01000000 03000000 02000000 6200 0000"
        "01000000 07 01020304 000000"
        f"01000000 00000000 {ONE} 05000000",
    )


def test_appendable_types_have_a_dheader(x: Any) -> None:
    both(
        x.New(1, 2, "c", x.GREEN),
        2,
        "14000000 01000000 02000000 02000000 6300 0000 01000000",
    )
    both(x.New(1, 2, "c", x.GREEN), 1, "01000000 02000000 02000000 6300 0000 01000000")


def test_an_appendable_type_reads_older_and_newer_ones(x: Any) -> None:
    new, old = x.New(1, 2, "c", x.GREEN), x.Old(1)
    for version in (1, 2):
        assert decode(x.Old, encode(x.New, new, version, True), version, True) == old
        assert decode(x.New, encode(x.Old, old, version, True), version, True) == x.New(
            1
        )
    # Truncated between a and b, and between c and d, which are not in one run.
    assert x.New.from_xcdr2(bytes.fromhex("0e000000010000000200000002000000 6300")) == (
        x.New(1, 2, "c")
    )


def test_headers_of_mutable_members(x: Any) -> None:
    value = x.Headers(1, 2, 3, 1.0, "a", b"\1\2", [7], [1.0], [8], x.Point(1.0, 4))
    both(
        value,
        2,
        "7c000000"
        "00000000 01 000000"  # LC 0: one octet
        "01000010 0200 0000"  # LC 1: two
        "02000020 03000000"  # LC 2: four
        f"03000030 {ONE}"  # LC 3: eight
        "04000050 02000000 6100 0000"  # LC 5: the length is that of the string
        "05000050 02000000 0102 0000"
        "06000060 01000000 07000000"  # LC 6: the length times 4
        f"07000070 01000000 {ONE}"  # LC 7: the length times 8
        "08000040 06000000 01000000 0800 0000"  # LC 4: a length of its own
        f"09000040 0c000000 {ONE} 04000000",
    )


@pytest.mark.parametrize(
    "octets",
    [
        "08000000 05000020 2a000000",
        "0c000000 05000040 04000000 2a000000",
        "14000000 01000000 07 000000 05000040 04000000 2a000000",
    ],
    ids=["LC 2", "LC 4", "behind an unknown member"],
)
def test_any_length_code_is_read(x: Any, octets: str) -> None:
    assert x.Few.from_xcdr2(bytes.fromhex(octets)) == x.Few(42)


@pytest.mark.parametrize(
    ("code", "rest"),
    [(5, "02000000 0102"), (6, "01000000 01020304"), (7, "01000000 0102030405060708")],
)
def test_unknown_members_are_skipped_by_their_length(
    x: Any, code: int, rest: str
) -> None:
    unknown = struct.pack("<I", code << 28 | 99) + bytes.fromhex(rest)
    unknown += bytes(-len(unknown) % 4)
    body = unknown + bytes.fromhex("050000202a000000")
    assert x.Few.from_xcdr2(struct.pack("<I", len(body)) + body) == x.Few(42)


@pytest.mark.parametrize(
    ("version", "optional", "required"),
    [
        (1, "07000400 05000000 023f0000", "07400400 05000000 023f0000"),
        (2, "08000000 07000020 05000000", "08000000 070000a0 05000000"),
    ],
)
def test_a_list_of_unknown_members_alone(
    tmp_path: Path, version: int, optional: str, required: str
) -> None:
    type_ = emitted.emit_text(tmp_path, "@mutable struct Unfilled {};").Unfilled
    assert decode(type_, bytes.fromhex(optional), version, True) == type_()
    with pytest.raises(CdrError, match="unknown member 7 has to be understood"):
        decode(type_, bytes.fromhex(required), version, True)


def test_members_that_are_seldom_in_types(tmp_path: Path) -> None:
    """Structs with lists of members within others, arrays of conversions in a record, bounds."""
    package = emitted.emit_text(
        tmp_path,
        """
        @mutable struct Listed { @id(3) long a; };
        @final struct Nothing {};
        @final struct Record { boolean flags[2][2]; octet last; };
        @final struct Outer {
            Listed one; sequence<Listed> more; sequence<Record> records;
            sequence<string, 2> names; Nothing none[2]; octet last;
        };
        """,
    )
    listed, record = package.Listed, package.Record
    value = package.Outer(listed(1), [listed(2)], [record([[True, False]] * 2, 3)])
    value.names, value.last = ["a", "b"], 4
    for version in (1, 2):
        for little_endian in (True, False):
            octets = encode(package.Outer, value, version, little_endian)
            again = decode(package.Outer, octets, version, little_endian)
            assert again == value
            assert (type(again.one), type(again.more[0])) == (listed, listed)
            assert again.records[0].flags[0][0] is True
        for wrong, message in (
            ({"names": ["a", "b", "c"]}, r"Outer\.names: 3 items, and 2 are the most"),
            ({"none": [package.Nothing()]}, r"Outer\.none: 1 items instead of 2"),
        ):
            with pytest.raises(CdrError, match=message):
                encode(package.Outer, package.Outer(**wrong), version, True)


def test_items_without_octets_are_limited() -> None:
    for count in (3, 65536):
        items = Items([Empty()] * count, 7)
        octets = encode(Items, items, 1, True)
        assert octets == struct.pack("<IB", count, 7)
        assert decode(Items, octets, 1, True) == items
    with pytest.raises(CdrError, match="a length of 65537, and 1 octets are left"):
        decode(Items, struct.pack("<IB", 65537, 7), 1, True)


def test_unknown_members_that_must_be_understood_are_refused(x: Any) -> None:
    for version in (1, 2):
        octets = encode(x.Many, x.Many(1, 2, 3), version, True)
        with pytest.raises(CdrError, match="Few: the unknown member 7 has to be"):
            decode(x.Few, octets, version, True)
        other = encode(x.Other, x.Other(1, "t", 2), version, True)
        assert decode(x.Few, other, version, True) == x.Few(1)
        assert decode(x.Many, other, version, True) == x.Many(1)
        with pytest.raises(CdrError, match=r"Other\.k: a key is missing"):
            decode(x.Other, encode(x.Few, x.Few(1), version, True), version, True)


def test_the_header_of_a_member_that_has_a_dheader(tmp_path: Path) -> None:
    package = emitted.emit_text(
        tmp_path, "@mutable struct Listed { map<string, long> named; octet last; };"
    )
    both(
        package.Listed({"a": 1}, 2),
        2,
        "21000000"
        "00000040 14000000"
        "10000000 01000000 02000000 6100 0000 01000000"
        "01000000 02",
    )


def test_mutable_members_stand_once(x: Any) -> None:
    with pytest.raises(CdrError, match=r"Few\.a: the member stands twice"):
        x.Few.from_xcdr2(bytes.fromhex("10000000 05000020 01000000 05000020 01000000"))


def test_parameters_of_version_1(x: Any) -> None:
    both(
        x.Many(1, 2, None),
        1,
        "017f0800 05000000 04000000 01000000"
        "017f0800 07000040 04000000 02000000"
        "027f0000",
    )
    # A short header, one to be ignored, and the end without its flag.
    octets = "05000400 2a000000 033f0400 ffffffff 023f0000"
    assert decode(x.Few, bytes.fromhex(octets), 1, True) == x.Few(42)


def test_optional_members_of_final_structs(x: Any) -> None:
    both(x.Maybe(1, None, None), 2, "01 00 00")
    both(x.Maybe(1, 1.0, 2), 2, f"01 01 0000 {ONE} 01 00 0200")
    both(
        x.Maybe(1, None, 2),
        1,
        "01000000 017f0800 01000000 00000000 017f0800 02000040 02000000 0200",
    )
    # The origin of alignment is the value: 8 octets begin at 16, not at 24.
    both(
        x.Maybe(1, 1.0, None),
        1,
        f"01000000 017f0800 01000000 08000000 {ONE} 017f0800 02000040 00000000",
    )
    assert x.Maybe(1, 1.0).to_cdr() == encode(x.Maybe, x.Maybe(1, 1.0), 1, True)
    assert x.Maybe(1, 1.0)._snapshot_() == x.Maybe(1, 1.0)


def test_unions(x: Any) -> None:
    both(x.Choice.of_s("a", 3), 2, "0300 0000 02000000 6100")
    both(x.Choice(9, None), 2, "0900")
    both(x.Growing.of_l(5), 2, "08000000 00000000 05000000")
    both(x.Growing.of_s("a"), 2, "0a000000 01000000 02000000 6100")
    both(x.Loose.of_d(1.0), 2, f"14000000 00000000 01 000000 01000030 {ONE}")
    both(
        x.Loose.of_o(7),
        1,
        "017f0800 00000000 04000000 00 000000 017f0800 09000000 04000000 07 000000 027f0000",
    )
    # A union without its value has the initial one of its known discriminator.
    assert x.Growing.from_xcdr2(bytes.fromhex("04000000 00000000")) == x.Growing.of_l(0)
    assert x.Loose.from_xcdr2(bytes.fromhex("05000000 00000000 01")) == x.Loose.of_d(
        0.0
    )
    with pytest.raises(CdrError, match="discriminator is missing"):
        x.Loose.from_xcdr2(bytes(4))
    with pytest.raises(CdrError, match="no branch"):
        x.Choice(9, "s").to_xcdr2()


def test_key_hashes(x: Any) -> None:
    # By member id, most significant octet first, aligned to 4.
    place = x.Place(0x01020304, 5, 9.0)
    assert place.key_hash() == bytes.fromhex("05000000 01020304") + bytes(8)
    # A nested struct by its own key, or all of it.
    keyed = x.Keyed("not part of it", place, x.Anonymous(6, 7))
    assert keyed.key_hash() == bytes.fromhex("05000000 01020304 0607") + bytes(6)
    # Keys that may exceed 16 octets are hashed, however short they are; without member headers.
    octets = bytes.fromhex("00000002 6100")
    assert x.Named("a", 3).key_hash() == hashlib.md5(octets).digest()
    assert x.Holder([x.GREEN]).key_hash() == bytes.fromhex(
        "00000008 00000001 00000001"
    ) + bytes(4)
    with pytest.raises(CdrError, match="Plain: the type has no key"):
        x.Plain().key_hash()


def test_payloads(x: Any) -> None:
    value = x.Old(7)
    payload = serialize(value, Representation.D_CDR2_LE)
    assert payload.hex() == "00090003 01000000 07000000".replace(" ", "")
    assert deserialize(x.Old, payload) == value
    assert serialize(value, Representation.CDR_BE).hex() == "0000000307000000"
    assert serialize(x.Few(1), Representation.PL_CDR2_BE)[:2] == b"\0\x0a"
    assert serialize(x.Plain(), Representation.CDR2_BE)[:2] == b"\0\x06"
    with pytest.raises(CdrError, match="its representation is D_CDR2_LE, not CDR2_LE"):
        serialize(value, Representation.CDR2_LE)
    with pytest.raises(CdrError, match="its representation is CDR2_LE, not D_CDR2_LE"):
        deserialize(x.Plain, payload)
    for wrong in (b"", b"\0\x09\0", b"\0\x63\0\0"):
        with pytest.raises(CdrError, match="encapsulation"):
            deserialize(x.Old, wrong)


def samples(x: Any) -> list[Any]:
    tree = x.Tree(1, [x.Tree(2, []), x.Tree(3, [x.Tree(4, [])])])
    return [
        x.Plain(1, 1.0, 2, 3),
        x.Numbers(x.GREEN, x.T1, x.M1, x.Bits.LOW, x.Fields(1, False, -4)),
        x.Texts("ab", "cd", "e", 2.0),
        x.Lists(
            [1], ["a", ""], [x.RED, x.RED], {1: 1}, {1: "1"}, b"a", [b"ab", b"cd"], []
        ),
        x.New(1, 2, "c", x.GREEN),
        x.Headers(1, 2, 3, 1.0, "a", b"\1\2", [7], [1.0], [8], x.Point(1.0, 4)),
        x.Many(1, 2, 3),
        x.Maybe(1, 1.0, 2),
        x.Choice.of_s("abc"),
        x.Growing.of_s("a"),
        x.Loose.of_d(1.0),
        x.Loose.of_o(1),
        tree,
        x.Keyed("a", x.Place(1, 2, 3.0), x.Anonymous(6, 7)),
    ]


@pytest.mark.parametrize("version", [1, 2])
def test_nothing_shorter_or_longer_is_read(x: Any, version: int) -> None:
    for value in samples(x):
        type_ = type(value)
        octets = encode(type_, value, version, True)
        assert decode(type_, bytearray(octets), version, True) == value
        if version == 1 and type_._descriptor_.extensibility == "appendable":
            continue  # It ends only with the octets.
        for length in range(len(octets)):
            with pytest.raises(CdrError):
                decode(type_, octets[:length], version, True)
        with pytest.raises(CdrError, match="octets too many"):
            decode(type_, octets + b"\0", version, True)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("version", [1, 2])
def test_damaged_octets_give_a_value_or_an_error(x: Any, version: int) -> None:
    rand = random.Random(version)
    for value in samples(x):
        type_ = type(value)
        octets = encode(type_, value, version, True)
        for _ in range(300):
            damaged = bytearray(octets)
            for _ in range(rand.randint(1, 3)):
                damaged[rand.randrange(len(damaged))] = rand.choice((0, 1, 255, 127))
            try:
                read = decode(type_, damaged, version, True)
            except CdrError:
                continue
            encode(type_, read, version, True)


def test_faults_have_their_place(x: Any) -> None:
    with pytest.raises(CdrError, match=r"^Lists\.longs: a length of 99, and 0 octets"):
        x.Lists.from_xcdr2(struct.pack("<I", 99))
    with pytest.raises(CdrError, match=r"^Plain\.b: truncated: 8 octets are needed"):
        x.Plain.from_xcdr2(bytes(6))
    octets = x.Lists(points=[x.Point(1.0, 2)]).to_xcdr2()
    with pytest.raises(CdrError, match=r"^Lists\.points"):
        x.Lists.from_xcdr2(octets[:-1])
    with pytest.raises(CdrError, match=r"^Lists\.points\[1\]\.y: "):
        x.Lists(points=[x.Point(), x.Point(1.0, 1 << 31)]).to_xcdr2()
    octets = bytes.fromhex("017f0800 05000000 03000000 010000 00 027f0000")
    with pytest.raises(CdrError, match=r"^Few\.a: truncated: 4 octets are needed, 3 "):
        decode(x.Few, octets, 1, True)
    with pytest.raises(CdrError, match="octets are needed, not str"):
        x.Plain.from_xcdr2("text")


def test_depth_is_bounded(x: Any) -> None:
    deep = x.Tree(0, [])
    for _ in range(2000):
        deep = x.Tree(0, [deep])
    with pytest.raises(CdrError, match="nested too deeply"):
        deep.to_xcdr2()
    octets = b""
    for _ in range(2000):
        octets = struct.pack("<IIII", len(octets) + 12, 0, len(octets) + 4, 1) + octets
    with pytest.raises(CdrError):
        x.Tree.from_xcdr2(octets)


def test_typedefs_have_codecs(x: Any) -> None:
    points = [x.Point(1.0, 2), x.Point(3.0, 4)]
    for little in (True, False):
        octets = x.PointsCodec.to_xcdr2(points, little)
        assert x.PointsCodec.from_xcdr2(octets, little) == points


def test_an_annotation_makes_it_the_cdr_of_a_type(x: Any) -> None:
    for value in (x.Second(1, 2.0), x.Chain(1, [x.Chain(2, [])])):
        for little in (True, False):
            octets = value.to_cdr(little)
            assert octets == value.to_xcdr2(little)
            assert type(value).from_cdr(octets, little) == value
        assert value._snapshot_() == value


def test_the_defaults_of_options(tmp_path: Path) -> None:
    file = tmp_path / "case.idl"
    file.write_text(
        "struct A { octet x; }; @final struct B { octet x; }; struct D : B { octet y; };"
        "@data_representation(XCDR) struct C { fixed<3,1> x; };"
        "union U switch (long) { case 1: A m_a; }; typedef sequence<A> As;"
        "interface I { void work(in long x); };"
    )
    result = load([file], root=tmp_path)
    assert not result.diagnostics
    model = result.model
    options = Options("p", "s", "0", representation="xcdr2", extensibility="appendable")
    made = {a.path: a.text for a in BACKEND.emit(model, options).artifacts}
    text = made["p/_idl/case.py"]
    assert text.count('extensibility="appendable"') == 3
    # A, B, D, U, As; not C, which says otherwise.
    assert text.count("representation=2") == 5
    assert "representation=" not in made["p/_idl/case_calls.py"]


@pytest.mark.parametrize(
    "text",
    [
        "@data_representation(XCDR2) struct S { any a; };",
        "struct A { fixed<3,1> f; }; @mutable struct S { A inner; };",
        "interface I {}; @data_representation(XCDR2) union S switch (long) { case 1: I i1; };",
    ],
)
def test_what_dds_has_not_is_a_finding(tmp_path: Path, text: str) -> None:
    file = tmp_path / "case.idl"
    file.write_text(text)
    emission = BACKEND.emit(load([file], root=tmp_path).model, Options("p", "s", "0"))
    assert "PY0003" in [d.code for d in emission.diagnostics]
    assert not emission.artifacts


def test_what_dds_has_not_is_an_error_of_the_codec(tmp_path: Path) -> None:
    package = emitted.emit_text(
        tmp_path, "struct A { fixed<3,1> f; }; struct S { sequence<A> list; };"
    )
    with pytest.raises(
        CdrError, match=r"^S\.list\.f: XCDR has no representation of fixed"
    ):
        package.S().to_xcdr2()


def test_the_command_line_and_the_project_file_choose(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    Path("case.idl").write_text("struct A { octet x; };")
    made = Path("generated/robots/_idl/case.py")
    for arguments, found in (([], 0), (["--representation", "xcdr2"], 1), ([], 0)):
        assert run(["generate", "case.idl", *arguments]) == 0
        assert made.read_text().count("representation=2") == found
    assert run(["generate", "case.idl", "--representation", "xcdr"]) == 2
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["case.idl"]\n'
        '[output]\nrepresentation = "xcdr2"\nextensibility = "mutable"\n'
    )
    assert run(["generate"]) == 0
    assert "representation=2" in made.read_text()
    assert 'extensibility="mutable"' in made.read_text()
    assert run(["check"]) == 0


def test_external_members_may_be_recursive(tmp_path: Path) -> None:
    package = emitted.emit_text(
        tmp_path,
        """
        struct Node;
        union Tree;
        @appendable struct Mark;
        struct Chain { long first; @external Node rest; };
        struct Node { @external Tree branches; @external Mark its; string text; };
        union Tree switch (long) {
            case 0: @external Node inner;
            case 1: long leaf;
        };
        @appendable struct Mark { double x; };
        @mutable struct Ring { long a; @external Ring next; };
        """,
    )
    chain, node, tree = package.Chain, package.Node, package.Tree
    leaf = node(tree(1, 5), package.Mark(2.0), "leaf")
    whole = chain(3, node(tree(0, leaf), package.Mark(1.0), "root"))
    for method in ("cdr", "xcdr1", "xcdr2"):
        octets = getattr(whole, f"to_{method}")()
        assert getattr(chain, f"from_{method}")(octets) == whole
        for unset in (chain(), node(), tree(), package.Ring()):
            assert unset._snapshot_() == unset
            with pytest.raises(CdrError, match="NoneType"):
                getattr(unset, f"to_{method}")()
    ring = package.Ring()
    ring.next = ring
    with pytest.raises(CdrError, match="contains itself"):
        ring.to_xcdr2()


@pytest.mark.parametrize("version", [1, 2])
def test_all_readers_of_a_type_agree(x: Any, version: int) -> None:
    """The codec, the reader of other versions, and the search for faults, which finds none."""
    for value in samples(x):
        type_ = type(value)
        descriptor = type_._descriptor_
        for little in (True, False):
            octets = encode(type_, value, version, little)
            assert decode(type_, octets, version, little) == value
            evolved = compiled("from_evolved", descriptor, Format(version))
            assert evolved(type_, octets, little) == value
            assert fault_in_body(descriptor, octets, Format(version), little) is None
        function = unwrap(getattr(type_, f"from_xcdr{version}").__func__)
        assert function.__code__.co_filename.startswith(f"<XCDR{version} from_cdr")
