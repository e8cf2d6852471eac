"""The medium within one process satisfies the contract of media."""

from __future__ import annotations

import threading

import pytest
from in_process import Network

from refrobots._idl.basic_data_type import TimedDouble
from rtgen.runtime.distribution.medium import (
    MediumError,
    NotServedError,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
    Sample,
    Topic,
)
from rtgen.runtime.distribution.rpc_header import OctetsClient, serve_octets

TOPIC = Topic("a/out", TimedDouble)


def test_a_durable_publisher_serves_late_subscriptions() -> None:
    network = Network()
    here, there = network.medium(), network.medium()
    publisher = here.publisher(TOPIC, Qos(durable=True, depth=2))
    for number in (1, 2, 3):
        publisher.publish(bytes([number]))
    late: list[Sample] = []
    there.subscribe(TOPIC, Qos(durable=True), late.append)
    assert [sample.octets for sample in late] == [b"\2", b"\3"]
    volatile: list[Sample] = []
    there.subscribe(TOPIC, Qos(), volatile.append)
    publisher.publish(b"\4")
    assert [sample.sequence for sample in late] == [2, 3, 4]
    assert [sample.sequence for sample in volatile] == [4]


def test_a_subscription_gets_no_less_than_it_asks_for() -> None:
    network = Network()
    publisher = network.medium().publisher(TOPIC, Qos(reliable=False))
    got: list[Sample] = []
    network.medium().subscribe(TOPIC, Qos(reliable=True), got.append)
    publisher.publish(b"")
    assert not publisher.matched
    assert not got


def test_calls_end_in_one_of_four_ways() -> None:
    network = Network()
    server, medium = network.medium(), network.medium()
    client = OctetsClient(medium, "a/service")
    with pytest.raises(NotServedError):
        client.call(b"x", 1)
    service = serve_octets(server, "a/service", lambda octets, reply: reply(octets * 2))
    assert client.call(b"x", 1) == b"xx"
    service.close()
    asked = threading.Event()
    serve_octets(server, "a/service", lambda octets, reply: asked.set())
    with pytest.raises(ReplyTimeoutError):
        client.call(b"x", 0.001)
    asked.clear()
    ended = threading.Thread(target=lambda: asked.wait() and server.close())
    ended.start()
    with pytest.raises(PeerLostError):
        client.call(b"x", 10)
    ended.join()


def test_presence_ends_with_the_medium() -> None:
    network = Network()
    here, there = network.medium(), network.medium()
    here.announce("instance/a/1")
    seen: list[tuple[str, bool]] = []
    there.watch("instance/", lambda name, present: seen.append((name, present)))
    here.announce("other/b")
    here.close()
    assert seen == [("instance/a/1", True), ("instance/a/1", False)]


@pytest.mark.parametrize("name", ["", "/a", "a/", "a b", "ä", "a" * 201])
def test_names_are_checked(name: str) -> None:
    with pytest.raises(MediumError):
        Network().medium().announce(name)
