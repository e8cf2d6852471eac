"""Large arrays and octets are joined to the rest of a message: the same octets and faults."""

from __future__ import annotations

import struct
import sys
from array import array
from typing import Any

import emitted
import numpy
import pytest

from rtgen.facts.numeric import FORMS, Numeric
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.dynamic.values import encoded
from rtgen.runtime.xcdr import deserialize, representation_of, serialize

IDL = """
module n {
    struct Gap { double x; octet state; };
    struct Point { double x; double y; };
    struct Titled { sequence<double> scan; string text; };
    struct Row { octet number; double values[1500]; };
    @final struct Large {
        octet first;
        sequence<double> scan;
        octet mark;
        sequence<short> image;
        float grid[50][400];
        octet block[120000];
        sequence<octet> pixels;
        sequence<Gap> gaps;
        sequence<Point> points;
        sequence<Row> rows;
        string text;
        char letters[100001];
        short last;
    };
    @appendable struct Named { sequence<string> names; Large inner; string end; };
    @mutable struct Listed { @id(1) Large inner; @id(2) @optional sequence<double> scan; };
};
"""
WAYS = ("cdr", "xcdr1", "xcdr2")
MEMBERS = """
    octet first; sequence<double> scan; octet mark; float grid[50][400]; sequence<octet> pixels;
    string text;
"""
APPENDABLE = f"""
module n {{
    struct Point {{ double x; double y; }};
    struct Plain {{ {MEMBERS} short last; }};
    @appendable struct Grown {{ {MEMBERS} short last; }};
    @appendable struct Base {{ {MEMBERS} }};
    @appendable struct Derived : Base {{ short last; }};
    struct Only {{ Derived inner; }};
    @appendable struct Outer {{ octet first; Grown one; Only other; octet last; }};
    struct PlainBlock {{ octet first; double values[1500]; short last; }};
    @appendable struct Block {{ octet first; double values[1500]; short last; }};
    struct Track {{ sequence<Point> points; }};
    @appendable struct Titled {{ sequence<double> scan; string text; }};
}};
"""


@pytest.fixture(scope="module")
def appendable(tmp_path_factory: pytest.TempPathFactory) -> dict[Numeric, Any]:
    return emitted.in_each_form(tmp_path_factory, APPENDABLE)


def filled(n: Any, count: int) -> Any:
    """Return a value with that many items in each sequence, all of them in lists."""
    return n.Large(
        first=1,
        scan=[i / 3 for i in range(count)],
        mark=2,
        image=[i - 500 for i in range(count)],
        grid=[[i + 0.5] * 400 for i in range(50)],
        block=bytes(range(240)) * 500,
        pixels=bytes(i % 251 for i in range(8 * count + 1)),
        gaps=[n.Gap(i / 7, i % 200) for i in range(count)],
        points=[n.Point(i / 7, -i) for i in range(count)],
        rows=[n.Row(i, [i / 9] * 1500) for i in range(2)],
        text="é" * (4 * count),
        letters="ab" * 50000 + "c",
        last=-3,
    )


@pytest.mark.sampled(4)
@pytest.mark.parametrize("count", [1000, 1250, 13000])
@pytest.mark.parametrize("little", [True, False])
@pytest.mark.parametrize("loads_numpy", [True, False])
def test_octets_are_those_of_small_members(
    packages: dict[Numeric, Any],
    count: int,
    little: bool,
    loads_numpy: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lists = packages["list"]
    wanted = filled(lists, count)
    for form in FORMS if loads_numpy else ("array",):
        n = packages[form]
        for way in WAYS:
            octets = getattr(wanted, f"to_{way}")(little)
            if way == "cdr":
                assert octets == encoded(lists.Large._descriptor_, wanted, little)
            value = getattr(n.Large, f"from_{way}")(octets, little)
            with monkeypatch.context() as without:
                if not loads_numpy:
                    without.delitem(sys.modules, "numpy")
                for _ in range(6):  # memory of the swapped numbers is used again
                    again = getattr(value, f"to_{way}")(little)
                    assert type(again) is bytes
                    assert again == octets


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("version", [1, 2])
def test_members_of_other_types(
    packages: dict[Numeric, Any], form: Numeric, version: int
) -> None:
    lists, n = packages["list"], packages[form]
    large = filled(lists, 1300)
    values = [large, lists.Named(["a", "bcd"], large, "e"), lists.Listed(large)]
    values.append(lists.Listed(large, [0.5] * 1300))
    for wanted in values:
        type_ = getattr(n, type(wanted).__name__)
        for little in (True, False):
            octets = getattr(wanted, f"to_xcdr{version}")(little)
            value = getattr(type_, f"from_xcdr{version}")(octets, little)
            assert getattr(value, f"to_xcdr{version}")(little) == octets
            payload = serialize(value, representation_of(type_, version, little))
            assert payload[4 : 4 + len(octets)] == octets
            assert payload[4 + len(octets) :] == bytes(-len(octets) % 4)
            again = deserialize(type_, payload)
            assert getattr(again, f"to_xcdr{version}")(little) == octets


VIEWS = [
    array("d", range(20000)),
    numpy.arange(20000.0),
    numpy.arange(20000, dtype="<f8"),
    numpy.arange(20000, dtype=">f8"),
    numpy.arange(40000.0)[::2],
    numpy.arange(20000, dtype=">f8")[::-1],
    memoryview(array("d", range(20001)))[1:],
    memoryview(array("d", range(20000)))[::-1],
]


@pytest.mark.parametrize("scan", VIEWS)
@pytest.mark.parametrize("form", ["array", "numpy"])
def test_buffers_in_any_layout(
    packages: dict[Numeric, Any], form: Numeric, scan: Any
) -> None:
    numbers = scan.tolist()
    for little in (True, False):
        octets = packages["list"].Listed(scan=numbers).to_xcdr2(little)
        assert packages[form].Listed(scan=scan).to_xcdr2(little) == octets
        octets = packages["list"].Large(scan=numbers).to_cdr(little)
        assert packages[form].Large(scan=scan).to_cdr(little) == octets


WRONG: list[tuple[str, Any, str]] = [
    ("scan", array("f", bytes(80000)), ".scan: a buffer of float of 64 bits"),
    ("scan", numpy.zeros((2000, 2)), ".scan: a buffer of 1 dimension"),
    ("image", [0] * 20000 + [70000], ".image[20000]: 70000 is out of the range"),
    ("block", bytes(120001), ".block: 120001 items instead of 120000"),
    ("pixels", array("d", [0.0] * 200000), ".pixels"),
    ("pixels", array("b", bytes(200000)), ".pixels"),
    ("pixels", "a" * 200000, ".pixels"),
    ("pixels", [0] * 200000, ".pixels"),
    ("text", "a" * 200000 + "\0", ".text"),
    ("letters", "a" * 100000 + "\u0100", ".letters"),
    ("last", 70000, ".last: 70000 is out of the range of short"),
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("member", "wrong", "message"), WRONG)
@pytest.mark.parametrize("form", ["array", "numpy"])
def test_faults_have_the_path_of_the_member(
    packages: dict[Numeric, Any], form: Numeric, member: str, wrong: Any, message: str
) -> None:
    value = filled(packages[form], 1300)
    value.scan = array("d", value.scan)
    setattr(value, member, wrong)
    for way in WAYS:
        with pytest.raises(CdrError) as caught:
            getattr(value, f"to_{way}")()
        assert str(caught.value).startswith(f"Large{message}")
        if member != "scan":
            value.scan.append(1.5)  # the error keeps no view of the array


def members(count: int, form: Numeric) -> list[Any]:
    """Return the members of `Plain`, with that many items in its sequences."""
    scan: Any = [i / 3 for i in range(count)]
    grid: Any = [[i + 0.5] * 400 for i in range(50)]
    if form == "array":
        scan = array("d", scan)
    if form == "numpy":
        scan, grid = numpy.array(scan), numpy.array(grid, "f")
    return [1, scan, 2, grid, bytes(i % 251 for i in range(9 * count)), "é" * count, -3]


def delimited(octets: bytes, little: bool) -> bytes:
    """Return the octets of a value after its DHEADER."""
    return struct.pack("<I" if little else ">I", len(octets)) + octets


@pytest.mark.sampled(8)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("little", [True, False])
@pytest.mark.parametrize("count", [0, 3, 1250, 13001])
def test_a_dheader_precedes_appendable_types(
    appendable: dict[Numeric, Any], form: Numeric, little: bool, count: int
) -> None:
    n = appendable[form]
    values = members(count, form)
    wanted = delimited(n.Plain(*values).to_xcdr2(little), little)
    grown, derived = n.Grown(*values), n.Derived(*values)
    for value in (grown, derived, n.Only(derived)):
        for _ in range(6):  # memory of the swapped numbers is used again
            octets = value.to_xcdr2(little)
            assert type(octets) is bytes
            assert octets == wanted
        assert type(value).from_xcdr2(octets, little).to_xcdr2(little) == octets
        payload = serialize(value, representation_of(type(value), 2, little))
        padding = -len(octets) % 4
        number = (6 if type(value) is n.Only else 8) | little
        assert payload == bytes((0, number, 0, padding)) + octets + bytes(padding)
    between = bytes(-len(wanted) % 4)
    inner = b"\7\0\0\0" + wanted + between + wanted + b"\t"
    outer = n.Outer(7, grown, n.Only(derived), 9)
    assert outer.to_xcdr2(little) == delimited(inner, little)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("little", [True, False])
def test_a_dheader_precedes_values_of_other_layouts(
    appendable: dict[Numeric, Any], form: Numeric, little: bool
) -> None:
    n = appendable[form]
    numbers: Any = [i / 7 for i in range(1500)]
    if form != "list":
        numbers = array("d", numbers)
    octets = n.PlainBlock(1, numbers, -2).to_xcdr2(little)
    assert n.Block(1, numbers, -2).to_xcdr2(little) == delimited(octets, little)
    for count in (0, 3, 5000):
        points = [n.Point(i / 7, -i) for i in range(count)]
        octets = n.Track(points).to_xcdr2(little)
        pairs = [number for point in points for number in (point.x, point.y)]
        order = "<" if little else ">"
        inner = struct.pack(f"{order}I{len(pairs)}d", count, *pairs)
        assert octets == delimited(inner, little)
        again = n.Track.from_xcdr2(octets, little)  # with a structured array of numpy
        assert again.to_xcdr2(little) == octets


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("member", "wrong", "message"), [row for row in WRONG if f" {row[0]};" in MEMBERS]
)
@pytest.mark.parametrize("form", ["array", "numpy"])
def test_faults_of_appendable_types_have_the_path_of_the_member(
    appendable: dict[Numeric, Any],
    form: Numeric,
    member: str,
    wrong: Any,
    message: str,
) -> None:
    n = appendable[form]
    values = members(1300, form)
    values[["first", "scan", "mark", "grid", "pixels", "text"].index(member)] = wrong
    grown, derived = n.Grown(*values), n.Derived(*values)
    cases = [("Grown", grown), ("Derived", derived), ("Only.inner", n.Only(derived))]
    for path, value in cases:
        representation = representation_of(type(value), 2, True)
        for encode in (
            value.to_xcdr2,
            lambda v=value, r=representation: serialize(v, r),
        ):
            with pytest.raises(CdrError) as caught:
                encode()
            assert str(caught.value).startswith(f"{path}{message}")


@pytest.mark.parametrize("extensibility", ["final", "appendable"])
def test_arrays_that_grow_while_they_are_encoded(
    arrays: Any, appendable: dict[Numeric, Any], extensibility: str
) -> None:
    n = arrays if extensibility == "final" else appendable["array"]

    class Growing(str):
        """A text that appends to the array when it is encoded, as another thread may do."""

        def encode(self, *_: Any) -> bytes:
            value.scan.append(1.0)
            return b""

    value = n.Titled(array("d", range(20000)), Growing())
    for encode in (value.to_cdr, value.to_xcdr2):
        with pytest.raises(
            CdrError, match="Titled: a member changed while it was encoded"
        ):
            encode()
