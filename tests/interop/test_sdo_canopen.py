"""SDO client and server with the `canopen` package's, over python-can's virtual bus."""

from __future__ import annotations

import time
from collections.abc import Iterator

import can
import canopen
import pytest

from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import NO_OBJECT, SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

NODE = 5
SIZES = [1, 4, 5, 8, 889, 890, 3000]


def value_of(size: int) -> bytes:
    return bytes(i * 31 % 251 for i in range(size))


def dictionary() -> canopen.ObjectDictionary:
    objects = canopen.ObjectDictionary()
    variable = canopen.objectdictionary.ODVariable("Data", 0x2000)
    variable.data_type = canopen.objectdictionary.DOMAIN
    variable.access_type = "rw"
    objects.add_object(variable)
    return objects


class Values:
    def __init__(self) -> None:
        self.value = b"?"

    def read(self, index: int, subindex: int) -> bytes:
        if index != 0x2000:
            raise SdoAbort(NO_OBJECT)
        return self.value

    def writable_size(self, index: int, subindex: int) -> int:
        self.read(index, subindex)
        return 1 << 16

    def write(self, index: int, subindex: int, value: bytes) -> None:
        self.value = value


def frame_of(message: can.Message) -> Frame:
    return Frame(message.arbitration_id, bytes(message.data))


def send(bus: can.BusABC, frames: list[Frame]) -> None:
    for frame in frames:
        message = can.Message(
            arbitration_id=frame.can_id, data=frame.data, is_extended_id=False
        )
        bus.send(message)


@pytest.fixture
def network(request: pytest.FixtureRequest) -> Iterator[canopen.Network]:
    network = canopen.Network()
    network.NOTIFIER_CYCLE = 0.05
    network.connect(interface="virtual", channel=request.node.name)
    yield network
    network.disconnect()


@pytest.fixture
def bus(request: pytest.FixtureRequest) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=request.node.name) as bus:
        yield bus


def transfer(bus: can.BusABC, client: SdoClient, frames: list[Frame]) -> bytes:
    send(bus, frames)
    while client.busy:
        message = bus.recv(0.05)
        now = time.monotonic_ns()
        if message is not None:
            send(bus, client.receive(frame_of(message), now))
        send(bus, client.poll(now))
    return client.result()


@pytest.mark.parametrize("size", SIZES)
def test_client_against_canopen(
    network: canopen.Network, bus: can.BusABC, size: int
) -> None:
    """Its server does not support block transfer: it answers a block upload by a segmented one."""
    node = network.create_node(NODE, dictionary())
    client, value = SdoClient(NODE), value_of(size)
    started = client.download(0x2000, 0, value, time.monotonic_ns())
    assert transfer(bus, client, started) == b""
    assert node.data_store[0x2000][0] == value
    for block in (False, True):
        started = client.upload(0x2000, 0, time.monotonic_ns(), block=block)
        assert transfer(bus, client, started) == value


def test_aborts_of_canopen(network: canopen.Network, bus: can.BusABC) -> None:
    network.create_node(NODE, dictionary())
    client = SdoClient(NODE)
    with pytest.raises(SdoAbort, match="06020000h"):
        transfer(bus, client, client.upload(0x3000, 0, time.monotonic_ns()))
    started = client.download(0x2000, 0, b"abc", time.monotonic_ns(), block=True)
    with pytest.raises(SdoAbort, match="05040001h"):
        transfer(bus, client, started)


@pytest.fixture
def served(bus: can.BusABC) -> Iterator[Values]:
    values = Values()
    server = SdoServer(NODE, values)

    def answer(message: can.Message) -> None:
        send(bus, server.receive(frame_of(message), time.monotonic_ns()))

    notifier = can.Notifier(bus, [answer], timeout=0.05)
    yield values
    notifier.stop()


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize("size", SIZES)
def test_server_against_canopen(
    network: canopen.Network, served: Values, size: int, block: bool
) -> None:
    node = network.add_node(NODE, dictionary())
    node.sdo.RESPONSE_TIMEOUT = 5.0
    value = value_of(size)
    with node.sdo.open(
        0x2000, 0, mode="wb", size=size, block_transfer=block, buffering=1024
    ) as stream:
        stream.write(value)
    assert served.value == value
    with node.sdo.open(0x2000, 0, mode="rb", block_transfer=block) as stream:
        assert stream.read() == value


def test_aborts_for_canopen(network: canopen.Network, served: Values) -> None:
    node = network.add_node(NODE, dictionary())
    node.sdo.RESPONSE_TIMEOUT = 5.0
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        node.sdo.upload(0x3000, 0)
    assert aborted.value.code == NO_OBJECT
