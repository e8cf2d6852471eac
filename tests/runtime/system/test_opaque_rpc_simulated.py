"""OpaqueRPC in simulated time: channel and server on one network, without waiting."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_OBJ,
    E_TMOUT,
    ChannelError,
    Handlers,
    More,
    SimulatedChannel,
    SimulatedServer,
)
from rtgen.runtime.timing.clocks import SimulatedClock
from rtgen.runtime.timing.simulated_network import SimulatedNetwork

HERE = "127.0.0.1:8931"
ECHO = bytes.fromhex("672a 0001")
TELL = bytes.fromhex("672a 0002")
FAIL = bytes.fromhex("672a 0003")


class Service:
    """Three functions of one byte: one with a reply, one without, one that fails."""

    def __init__(self) -> None:
        self.calls: list[bytes] = []

    @property
    def handlers(self) -> Handlers:
        return {ECHO: self.echo, TELL: self.tell, FAIL: self.fail}

    def echo(self, more: More) -> bytes:
        self.calls.append(more(1))
        return b"<" + self.calls[-1] + b">"

    def tell(self, more: More) -> None:
        self.calls.append(more(1))

    def fail(self, more: More) -> bytes:
        raise RuntimeError("no wheels")


@pytest.fixture
def network() -> SimulatedNetwork:
    return SimulatedNetwork(SimulatedClock())


@pytest.fixture
def service(network: SimulatedNetwork) -> Iterator[Service]:
    service = Service()
    server = SimulatedServer(network, HERE, service, allocator_size=64)
    yield service
    server.close()


@pytest.fixture
def channel(network: SimulatedNetwork, service: Service) -> Iterator[SimulatedChannel]:
    channel = SimulatedChannel(network, HERE)
    yield channel
    channel.close()


def fails(call: Callable[[], object]) -> int:
    with pytest.raises(ChannelError) as caught:
        call()
    return caught.value.sub


def test_calls_with_and_without_a_reply(
    channel: SimulatedChannel, service: Service
) -> None:
    assert channel.begin(ECHO + b"1", 2) + channel.more(1) == b"<1>"
    channel.end()
    assert channel.begin(TELL + b"2", 0) == b""
    channel.end()
    assert channel.begin(ECHO + b"3" + ECHO + b"4", 6) == b"<3><4>"
    channel.end()
    assert service.calls == [b"1", b"2", b"3", b"4"]


def test_a_call_keeps_the_channel_until_its_end(channel: SimulatedChannel) -> None:
    channel.begin(ECHO + b"1", 1)
    assert fails(lambda: channel.begin(ECHO + b"2", 1)) == E_TMOUT
    assert channel.more(2) == b"1>"
    channel.end()
    channel.begin(TELL + b"2", 0)


def test_nobody_listens(network: SimulatedNetwork) -> None:
    channel = SimulatedChannel(network, HERE)
    assert fails(lambda: channel.begin(ECHO + b"1", 3)) == E_OBJ
    server = SimulatedServer(network, HERE, Service())
    assert channel.begin(ECHO + b"1", 3) == b"<1>"
    channel.end()
    server.close()
    assert fails(lambda: channel.begin(ECHO + b"1", 3)) == E_OBJ


def test_one_connection_at_a_time(
    channel: SimulatedChannel, network: SimulatedNetwork
) -> None:
    channel.begin(TELL + b"1", 0)
    channel.end()
    other = SimulatedChannel(network, HERE)
    assert fails(lambda: other.begin(TELL + b"2", 0)) == E_OBJ
    channel.close()
    assert other.begin(ECHO + b"2", 3) == b"<2>"
    other.close()


@pytest.mark.parametrize(
    "packet", [b"\x00", bytes.fromhex("672a 0063"), FAIL + b"1", bytes(100)]
)
def test_an_error_ends_the_connection_without_a_reply(
    channel: SimulatedChannel, service: Service, packet: bytes
) -> None:
    assert fails(lambda: channel.begin(packet, 1)) == E_BOVR
    assert channel.begin(ECHO + b"1", 3) == b"<1>"
    channel.end()
    assert service.calls == [b"1"]


@pytest.mark.parametrize("cut", range(1, 5))
def test_half_a_request_is_never_executed(
    channel: SimulatedChannel, service: Service, cut: int
) -> None:
    assert fails(lambda: channel.begin((ECHO + b"1")[:cut], 1)) == E_BOVR
    assert service.calls == []


def test_no_answer_is_reported_at_once(
    channel: SimulatedChannel, service: Service
) -> None:
    assert fails(lambda: channel.begin(TELL + b"1", 1)) == E_TMOUT
    assert channel.begin(ECHO + b"2", 3) == b"<2>"
    channel.end()
    assert service.calls == [b"1", b"2"]


def test_a_late_rest_is_never_taken_for_an_answer(channel: SimulatedChannel) -> None:
    assert channel.begin(ECHO + b"1", 2) == b"<1"
    channel.end()
    assert channel.begin(ECHO + b"2", 3) == b"<2>"
    channel.end()


def test_a_server_that_closes_in_a_call(network: SimulatedNetwork) -> None:
    class Leaving(Service):
        def echo(self, more: More) -> bytes:
            server.close()
            return super().echo(more)

    service = Leaving()
    server = SimulatedServer(network, HERE, service)
    channel = SimulatedChannel(network, HERE)
    assert fails(lambda: channel.begin(ECHO + b"1", 3)) in (E_BOVR, E_OBJ)
    assert fails(lambda: channel.begin(ECHO + b"2", 3)) == E_OBJ
    assert service.calls == [b"1"]
