"""Samples, calls, presence and control between processes, over the in-process medium."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

import pytest
from distributed_system import Process, Servant, arrived, sample
from patience import PATIENCE, until

from rtgen import runtime
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.control import ControlError
from rtgen.runtime.distribution.data import Arrivals, encoder
from rtgen.runtime.distribution.medium import (
    SEQUENCES,
    MediumError,
    NotServedError,
    Qos,
    Sample,
    representation,
)
from rtgen.runtime.distribution.names import escaped, in_topic, out_topic, unescaped
from rtgen.runtime.distribution.rpc_calls import RpcServer
from rtgen.runtime.distribution.rpc_header import Identities
from rtgen.runtime.distribution.rpc_types import interface_types, lineage_types
from rtgen.runtime.distribution.services import RemoteCalls
from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.failures import NOTE
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc, OpaqueRpcFailed
from rtgen.runtime.services.transports import RemotePort
from rtgen.runtime.system.records import Record, SampleRecord
from rtgen.runtime.xcdr import deserialize, serialize
from rtgen.tools.running.losses import Losses

Start = Callable[..., Process]


@pytest.fixture
def pair(start: Start) -> tuple[Process, Process]:
    return start("a"), start("b")


def connect(here: Process, there: Process, **properties: str) -> Any:
    """Connect a.out with b.in, as both processes do; return the receiving connector."""
    here.connect("a.out", "b.in", **properties)
    made = there.connect("a.out", "b.in", **properties)
    here.ready()
    there.ready()
    return made


# Data ports.


def test_samples_arrive_in_order(pair: tuple[Process, Process]) -> None:
    here, there = pair
    connector = connect(here, there, buffer__length="100")
    for number in range(100):
        assert here.node("a").out.write(sample(number)) is runtime.PORT_OK
    arrived(there.node("b"), [*range(100)])
    assert connector.lost == 0


@pytest.mark.parametrize("policy", ["overwrite", "do_nothing"])
def test_full_buffers_are_those_of_the_receiving_end(
    pair: tuple[Process, Process], policy: str
) -> None:
    connector = connect(*pair, buffer__length="2", buffer__write__full_policy=policy)
    for number in range(5):
        pair[0].node("a").out.write(sample(number))
    until(lambda: connector.lost == 3)
    kept = {"overwrite": [3.0, 4.0], "do_nothing": [0.0, 1.0]}[policy]
    assert pair[1].node("b").take() == kept


def test_missed_deadlines_are_in_the_report_of_a_run(
    pair: tuple[Process, Process],
) -> None:
    connector = connect(*pair, qos__deadline="0.01")
    node = pair[1].node("b")
    losses = Losses(pair[1].system)
    assert not list(losses.notes("b", runtime.ACTIVE_STATE))
    pair[0].node("a").out.write(sample(1))
    arrived(node, [1])
    until(lambda: connector.missed_deadlines > 1)
    [line] = losses.notes("b", runtime.ACTIVE_STATE)
    assert line.startswith("b.in: no sample of a.out within 0.01 s, ")
    assert line.endswith(" times: dataport.qos.deadline")


def test_a_pulled_connection_serves_late_readers(start: Start) -> None:
    here = start("a")
    here.connect("a.out", "b.in", dataflow_type="pull")
    for number in range(3):
        here.node("a").out.write(sample(number))
    there = start("b")
    there.connect("a.out", "b.in", dataflow_type="pull")
    arrived(there.node("b"), [0, 1, 2])


def test_what_is_lost_or_doubled_or_garbage_is_counted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    arrivals = Arrivals("a connection", type(sample(0)))
    octets = encoder(type(sample(0)))(sample(7))

    def take(number: int, source: str = "one", body: bytes = octets) -> Any:
        return arrivals.taken(Sample(body, source, number))

    assert take(5) == sample(7)
    assert take(6) == sample(7)
    assert take(6) is None
    assert take(9) == sample(7)
    assert take(1, "another") == sample(7)
    with caplog.at_level(logging.WARNING):
        assert take(10, body=b"\0\1\0\0garbage") is None
        assert take(11, body=b"") is None
    assert (arrivals.missed, arrivals.doubles, arrivals.invalid) == (2, 1, 2)
    assert caplog.text.count("cannot be decoded") == 1


def test_numbers_of_samples_begin_again_after_the_highest() -> None:
    arrivals = Arrivals("a connection", type(sample(0)))
    octets = encoder(type(sample(0)))(sample(7))
    for number in (SEQUENCES - 2, SEQUENCES - 1, 0, 3):
        assert arrivals.taken(Sample(octets, "one", number)) == sample(7)
    assert arrivals.taken(Sample(octets, "one", SEQUENCES - 1)) is None
    assert (arrivals.missed, arrivals.doubles) == (2, 1)


def test_programs_without_rtgen_read_and_write_ports(
    start: Start, network: Any
) -> None:
    here = start("a")
    node = here.node("a")
    medium = network.medium()
    type_ = type(sample(0))
    here.connect("a.out", "another.in", dataflow_type="pull")
    read: list[Sample] = []
    medium.subscribe(out_topic("a", "out", type_), Qos(durable=True), read.append)
    node.out.write(sample(3))
    until(lambda: read)
    assert [deserialize(type_, each.octets) for each in read] == [sample(3)]
    writer = medium.publisher(in_topic("a", "in", type_), Qos())
    until(lambda: writer.matched)
    writer.publish(encoder(type_)(sample(4)))
    arrived(node, [4])


def test_what_is_only_made_for_readers_is_sent_to_them(
    pair: tuple[Process, Process],
) -> None:
    here, there = pair
    here.ready()
    out, type_ = here.node("a").out, type(sample(0))
    recorded: list[Record] = []
    here.system.add_listener(recorded.append)
    made: list[float] = []

    def make() -> Any:
        made.append(len(made) + 1.0)
        return sample(made[-1])

    def is_made() -> bool:
        before = len(made)
        out.offer(make)
        return len(made) > before

    assert not is_made()
    seen: list[float] = []
    port = RemotePort("a", "out")
    page = there.transport.listen(port, type_, lambda value: seen.append(value.data))
    until(lambda: is_made() and seen)
    page.close()
    until(lambda: not is_made())
    assert not recorded
    connect(here, there)
    assert is_made()
    arrived(there.node("b"), made[-1:])
    assert [each.port for each in recorded if isinstance(each, SampleRecord)] == ["out"]


def test_a_foreign_sample_is_refused(pair: tuple[Process, Process]) -> None:
    connect(*pair)
    with pytest.raises(runtime.SampleTypeError):
        pair[0].node("a").out.write(object())


def test_a_moved_sample_goes_both_ways(start: Start) -> None:
    here, there = start("a", "c"), start("b")
    here.connect("a.out", "c.in")
    connect(here, there)
    here.node("a").out.write(sample(1), move=True)
    arrived(here.node("c"), [1])
    arrived(there.node("b"), [1])


# Calls.


@pytest.fixture
def called(pair: tuple[Process, Process]) -> tuple[Process, Process]:
    """Return two processes; the first calls the second one, which is ACTIVE."""
    here, there = pair
    here.connect("a.taken", "b.given")
    there.activate("b")
    here.ready()
    return here, there


def test_a_call_returns_or_raises_what_is_declared(
    called: tuple[Process, Process],
) -> None:
    rpc = called[0].node("a").consumer.object
    assert rpc.begin(b"ab", 2) == b"abab"
    with pytest.raises(OpaqueRpcFailed) as failure:
        rpc.begin(b"", 7)
    assert (failure.value.code, failure.value.reason) == (7, "nothing was given")
    rpc.end()
    assert called[1].node("b").servant.calls == ["begin", "begin", "end"]


class DerivedRpc(OpaqueRpc):
    """An interface that inherits all of its operations."""

    _descriptor_ = InterfaceDescriptor(
        "IDL:DerivedRpc:1.0", "DerivedRpc", (), (OpaqueRpc._descriptor_,)
    )


def test_a_client_of_a_base_calls_a_provider_of_a_derived_interface(
    network: Any,
) -> None:
    servant = Servant()

    def invoke(operation: str, arguments: tuple[object, ...]) -> object:
        found: object = getattr(servant, operation)(*arguments)
        return found

    media = network.medium(), network.medium()
    server = RpcServer(DerivedRpc, invoke)

    def on_request(octets: bytes, reply: Callable[[bytes], None]) -> None:
        reply(server.answer(*server.request(octets)))

    media[0].serve("b/given/rpc", lineage_types(DerivedRpc), on_request)
    for interface in (OpaqueRpc, DerivedRpc):
        calls = RemoteCalls(media[1], interface, "b/given/rpc", PATIENCE)

        def found(calls: RemoteCalls = calls) -> object:
            try:
                return calls.invoke("begin", (b"ab", 2))
            except runtime.ObjectNotExist:
                return None

        assert until(found) == b"abab"
        calls.close()


def test_a_defect_of_the_servant_is_unknown_to_the_client(
    called: tuple[Process, Process],
) -> None:
    here, there = called
    failures: list[Any] = []
    there.system.on_failure = failures.append
    with pytest.raises(runtime.UnknownException):
        here.node("a").consumer.object.begin(b"defect", 1)
    assert [type(failure.error) for failure in failures] == [KeyError]


def test_arguments_are_checked_before_they_are_sent(
    called: tuple[Process, Process],
) -> None:
    with pytest.raises(CdrError):
        called[0].node("a").consumer.object.begin(b"ab", -1)
    assert called[1].node("b").servant.calls == []


def test_a_provider_that_is_not_active_does_not_exist(
    pair: tuple[Process, Process],
) -> None:
    here, _ = pair
    here.connect("a.taken", "b.given")
    here.ready()
    with pytest.raises(runtime.ObjectNotExist):
        here.node("a").consumer.object.end()
    assert not here.transport.is_ready("a", ["b"])


def test_a_call_that_takes_too_long_times_out(start: Start, network: Any) -> None:
    there = start("b")
    there.activate("b")
    with Process(network.medium(), "a", timeout=0.2) as here:
        here.connect("a.taken", "b.given")
        until(lambda: here.transport.peers.description("b"))
        here.ready()
        rpc = here.node("a").consumer.object
        with pytest.raises(runtime.CallTimeout):
            rpc.more(1)
    there.node("b").servant.wait.set()


def test_a_process_that_dies_fails_the_call_and_is_found_again(
    called: tuple[Process, Process], start: Start
) -> None:
    here, there = called
    rpc = here.node("a").consumer.object
    raised: list[BaseException] = []

    def call() -> None:
        try:
            rpc.more(1)
        except runtime.ServiceError as error:
            raised.append(error)

    caller = threading.Thread(target=call)
    caller.start()
    until(lambda: there.node("b").servant.held.is_set())
    there.medium.close()
    caller.join()
    assert [type(error) for error in raised] == [runtime.CommunicationFailure]
    there.node("b").servant.wait.set()
    until(lambda: here.transport.peers.is_lost("b"))
    with pytest.raises(runtime.ObjectNotExist):
        rpc.end()
    again = start("b")
    again.activate("b")
    here.ready()
    assert rpc.begin(b"x", 3) == b"xxx"


def test_requests_are_carried_out_once(
    called: tuple[Process, Process], network: Any
) -> None:
    medium = network.medium()
    seen: list[str] = []
    medium.watch("b/", lambda name, present: seen.append(name))
    until(lambda: seen)
    types = interface_types(OpaqueRpc)
    client = medium.client("b/given/rpc", types)
    end = types.operations["end"]
    data = types.call(end.label, end.request(0))
    request = types.request(Identities().header(), data)
    octets = serialize(request, representation(types.request))

    def called_first() -> bytes | None:
        try:
            return client.call(octets, 10)
        except NotServedError:
            return None

    until(called_first)
    with pytest.raises(Exception, match="no reply"):
        client.call(octets, 0.001)
    with pytest.raises(MediumError):  # DDS does not even send it.
        client.call(octets[:40], 0.001)
    request = types.request(Identities().header(), types.call(0, 0))
    octets = serialize(request, representation(types.request))
    reply = deserialize(types.reply, client.call(octets, 10))
    assert reply.header.related_request_id == request.header.request_id
    assert reply.header.remote_ex.name == "REMOTE_EX_UNKNOWN_OPERATION"
    servant = called[1].node("b").servant
    until(lambda: servant.calls)
    assert servant.calls == ["end"]


# Presence.


def test_a_lost_process_is_a_lost_connection(
    pair: tuple[Process, Process], start: Start
) -> None:
    here, there = pair
    connect(here, there)
    out = here.node("a").out
    assert out.write(sample(1)) is runtime.PORT_OK
    there.medium.close()
    until(lambda: here.transport.peers.is_lost("b"))
    assert out.write(sample(2)) is runtime.PortStatus.CONNECTION_LOST
    again = start("b")
    again.connect("a.out", "b.in")
    here.ready()
    assert out.write(sample(3)) is runtime.PORT_OK
    arrived(again.node("b"), [3])


def test_a_lost_process_fails_who_needs_it_once_until_it_is_back(
    pair: tuple[Process, Process], start: Start, caplog: pytest.LogCaptureFixture
) -> None:
    here, there = pair
    state = here.system.state
    here.connect("a.out", "b.in", qos__on_loss="error")
    here.system.connect(
        ("a", "taken"), ("b", "given"), {"port.connection.on_loss": "error"}
    )
    there.connect("a.out", "b.in")
    here.ready()
    here.activate("a")
    there.medium.close()
    until(lambda: state("a") is runtime.LifeCycleState.ERROR_STATE)
    assert "b is lost" in here.system.statistics("a").reason
    ticks = here.system.statistics("a").ticks
    again = start("b")
    again.connect("a.out", "b.in")
    here.ready()
    assert state("a") is runtime.LifeCycleState.ERROR_STATE
    assert here.system.statistics("a").ticks == ticks
    assert sum(text.startswith("a: ") for text in caplog.messages) == 1
    here.system.reset("a")
    until(lambda: state("a") is runtime.LifeCycleState.INACTIVE_STATE)
    here.activate("a")
    assert here.node("a").out.write(sample(3)) is runtime.PORT_OK
    arrived(again.node("b"), [3])
    again.medium.close()
    until(lambda: state("a") is runtime.LifeCycleState.ERROR_STATE)


def test_a_lost_process_fails_nobody_who_can_do_without_it(
    pair: tuple[Process, Process],
) -> None:
    here, there = pair
    here.connect("a.out", "b.in")
    there.connect("a.out", "b.in")
    here.ready()
    here.activate("a")
    there.medium.close()
    until(lambda: here.transport.peers.is_lost("b"))
    before = here.system.statistics("a").ticks
    until(lambda: here.system.statistics("a").ticks > before + 2)
    assert here.system.state("a") is runtime.LifeCycleState.ACTIVE_STATE


@pytest.mark.parametrize("end", ["system", "transport", "killed"])
def test_a_process_that_ends_as_planned_is_not_reported_as_lost(
    pair: tuple[Process, Process],
    end: str,
    caplog: pytest.LogCaptureFixture,
) -> None:
    here, there = pair
    caplog.set_level(NOTE)
    here.ready()
    until(lambda: here.transport.peers.is_elsewhere("b"))
    is_planned = end != "killed"
    if end == "system":
        there.system.close()
    elif end == "transport":
        there.transport.close()
    else:
        there.medium.close()
    until(lambda: here.transport.peers.is_lost("b"))
    until(lambda: any("b " in text for text in caplog.messages))
    [line] = [r for r in caplog.records if r.getMessage().startswith("b ")]
    assert (line.levelno < logging.WARNING) is is_planned
    assert ("has ended" if is_planned else "is lost") in line.getMessage()


def test_who_is_missing_is_named(start: Start) -> None:
    here = start("a")
    here.connect("a.out", "b.in")
    with pytest.raises(runtime.TransportError, match=r"a.out waits for b.in"):
        here.transport.await_others(0)


def test_two_processes_do_not_run_one_instance(start: Start) -> None:
    here, _ = start("a"), start("a")
    until(lambda: here.transport.peers.is_elsewhere("a"))
    with pytest.raises(runtime.TransportError, match="runs a, too"):
        here.transport.await_others(0)


def test_ports_of_other_processes_are_checked(pair: tuple[Process, Process]) -> None:
    here, _ = pair
    here.connect("a.out", "b.nowhere")
    with pytest.raises(runtime.ConnectError, match=r"b.nowhere is not an InPort"):
        here.transport.await_others(1)


# Control.


def test_another_process_is_watched_and_steered(pair: tuple[Process, Process]) -> None:
    here, there = pair
    here.transport.await_instance("b", PATIENCE)
    with pytest.raises(runtime.TransportError, match="has nobody"):
        here.transport.await_instance("nobody", 0)
    asker = here.transport.peers.asker("b")
    assert asker.state().state == "INACTIVE_STATE"
    described = asker.describe()
    assert described.type == "Node"
    assert described.out_ports["out"].type == "RTC::TimedDouble"
    assert asker.activate() == "RTC_OK"
    there.system.run(
        10**10, lambda s: s.state("b") is runtime.LifeCycleState.ACTIVE_STATE
    )
    assert asker.state().state == "ACTIVE_STATE"
    assert asker.activate() == "PRECONDITION_NOT_MET"
    with pytest.raises(ControlError, match="no configuration parameter"):
        asker.set("speed", "1")
    assert asker.parameters().active == "default"


def test_other_processes_cannot_make_sets_without_end(
    pair: tuple[Process, Process],
) -> None:
    here, _ = pair
    here.transport.await_instance("b", PATIENCE)
    asker = here.transport.peers.asker("b")
    for number in range(63):
        asker.set("gain", "2", f"set {number}")
    with pytest.raises(ControlError, match="64 configuration sets already"):
        asker.set("gain", "2", "one more")
    asker.set("gain", "3", "set 1")


def test_workers_that_are_closed_take_nothing() -> None:
    workers = Workers()
    workers.close()
    # As many as may wait at once, and more.
    assert not any(workers.submit(lambda: None) for _ in range(2000))


def test_names_of_ports_have_any_characters() -> None:
    for text in (".positon", "a/b-c", "größe", "Motor_0"):
        part = escaped(text)
        assert part.replace("_", "").replace("-", "").isalnum()
        assert unescaped(part) == text
