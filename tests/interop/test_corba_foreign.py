"""Calls through a process with omniidl's stubs only: rtgen's stub, its servant and stub, rtgen's.

The values compared at the end were marshalled and read by both.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import programs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from patience import until

pytest.importorskip("omniORB", reason="omniORBpy is not installed")
sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted
import samples
import test_cdr_constructs
from omniORB import tcInternal

from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    InterfaceDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
)
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.servants import UnknownException
from rtgen.runtime.values import AnyValue, DynamicValue

HERE = Path(__file__).parent
FILES = [HERE / "foreign.idl", HERE / "constructs.idl"]


@dataclass
class Chain:
    """rtgen's package, omniidl's modules, and a stub whose calls return to `servant`."""

    foreign: Any
    constructs: Any
    theirs: dict[str, Any]
    objects: Objects
    servant: Any
    stub: Any


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chain]:
    folder = tmp_path_factory.mktemp("theirs")
    command = [programs.omniidl(), "-bpython", f"-C{folder}", *map(str, FILES)]
    subprocess.run(command, check=True, capture_output=True)
    package = emitted.emit(tmp_path_factory.mktemp("ours"), FILES)
    sys.path.insert(0, str(folder))
    theirs = {name: importlib.import_module(name) for name in ("Foreign", "Constructs")}
    sys.path.remove(str(folder))
    orb = Orb(timeout=20.0)
    objects = Objects(orb)
    servant = echo(package.foreign, package.constructs)
    own = objects.exported(servant, None)
    peer = subprocess.Popen(
        [
            sys.executable,
            str(HERE / "foreign_peer.py"),
            str(folder),
            orb.orb.object_to_string(own),
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert peer.stdout is not None
    reference = orb.orb.string_to_object(peer.stdout.readline().strip())
    stub = objects.stub(package.foreign.Echo, reference)
    yield Chain(package.foreign, package.constructs, theirs, objects, servant, stub)
    peer.communicate()
    assert peer.returncode == 0
    orb.close()


def echo(foreign: Any, constructs: Any) -> Any:
    """Return a servant that returns its arguments in another order."""

    class Twig(foreign.Twig):  # type: ignore[misc]
        def name(self) -> str:
            return "twig"

        def age(self) -> int:
            return 7

    class Echo(foreign.Echo):  # type: ignore[misc]
        speed = 0.5
        top = Twig()
        noted: list[Any] = []  # noqa: RUF012

        def fail(self, which: int) -> None:
            if which == 0:
                numbers = foreign.Numbers(1, l=foreign.HIGH)
                raise foreign.Broken("é", numbers, Decimal("1.500"))
            if which == 1:
                detail = constructs.ByBoolean(False, [1.0])
                raise constructs.Failure("why", detail, b"abc")
            raise KeyError("nobody declared it")

        def note(self, text: str, shifted: Any) -> None:
            self.noted.append((text, shifted))

        def same(self, given: Any, both: Any) -> Any:
            return given, self.top, foreign.Branch(both.other, both.first)

        def where(self, a: int) -> int:
            return a + 2**63

    for name in calls_of(foreign.Types):
        setattr(Echo, name, lambda self, a, b: (b, a, b))
    Echo.__abstractmethods__ = frozenset()
    return Echo()


def check(chain: Chain, name: str, one: Any, other: Any) -> None:
    """Send two values of a type round."""
    assert getattr(chain.stub, f"echo_{name}")(one, other) == (other, one, other)


def test_constructs(chain: Chain) -> None:
    values = test_cdr_constructs.values(
        chain.constructs, lambda digits, scale, text: Decimal(text)
    )
    operations = {
        "ByLong": "by_long",
        "ByBoolean": "by_boolean",
        "ByChar": "by_char",
        "ByEnum": "by_enum",
        "Money": "money",
        "Mixed": "mixed",
        "Tree": "trees",
    }
    for name, operation in operations.items():
        for value in values[name]:
            check(chain, operation, value, values[name][0])


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "name", ["octets", "keys", "grids", "flags", "prices", "numbers", "wide"]
)
def test_random_values(chain: Chain, name: str) -> None:
    foreign = chain.foreign
    types = {t._descriptor_.repository_id: t for t in (foreign.Numbers, foreign.Gear)}
    request = calls_of(foreign.Types)[f"echo_{name}"].request
    assert request is not None
    descriptor = request._descriptor_.members[0].type
    values = samples.values(descriptor).filter(_is_ascii)

    @settings(max_examples=25, deadline=None, database=None)
    @given(values, values)
    def compare(one: Any, other: Any) -> None:
        pair = [samples.build(descriptor, tree, types) for tree in (one, other)]
        check(chain, name, *pair)

    compare()


def _is_ascii(tree: Any) -> bool:
    """Return whether it is ASCII: omniORBpy decodes chars as UTF-8."""
    return not isinstance(tree, list) or all(
        item["j"].isascii() for item in tree if isinstance(item, dict)
    )


ANYS = st.sampled_from(
    [
        AnyValue(),
        AnyValue(PrimitiveDescriptor("double"), 0.25),
        AnyValue(StringDescriptor(), "あ"),
        AnyValue(StringDescriptor(wide=True), "あé"),
        AnyValue(SequenceDescriptor(PrimitiveDescriptor("octet")), b"\0\xff"),
        AnyValue(PrimitiveDescriptor("any"), AnyValue(PrimitiveDescriptor("short"), 3)),
    ]
)


_UNKNOWN = StructDescriptor(
    "IDL:example.org/Unknown:1.0",
    "Unknown",
    (
        MemberDescriptor("a", PrimitiveDescriptor("long")),
        MemberDescriptor(
            "b", EnumDescriptor("IDL:example.org/E:1.0", "E", (("X", 0), ("Y", 1)))
        ),
    ),
)
"""A type that neither side has a class of."""


def test_words(chain: Chain) -> None:
    foreign = chain.foreign
    for any_ in (
        AnyValue(foreign.Numbers, foreign.Numbers(-1, 2, l=foreign.HIGH)),
        AnyValue(foreign.Gear, foreign.HIGH),
        AnyValue(chain.constructs.ByLong, chain.constructs.ByLong(-3, "text")),
        *(AnyValue(PrimitiveDescriptor(kind), 1) for kind in ("octet", "long long")),
        AnyValue(SequenceDescriptor(foreign.Numbers._descriptor_), [foreign.Numbers()]),
        AnyValue(ANY, AnyValue(ANY, AnyValue(foreign.Numbers, foreign.Numbers(c=3)))),
        AnyValue(chain.constructs.ByBoolean, chain.constructs.ByBoolean(False, [1.0])),
        AnyValue(FixedDescriptor(5, 2), Decimal("-1.25")),
        AnyValue(_UNKNOWN, DynamicValue(_UNKNOWN, {"a": 3, "b": 1})),
        AnyValue(PrimitiveDescriptor("CORBA::TypeCode"), foreign.Numbers._descriptor_),
    ):
        check(chain, "anys", any_, AnyValue())
        words = foreign.Words("é", "あ", "12345678", any_, Decimal("-1.250"), b"abcd")
        check(chain, "words", [words, foreign.Words(sign=bytes(4))], [])
    check(chain, "letters", "abc", "")

    @settings(max_examples=20, deadline=None, database=None)
    @given(ANYS, ANYS)
    def compare(one: Any, other: Any) -> None:
        check(chain, "anys", one, other)

    compare()


def test_exceptions(chain: Chain) -> None:
    foreign, constructs = chain.foreign, chain.constructs
    with pytest.raises(foreign.Broken) as broken:
        chain.stub.fail(0)
    numbers = foreign.Numbers(1, l=foreign.HIGH)
    assert broken.value == foreign.Broken("é", numbers, Decimal("1.500"))
    with pytest.raises(constructs.Failure) as failure:
        chain.stub.fail(1)
    detail = constructs.ByBoolean(False, [1.0])
    assert failure.value == constructs.Failure("why", detail, b"abc")
    with pytest.raises(UnknownException, match="UNKNOWN"):
        chain.stub.fail(2)


def test_objects_attributes_and_the_rest(chain: Chain) -> None:
    foreign, stub = chain.foreign, chain.stub
    stub.speed = stub.speed + 0.25
    assert stub.speed == chain.servant.speed == 0.75
    assert stub.where(1) == 2**63 + 1

    class Leaf(foreign.Leaf):  # type: ignore[misc]
        def name(self) -> str:
            return "leaf"

    own = Leaf()
    reference = chain.objects.imported(chain.objects.exported(own, None), None)
    assert isinstance(reference, ObjectReference)
    given_back, twig, both = stub.same(own, foreign.Branch(reference, None))
    assert given_back.name() == "leaf"
    assert (twig.name(), twig.age()) == ("twig", 7)
    assert isinstance(twig, foreign.Twig)
    assert both.first is None
    again = chain.objects.stub(foreign.Leaf, chain.objects.exported(both.other, None))
    assert again.name() == "leaf"
    assert stub.top.name() == "twig"
    nothing = stub.same(None, foreign.Branch())
    assert (nothing[0], nothing[2]) == (None, foreign.Branch())
    stub.note("oneway", foreign.HIGH)
    until(lambda: chain.servant.noted)
    assert chain.servant.noted == [("oneway", foreign.HIGH)]


def test_the_peer_sees_interfaces_and_their_bases(chain: Chain) -> None:
    reference = chain.objects.exported(chain.servant, None)
    foreign = chain.foreign
    for interface in (foreign.Echo, foreign.Types):
        assert reference._is_a(interface._descriptor_.repository_id)
    assert not reference._is_a("IDL:example.org/Foreign/Leaf:1.0")
    assert isinstance(
        reference._narrow(chain.theirs["Foreign"].Types),
        chain.theirs["Foreign"]._objref_Types,
    )


def test_repository_ids_and_type_codes_are_the_same(chain: Chain) -> None:
    compared = 0
    of_any = chain.objects.types.of(ANY).descriptor
    for ours, module in ((chain.foreign, "Foreign"), (chain.constructs, "Constructs")):
        for name in ours.__all__:
            descriptor = getattr(getattr(ours, name), "_descriptor_", None)
            theirs = getattr(chain.theirs[module], f"_d_{name}", None)
            if descriptor is None or theirs is None or holds_characters(descriptor):
                continue
            if isinstance(descriptor, ExceptionDescriptor):
                mine = chain.objects.types.exception(getattr(ours, name)).descriptor
            else:
                mine = chain.objects.types.of(descriptor).descriptor
            if not isinstance(descriptor, InterfaceDescriptor):
                assert tcInternal.equivalentDescriptors(mine, theirs), name
            assert descriptor.repository_id in (mine[1], mine[2])
            code = getattr(chain.theirs[module], f"_tc_{name}")
            assert code.id() == descriptor.repository_id
            assert shape(mine, of_any) == shape(theirs, of_any), name
            compared += 1
    assert compared > 10


def holds_characters(descriptor: Any) -> bool:
    """Return whether the type contains a char or a wchar, which travel as octets."""
    return "char'" in repr(descriptor) or "Tree" in repr(descriptor)


def shape(descriptor: Any, of_any: Any) -> Any:
    """Return a descriptor without classes, and without the underscore of Python's keywords."""
    if descriptor is of_any:
        return tcInternal.tv_any
    if isinstance(descriptor, str):
        return descriptor.lstrip("_")
    if isinstance(descriptor, (tuple, list)):
        return [shape(part, of_any) for part in descriptor]
    if isinstance(descriptor, int):
        return int(descriptor)
    return None if callable(descriptor) else getattr(descriptor, "_v", None)
