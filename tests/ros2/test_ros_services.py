"""Operations as services, with servers and clients of cyclonedds and Zenoh alone.

The other side uses what ROS 2 puts on the wire: names of topics and types, the header of
rmw_cyclonedds, the key expressions and attachments of rmw_zenoh.
"""

from __future__ import annotations

import importlib
import logging
import struct
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from queue import Queue
from types import ModuleType, SimpleNamespace
from typing import Any
from uuid import uuid4

import pytest
from patience import PATIENCE, until
from test_networks import DOMAIN, participant, reliable, zenoh_pair

from rtgen.cli import run as rtgen
from rtgen.compiler.kit.resources import ros_file
from rtgen.compiler.layouts.ros_types import service_hash
from rtgen.facts.ros_names import dds_type
from rtgen.ros2.rosidl import load
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    RealClock,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.ros2 import dds_ends, dds_services, services, types
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.ros2.network import RosNode, RosService
from rtgen.runtime.ros2.services import (
    RosServices,
    ServiceJoint,
    messages_of,
)
from rtgen.runtime.services.servants import (
    CallEnded,
    CallTimeout,
    ObjectNotExist,
    ServiceError,
)
from rtgen.tools.running.ros2_classes import message_classes

cyclonedds = pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

IDL = """
#include "std_srvs/srv/SetBool.idl"
#include "lab/action/Go.idl"
interface Mover {
    lab::action::Go_SendGoal_Response send(in lab::action::Go_SendGoal_Request request);
    lab::action::Go_GetResult_Response result(in lab::action::Go_GetResult_Request request);
};
interface Lamp {
    std_srvs::srv::SetBool_Response set(in std_srvs::srv::SetBool_Request request);
    std_srvs::srv::SetBool_Request twice(in std_srvs::srv::SetBool_Request request);
    boolean plainly(in boolean on);
};
"""
NAME = f"lamp_{uuid4().hex}"
"""A service name that is unique among the processes of the tests."""
REQUEST = f"rq/lab/{NAME}Request", "std_srvs::srv::dds_::SetBool_Request_"
REPLY = f"rr/lab/{NAME}Reply", "std_srvs::srv::dds_::SetBool_Response_"
CLIENT, SEQUENCE = 0x0102030405060708, 41
DONE = b"\x01\x00\x00\x00" + struct.pack("<I", 5) + b"done\x00"
"""A response: success, and its message."""


@pytest.fixture(scope="module")
def lamp(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    """Import the generated package."""
    folder = tmp_path_factory.mktemp("services")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("t.idl").write_text(IDL)
        Path("lab/action").mkdir(parents=True)
        Path("lab/action/Go.action").write_text(
            "float64 x\n---\nbool done\n---\nfloat64 left\n"
        )
        Path("rtgen.toml").write_text(
            '[sources]\npaths = ["t.idl", "lab"]\n[output]\npackage = "ros_lamp"\n'
        )
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        package = importlib.import_module("ros_lamp")
        importlib.import_module("ros_lamp.std_srvs.srv")
        return package


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def service(lamp: ModuleType) -> RosService:
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    return RosService(*messages_of(lamp.Lamp, "set"), f"/lab/{NAME}", info)


def served(lamp: ModuleType, *, active: bool = True) -> tuple[System, Any]:
    """Return a system with a provider and a consumer."""
    response = lamp.std_srvs.srv.SetBool_Response

    class Servant(lamp.Lamp):  # type: ignore[misc, name-defined]
        def set(self, request: Any) -> Any:
            return response(request.data, "done")

        def twice(self, request: Any) -> Any:
            return request

        def plainly(self, on: bool) -> bool:
            return on

    system = System(SimulatedClock())
    component = Component("Lamp0")
    component.add_provider("power", "lamp", lamp.Lamp).set_servant(Servant())
    component.add_consumer("other", "lamp", lamp.Lamp)
    system.add(component, 100.0)
    if active:
        assert system.activate("Lamp0") == RTC_OK
        system.run(20_000_000)
    return system, component


def joined(
    stack: ExitStack, network: Any, lamp: ModuleType, *, provides: bool, wait: float
) -> Any:
    """Connect the component's provider or consumer with the service."""
    system, component = served(lamp)
    stack.callback(system.close)
    ports = component.providers if provides else component.consumers
    joint = ServiceJoint(next(iter(ports.values())), "set", service(lamp))
    stack.callback(network.close)
    stack.callback(RosServices(network, [joint], wait).close)
    return component


@pytest.mark.parametrize("lifetime", [PATIENCE, 0.0])
def test_requests_before_the_first_activation(
    lamp: ModuleType,
    stack: ExitStack,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    lifetime: float,
) -> None:
    """They wait for it, not too many and not for too long; after it none does."""
    monkeypatch.setattr(services, "_EARLY_LIFETIME", lifetime)
    monkeypatch.setattr(services, "_MAX_EARLY", 3)
    system, component = served(lamp, active=False)
    stack.callback(system.close)
    servers: list[Any] = []
    network = SimpleNamespace(turns=None, serve=lambda *pair: servers.append(pair[1]))
    joint = ServiceJoint(next(iter(component.providers.values())), "set", service(lamp))
    made = RosServices(network, [joint], system=system)  # type: ignore[arg-type]
    stack.callback(made.close)
    [take] = servers
    replies: Queue[bytes] = Queue()
    request = b"\x00\x01\x00\x00\x01"

    def refusals() -> int:
        return sum("is not active, so 'set'" in each for each in caplog.messages)

    for _ in range(5 if lifetime else 3):
        take(request, replies.put)
    assert "a request waits until the component is active" in caplog.text
    until(lambda: refusals() == (2 if lifetime else 0))
    assert replies.empty()
    assert system.activate("Lamp0") == RTC_OK
    system.run(system.time + 20_000_000)
    for _ in range(3 if lifetime else 0):
        assert replies.get(timeout=PATIENCE).endswith(DONE)
    assert system.deactivate("Lamp0") == RTC_OK
    system.run(system.time + 20_000_000)
    before = refusals()
    take(request, replies.put)
    until(lambda: refusals() == before + 1)
    assert replies.empty()


def dds_network() -> Any:
    from rtgen.runtime.ros2.dds import open_dds

    return open_dds(RosNode("node", "/lab", DOMAIN))


def dds_classes() -> tuple[Any, Any]:
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import int64, uint64

    head = {"rmw_client": uint64, "rmw_sequence": int64}
    request = make_idl_struct("Req", REQUEST[1], {**head, "data": bool})
    members = {**head, "success": bool, "message": str}
    return request, make_idl_struct("Rep", REPLY[1], members)


def test_a_client_of_cyclonedds_calls(lamp: ModuleType, stack: ExitStack) -> None:
    from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
    from cyclonedds.pub import DataWriter
    from cyclonedds.qos import Policy
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    joined(stack, dds_network(), lamp, provides=True, wait=1.0)
    request, reply = dds_classes()
    part = participant()
    writer = DataWriter(part, Topic(part, REQUEST[0], request), reliable("clientid"))
    reader = DataReader(part, Topic(part, REPLY[0], reply), reliable("clientid"))
    until(writer.get_matched_subscriptions)
    until(reader.get_matched_publications)
    for number, on in enumerate((True, False)):
        writer.write(request(CLIENT, SEQUENCE + number, on))
        [found] = until(lambda: reader.take(8))
        assert (found.rmw_client, found.rmw_sequence) == (CLIENT, SEQUENCE + number)
        assert (found.success, found.message) == (on, "done")
    publications = BuiltinDataReader(part, BuiltinTopicDcpsPublication)
    own = until(lambda: [p for p in publications.take(64) if p.topic_name == REPLY[0]])
    assert own[0].type_name == REPLY[1]
    data = bytes(own[0].qos[Policy.Userdata].data)
    assert data.startswith(b"serviceid=")
    assert data.endswith(f"typehash={service(lamp).hashes[1]};".encode())


def test_a_server_of_cyclonedds_is_called(lamp: ModuleType, stack: ExitStack) -> None:
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    component = joined(stack, dds_network(), lamp, provides=False, wait=20.0)
    request, reply = dds_classes()
    part = participant()
    reader = DataReader(part, Topic(part, REQUEST[0], request), reliable("serviceid"))
    writer = DataWriter(part, Topic(part, REPLY[0], reply), reliable("serviceid"))

    def answer() -> None:
        for _ in range(2):
            for each in until(lambda: reader.take(1)):
                # One for another client, then that of the caller.
                for client in (each.rmw_client ^ 1, each.rmw_client):
                    text = "mine" if client == each.rmw_client else "other"
                    writer.write(reply(client, each.rmw_sequence, each.data, text))

    thread = threading.Thread(target=answer)
    thread.start()
    consumer = next(iter(component.consumers.values()))
    for on in (True, False):
        response = consumer.set(lamp.std_srvs.srv.SetBool_Request(on))
        assert (response.success, response.message) == (on, "mine")
    thread.join()


def test_a_client_without_the_header_is_not_served(
    lamp: ModuleType, stack: ExitStack, caplog: pytest.LogCaptureFixture
) -> None:
    """It does not say `clientid`, so its octets are not taken for a header and a request."""
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    joined(stack, dds_network(), lamp, provides=True, wait=1.0)
    request, reply = dds_classes()
    part = participant()
    known = reliable("clientid")
    writer, other = (
        DataWriter(part, Topic(part, REQUEST[0], request), qos)
        for qos in (reliable(), known)
    )
    reader = DataReader(part, Topic(part, REPLY[0], reply), known)
    for each in (writer, other):
        until(each.get_matched_subscriptions)
    until(reader.get_matched_publications)
    for number in range(3):
        writer.write(request(CLIENT, number, True))
    until(lambda: caplog.messages)
    # One that says it is served, behind anything that has come before.
    other.write(request(CLIENT, SEQUENCE, True))
    [found] = until(lambda: reader.take(8))
    assert found.rmw_sequence == SEQUENCE
    [message] = [m for m in caplog.messages if m.startswith(f"/lab/{NAME}: the client")]
    assert f"in DDS entity {writer.guid.bytes.hex()} gets no response" in message


def test_a_server_without_the_header_is_not_called(
    lamp: ModuleType,
    stack: ExitStack,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Not even beside a server that has it: a request reaches both."""
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    monkeypatch.setattr(dds_ends, "_NAME_TIMEOUT", 0.05)
    component = joined(stack, dds_network(), lamp, provides=False, wait=20.0)
    consumer = next(iter(component.consumers.values()))
    request, reply = dds_classes()
    part = participant()
    topic = Topic(part, REQUEST[0], request)
    served = DataReader(part, topic, reliable("serviceid"))
    other = DataReader(part, topic, reliable())
    writer = DataWriter(part, Topic(part, REPLY[0], reply), reliable("serviceid"))
    until(served.get_matched_publications)
    until(other.get_matched_publications)
    until(writer.get_matched_subscriptions)
    for _ in range(3):
        with pytest.raises(ServiceError, match="is not called: its middleware"):
            consumer.set(lamp.std_srvs.srv.SetBool_Request(True))
    [message] = [m for m in caplog.messages if m.startswith(f"/lab/{NAME}: the server")]
    assert f"DDS entity {other.guid.bytes.hex()}" in message
    assert not other.take(8)
    assert not served.take(8)


def test_without_a_server_of_dds(
    lamp: ModuleType, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "NAME", f"nobody_{uuid4().hex}")
    component = joined(stack, dds_network(), lamp, provides=False, wait=0.05)
    consumer = next(iter(component.consumers.values()))
    request = lamp.std_srvs.srv.SetBool_Request(True)
    with pytest.raises(ObjectNotExist, match="nobody serves /lab/nobody_"):
        consumer.set(request)
    with pytest.raises(ObjectNotExist, match="'plainly' is not a service"):
        consumer.plainly(True)


def zenoh_key(lamp: ModuleType) -> str:
    hash_ = service(lamp).type_hash
    return f"{DOMAIN}/lab/{NAME}/std_srvs::srv::dds_::SetBool_/{hash_}"


def test_a_client_of_zenoh_calls(lamp: ModuleType, stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    joined(stack, network, lamp, provides=True, wait=1.0)
    key = zenoh_key(lamp)
    gid = bytes(range(16))
    attachment = struct.pack("<qqB16s", SEQUENCE, 5, 16, gid)

    def replies() -> Any:
        options = {"payload": b"\x00\x01\x00\x00\x01", "attachment": attachment}
        return [
            r.ok
            for r in plain.get(key, target=zenoh.QueryTarget.ALL_COMPLETE, **options)
            if r.ok
        ]

    [sample] = until(replies)
    assert sample.payload.to_bytes() == b"\x00\x01\x00\x00" + DONE
    sequence, _, size, of = struct.unpack("<qqB16s", sample.attachment.to_bytes())
    assert (sequence, size, of) == (SEQUENCE, 16, gid)
    tokens = [str(reply.ok.key_expr) for reply in plain.liveliness().get("@ros2_lv/**")]
    own = [token for token in tokens if "/SS/" in token]
    assert len(own) == 1
    shown = f"%/%robot/node/%lab%{NAME}/std_srvs::srv::dds_::SetBool_/"
    assert own[0].split("/SS/")[1].startswith(f"{shown}{service(lamp).type_hash}/")


def test_garbage_has_no_reply(lamp: ModuleType, stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    joined(stack, network, lamp, provides=True, wait=1.0)
    key = zenoh_key(lamp)
    until(lambda: [t for t in plain.liveliness().get("@ros2_lv/**") if t.ok])
    attachment = struct.pack("<qqB16s", 1, 5, 16, bytes(16))
    for payload, more in (
        (b"\x00\x01\x00\x00\x01", None),
        (b"\x00\x01\x00\x00\x01", b"short"),
        (b"\x00", attachment),
        (None, attachment),
    ):
        found = plain.get(key, payload=payload, attachment=more, timeout=0.5)
        assert not [reply for reply in found if reply.ok]


def test_a_server_of_zenoh_is_called(lamp: ModuleType, stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    key = zenoh_key(lamp)
    came: list[tuple[bytes, bytes]] = []

    def answer(query: Any) -> None:
        with query:
            came.append((query.payload.to_bytes(), query.attachment.to_bytes()))
            query.reply(key, b"\x00\x01\x00\x00" + DONE, attachment=came[-1][1])

    component = joined(stack, network, lamp, provides=False, wait=1.0)
    consumer = next(iter(component.consumers.values()))
    request = lamp.std_srvs.srv.SetBool_Request(True)
    with pytest.raises((ObjectNotExist, CallTimeout)):
        consumer.set(request)
    stack.callback(plain.declare_queryable(key, answer, complete=True).undeclare)

    def called() -> Any:
        try:
            return consumer.set(request)
        except ServiceError:
            return None

    response = until(called)
    assert (response.success, response.message) == (True, "done")
    assert came[-1][0] == b"\x00\x01\x00\x00\x01"
    sequence, _, size, _ = struct.unpack("<qqB16s", came[-1][1])
    assert sequence >= 1
    assert size == 16


def test_the_hash_is_that_of_the_definitions(lamp: ModuleType) -> None:
    """`tests/ros2/rosidl` compares it with one in rmw_zenoh's document."""
    files = [
        ros_file("std_srvs/srv/SetBool.srv"),
        ros_file("service_msgs/msg/ServiceEventInfo.msg"),
    ]
    model = load(files, root=files[0].parents[2]).model
    pair = [model.find(("std_srvs", "srv", f"SetBool_{part}")) for part in PARTS]
    expected = service_hash(model, *pair)  # type: ignore[arg-type]
    assert service(lamp).type_hash == expected
    assert types.request_of(lamp.std_srvs.srv.SetBool_Response) is None


@pytest.mark.parametrize("text", ["", "a", "ab", "abc", "abcd", "abcde"])
@pytest.mark.parametrize("more", [b"", b"\x00", b"\x01", bytes(4), b"\xff" * 300])
def test_octets_after_a_message_are_ignored(
    lamp: ModuleType, text: str, more: bytes
) -> None:
    """As by ROS 2, whose middlewares fill messages up; `from_cdr` refuses them."""
    type_ = lamp.std_srvs.srv.SetBool_Response
    whole = type_(True, text)
    octets = types.encoded(whole)
    assert octets == b"\x00\x01\x00\x00" + whole.to_cdr(True)
    assert types.decoded(type_, octets + more) == whole
    big = b"\x00\x00\x00\x00" + whole.to_cdr(False)
    assert types.decoded(type_, big + more) == whole
    with pytest.raises(CdrError):
        types.decoded(type_, octets[:-1])
    if more:
        with pytest.raises(CdrError, match="octets too many"):
            type_.from_cdr(octets[4:] + more)


def test_services_of_an_action(lamp: ModuleType) -> None:
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    for operation, kind in (("send", "SendGoal"), ("result", "GetResult")):
        found = RosService(*messages_of(lamp.Mover, operation), "/go/_action/x", info)
        assert found.type_name == f"lab/action/Go_{kind}"
        assert dds_type(f"{found.type_name}_Request") == (
            f"lab::action::dds_::Go_{kind}_Request_"
        )


PARTS = ("Request", "Response")


@pytest.mark.parametrize(
    ("operation", "why"),
    [
        ("twice", "does not return std_srvs::srv::SetBool_Response"),
        ("plainly", "does not take a request of ROS 2 alone"),
        ("missing", "there is no operation Lamp::missing; known: set, twice, plainly"),
    ],
)
def test_other_operations_are_refused(
    lamp: ModuleType, operation: str, why: str
) -> None:
    with pytest.raises(ServiceError, match=why):
        messages_of(lamp.Lamp, operation)


class Waiting(Component):
    """Waits for a service in a tick; calls it again when it is deactivated."""

    profile = ComponentProfile("Waiting")

    def __init__(self, lamp: ModuleType) -> None:
        super().__init__("W0")
        self.lamp = lamp
        self.other = self.add_consumer("other", "lamp", lamp.Lamp)
        self.ended: list[str] = []

    def ask(self) -> None:
        self.other.set(self.lamp.std_srvs.srv.SetBool_Request(True))

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        try:
            self.ask()
        finally:
            self.ended.append("call")
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        try:
            self.ask()
        except CallTimeout:
            self.ended.append("deactivated")
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        self.ended.append("aborted")
        return RTC_OK


@pytest.mark.parametrize("kind", ["dds", "zenoh"])
def test_a_call_that_waits_ends_with_the_run(
    kind: str,
    lamp: ModuleType,
    stack: ExitStack,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """That is no failure: the component is deactivated, where it can still call."""
    monkeypatch.setitem(globals(), "NAME", f"silent_{uuid4().hex}")
    asked = threading.Event()
    if kind == "dds":
        network = dds_network()
        silent = dds_network()
        silent.serve(service(lamp), lambda octets, reply: asked.set())
        stack.callback(silent.close)
    else:
        network, plain, _ = zenoh_pair(stack)
        held: list[Any] = []

        def hold(query: Any) -> None:
            """Hold requests; what nobody holds ends a call."""
            if query.payload is not None and query.payload.to_bytes():
                held.append(query)
                asked.set()

        queryable = plain.declare_queryable(zenoh_key(lamp), hold, complete=True)
        stack.callback(held.clear)
        stack.callback(queryable.undeclare)
        probe = network.client(service(lamp))

        def is_known() -> bool:
            with pytest.raises(ServiceError) as raised:
                probe(b"", 1.0)
            return not isinstance(raised.value, ObjectNotExist)

        until(is_known)
    stack.callback(network.close)
    component = Waiting(lamp)
    system = System(RealClock())
    system.closing.at_halt(network.end_calls)
    joint = ServiceJoint(next(iter(component.consumers.values())), "set", service(lamp))
    long_enough = RosServices(network, [joint], PATIENCE)
    stack.callback(long_enough.close)
    system.add(component, 100.0)
    assert system.activate("W0") == RTC_OK
    system.run(system.time + 1)
    assert asked.wait(PATIENCE)
    short = RosServices(network, [joint], 0.05)
    stack.callback(short.close)
    system.close()
    assert component.ended == ["call", "deactivated"]
    assert not [r for r in caplog.records if r.levelno >= logging.ERROR]


def test_each_call_that_the_run_ends_says_so(
    lamp: ModuleType, stack: ExitStack
) -> None:
    """Zenoh ends the replies of a call before its token says that it is cancelled."""
    network, plain, _ = zenoh_pair(stack)
    stack.callback(network.close)
    asked: Queue[Any] = Queue()
    queryable = plain.declare_queryable(zenoh_key(lamp), asked.put, complete=True)
    stack.callback(queryable.undeclare)
    call = network.client(service(lamp))
    pool = stack.enter_context(ThreadPoolExecutor(1))

    def waiting() -> tuple[Any, Any]:
        """Return a call and its query, as soon as the client knows of the queryable."""
        while True:
            waits = pool.submit(call, b"", PATIENCE)
            until(lambda waits=waits: not asked.empty() or waits.done())
            if not asked.empty():
                return waits, asked.get()
            assert isinstance(waits.exception(), ObjectNotExist)

    for _ in range(200):
        # A query that nobody refers to has no reply, which ends the call.
        waits, query = waiting()
        network.end_calls()
        with pytest.raises(CallEnded):
            waits.result(PATIENCE)
        del query


SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:lamps:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Lamps:1.0.0" rts:instanceName="L0"
      rts:pathUri="localhost/L0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
MODULE = """
import ros_lamp
from ros_lamp.std_srvs.srv import SetBool_Request, SetBool_Response
from rtgen.runtime import RTC_ERROR, Component, ComponentProfile
from rtgen.runtime.services.servants import ServiceError

FOUND = []


class Servant(ros_lamp.Lamp):
    def set(self, request):
        return SetBool_Response(not request.data, "own")

    def twice(self, request):
        return request

    def plainly(self, on):
        return on


class Lamps(Component):
    profile = ComponentProfile("Lamps", rate=20.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.add_provider("power", "lamp", ros_lamp.Lamp).set_servant(Servant())
        self.other = self.add_consumer("other", "lamp", ros_lamp.Lamp)

    def on_execute(self, ec_id):
        FOUND.append(self.other.set(SetBool_Request(True)))
        return RTC_ERROR
"""
COMMAND = (
    "run",
    "s.xml",
    "--clock",
    "real",
    "--ros2",
    "dds",
    "--until",
    "L0=ERROR",
    "-q",
)


def run_lamps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, services: str
) -> tuple[int, ModuleType]:
    name = f"lamps_{tmp_path.name}"
    monkeypatch.chdir(tmp_path)
    Path(f"{name}.py").write_text(MODULE)
    Path("s.xml").write_text(SYSTEM)
    Path("rtgen.toml").write_text(
        f'[components]\nLamps = "{name}:Lamps"\n[ros2]\ndomain = {DOMAIN}\n'
        f"namespace = '{NAME}'\n[ros2.services]\n{services}\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    code = rtgen([*COMMAND])
    return code, importlib.import_module(name)


def test_of_a_system(
    lamp: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its consumer calls its provider through the service."""
    monkeypatch.syspath_prepend(Path(str(lamp.__file__)).parents[1])
    text = '"L0.power.set" = "x/set"\n"L0.other.set" = "x/set"'
    _, module = run_lamps(tmp_path, monkeypatch, text)
    [response] = module.FOUND
    assert (response.success, response.message) == (False, "own")


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ("L1.power.set", "there is no component 'L1'; known: L0"),
        ("L0.light.set", "L0 has no service port 'light'; known: power, other"),
        ("L0.power.plainly", "Lamp::plainly does not take a request of ROS 2 alone"),
    ],
)
def test_refused_before_the_start(
    entry: str,
    why: str,
    lamp: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.syspath_prepend(Path(str(lamp.__file__)).parents[1])
    code, _ = run_lamps(tmp_path, monkeypatch, f'"{entry}" = "x"')
    assert code == 2
    errors = capsys.readouterr().err
    assert "rtgen.toml:7:1: error[SYS0025]" in errors
    assert why in errors


def test_a_reply_waits_for_the_reader_of_its_client(
    lamp: ModuleType, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another client's reader, which exists already, does not belong to the request."""
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    waits = threading.Event()

    def sleep(seconds: float) -> None:
        waits.set()
        time.sleep(seconds)

    clock = SimpleNamespace(monotonic=time.monotonic, sleep=sleep)
    monkeypatch.setattr(dds_services, "time", clock)
    monkeypatch.setattr(dds_services, "_READER_TIMEOUT", PATIENCE)
    joined(stack, dds_network(), lamp, provides=True, wait=1.0)
    request, reply = dds_classes()
    part, other = participant(), participant()
    first = DataReader(other, Topic(other, REPLY[0], reply), reliable())
    until(first.get_matched_publications)
    own = reliable("clientid")
    writer = DataWriter(part, Topic(part, REQUEST[0], request), own)
    until(writer.get_matched_subscriptions)
    writer.write(request(CLIENT, SEQUENCE, True))
    # rmw_cyclonedds creates it first, but discovery keeps no order.
    assert waits.wait(PATIENCE)
    reader = DataReader(part, Topic(part, REPLY[0], reply), own)
    [found] = until(lambda: reader.take(8))
    assert (found.rmw_client, found.rmw_sequence) == (CLIENT, SEQUENCE)


@pytest.mark.parametrize("octets", [b"", b"\x00", b"\x00\x01\x00\x00", bytes(8)])
def test_messages_that_are_none(lamp: ModuleType, octets: bytes) -> None:
    with pytest.raises(CdrError):
        types.decoded(lamp.std_srvs.srv.SetBool_Response, octets)
