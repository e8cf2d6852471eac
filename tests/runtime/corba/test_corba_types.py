"""Types whose form differs in omniORB, and those that cannot be transferred."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from decimal import Decimal
from pathlib import Path
from typing import Any

import forwarder
import numpy
import pytest
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")
sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "types"))

import emitted

from rtgen.facts.numeric import Numeric
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.marshalling.descriptors import PrimitiveDescriptor, StringDescriptor
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.servants import MarshalError
from rtgen.runtime.values import AnyValue

IDL = """
module M {
  typedef sequence<any> ListOfAny;
  typedef sequence<wchar> WideLetters;
  typedef wchar WideKey[2];
  typedef char Letters[2][3];
  typedef sequence<char, 4> Word;
  typedef fixed<31,4> Large;
  typedef sequence<fixed<3,1> > Smalls;
  struct Node;
  typedef sequence<Node> Nodes;
  struct Node { any load; Nodes below; string class; };
  struct Plain;
  typedef sequence<Plain> Plains;
  struct Plain { long load; Plains below; };
  union Tree switch (char) {
    case 'n': Node deep; case 'a': case 'b': any load; default: fixed<3,1> small;
  };
  union Quiet switch (short) { case 1: long number; case -2: string text; };
  enum Numbered { @value(3) THREE, @value(7) SEVEN };
  struct Held { Numbered which; Word few; int8 small; uint8 octet_; };
  exception Odd { any what; Large much; string from; Held rest; };
  interface Echo {
    WideLetters echo_wide_letters(in WideLetters a);
    WideKey echo_wide_keys(in WideKey a);
    Letters echo_letters(in Letters a);
    Word echo_words(in Word a);
    Large echo_large(in Large a);
    Smalls echo_smalls(in Smalls a);
    Node echo_nodes(in Node a);
    Plain echo_plains(in Plain a);
    Tree echo_trees(in Tree a);
    Quiet echo_quiet(in Quiet a);
    Numbered echo_numbered(in Numbered a);
    Held echo_held(in Held a);
    CORBA::TypeCode echo_codes(in CORBA::TypeCode a);
    any echo_anys(in any a);
    ListOfAny echo_lists(in ListOfAny a);
    void fail(in long a) raises (Odd);
  };

  valuetype V { public long x; };
  struct Loose { @optional long x; };
  bitmask Flags { F0, F1 };
  typedef map<string, long> Table;
  interface Refused {
    V echo_values(in V a);
    long double echo_quads(in long double a);
    Loose echo_loose(in Loose a);
    Flags echo_flags(in Flags a);
    Table echo_tables(in Table a);
    long works(in long a);
  };
};
"""

Connect = Callable[[Any], Any]


@pytest.fixture(scope="module")
def m(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("corba_types"), IDL).m


@pytest.fixture(params=["in the process", "by a socket"])
def connect(m: Any, request: pytest.FixtureRequest) -> Iterator[Connect]:
    """Yield the stub of a servant that returns its arguments."""
    orb = Orb(timeout=PATIENCE)
    objects = Objects(orb)
    with ExitStack() as stack:

        def connected(interface: Any) -> Any:
            methods = {name: lambda self, a: a for name in calls_of(interface)}

            def fail(self: Any, a: int) -> None:
                raise odd(m, a)

            methods["fail"] = fail
            servant = type("Servant", (interface,), methods)()
            reference = objects.exported(servant, None)
            if request.param == "by a socket":
                imported = objects.imported(reference, None)
                imported = stack.enter_context(forwarder.forwarded(imported))
                reference = objects.exported(imported, None)
            return objects.stub(interface, reference)

        yield connected
    orb.close()


def odd(m: Any, number: int) -> Any:
    held = m.Held(m.SEVEN, "ab", -1, 2)
    what = AnyValue(m.Plain, m.Plain(number))
    return m.Odd(what, Decimal("-1.2500"), "here", held)


@pytest.mark.parametrize("numeric", ["array", "numpy"])
def test_numbers_in_each_form(
    tmp_path: Path, connect: Connect, numeric: Numeric
) -> None:
    text = """module m {
        struct Point { double x; octet rgb[8]; };
        typedef sequence<double> Doubles;
        typedef sequence<Point> Points;
        struct Scan { Doubles ranges; Points cloud; long table[2][2]; };
        typedef sequence<Scan> Scans;
        interface Echo { Scans of_scans(in Scans a); Doubles of_doubles(in Doubles a); };
    };"""
    n = emitted.emit_text(tmp_path, text, numeric).m
    stub = connect(n.Echo)
    for count in (0, 3, 100):
        numbers = [i / 3 for i in range(count)]
        points = [n.Point(i, b"octets..") for i in numbers]
        scan = n.Scan(numbers, points, [[1, 2], [3, 4]])
        decoded = n.Scan.from_cdr(scan.to_cdr())
        for given in (scan, decoded):
            assert stub.of_scans([given, given]) == [decoded, decoded]
            made = stub.of_doubles(given.ranges)
            assert type(made) is type(decoded.ranges)
            assert list(made) == numbers


@pytest.mark.parametrize("numeric", ["list", "array", "numpy"])
def test_buffers_travel(tmp_path: Path, connect: Connect, numeric: Numeric) -> None:
    text = """module m {
        typedef sequence<octet> Octets; typedef sequence<double> Doubles;
        typedef long Table[2][2]; typedef sequence<boolean, 9> Truths; typedef int8 Small[2];
        struct Image {
            Octets pixels; octet mac[4]; Doubles numbers; Table cells; Truths flags; Small few;
        };
        struct Raw { octet mac[4]; sequence<double, 3> few; };
        union Choice switch (long) { case 1: Octets content; case 2: Raw inner; };
        interface Echo {
            Octets of_octets(in Octets a); Doubles of_doubles(in Doubles a);
            Table of_table(in Table a); Truths of_truths(in Truths a); Small of_small(in Small a);
            Image of_image(in Image a); Raw of_raw(in Raw a); Choice of_choice(in Choice a);
            any of_any(in any a);
        };
    };"""
    n = emitted.emit_text(tmp_path, text, numeric).m
    stub = connect(n.Echo)
    octets = numpy.frombuffer(b"abcd", "u1")
    table = numpy.array([[1, 2], [3, 4]], "i4")
    flags, small = numpy.array([True, False]), array("b", [-1, 1])
    raw = n.Raw(bytearray(b"abcd"), numpy.arange(2.0))
    image = n.Image(octets, octets, array("d", [0.5]), table, flags, small)
    assert stub.of_octets(octets) == stub.of_octets(memoryview(octets)) == b"abcd"
    assert [*stub.of_doubles(memoryview(array("d", [0.5])))] == [0.5]
    for cells in (table, memoryview(table), [*table]):
        assert numpy.array_equal(stub.of_table(cells), table)
    assert stub.of_truths(flags) == [True, False]
    assert [*stub.of_small(small)] == [-1, 1]
    for name, value in (
        ("image", image),
        ("raw", raw),
        ("choice", n.Choice.of_content(octets)),
        ("choice", n.Choice.of_inner(raw)),
    ):
        answer = getattr(stub, f"of_{name}")(value)
        assert answer.to_cdr() == value.to_cdr()
    for value in (AnyValue(n.Raw, raw), AnyValue(n.OctetsCodec, octets)):
        assert stub.of_any(value).to_cdr() == value.to_cdr()
    for name, wrong in (
        ("octets", [1, 2]),
        ("doubles", numpy.zeros(2, "f4")),
        ("table", numpy.zeros((2, 2))),
        ("image", n.Image(numpy.zeros(2))),
    ):
        with pytest.raises(CdrError, match=rf"^Echo\.of_{name} request\.a"):
            getattr(stub, f"of_{name}")(wrong)


def test_what_is_converted(m: Any, connect: Connect) -> None:
    stub = connect(m.Echo)
    leaf = m.Node(AnyValue(StringDescriptor(), "leaf"), [], "é")
    node = m.Node(AnyValue(m.Plain, m.Plain(1, [m.Plain(2)])), [leaf, leaf], "root")
    plain = m.Plain(1, [m.Plain(2, [m.Plain(3)]), m.Plain(4)])
    largest = Decimal("123456789012345678901234567.8901")
    cases: list[tuple[str, Any]] = [
        ("wide_letters", ["あ", "é", "\ud7ff"]),
        ("wide_keys", ["あ", "\0"]),
        ("letters", ["abc", "\xe9\0z"]),
        ("words", "\xe9\xffa"),
        ("words", ""),
        ("large", largest),
        ("large", -largest),
        ("large", Decimal("0.0000")),
        ("smalls", [Decimal("-99.9"), Decimal("0.1")]),
        ("nodes", node),
        ("plains", plain),
        ("trees", m.Tree("n", node)),
        ("trees", m.Tree("b", AnyValue(PrimitiveDescriptor("double"), 0.5))),
        ("trees", m.Tree("z", Decimal("1.5"))),
        ("quiet", m.Quiet(1, 7)),
        ("quiet", m.Quiet(-2, "text")),
        ("quiet", m.Quiet(5, None)),
        ("numbered", m.SEVEN),
        ("held", m.Held(m.THREE, "ab", -128, 255)),
        ("anys", AnyValue(m.Node, node)),
        ("anys", AnyValue()),
    ]
    for name, value in cases:
        answer = getattr(stub, f"echo_{name}")(value)
        assert answer == value, name
        assert type(answer) is type(value)
    assert stub.echo_large(Decimal("1.5")).as_tuple().exponent == -4
    for code in (m.Plain, m.Node, m.Quiet):
        assert stub.echo_codes(code._descriptor_) is code._descriptor_
    assert stub.echo_codes(PrimitiveDescriptor("double")) == PrimitiveDescriptor(
        "double"
    )
    with pytest.raises(m.Odd) as caught:
        stub.fail(3)
    assert caught.value == odd(m, 3)


def test_what_does_not_fit_is_reported_with_its_place(m: Any, connect: Connect) -> None:
    stub = connect(m.Echo)
    for name, value in (
        ("wide_keys", ["あ"]),
        ("wide_letters", ["\U0001f600"]),
        ("letters", ["abc", "ab"]),
        ("words", "abcde"),
        ("words", "あ"),
        ("large", Decimal("0.00001")),
        ("nodes", m.Node(3, [], "")),
        ("plains", m.Plain(2**31)),
        ("trees", m.Tree("z", Decimal("100.5"))),
        ("held", m.Held(m.THREE, "ab", 128, 0)),
        ("anys", AnyValue(m.Plain, m.Plain(2**31))),
        ("anys", AnyValue(m.Held, m.Held(m.THREE, "ab", 128, 0))),
        ("anys", AnyValue(StringDescriptor(bound=3), "abcd")),
        ("anys", 3),
    ):
        with pytest.raises(CdrError, match=rf"^Echo\.echo_{name} request\.a"):
            getattr(stub, f"echo_{name}")(value)
    with pytest.raises(CdrError, match=r"request\.a\[1\]\.value\.below\[0\]\.load: "):
        stub.echo_lists([AnyValue(), AnyValue(m.Plain, m.Plain(1, [m.Plain(2**31)]))])


def test_what_cannot_travel_is_refused_when_it_is_called(
    m: Any, connect: Connect
) -> None:
    stub = connect(m.Refused)
    for name, value in (
        ("values", None),
        ("quads", 0.5),
        ("loose", m.Loose()),
        ("flags", m.Flags(1)),
        ("tables", {}),
    ):
        with pytest.raises(MarshalError, match=f"echo_{name} is not marshalled: "):
            getattr(stub, f"echo_{name}")(value)
    assert stub.works(3) == 3
