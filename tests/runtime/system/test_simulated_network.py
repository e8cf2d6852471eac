"""The network of simulated time: connections served inside `send`, refusals, ends of streams."""

from __future__ import annotations

import pytest

from rtgen.runtime import Component, RealClock, SimulatedClock, System
from rtgen.runtime.timing.simulated_network import SimulatedNetwork, Stream


class Echo:
    """A service that sends back what it receives."""

    def __init__(self) -> None:
        self.streams: list[Stream] = []

    def accept(self, stream: Stream) -> bool:
        def answer() -> None:
            if data := stream.take(1 << 20):
                stream.send(data)
            else:
                stream.close()

        self.streams.append(stream)
        stream.on_data = answer
        return True


@pytest.fixture
def network() -> SimulatedNetwork:
    return SimulatedNetwork(SimulatedClock())


def test_the_answer_is_there_when_send_returns(network: SimulatedNetwork) -> None:
    network.listen("here", Echo().accept)
    stream = network.connect("here")
    stream.send(b"one")
    stream.send(b"two")
    assert stream.receive(4) == b"onet"
    assert stream.receive(2) == b"wo"
    with pytest.raises(TimeoutError):
        stream.receive(1)
    stream.close()


def test_more_than_a_socket_holds_goes_through(network: SimulatedNetwork) -> None:
    network.listen("here", Echo().accept)
    stream = network.connect("here")
    data = bytes(range(256)) * 40_000
    stream.send(data)
    assert stream.receive(len(data)) == data
    stream.close()


def test_an_address_is_taken_once_until_it_is_free(network: SimulatedNetwork) -> None:
    with pytest.raises(ConnectionRefusedError):
        network.connect("here")
    listener = network.listen("here", Echo().accept)
    with pytest.raises(OSError, match="in use"):
        network.listen("here", Echo().accept)
    listener.close()
    listener.close()
    with pytest.raises(ConnectionRefusedError):
        network.connect("here")
    network.listen("here", Echo().accept)
    network.connect("here").close()


def test_whoever_listens_may_refuse(network: SimulatedNetwork) -> None:
    network.listen("here", lambda stream: False)
    with pytest.raises(ConnectionRefusedError):
        network.connect("here")


def test_the_end_of_a_stream_is_seen_on_both_sides(network: SimulatedNetwork) -> None:
    echo = Echo()
    network.listen("here", echo.accept)
    stream = network.connect("here")
    assert not stream.stale
    echo.streams[0].close()
    assert stream.stale
    with pytest.raises(EOFError):
        stream.receive(1)
    with pytest.raises(ConnectionError):
        stream.send(b"x")
    stream.close()
    assert stream.stale


def test_unread_bytes_make_a_stream_stale(network: SimulatedNetwork) -> None:
    network.listen("here", Echo().accept)
    stream = network.connect("here")
    stream.send(b"x")
    assert stream.stale
    stream.close()


def test_systems_in_simulated_time_have_one_network_each() -> None:
    with System(SimulatedClock()) as one, System(SimulatedClock()) as other:
        components = [Component("A0"), Component("B0"), Component("C0")]
        for system, component in zip((one, one, other), components, strict=True):
            system.add(component, 10.0)
        first, second, third = (component.network for component in components)
        assert first is second is one.clock.network
        assert third is not first


def test_in_real_time_the_machine_s_own_is_used() -> None:
    assert RealClock().network is None
