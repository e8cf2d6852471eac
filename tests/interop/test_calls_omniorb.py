"""Calls between rtgen's stubs and omniORB's servants, and the other way round."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import giop
import programs
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted

from rtgen.runtime.marshalling.octets import ObjectReference, read_reference
from rtgen.runtime.services.calls import Client, Server
from rtgen.runtime.services.servants import UnknownException

FILE = Path(__file__).with_name("calls.idl")


@pytest.fixture(scope="module")
def sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Import rtgen's package, omniORBpy's modules and its ORB."""
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    folder = tmp_path_factory.mktemp("calls_omniorb")
    command = [programs.omniidl(), "-bpython", f"-C{folder}", str(FILE)]
    subprocess.run(command, check=True, capture_output=True)
    ours = emitted.emit(tmp_path_factory.mktemp("calls"), [FILE]).peers
    # The code set is global to the process: other tests need this one.
    options = {
        "-ORBnativeCharCodeSet": "UTF-8",
        "-ORBendPoint": "giop:tcp:127.0.0.1:0",
        "-ORBverifyObjectExistsAndType": "0",
    }
    words = ["rtgen", *(word for pair in options.items() for word in pair)]
    orb = importlib.import_module("omniORB.CORBA").ORB_init(words)
    sys.path.insert(0, str(folder))
    try:
        theirs = importlib.import_module("Peers")
        skeletons = importlib.import_module("Peers__POA")
    finally:
        sys.path.remove(str(folder))
    yield SimpleNamespace(ours=ours, theirs=theirs, skeletons=skeletons, orb=orb)
    orb.destroy()


def behaviour(side: Any, notes: list[Any]) -> dict[str, Any]:
    """Return the methods of a servant, which are the same on either side."""

    def many(self: Any, a: list[Any]) -> Any:
        if not a:
            raise side.Empty
        if a[0].tag == 0:
            raise side.Broken("empty tag", 0.25)
        return [*reversed(a)], len(a) - 2**40

    def fail(self: Any) -> None:
        raise KeyError("nothing that IDL knows")

    return {
        "level": lambda self: 3,
        "all": lambda self, a, b, d, e: (
            a,
            -b,
            f"{d}",
            side.Pose(e.tag + 1, e.x / 2),
            side.HIGH,
        ),
        "many": many,
        "note": lambda self, *given: notes.append(given),
        # omniORBpy passes the context, which is empty, as a further argument.
        "where": lambda self, a, context=None: "here" * a,
        "same": lambda self, given: (given, given),
        "fail": fail,
    }


def check(side: Any, stub: Any, notes: list[Any], child: Any) -> None:
    """Call every operation of the stub."""
    assert stub.level() == 3
    number, b, c, e, f = stub.all(7, 2.5, True, side.Pose(1, 3.0))
    assert (number, b, c, e.tag, e.x, f) == (7, -2.5, "True", 2, 1.5, side.HIGH)
    poses, size = stub.many([side.Pose(1, 2.0), side.Pose(2, 4.0)])
    assert [(p.tag, p.x) for p in poses] == [(2, 4.0), (1, 2.0)]
    assert size == 2 - 2**40
    with pytest.raises(side.Empty):
        stub.many([])
    with pytest.raises(side.Broken) as caught:
        stub.many([side.Pose(0, 0.0)])
    assert (caught.value.what, caught.value.code) == ("empty tag", 0.25)
    stub.note("later", 1.5)
    assert stub.same(None) == (None, None)
    given, again = stub.same(child)
    assert given.number() == again.number() == 5
    assert notes == [("later", 1.5)]


def test_our_stub_calls_their_servant(sides: Any) -> None:
    notes: list[Any] = []
    methods = behaviour(sides.theirs, notes)
    methods |= {
        "_get_speed": lambda self: notes[-1] if notes else 1.0,
        "_set_speed": lambda self, value: notes.append(value),
        "_get_label": lambda self: "omni",
    }
    servant = type("Servant", (sides.skeletons.Probe,), methods)()
    number = {"number": lambda self: 5}
    child = type("Number", (sides.skeletons.Child,), number)()
    sides.orb.resolve_initial_references("RootPOA")._get_the_POAManager().activate()
    stub = our_stub(sides.ours.Probe, ior(sides.orb, servant))
    assert stub.speed == 1.0
    stub.speed = 0.25
    assert stub.speed == notes.pop() == 0.25
    assert stub.label == "omni"
    assert stub.where(2) == "herehere"
    with pytest.raises(UnknownException, match="CORBA/UNKNOWN"):
        stub.fail()
    check(sides.ours, stub, notes, our_stub(sides.ours.Child, ior(sides.orb, child)))


def ior(orb: Any, servant: Any) -> ObjectReference:
    text = orb.object_to_string(servant._this())
    octets = bytes.fromhex(text.removeprefix("IOR:"))
    reference, _ = read_reference(octets[4:], 0, bool(octets[0]))
    assert reference is not None
    return reference


class Objects:
    """References to objects of the other side, and their stubs."""

    def __init__(self) -> None:
        self._references: dict[int, tuple[Any, ObjectReference]] = {}

    def reference(self, interface: Any, servant: Any) -> ObjectReference:
        return self._references[id(servant)][1]

    def resolve(self, interface: Any, reference: ObjectReference) -> Any:
        client = Client(interface, giop.sender(reference), objects=self)
        stub = interface._stub_(client)
        self._references[id(stub)] = (stub, reference)
        return stub


_OBJECTS = Objects()


def our_stub(interface: Any, reference: ObjectReference) -> Any:
    return _OBJECTS.resolve(interface, reference)


def test_their_stub_calls_our_servant(sides: Any) -> None:
    notes: list[Any] = []
    methods = behaviour(sides.ours, notes)
    servant = type(
        "Servant", (sides.ours.Probe,), {**methods, "speed": 1.0, "label": "ours"}
    )()
    number = type("Number", (sides.ours.Child,), {"number": lambda self: 5})()
    handlers = {
        b"probe": Server(sides.ours.Probe, servant, objects=_OBJECTS).handle,
        b"child": Server(sides.ours.Child, number).handle,
    }
    corba = importlib.import_module("omniORB.CORBA")
    with giop.listening(handlers) as port:

        def their_stub(key: str, interface: Any) -> Any:
            text = f"corbaloc:iiop:1.2@127.0.0.1:{port}/{key}"
            return sides.orb.string_to_object(text)._narrow(interface)

        stub = their_stub("probe", sides.theirs.Probe)
        stub._set_speed(0.25)
        assert stub._get_speed() == servant.speed == 0.25
        assert stub._get_label() == "ours"
        with pytest.raises(corba.UNKNOWN):
            stub.fail()
        child = their_stub("child", sides.theirs.Child)
        check(sides.theirs, stub, notes, child)
