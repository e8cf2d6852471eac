"""Every form of operation, attribute and interface, called through its stub."""

from __future__ import annotations

import logging
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.services.calls import Client, Reply, ReplyStatus, Server, calls_of
from rtgen.runtime.services.servants import (
    BadOperation,
    MarshalError,
    ObjectNotExist,
    ServiceError,
    UnknownException,
)

CASE = Path(__file__).with_name("service_forms.idl")
Connect = Callable[[Any, Any], Any]


@pytest.fixture(scope="module")
def forms(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit(tmp_path_factory.mktemp("forms"), [CASE]).forms


def direct(interface: Any, servant: Any) -> Any:
    return interface._stub_(interface._skeleton_(servant).dispatch)


def marshalled(interface: Any, servant: Any, little_endian: bool = True) -> Any:
    """Return a stub whose calls are encoded and decoded."""
    objects = Objects(little_endian)
    server = Server(interface, servant, objects=objects)

    def send(operation: str, body: bytes, oneway: bool) -> Reply | None:
        return server.handle(operation, body, little_endian)

    client = Client(interface, send, little_endian=little_endian, objects=objects)
    return interface._stub_(client)


def marshalled_big(interface: Any, servant: Any) -> Any:
    return marshalled(interface, servant, little_endian=False)


class Objects:
    """Names the servants of one process by number."""

    def __init__(self, little_endian: bool) -> None:
        self._little_endian = little_endian
        self._known: list[Any] = []

    def reference(self, interface: Any, servant: Any) -> ObjectReference:
        key = bytes([len(self._known)])
        self._known.append(servant)
        return ObjectReference(interface._descriptor_.repository_id, ((0, key),))

    def resolve(self, interface: Any, reference: ObjectReference) -> Any:
        ((_, key),) = reference.profiles
        return marshalled(interface, self._known[key[0]], self._little_endian)


@pytest.fixture(params=[direct, marshalled, marshalled_big])
def connect(request: pytest.FixtureRequest) -> Connect:
    """Return a servant's stub, by each way to carry calls."""
    way: Connect = request.param
    return way


def serving(interface: Any, **behaviour: Any) -> Any:
    """Return a servant: callables become methods, other values attributes."""
    methods = {
        name: (lambda self, *given, _f=value: _f(*given)) if callable(value) else value
        for name, value in behaviour.items()
    }
    wanted = dict.fromkeys(interface.__abstractmethods__)
    return type("Servant", (interface,), {**wanted, **methods})()


def test_directions(forms: Any, connect: Connect) -> None:
    pose, other = forms.Pose(1.0, 2.0), forms.Pose(3.0, 4.0)
    servant = serving(
        forms.Directions,
        nothing=lambda: None,
        back=lambda: 1,
        one_in=lambda a: None,
        one_out=lambda: 2,
        one_inout=lambda a: a + 1,
        in_out=lambda a: (a, "out"),
        out_in=lambda a: (a, "out first"),
        all=lambda a, b, d, e: (a, b / 2, f"{d}", other, forms.HIGH),
        three=lambda: (1, 0.5, 255),
        self_named=lambda self, result: (self, result),
    )
    stub = connect(forms.Directions, servant)
    assert stub.nothing() is None
    assert stub.back() == 1
    assert stub.one_in(5) is None
    assert stub.one_out() == 2
    assert stub.one_inout(-1) == 0
    assert stub.in_out(7) == (7, "out")
    assert stub.out_in(8) == (8, "out first")
    assert stub.all(255, 3.0, True, pose) == (255, 1.5, "True", other, forms.HIGH)
    assert stub.three() == (1, 0.5, 255)
    assert stub.self_named(4, 5) == (4, 5)
    assert stub.self_named(self_=4, result=6) == (4, 6)


def test_types(forms: Any, connect: Connect) -> None:
    # IIOP 1.2 (CORBA 3.3 part 2, 9.7.2): host "h", port 1, object key "key", no components.
    place = bytes.fromhex("01010200 02000000 68000100 03000000 6b657900 00000000")
    reference = ObjectReference("IDL:Forms/Later:1.0", ((0, place),))
    servant = serving(
        forms.Types,
        booleans=lambda a: (not a, a),
        chars=lambda a: (a, "\u3042"),
        octets=lambda a, c: (a, -1, c + 1),
        longs=lambda a, c: (a, 2**32 - 1, c, 2**64 - 1),
        floats=lambda a: (a, 0.1),
        strings=lambda a, b: (a.upper(), b, "\u00e9" * 3),
        prices=lambda a: -a,
        gears=lambda a: forms.HIGH,
        structs=lambda a, b: (a, [*b, a], [1, 2, 3]),
        unions=lambda a: forms.Either.of_text("odd") if a.number % 2 else a,
        objects=lambda a: a,
        lists=lambda a: [*a, None],
        holders=lambda a: forms.Holder(a.before + 1, a.anything, a.peer),
    )
    stub = connect(forms.Types, servant)
    pose = forms.Pose(1.5, -2.5)
    assert stub.booleans(True) == (False, True)
    assert stub.chars("\xe9") == ("\xe9", "\u3042")
    assert stub.octets(9, 65534) == (9, -1, 65535)
    assert stub.longs(-(2**31), -(2**63)) == (
        -(2**31),
        2**32 - 1,
        -(2**63),
        2**64 - 1,
    )
    assert stub.floats(0.5) == (0.5, 0.1)
    assert stub.strings("a\u3042", "12345") == ("A\u3042", "12345", "\u00e9" * 3)
    assert stub.prices(Decimal("12.345")) == Decimal("-12.345")
    assert stub.gears(forms.LOW) is forms.HIGH
    assert stub.structs(pose, []) == (pose, [pose], [1, 2, 3])
    assert stub.unions(forms.Either.of_number(3)) == forms.Either.of_text("odd")
    assert stub.unions(forms.Either.of_number(2)) == forms.Either.of_number(2)
    assert stub.objects(reference) == reference
    assert stub.objects(None) is None
    assert stub.lists([reference]) == [reference, None]
    assert stub.holders(forms.Holder(1, reference, None)) == (
        forms.Holder(2, None, reference)
    )


def test_exceptions(forms: Any, connect: Connect) -> None:
    raised = [
        forms.Broken("bang", 3),
        forms.Empty(),
        forms.Stopped(forms.Pose(0.0, 1.0)),
        KeyError("not declared"),
    ]

    def fail(which: int) -> int:
        if which < len(raised):
            raise raised[which]
        return which

    def fail_always() -> None:
        raise forms.Empty

    servant = serving(forms.Errors, one=fail, several=fail, repeated=fail_always)
    stub = connect(forms.Errors, servant)
    for which, expected in enumerate(raised[:3]):
        with pytest.raises(type(expected)) as caught:
            stub.several(which)
        assert caught.value == expected
    assert stub.several(4) == 4
    with pytest.raises(forms.Broken):
        stub.one(0)
    with pytest.raises(UnknownException):
        stub.one(1)  # declared by another operation only
    with pytest.raises(UnknownException):
        stub.several(3)
    with pytest.raises(forms.Empty):
        stub.repeated()


def test_attributes(forms: Any, connect: Connect) -> None:
    class Servant(forms.Attributes):  # type: ignore[misc]
        plain = 1
        fixed_pose = forms.Pose(1.0, 2.0)
        first = second = "text"
        friend = None
        broken: Exception | None = None

        @property
        def guarded(self) -> int:
            raise forms.Broken("no", 1)

        @property
        def careful(self) -> int:
            if self.broken is not None:
                raise self.broken
            return 5

        @careful.setter
        def careful(self, value: int) -> None:
            self.broken = forms.Broken("set before", value)
            raise forms.Stopped(forms.Pose(float(value), 0.0))

    servant = Servant()
    stub = connect(forms.Attributes, servant)
    stub.plain = stub.plain + 1
    assert servant.plain == stub.plain == 2
    assert stub.fixed_pose == forms.Pose(1.0, 2.0)
    with pytest.raises(AttributeError):
        stub.fixed_pose = forms.Pose()
    stub.second = "more"
    assert (stub.first, stub.second) == ("text", "more")
    with pytest.raises(forms.Broken, match="no"):
        _ = stub.guarded
    assert stub.careful == 5
    with pytest.raises(forms.Stopped):
        stub.careful = 7
    with pytest.raises(forms.Broken) as caught:
        _ = stub.careful
    assert caught.value == forms.Broken("set before", 7)
    assert stub.friend is None


def test_nobody_learns_that_a_oneway_operation_failed(
    forms: Any, connect: Connect, caplog: pytest.LogCaptureFixture
) -> None:
    received: list[object] = []

    def fail() -> None:
        raise ObjectNotExist("gone")

    servant = serving(forms.Signals, fire=lambda *x: received.append(x), tick=fail)
    stub = connect(forms.Signals, servant)
    assert stub.fire("now", forms.Pose(1.0, 2.0)) is None
    assert received == [("now", forms.Pose(1.0, 2.0))]
    with caplog.at_level(logging.WARNING, "rtgen.runtime"):
        assert stub.tick() is None
    assert "tick failed" in caplog.text
    assert "gone" in caplog.text


def test_a_context_clause_is_no_parameter(forms: Any, connect: Connect) -> None:
    stub = connect(forms.Contexts, serving(forms.Contexts, where=lambda: "here"))
    assert stub.where() == "here"
    operations = forms.Contexts._descriptor_.operations
    assert operations == ('string where() context ("ROOM", "FLOOR.*")',)


def test_inherited_operations_go_through_the_base_skeleton(
    forms: Any, connect: Connect
) -> None:
    class Servant(forms.Woven, forms.Diamond, forms.Straight):  # type: ignore[misc]
        level = 1

        def name(self) -> str:
            return "woven"

        def ground(self) -> int:
            return 1

        def port_side(self) -> int:
            return 2

        def starboard(self) -> int:
            raise forms.Broken("inherited", 3)

        def keel(self) -> int:
            return 4

        def ahead(self) -> int:
            return 5

        def weave(self) -> int:
            return 6

    own = {forms.Woven: "weave", forms.Diamond: "keel", forms.Straight: "ahead"}
    servant = Servant()
    for interface, operation in own.items():
        stub = connect(interface, servant)
        assert stub.name() == "woven"
        assert stub.ground() == 1
        assert stub.port_side() == 2
        assert getattr(stub, operation)() == getattr(servant, operation)()
        stub.level += 1
        if interface is not forms.Straight:
            with pytest.raises(forms.Broken):
                stub.starboard()
        for ancestor in (forms.Base, forms.Nameable, forms.Left):
            assert isinstance(stub, ancestor)
            assert connect(ancestor, servant).name() == "woven"
    assert servant.level == 4


def test_names_that_mean_something_in_python_or_here(
    forms: Any, connect: Connect
) -> None:
    servant = serving(
        forms.Keywords,
        from__=lambda import_: import_ + 1,
        from_=lambda: 2,
        dispatch=lambda servant: None,
        to_cdr=lambda: None,
        print=lambda *texts: len("".join(texts)),
        invoke=lambda operation, arguments: None,
        None_=3,
        property=4,
    )
    stub = connect(forms.Keywords, servant)
    assert stub.from__(1) == 2
    assert stub.from_() == 2
    assert stub.print("a", "bc") == 3
    assert stub.print(str="a", int="bc") == 3
    assert stub.dispatch(1) is stub.to_cdr() is stub.invoke(1, 2) is None
    stub.property = stub.None_
    assert servant.property == 3


def test_types_declared_inside(forms: Any, connect: Connect) -> None:
    inner = forms.MoreInner

    def step(wanted: Any) -> Any:
        if wanted is inner.OFF:
            raise inner.Refused(inner.State(inner.OFF, []))
        return inner.State(wanted, [inner.OFF] * inner.LIMIT)

    servant = serving(inner, step=step, history=lambda last: last.before)
    stub = connect(inner, servant)
    state = inner.State(inner.Mode.ON, [inner.OFF] * 3)
    assert stub.step(inner.ON) == state
    assert stub.history(state) == state.before
    with pytest.raises(forms.Inner.Refused) as caught:
        stub.step(inner.OFF)
    assert caught.value.now == inner.State(inner.OFF, [])


def test_objects_are_called_wherever_they_are(forms: Any, connect: Connect) -> None:
    class Numbered(forms.Later):  # type: ignore[misc]
        def __init__(self, number: int) -> None:
            self._number = number

        def number(self) -> int:
            return self._number

        def self(self) -> Any:
            return self

        def nobody(self, a: Any) -> Any:
            assert a is None
            return a

        def other(self, given: Any, both: Any) -> Any:
            return given, Numbered(given.back()), both

    stub = connect(forms.Later, Numbered(1))
    assert stub.number() == stub.self().number() == stub.self().self().number() == 1
    assert stub.nobody(None) is None
    given = serving(forms.Directions, back=lambda: 7)
    back, taken, both = stub.other(given, None)
    assert back.back() == taken.number() == 7
    assert both is None
    with pytest.raises(UnknownException):
        stub.other(None, None)


def test_a_local_interface_works_in_one_process(forms: Any) -> None:
    handle, later = object(), object()
    servant = serving(
        forms.Gauge, value=2.5, read=lambda source: source, take=lambda h: h
    )
    stub = direct(forms.Gauge, servant)
    assert stub.value == 2.5
    assert stub.take(handle) is handle
    assert stub.read(later) is later
    with pytest.raises(ServiceError, match="Forms::Gauge is local"):
        marshalled(forms.Gauge, servant)


@pytest.fixture
def errors(forms: Any) -> Any:
    """Return a server whose operations raise the given errors."""

    class Servant(forms.Errors):  # type: ignore[misc]
        def one(self, which: int) -> None:
            raise (forms.Broken("x" * which, which), BadOperation("inner"))[which > 1]

        def several(self, which: int) -> int:
            return 2**31 + which

        def repeated(self) -> None:
            raise forms.Broken("not declared", 1)

    return Server(forms.Errors, Servant())


def test_octets(forms: Any, errors: Any) -> None:
    broken = errors.handle("one", bytes(4))
    assert broken.status is ReplyStatus.USER_EXCEPTION
    identity = b"IDL:Forms/Broken:1.0\0"
    assert broken.body == b"".join(
        (b"\x15\0\0\0", identity, b"\0\0\0", b"\1\0\0\0\0\0\0\0", bytes(4))
    )
    unknown = errors.handle("none", b"", little_endian=False)
    assert unknown.status is ReplyStatus.SYSTEM_EXCEPTION
    identity = b"IDL:omg.org/CORBA/BAD_OPERATION:1.0\0"
    assert unknown.body == b"\0\0\0\x24" + identity + b"\0\0\0\0\0\0\0\2"
    request = calls_of(forms.Directions)["all"].request
    values = (1, 0.5, True, forms.Pose(1.0, 2.0))
    assert request(*values).to_cdr().hex(" ", 8) == (
        "0100000000000000 000000000000e03f 0100000000000000 "
        "000000000000f03f 0000000000000040"
    )


@pytest.mark.parametrize(
    ("operation", "body", "expected"),
    [
        ("one", bytes(3), MarshalError),  # truncated
        ("one", bytes(5), MarshalError),  # an octet too many
        ("one", b"\2\0\0\0", BadOperation),  # failed in the servant
        ("several", bytes(4), MarshalError),  # the result is not a long
        ("repeated", b"", UnknownException),
        ("_get_one", b"", BadOperation),
    ],
)
def test_failures_of_a_server(
    forms: Any, errors: Any, operation: str, body: bytes, expected: type[Exception]
) -> None:
    reply = errors.handle(operation, body)
    assert reply.status is ReplyStatus.SYSTEM_EXCEPTION
    client = Client(forms.Errors, lambda *_: reply)
    with pytest.raises(expected, match=r"the server reports IDL:omg\.org/CORBA/"):
        client("one", (1,))


@pytest.mark.parametrize(
    "reply",
    [
        None,
        Reply(ReplyStatus.NO_EXCEPTION, b"\0"),
        Reply(ReplyStatus.USER_EXCEPTION, b"\0\0"),
        Reply(ReplyStatus.USER_EXCEPTION, b"\xff\xff\xff\xffIDL"),
        Reply(ReplyStatus.SYSTEM_EXCEPTION, b""),
        Reply(ReplyStatus.SYSTEM_EXCEPTION, b"\2\0\0\0x\0\0\0" + b"\7" * 8),
    ],
)
def test_replies_that_cannot_be_understood(forms: Any, reply: Reply | None) -> None:
    client = Client(forms.Errors, lambda *_: reply)
    with pytest.raises(MarshalError):
        client("one", (1,))


def test_failures_of_a_client(forms: Any) -> None:
    identity = b"\x10\0\0\0IDL:Other/X:1.0\0"
    replies = {
        ReplyStatus.USER_EXCEPTION: UnknownException,
        ReplyStatus.SYSTEM_EXCEPTION: ServiceError,
    }
    for status, expected in replies.items():
        reply = Reply(status, identity + bytes(8))
        with pytest.raises(expected, match=r"IDL:Other/X:1\.0"):
            Client(forms.Errors, lambda *_, _r=reply: _r)("one", (1,))
    client = Client(forms.Errors, lambda *_: None)
    with pytest.raises(CdrError, match=r"^Errors\.one request\.which: "):
        client("one", (2**31,))
    with pytest.raises(BadOperation, match="takes 1 arguments, not 0"):
        client("one", ())
    with pytest.raises(BadOperation, match="there is no operation fly"):
        client("fly", ())
    later = Client(forms.Attributes, lambda *_: None)
    with pytest.raises(
        MarshalError, match="passes no objects, here one of Forms::Later"
    ):
        later("_set_friend", (serving(forms.Later),))


def test_a_servant_gives_all_results_or_the_call_fails(forms: Any) -> None:
    servant = serving(forms.Directions, three=lambda: (1, 2.0), back=lambda: None)
    stub = marshalled(forms.Directions, servant)
    with pytest.raises(UnknownException):
        stub.three()
    with pytest.raises(MarshalError):
        stub.back()
