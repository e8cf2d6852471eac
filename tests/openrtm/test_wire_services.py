"""Generated servants and stubs over omniORB: in one process, and between two."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from wires import Wires, stub_of, wired_text

from rtgen.runtime.services.servants import (
    BadOperation,
    CommunicationFailure,
    MarshalError,
    ObjectNotExist,
    UnknownException,
)
from rtgen.runtime.values import AnyValue

STEM = "wired_services"
IDL = """
module WiredServices {
    enum Gear { LOW, HIGH };
    struct Pose { octet tag; double x; Gear shift; };
    typedef sequence<Pose> Poses;
    typedef sequence<octet> Octets;
    typedef char Word[3];
    exception Broken { string what; Pose where; long from; };
    exception Empty {};
    interface Child { readonly attribute long number; };
    interface Base { long level(); };
    interface Probe : Base {
        enum Mode { idle, busy };
        attribute double speed;
        readonly attribute Mode doing;
        attribute Pose place;
        long all(in octet a, inout double b, out string c, in boolean d, inout Pose e, out Gear f);
        Poses many(in Poses a, out long long b) raises (Broken, Empty);
        Octets join(in Octets given, in Word three);
        any anything(in any given);
        oneway void note(in string text);
        string room(in octet a) context ("ROOM");
        Child same(in Child given, out Child again);
        Object plain(in Object given);
        long lambda(in long self, in long error, in long result);
        void fail();
        void missing();
    };
};
"""


@pytest.fixture(scope="module")
def wires(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    return wired_text(tmp_path_factory.mktemp("services"), IDL, STEM)


def wire() -> Any:
    return importlib.import_module("rtgen.runtime.openrtm.wire")


def probe(types: Any, notes: list[str]) -> Any:
    """Return a servant of rtgen."""

    class Probe(types.Probe):  # type: ignore[misc]
        speed = 1.5
        doing = types.Probe.busy
        place = types.Pose(7, 0.25, types.Gear.HIGH)

        def level(self) -> int:
            return 3

        def all(self, a: int, b: float, d: bool, e: Any) -> Any:
            return (
                a,
                -b,
                f"{d} ロボット",
                types.Pose(e.tag + 1, e.x / 2),
                types.Gear.HIGH,
            )

        def many(self, a: list[Any]) -> Any:
            if not a:
                raise types.Empty
            if a[0].tag == 0:
                raise types.Broken("leer - 空", a[0], 5)
            return [*reversed(a)], len(a) - 2**40

        def join(self, given: bytes, three: str) -> bytes:
            return given + three.encode()

        def anything(self, given: AnyValue) -> AnyValue:
            return given

        def note(self, text: str) -> None:
            notes.append(text)

        def room(self, a: int) -> str:
            return f"room {a}"

        def same(self, given: Any, again: Any = None) -> Any:
            return given, None

        def plain(self, given: Any) -> Any:
            return given

        def lambda_(self, self_: int, error: int, result: int) -> int:
            return self_ * 100 + error * 10 + result

        def fail(self) -> None:
            raise KeyError("nothing that IDL knows")

        def missing(self) -> None:
            raise NotImplementedError

    return Probe()


@pytest.fixture(scope="module")
def near(wires: Wires) -> Any:
    """Return a stub whose servant is in this process."""
    types = wires.declared(STEM)
    return SimpleNamespace(types=types, stub=stub_of(types.Probe, probe(types, [])))


SERVER = """
import sys
sys.path[:0] = {path!r}
from omniORB import CORBA
orb = CORBA.ORB_init(["server", "-ORBnativeCharCodeSet", "UTF-8",
                      "-ORBendPoint", "giop:tcp:127.0.0.1:0"])
orb.resolve_initial_references("RootPOA")._get_the_POAManager().activate()
from rtgen.runtime.openrtm import stubs
stubs.load({stubs!r}, [{stem!r}])
import test_wire_services
from rtgen.runtime.openrtm import wire
from {package}._idl import {stem} as types
servant = test_wire_services.probe(types, [])
print(orb.object_to_string(wire.objects_of(types.Probe).to(servant)), flush=True)
sys.stdin.read()
"""


@pytest.fixture(scope="module")
def far(orb: Any, wires: Wires, rtm_environment: dict[str, str]) -> Iterator[Any]:
    """Yield a stub whose servant is in another process."""
    types = wires.declared(STEM)
    folder = wires.folder.parent
    text = SERVER.format(
        path=[str(folder), *map(str, Path(__file__).parents[:2])],
        stubs=str(folder / "stubs"),
        stem=STEM,
        package=wires.package,
    )
    process = subprocess.Popen(
        [sys.executable, "-c", text],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=rtm_environment,
    )
    with process:
        assert process.stdout is not None
        reference = orb.string_to_object(process.stdout.readline().strip())
        stub = wire().stub(types.Probe, lambda: reference)
        yield SimpleNamespace(types=types, stub=stub, process=process)
        process.kill()


@pytest.fixture(params=["near", "far"])
def side(request: pytest.FixtureRequest) -> Any:
    return request.getfixturevalue(request.param)


def test_arguments_and_results(side: Any) -> None:
    types, stub = side.types, side.stub
    pose = types.Pose(1, 4.0, types.Gear.LOW)
    assert stub.all(255, 2.5, True, pose) == (
        *(255, -2.5, "True ロボット"),
        *(types.Pose(2, 2.0, types.Gear.LOW), types.Gear.HIGH),
    )
    poses = [pose, types.Pose(2, 1.0, types.Gear.HIGH)]
    assert stub.many(poses) == (poses[::-1], 2 - 2**40)
    assert stub.join(b"\0\xff", "abc") == b"\0\xffabc"
    assert stub.level() == 3
    assert stub.room(4) == "room 4"
    assert stub.lambda_(1, 2, 3) == 123
    assert stub.note("unheard") is None


def test_attributes(side: Any) -> None:
    types, stub = side.types, side.stub
    assert stub.speed == 1.5
    assert stub.doing is types.Probe.busy
    before = stub.place
    assert before == types.Pose(7, 0.25, types.Gear.HIGH)
    stub.place = types.Pose(8, 0.5, types.Gear.LOW)
    assert stub.place == types.Pose(8, 0.5, types.Gear.LOW)
    stub.place = before
    with pytest.raises(AttributeError):
        stub.doing = types.Probe.idle


def test_exceptions_of_the_definition(side: Any) -> None:
    types, stub = side.types, side.stub
    with pytest.raises(types.Empty):
        stub.many([])
    with pytest.raises(types.Broken) as caught:
        stub.many([types.Pose(0, 1.0, types.Gear.HIGH)])
    error = caught.value
    assert (error.what, error.where, error.from_) == (
        *("leer - 空", types.Pose(0, 1.0, types.Gear.HIGH)),
        5,
    )


def test_exceptions_that_derive_from_one_of_the_definition(near: Any) -> None:
    types = near.types

    class Torn(types.Broken):  # type: ignore[misc]
        pass

    class Tearing(type(probe(types, []))):  # type: ignore[misc]
        def many(self, a: list[Any]) -> Any:
            raise Torn("torn", types.Pose(), 1)

        def level(self) -> int:
            raise Torn("torn", types.Pose(), 1)

    reference = wire().objects_of(types.Probe).to(Tearing())
    stub = wire().stub(types.Probe, lambda: reference)
    with pytest.raises(types.Broken) as caught:
        stub.many([])
    assert type(caught.value) is types.Broken
    with pytest.raises(UnknownException):
        stub.level()


def test_other_errors(side: Any, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(UnknownException, match="fail: UNKNOWN"):
        side.stub.fail()
    with pytest.raises(MarshalError, match="join: BAD_PARAM"):
        side.stub.join([1, 2], "abc")
    with pytest.raises(MarshalError, match="join: BAD_PARAM"):
        side.stub.join(b"", "four")
    capfd.readouterr()


def test_values_of_any_type(side: Any) -> None:
    types, stub = side.types, side.stub
    pose = types.Pose(1, 4.0, types.Gear.HIGH)
    given = AnyValue(types.Pose, pose)
    assert stub.anything(given) == given
    assert stub.anything(AnyValue()) == AnyValue()


def test_objects(side: Any) -> None:
    types, stub = side.types, side.stub

    class Child(types.Child):  # type: ignore[misc]
        number = 12

    child = Child()
    given, again = stub.same(child)
    assert isinstance(given, types.Child)
    assert (given.number, again) == (12, None)
    returned, _ = stub.same(given)
    assert returned.number == 12
    assert stub.same(None) == (None, None)
    assert stub.plain(None) is None


def test_an_object_reference_goes_there_and_back(side: Any, orb: Any) -> None:
    octets = importlib.import_module("rtgen.runtime.openrtm.conversions").BASIC[
        "Object"
    ]
    theirs = wire().objects_of(side.types.Probe).to(side.stub)
    reference = octets.of(theirs)
    assert reference is not None
    returned = side.stub.plain(reference)
    assert octets.to(returned)._is_equivalent(theirs)


def test_without_a_provider(wires: Wires) -> None:
    stub = wire().stub(wires.declared(STEM).Probe, lambda: None)
    with pytest.raises(ObjectNotExist, match="no provider is connected"):
        stub.level()
    with pytest.raises(ObjectNotExist):
        _ = stub.speed


def test_a_deactivated_servant(wires: Wires, orb: Any) -> None:
    types = wires.declared(STEM)
    reference = wire().objects_of(types.Probe).to(probe(types, []))
    poa = orb.resolve_initial_references("RootPOA")
    poa.deactivate_object(poa.reference_to_id(reference))
    with pytest.raises(ObjectNotExist, match="level: OBJECT_NOT_EXIST"):
        wire().stub(types.Probe, lambda: reference).level()


def test_a_system_exception_of_a_servant_reaches_the_client(near: Any) -> None:
    corba = importlib.import_module("omniORB.CORBA")
    types = near.types

    class Asleep(type(probe(types, []))):  # type: ignore[misc]
        def level(self) -> int:
            raise corba.OBJECT_NOT_EXIST(0, corba.COMPLETED_NO)

        def missing(self) -> None:
            raise corba.BAD_OPERATION(0, corba.COMPLETED_NO)

    reference = wire().objects_of(types.Probe).to(Asleep())
    stub = wire().stub(types.Probe, lambda: reference)
    with pytest.raises(ObjectNotExist):
        stub.level()
    with pytest.raises(BadOperation):
        stub.missing()


def test_one_servant_has_one_reference(near: Any) -> None:
    servant = probe(near.types, [])
    objects = wire().objects_of(near.types.Probe)
    first, second = (objects.to(servant) for _ in range(2))
    assert first is second
    assert wire().objects_of(near.types.Base).of(first).level() == 3


def test_a_server_that_ended(far: Any) -> None:
    far.process.kill()
    far.process.wait()
    with pytest.raises(CommunicationFailure):
        far.stub.level()


def test_a_servant_without_conversion_is_omniorbs_own(wires: Wires, orb: Any) -> None:
    """Another author's servant, written as for OpenRTM, answers rtgen's stub."""
    skeletons = importlib.import_module("WiredServices__POA")
    theirs = importlib.import_module("WiredServices")

    class Child(skeletons.Child):  # type: ignore[misc]
        def _get_number(self) -> int:
            return 31

    reference = Child()._this()._narrow(theirs.Child)
    child = wires.declared(STEM).Child
    assert wire().stub(child, lambda: reference).number == 31
