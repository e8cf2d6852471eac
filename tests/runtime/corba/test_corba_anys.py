"""Values of `any` over omniORB: all kinds of types, types of one id, type codes that are wrong."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from decimal import Decimal
from pathlib import Path
from typing import Any

import forwarder
import pytest
from patience import PATIENCE

pytest.importorskip("omniORB", reason="omniORBpy is not installed")
sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "types"))
sys.path.insert(0, str(Path(__file__).parents[2] / "interop"))

import emitted
import omniORB
import padding
from omniORB import CORBA, tcInternal

from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.wire_conversions import through
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    NULL,
    ArrayDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    FixedDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
)
from rtgen.runtime.marshalling.type_codes import type_code_octets
from rtgen.runtime.services.servants import MarshalError
from rtgen.runtime.values import AnyValue, DynamicUnion, DynamicValue

IDL = """
module Anys {
  enum Gear { LOW, HIGH };
  struct Pair { long one; string other; };
  typedef sequence<Pair> Pairs;
  typedef Pair Two[2];
  struct Tree;
  typedef sequence<Tree> Trees;
  struct Tree { char mark; any load; Trees below; };
  union Either switch (Gear) { case LOW: Pair both; default: any rest; };
  exception Odd { string why; };
  valuetype Shared { public long x; };
  struct HolderOfShared { Shared one; };
  union First switch (long) { default: long rest; case 1: string text; };
  typedef sequence<any> List;
  interface Calls {
    any echo(in any a);
    List echo_all(in List a);
    CORBA::TypeCode echo_code(in CORBA::TypeCode a);
  };
};
"""
CLASHING = """
module %s {
  struct Same { %s };
};
#pragma ID %s::Same "IDL:clash.example/Same:1.0"
"""

LONG, DOUBLE = PrimitiveDescriptor("long"), PrimitiveDescriptor("double")


@pytest.fixture(scope="module")
def anys(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("corba_anys"), IDL).anys


class Served:
    """A servant that returns its arguments, with its stub."""

    def __init__(self, anys: Any, stack: ExitStack, by_socket: bool) -> None:
        class Echo(anys.Calls):  # type: ignore[misc]
            calls = 0

            def echo(self, a: Any) -> Any:
                self.calls += 1
                return a

            def echo_all(self, a: Any) -> Any:
                return a

            def echo_code(self, a: Any) -> Any:
                return a

        self.orb = Orb(timeout=PATIENCE)
        stack.callback(self.orb.close)
        self.objects = Objects(self.orb)
        self.servant = Echo()
        self.reference = self.objects.exported(self.servant, None)
        if by_socket:
            imported = self.objects.imported(self.reference, None)
            imported = stack.enter_context(forwarder.forwarded(imported))
            self.reference = self.objects.exported(imported, None)
        self.stub = self.objects.stub(anys.Calls, self.reference)


@pytest.fixture(params=["in the process", "by a socket"])
def served(
    anys: Any, stack: ExitStack, request: pytest.FixtureRequest
) -> Iterator[Served]:
    with stack:
        yield Served(anys, stack, request.param == "by a socket")


@pytest.fixture
def remote(anys: Any, stack: ExitStack) -> Iterator[Served]:
    with stack:
        yield Served(anys, stack, True)


def unknown() -> StructDescriptor:
    """Return a type without a generated class."""
    enum = EnumDescriptor("IDL:Unknown/Kind:1.0", "Kind", (("A", 0), ("B", 1)))
    members = (
        MemberDescriptor("mark", PrimitiveDescriptor("char")),
        MemberDescriptor("kind", enum),
    )
    return StructDescriptor("IDL:Unknown/Thing:1.0", "Thing", members)


def unknown_union(switch: Descriptor, label: Any) -> UnionDescriptor:
    """Return a union without a generated class, with its default first."""
    branches = (
        BranchDescriptor((), True, "rest", unknown()),
        BranchDescriptor((label,), False, "text", StringDescriptor()),
    )
    name = f"By{switch}"
    return UnionDescriptor(f"IDL:Unknown/{name}:1.0", name, switch, branches)


def values(anys: Any) -> list[AnyValue]:
    pair = anys.Pair(1, "other")
    pairs = [pair, anys.Pair(-2, "")]
    leaf = anys.Tree("\xe9", AnyValue(anys.Pair, pair), [])
    tree = anys.Tree("t", AnyValue(anys.Tree, leaf), [leaf, leaf])
    thing = DynamicValue(unknown(), {"mark": "\xe9", "kind": 1})
    kind = unknown().members[1].type
    by_kind, by_long = unknown_union(kind, 0), unknown_union(LONG, -3)
    wide = StringDescriptor(wide=True)
    char = PrimitiveDescriptor("char")
    return [
        AnyValue(),
        AnyValue(LONG, -3),
        AnyValue(PrimitiveDescriptor("unsigned long long"), 2**63),
        AnyValue(PrimitiveDescriptor("boolean"), True),
        AnyValue(char, "\xe9"),
        AnyValue(StringDescriptor(), "あé"),
        AnyValue(StringDescriptor(bound=4), "four"),
        AnyValue(wide, "あé"),
        AnyValue(FixedDescriptor(5, 2), Decimal("-1.25")),
        AnyValue(PrimitiveDescriptor("CORBA::TypeCode"), anys.Tree._descriptor_),
        AnyValue(SequenceDescriptor(DOUBLE), [0.5, -0.5]),
        AnyValue(SequenceDescriptor(PrimitiveDescriptor("octet"), 3), b"\0\xff"),
        AnyValue(SequenceDescriptor(SequenceDescriptor(wide)), [["あ"], []]),
        AnyValue(ArrayDescriptor(char, (2, 3)), ["abc", "\xe9\0z"]),
        AnyValue(anys.Gear, anys.HIGH),
        AnyValue(anys.Pair, pair),
        AnyValue(anys.PairsCodec, pairs),
        AnyValue(anys.TwoCodec, pairs),
        AnyValue(SequenceDescriptor(anys.Pair._descriptor_), pairs),
        AnyValue(anys.Either, anys.Either(anys.LOW, pair)),
        AnyValue(
            anys.Either,
            anys.Either(anys.HIGH, AnyValue(anys.Either, anys.Either(anys.LOW, pair))),
        ),
        AnyValue(anys.Tree, tree),
        AnyValue(ANY, AnyValue(ANY, AnyValue(anys.Tree, tree))),
        AnyValue(unknown(), thing),
        AnyValue(SequenceDescriptor(unknown()), [thing, thing]),
        AnyValue(
            SequenceDescriptor(ANY),
            [AnyValue(unknown(), thing), AnyValue(anys.Pair, pair)],
        ),
        AnyValue(anys.First, anys.First(3, 4)),
        AnyValue(kind, 1),
        AnyValue(by_kind, DynamicUnion(by_kind, 0, "text")),
        AnyValue(by_kind, DynamicUnion(by_kind, 1, thing)),
        AnyValue(by_long, DynamicUnion(by_long, 7, thing)),
        AnyValue(by_long, DynamicUnion(by_long, -3, "text")),
        AnyValue(anys.Odd, anys.Odd("why")),
        AnyValue(PrimitiveDescriptor("Object"), None),
    ]


def test_values_of_all_types(anys: Any, served: Served) -> None:
    """A value arrives as the codecs decode it."""
    for given in values(anys) * 2:
        got = served.stub.echo(given)
        expected = AnyValue.from_cdr(given.to_cdr())
        assert got == expected
        assert type(got.value) is type(expected.value) is type(given.value)
    assert served.stub.echo_all(values(anys)) == [
        AnyValue.from_cdr(given.to_cdr()) for given in values(anys)
    ]
    for class_ in (anys.Pair, anys.Gear, anys.Either, anys.Tree, anys.Odd):
        given = next(v for v in values(anys) if v.type is class_._descriptor_)
        assert served.stub.echo(given).type is class_._descriptor_


def test_references(anys: Any, served: Served) -> None:
    reference = served.objects.imported(served.reference, None)
    for type_ in (PrimitiveDescriptor("Object"), anys.Calls):
        got = served.stub.echo(AnyValue(type_, reference))
        again = served.objects.stub(
            anys.Calls, served.objects.exported(got.value, None)
        )
        assert again.echo(AnyValue(LONG, 3)) == AnyValue(LONG, 3)


def test_values_are_copies(anys: Any, served: Served) -> None:
    given = AnyValue(anys.PairsCodec, [anys.Pair(1, "one")])
    got = served.stub.echo(given)
    given.value[0].one = 2
    given.value.append(anys.Pair(3, "three"))
    assert got.value == [anys.Pair(1, "one")]


def test_octets_are_those_of_the_codecs(anys: Any, served: Served) -> None:
    wire = served.objects.types.of(ANY)
    code = tcInternal.TypeCode_union(wire.descriptor)
    for value in values(anys):
        octets = omniORB.cdrMarshal(code, through(wire.outgoing, value), 1)
        same = value.to_cdr()
        places = padding.padding(ANY, same, True)
        assert padding.masked(octets, places) == same
        assert omniORB.cdrUnmarshal(code, octets, 1) == AnyValue.from_cdr(same)


def test_more_types_than_are_cached(anys: Any, served: Served) -> None:
    many = [AnyValue(StringDescriptor(bound=1 + i), "a") for i in range(600)]
    many += [
        AnyValue(ArrayDescriptor(LONG, (1 + i % 9,)), [0] * (1 + i % 9))
        for i in range(50)
    ]
    many += [AnyValue(anys.Pair, anys.Pair(i, "")) for i in range(2)]
    assert served.stub.echo_all(many) == many
    for value in many:
        assert served.stub.echo(value) == value


def test_objects_of_one_process(anys: Any, served: Served) -> None:
    """Another table of types, in another order, reads the same values."""
    stub = Objects(served.orb).stub(anys.Calls, served.reference)
    given = values(anys)
    for value in given:
        served.stub.echo(value)
    for value in reversed(given):
        assert stub.echo(value) == AnyValue.from_cdr(value.to_cdr())


@pytest.mark.parametrize("known_to_omniorb", [False, True])
def test_types_of_one_repository_id(
    tmp_path: Path,
    served: Served,
    monkeypatch: pytest.MonkeyPatch,
    known_to_omniorb: bool,
) -> None:
    """Each value has the members of its own type, whichever other types have its id."""
    identity = "IDL:clash.example/Same:1.0"
    if known_to_omniorb:
        kept = (
            tcInternal.tv_struct,
            tuple,
            identity,
            "Same",
            "x",
            tcInternal.tv_double,
        )
        monkeypatch.setitem(omniORB.typeMapping, identity, kept)
    texts = {"First": "long a; string b;", "Second": "string b; long a; double c;"}
    both = []
    for name, members in texts.items():
        (tmp_path / name).mkdir()
        package = emitted.emit_text(tmp_path / name, CLASHING % (name, members, name))
        both.append(getattr(package, name.lower()).Same)
    first, second = both
    one, other = first(1, "one"), second("two", 2, 0.5)
    for _ in range(2):
        assert served.stub.echo(AnyValue(second, other)) == AnyValue(second, other)
        if known_to_omniorb:
            continue
        got = served.stub.echo(AnyValue(first, one))
        assert got.type.repository_id == identity
        assert got.value.members == {"a": 1, "b": "one"}
    assert served.stub.echo_code(second._descriptor_) is second._descriptor_


def test_a_type_becomes_known(tmp_path: Path, remote: Served) -> None:
    members = (MemberDescriptor("a", LONG),)
    described = StructDescriptor("IDL:Later/Known:1.0", "Known", members)
    given = AnyValue(described, DynamicValue(described, {"a": 3}))
    assert remote.stub.echo(given) == given
    later = emitted.emit_text(
        tmp_path, "module Later { struct Known { long a; }; };"
    ).later
    assert remote.stub.echo(given) == AnyValue(later.Known, later.Known(3))
    assert remote.stub.echo(AnyValue(later.Known, later.Known(4))).value == later.Known(
        4
    )


def deep(levels: int) -> Descriptor:
    type_: Descriptor = LONG
    for _ in range(levels):
        type_ = SequenceDescriptor(type_)
    return type_


def code(type_: Descriptor) -> tuple[int, bytes]:
    return type_code_octets(type_, True)


def send_type_code(remote: Served, kind: int, parameters: bytes) -> None:
    """Call `echo` with an `any` of this type code."""
    head = (tcInternal.tv_struct, tuple, "", "", "kind", tcInternal.tv_ulong, "rest")
    octets = (tcInternal.tv_array, tcInternal.tv_octet, len(parameters) + 64)

    class Given:
        def __init__(self) -> None:
            self.kind = kind
            self.rest = parameters + bytes(64)

    operation = ((*head, octets),), (tcInternal.tv_long,), None
    remote.reference._obj.invoke("echo", operation, (Given(),))


@pytest.mark.parametrize(
    ("kind", "parameters", "reason"),
    [
        (99, b"", "a type code of kind 99"),
        (*code(deep(101)), "nested more than 100 deep"),
        (*code(ArrayDescriptor(NULL, (2**31,))), "an array of elements without octets"),
        (28, b"\x28\0\0\0", "fixed<40,0> in a type code"),
        (15, b"\4\0\0\0\1\0\0\0", "a type code ends too soon"),
    ],
)
def test_type_codes_that_are_wrong(
    remote: Served,
    caplog: pytest.LogCaptureFixture,
    kind: int,
    parameters: bytes,
    reason: str,
) -> None:
    with pytest.raises(CORBA.MARSHAL):
        send_type_code(remote, kind, parameters)
    assert "a received type code is wrong: " in caplog.text
    assert reason in caplog.text
    assert remote.servant.calls == 0
    assert remote.stub.echo(AnyValue(LONG, 3)) == AnyValue(LONG, 3)


def test_valuetypes_are_refused(
    anys: Any, remote: Served, caplog: pytest.LogCaptureFixture
) -> None:
    """omniORB crashes for some octets of a valuetype, so it reads none."""
    for type_ in (
        anys.Shared._descriptor_,
        anys.HolderOfShared._descriptor_,
        SequenceDescriptor(anys.Shared._descriptor_),
    ):
        value: Any = [] if isinstance(type_, SequenceDescriptor) else None
        with pytest.raises(MarshalError, match="cannot travel by CORBA"):
            remote.stub.echo(AnyValue(type_, value))
        with pytest.raises(CORBA.MARSHAL):
            send_type_code(remote, *code(type_))
    assert caplog.text.count("a received type code is wrong: ") == 3
    assert remote.servant.calls == 0
    assert remote.stub.echo_code(anys.Shared._descriptor_) is anys.Shared._descriptor_


def test_results_that_are_wrong(anys: Any, remote: Served) -> None:
    remote.servant.echo = lambda a: AnyValue(anys.Pair, anys.Pair("no number", ""))
    with pytest.raises(MarshalError):
        remote.stub.echo(AnyValue())
