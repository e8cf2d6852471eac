"""Constructs without a reference type in the conversions: unions, fixed, recursion, values."""

from __future__ import annotations

import copy
import importlib
from array import array
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy
import pytest
from wires import (
    Wires,
    agree,
    marshalled,
    masked,
    padding,
    stub_of,
    values_agree,
    wired,
    wired_text,
)

from rtgen.facts.numeric import Numeric
from rtgen.runtime.marshalling.descriptors import StructDescriptor
from rtgen.runtime.marshalling.dynamic.values import encoded
from rtgen.runtime.values import AnyValue

INTEROP = Path(__file__).parents[1] / "interop"


@pytest.fixture(scope="module")
def constructs(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    return wired(tmp_path_factory.mktemp("constructs"), [INTEROP / "constructs.idl"])


@pytest.fixture(scope="module")
def further(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    return wired_text(tmp_path_factory.mktemp("further"), FURTHER, "wired_further")


FURTHER = """
module WiredFurther {
    typedef octet Byte;
    typedef sequence<Byte> Bytes;
    typedef char Letter;
    typedef sequence<Letter, 4> Letters;
    enum Colour { red, green, blue };
    struct Base { long number; };
    struct Derived : Base { Colour tint; Base inner; };
    typedef sequence<Colour> Colours;
    typedef Colour Flag[3];
    typedef sequence<Derived> Derivations;
    typedef Derived Pair[2];
    typedef sequence<Pair> Pairs;
    interface Thing { void touch(); };
    struct Texts {
        Bytes raw; octet fixed_raw[4]; octet table[2][3];
        Letters few; char fixed_letters[4]; char lines[2][3];
        sequence<Bytes> many; string<5> bounded; sequence<string> words; wstring wide;
        Letter one; wchar wide_one; boolean flag; sequence<boolean> flags;
    };
    struct Lists {
        Colours tints; Flag three; Colour grid[2][2];
        Derivations derived; Pair two; Pairs four; sequence<Derivations> nested;
        sequence<long> numbers; sequence<sequence<long> > rows; double matrix[2][3];
        Derivations again, once_more;
    };
    struct Dynamic { any anything; Thing there; Object plain; fixed<6,3> price; };
    union Choice switch (Colour) {
        case red: Derived one;
        case green: sequence<Base> several;
        default: octet raw[2];
    };
    struct Chosen { Choice chosen_one; sequence<Choice> several; };
    union Letterwise switch (char) { case 'a': long number; case '\\'': Colours tints; };
    struct Wide {
        Derived a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t;
    };
    struct Wider { Wide first; Wide second; Derived last; };
};
struct WiredTop { WiredFurther::Base base; };
"""


def test_constructs(constructs: Wires) -> None:
    for kind in constructs.kinds:
        values_agree(kind, constructs.types)


@pytest.mark.sampled(0)
def test_further_types(further: Wires) -> None:
    for kind in further.kinds:
        if not kind.descriptor.name.endswith("::Dynamic"):
            values_agree(kind, further.types)


NUMBERS = """
module WiredNumbers_{0} {{
    struct Point {{ double x; float y; float z; octet rgb[8]; }};
    typedef sequence<float> Floats;
    union Choice switch (long) {{ case 1: Floats some; case 2: sequence<Point> points; }};
    struct Scan {{
        sequence<double> ranges; Floats intensities; sequence<long, 100> bounded;
        sequence<Point> points; double matrix[2][3]; short row[80]; Choice chosen;
    }};
}};
"""


@pytest.mark.parametrize("numeric", ["array", "numpy"])
def test_numbers_in_each_form(orb: Any, tmp_path: Path, numeric: Numeric) -> None:
    text, stem = NUMBERS.format(numeric), f"wired_numbers_{numeric}"
    wires = wired_text(tmp_path, text, stem, numeric)
    types, kind = wires.declared(stem), wires.kind(f"WiredNumbers_{numeric}::Scan")
    kept = kind.new()
    for count in (0, 3, 100):
        numbers = [*range(count)]
        points = [types.Point(n / 3, n / 2, -n, bytes(8)) for n in numbers]
        listed = types.Scan(
            [n / 3 for n in numbers],
            [n / 2 for n in numbers],
            numbers,
            points,
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            [*range(80)],
            types.Choice(2, points) if count else types.Choice(1, [0.5] * 70),
        )
        for little_endian in (True, False):
            octets = listed.to_cdr(little_endian)
            decoded = types.Scan.from_cdr(octets, little_endian)
            agree(kind, decoded, kept, little_endian)
            kind.fill(kept, listed)
            for made in (kind.of(kept), kind.of(kind.to(listed))):
                assert made == decoded
                assert type(made.ranges) is type(decoded.ranges)
                assert type(made.row) is type(decoded.row)


BUFFERS = """
module WiredBuffers_{0} {{
    union Choice switch (long) {{ case 1: sequence<octet> raw; case 2: double few[3]; }};
    struct Image {{
        sequence<octet> pixels; octet mac[4]; octet table[2][4]; sequence<octet, 4> bounded;
        sequence<double> numbers; long few[3]; double matrix[2][2]; sequence<boolean> flags;
        Choice chosen;
    }};
}};
"""


@pytest.mark.parametrize("numeric", ["list", "array", "numpy"])
def test_buffers(orb: Any, tmp_path: Path, numeric: Numeric) -> None:
    text, stem = BUFFERS.format(numeric), f"wired_buffers_{numeric}"
    wires = wired_text(tmp_path, text, stem, numeric)
    types, kind = wires.declared(stem), wires.kind(f"WiredBuffers_{numeric}::Image")
    octets = numpy.arange(4, dtype="u1")
    matrix = numpy.arange(4.0).reshape(2, 2)
    value = types.Image(
        memoryview(octets),
        bytearray(octets),
        [octets, octets.tobytes()],
        octets,
        array("d", [0.5]),
        numpy.arange(3, dtype="i4"),
        memoryview(matrix),
        numpy.array([True, False]),
        types.Choice.of_raw(octets),
    )
    kept = kind.new()
    for _ in range(2):
        wanted = value.to_cdr()
        places = padding(kind.descriptor, wanted, True)
        kind.fill(kept, value)
        for wire in (kept, kind.to(value)):
            assert masked(marshalled(kind, wire), places) == wanted
            assert kind.of(wire).to_cdr() == wanted
        value.chosen = types.Choice.of_few(numpy.arange(3.0))


def test_initial_values(constructs: Wires, further: Wires) -> None:
    """Those of char, octet, enum and union members can be marshalled, with their structs."""
    for kind in (*constructs.kinds, *further.kinds):
        if not kind.is_exception:
            agree(kind, kind.type(), kind.new(), True)


def test_openrtm_can_copy_initial_values(constructs: Wires, further: Wires) -> None:
    """An OutPort stores a deep copy of its initial value."""
    for kind in (*constructs.kinds, *further.kinds):
        if isinstance(kind.descriptor, StructDescriptor):
            wire = kind.new()
            copied = copy.deepcopy(wire)
            assert kind.of(copied) == kind.of(wire)
            # omniORB's padding may have any value.
            assert len(marshalled(kind, copied)) == len(marshalled(kind, wire))


def test_what_refers_to_types_and_objects(further: Wires, orb: Any) -> None:
    types, kind = (
        further.declared("wired_further"),
        further.kind("WiredFurther::Dynamic"),
    )

    class Thing(types.Thing):  # type: ignore[misc]
        def touch(self) -> None:
            pass

    wire = importlib.import_module("rtgen.runtime.openrtm.wire")
    conversions = importlib.import_module("rtgen.runtime.openrtm.conversions")
    reference = conversions.BASIC["Object"].of(wire.objects_of(types.Thing).to(Thing()))
    base = types.Base(4)
    value = types.Dynamic(
        AnyValue(types.Base, base), reference, reference, Decimal("-12.345")
    )
    kept = kind.new()
    assert kind.of(kept) == types.Dynamic()
    kind.fill(kept, value)
    for wire in (kept, kind.to(value)):
        octets = importlib.import_module("omniORB").cdrMarshal(kind.code, wire, 1)
        assert types.Dynamic.from_cdr(octets) == value
        assert kind.of(wire) == value


def test_a_new_object_shares_nothing(further: Wires) -> None:
    types, kind = further.declared("wired_further"), further.kind("WiredFurther::Lists")
    value = types.Lists(
        derived=[types.Derived()], numbers=[1], rows=[[1], [2]], again=[types.Derived()]
    )
    before = value.to_cdr()
    wire = kind.to(value)
    wire.numbers.append(2)
    wire.rows[0].append(3)
    wire.derived[0].inner.number = 9
    wire.matrix[0][0] = 5.0
    assert value.to_cdr() == before
    again = kind.of(kind.to(value))
    sent = kind.to(value)
    made = kind.of(sent)
    sent.numbers.append(2)
    sent.rows[0].append(3)
    sent.derived[0].number = 8
    assert made == again == value


def test_a_kept_object_keeps_its_parts(further: Wires) -> None:
    types, kind = further.declared("wired_further"), further.kind("WiredFurther::Lists")
    kept = kind.new()
    several = types.Lists(derived=[types.Derived(n) for n in range(3)])
    kind.fill(kept, several)
    first, pair = kept.derived[0], kept.two[1]
    kind.fill(kept, types.Lists(derived=[types.Derived(7), types.Derived(8)]))
    assert kept.derived[0] is first
    assert kept.two[1] is pair
    assert [item.number for item in kept.derived] == [7, 8]


def test_a_fixed_point_number_out_of_range(further: Wires) -> None:
    corba = importlib.import_module("omniORB.CORBA")
    types, kind = (
        further.declared("wired_further"),
        further.kind("WiredFurther::Dynamic"),
    )
    with pytest.raises(corba.DATA_CONVERSION):
        kind.to(types.Dynamic(price=Decimal("12345.678")))


def test_valuetypes_keep_what_is_shared(
    orb: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    wires = wired(tmp_path_factory.mktemp("valuetypes"), [INTEROP / "valuetypes.idl"])
    types, kind = wires.declared("valuetypes"), wires.kind("Valued::S")
    shared, text = types.V(5), types.Text("shared")
    value = types.S(shared, shared, None, shared, None, text, text)
    wire = kind.to(value)
    assert wire.v1 is wire.v2
    back = kind.of(wire)
    assert back.v1 is back.v2
    octets = encoded(kind.descriptor, value, True)
    assert encoded(kind.descriptor, back, True) == octets
    kept = kind.new()
    kind.fill(kept, value)
    assert encoded(kind.descriptor, kind.of(kept), True) == octets
    assert marshalled(kind, kept) == marshalled(kind, wire)


CLASHES = """
module Clashing {
    struct _Any { long class; long def; long lambda; long value; long wire; };
    struct new_ { _Any value; sequence<_Any> wire; };
    struct to_Any { _Any item; };
    exception raised { _Any part; long error; };
    interface called {
        _Any refill(in _Any value, in _Any wire, in long Objects, in _Any to_Any, inout _Any state)
            raises (raised);
        long from(in _Any typing_, in long Reference);
    };
    interface Any_ { called _True(in called made); };
    struct calledServant { long x; };
    struct Octets;
    typedef sequence<Octets> Nest;
    struct Octets { Nest nested; };
    union Reference switch (boolean) { case TRUE: Octets None; case FALSE: long is; };
};
struct class_of { Clashing::_Any data; };
interface refill { class_of pass(in class_of wire); };
"""


def test_names_that_clash(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Names of generated code, of Python and of the module are distinguished."""
    folder = tmp_path_factory.mktemp("clashes")
    wires = wired_text(folder, CLASHES, "wire_typing")
    for kind in wires.kinds:
        values_agree(kind, wires.types)
    types = wires.declared("wire_typing")

    class Called(types.called):  # type: ignore[misc]
        def refill(
            self,
            value: Any,
            wire: Any,
            Objects: int,
            to_Any: Any,
            state: Any,
        ) -> Any:
            if Objects:
                raise types.raised(wire, Objects)
            return value, to_Any

        def from_(self, typing_: Any, Reference: int) -> int:
            return int(typing_.class_ + Reference)

    stub = stub_of(types.called, Called())
    plain = wires.kind("Clashing::Any").type
    one, two = plain(1), plain(class_=2)
    assert stub.refill(one, two, 0, two, one) == (one, two)
    with pytest.raises(types.raised) as caught:
        stub.refill(one, two, 3, two, one)
    assert (caught.value.part, caught.value.error) == (two, 3)
    assert stub.from_(two, 5) == 7


HIDING = """
module WiredHiding {
    interface Root { enum Mode { idle, busy }; Mode turn(in Mode given); attribute long level; };
    interface One : Root { struct Part { long x; }; Part first(); };
    interface Two : Root { struct Part { double y; }; Part second(); };
    interface Both : One, Two {
        struct Part { string z; };
        enum Mode { quick, slow };
        Part third(in Mode given);
    };
};
"""


def test_interfaces_with_several_bases(orb: Any, tmp_path: Path) -> None:
    """Members of a derived interface hide those of its bases with the same name."""
    wires = wired_text(tmp_path, HIDING, "wired_hiding")
    types = wires.declared("wired_hiding")

    class Both(types.Both):  # type: ignore[misc]
        level = 3

        def turn(self, given: Any) -> Any:
            return types.Root.Mode(1 - given)

        def first(self) -> Any:
            return types.One.Part(4)

        def second(self) -> Any:
            return types.Two.Part(0.5)

        def third(self, given: Any) -> Any:
            return types.Both.Part(given.name)

    stub = stub_of(types.Both, Both())
    assert stub.turn(types.Root.Mode.idle) is types.Root.Mode.busy
    assert (stub.first().x, stub.second().y, stub.level) == (4, 0.5, 3)
    assert stub.third(types.Both.Mode.slow) == types.Both.Part("slow")
    assert isinstance(stub_of(types.Two, Both()).second(), types.Two.Part)
