"""Systems over every transport, CORBA included, by ports alone: guarantees for components."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator
from contextlib import ExitStack

import media
import pytest
from both_sides import FarProcess, Pair, near_side
from far_side import FAR, NEAR, TIMEOUT, Side, far_side, sample
from patience import PATIENCE, until

from rtgen import runtime
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.medium import MediumError, Qos
from rtgen.runtime.distribution.names import out_topic
from rtgen.runtime.opaque_rpc.interface import OpaqueRpcFailed

pytestmark = pytest.mark.waits


@pytest.fixture(params=media.TRANSPORTS, scope="module")
def kind(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def network(kind: str) -> Iterator[media.Transports]:
    with media.transports(kind) as made:
        yield made


@pytest.fixture(scope="module")
def pair(
    network: media.Transports, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Pair]:
    """Both sides, connected."""
    with ExitStack() as stack:
        if network.address is None:
            far = stack.enter_context(far_side(network.open(TIMEOUT)))
            made = stack.enter_context(near_side(network))
            far.transport.await_others(PATIENCE)
            made.near.transport.await_others(PATIENCE)
            yield made
            return
        log = tmp_path_factory.mktemp("far") / "log.txt"
        process = FarProcess(network.address, log)
        stack.callback(process.kill)
        with near_side(network) as made:
            made.near.transport.await_others(PATIENCE)
            process.ready()
            yield made
        process.close()


# Data ports.


@pytest.mark.sampled(1)
def test_samples_arrive_in_order(pair: Pair) -> None:
    statuses = {pair.write("many", number) for number in range(500)}
    assert statuses == {runtime.PORT_OK}
    assert pair.numbers("many", 500) == [*range(500)]
    assert pair.ask("lost many") == b"0"
    for number in range(100):
        assert pair.ask("write many", number) == b"PORT_OK"
    found: list[int] = []

    def came() -> bool:
        found.extend(each.tm.sec for each in pair.end.take("many"))
        return len(found) >= 100

    until(came)
    assert found == [*range(100)]


@pytest.mark.sampled(2)
def test_full_buffers_keep_what_their_policy_says(pair: Pair) -> None:
    for number in range(5):
        pair.write("few", number)
    until(lambda: pair.ask("lost oldest") == pair.ask("lost newest") == b"3")
    assert [number for number, _ in pair.taken("oldest")] == [0, 1]
    assert [number for number, _ in pair.taken("newest")] == [3, 4]


@pytest.mark.sampled(2)
def test_a_late_reader_of_a_pulled_connection_finds_what_waits(pair: Pair) -> None:
    for number in range(3):
        pair.write("pulled", number)
    assert pair.numbers("pulled", 3) == [0, 1, 2]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("megabytes", [1, 10])
def test_big_samples_arrive_whole(pair: Pair, megabytes: int) -> None:
    octets = bytes(megabytes << 20)
    # Avoid megabytes in the message of a failure.
    status = pair.write("many", 7, octets)
    assert status is runtime.PORT_OK
    found: list[tuple[int, int]] = []
    until(lambda: found.extend(pair.taken("many")) or found)
    assert found == [(7, len(octets))]


def test_what_cannot_be_decoded_is_counted_and_no_sample(pair: Pair, kind: str) -> None:
    before = int(pair.ask("lost many"))
    if kind == "dds":
        with pytest.raises(MediumError):  # cyclonedds does not even send it.
            _garble(pair, kind)
    else:
        _garble(pair, kind)
        until(lambda: int(pair.ask("lost many")) == before + 1)
    pair.write("many", 1)
    assert pair.numbers("many", 1) == [1]


def test_a_foreign_sample_is_refused(pair: Pair) -> None:
    with pytest.raises(runtime.SampleTypeError):
        pair.end.out_ports["many"].write(object())  # type: ignore[arg-type]


# Calls.


def test_a_call_returns_or_raises_what_is_declared(pair: Pair) -> None:
    assert pair.ask("echo ab", 3) == b"ababab"
    with pytest.raises(OpaqueRpcFailed) as failure:
        pair.ask("refuse why", 7)
    assert (failure.value.code, failure.value.reason) == (7, "why")


def test_a_defect_of_the_servant_is_unknown_to_the_client(pair: Pair) -> None:
    with pytest.raises(runtime.UnknownException):
        pair.ask("fail now")
    assert pair.answers()


def test_arguments_are_checked_before_they_are_sent(pair: Pair) -> None:
    with pytest.raises(CdrError):
        pair.rpc.begin(b"echo x", -1)


def test_ten_megabytes_go_both_ways(pair: Pair) -> None:
    octets = bytes(range(256)) * (10 << 12)
    assert pair.rpc.begin(b"echo " + octets, 1) == octets


def test_oneway_calls_are_carried_out_once(pair: Pair) -> None:
    for _ in range(10):
        pair.end.board.object.stop()
    until(lambda: pair.ask("counted stops") == b"10")
    assert pair.ask("counted stops") == b"10"


def test_calls_of_many_threads_get_their_own_replies(pair: Pair) -> None:
    found: list[bool] = []

    def call(thread: int) -> None:
        for number in range(25):
            text = f"{thread}.{number}"
            found.append(pair.ask(f"echo {text}", 2) == (text * 2).encode())

    threads = [threading.Thread(target=call, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 100


@pytest.mark.sampled(2)
def test_calls_wait_for_their_turn_while_ticks_are_left_out(pair: Pair) -> None:
    assert pair.ask("echo x", 1) == b"x"
    pair.ask("late")
    for _ in range(5):
        assert pair.ask("echo x", 1) == b"x"
    waits, charges = struct.unpack("<II", pair.ask("turned"))
    assert waits >= 6
    assert charges >= 5


@pytest.mark.sampled(2)
def test_a_call_that_takes_too_long_is_sent_once(
    pair: Pair, network: media.Transports
) -> None:
    with Side(network.open(0.2), "hasty") as hasty:
        hasty.system.connect(("hasty", "taken"), (FAR, "given"))
        hasty.transport.await_others(PATIENCE)
        with pytest.raises(runtime.CallTimeout):
            hasty.end.rpc.object.more(1)
    until(lambda: pair.ask("counted holds") == b"1")
    pair.ask("release")
    assert pair.answers()
    assert pair.ask("counted holds") == b"1"


def _garble(pair: Pair, kind: str) -> None:
    """Send invalid octets by the way of samples."""
    if kind != "corba":
        medium = pair.near.transport._medium
        topic = out_topic(NEAR, "many", type(sample(0)))
        publisher = medium.publisher(topic, Qos())
        until(lambda: publisher.matched)
        publisher.publish(b"\0\1\0\0garbage")
        return
    from rtgen.runtime.corba.rt_objects import wire

    exported = pair.near.transport.rt_objects.exported
    port = pair.near.transport.rt_objects.port(pair.end.out_ports["many"])
    [profile] = port.get_connector_profiles()
    ior = wire.texts(profile.properties)["dataport.corba_cdr.inport_ior"]
    status = exported.call(exported.reference(ior), wire.IN_PORT_CDR, "put", b"garbage")
    assert status is runtime.PortStatus.PORT_ERROR
