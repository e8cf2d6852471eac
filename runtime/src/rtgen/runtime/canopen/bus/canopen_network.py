"""A bridge to programs of the package `canopen`, in both directions.

A program that has a `canopen.Network` shares it under a name; components with the parameters
`interface=canopen` and `channel=NAME` then use its bus instead of one of their own (`shared`). The
program's own nodes get the typed objects of a generated class (`typed`). Needs python-can;
`canopen` itself is imported by the program.
"""

from __future__ import annotations

import copy
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

import can

from rtgen.runtime.canopen.objects import O, over_service
from rtgen.runtime.canopen.wire.frames import (
    SDO_REQUEST,
    SDO_RESPONSE,
    SECOND,
    Frame,
)
from rtgen.runtime.failures import log
from rtgen.runtime.timing.steady import steady_utc

if TYPE_CHECKING:
    import canopen

INTERFACE: Final = "canopen"
"""The parameter `interface` of components on a shared network."""

_NODES: Final = range(1, 128)
_SDO_ANSWERS: Final = frozenset(SDO_RESPONSE + node for node in _NODES)


class _Registry:
    """The shared networks of the process by name."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._networks: dict[str, canopen.Network] = {}

    def add(self, name: str, network: canopen.Network) -> None:
        with self._lock:
            if name in self._networks:
                raise ValueError(f"a network is shared as {name!r} already")
            if any(other is network for other in self._networks.values()):
                raise ValueError("this network is shared already, by another name")
            self._networks[name] = network

    def remove(self, name: str) -> None:
        with self._lock:
            del self._networks[name]

    def get(self, name: str) -> canopen.Network | None:
        with self._lock:
            return self._networks.get(name)


_REGISTRY: Final = _Registry()


@contextmanager
def shared(network: canopen.Network, name: str = "can0") -> Iterator[None]:
    """Share a network as the channel `name` of the interface `canopen`.

    Components can join it once it is connected. To them, a disconnected network is a lost bus,
    until it is connected again. It belongs to its program: components never close it. Raises
    ValueError if the name is taken, or the network is already shared.
    """
    _REGISTRY.add(name, network)
    try:
        yield
    finally:
        _REGISTRY.remove(name)


def typed(class_: type[O], node: canopen.RemoteNode | canopen.LocalNode) -> O:
    """Access the objects of a node of the package by a generated `<Module>Objects`.

    Those of a `RemoteNode` are read and written by its SDO client, those of a `LocalNode` in its
    own dictionary. Raises the exceptions of `canopen` (SdoAbortedError, SdoCommunicationError), and
    ObjectValueError for a value that is invalid for an object, or octets that are none of it.
    """
    return over_service(class_, _Dictionary(node))


class _Dictionary:
    """The objects of a node as octets, as by the service of a proxy."""

    def __init__(self, node: canopen.RemoteNode | canopen.LocalNode) -> None:
        self._sdo = node.sdo

    def read(self, index: int, subindex: int, /) -> bytes:
        return bytes(self._sdo.upload(index, subindex))

    def write(self, index: int, subindex: int, value: bytes, /) -> None:
        self._sdo.download(index, subindex, value)


class NetworkBus(can.BusABC):
    """The bus of a shared network as a python-can bus.

    Frames sent through it reach the callbacks of the network, too, and frames sent by the network
    are received here, including periodic messages that python-can sends from a thread. Responses to
    SDO requests of the network are withheld: a client without a request would count them as those
    of a second client. Raises CanError if the network is not shared or not connected.
    """

    def __init__(self, name: str) -> None:
        network = _REGISTRY.get(name)
        if network is None:
            raise can.CanInitializationError(
                f"no canopen.Network is shared as {name!r}; "
                "use rtgen.runtime.canopen.bus.canopen_network.shared"
            )
        bus, notifier = network.bus, network.notifier
        # While the network connects, its notifier is still that of the previous bus.
        if bus is None or notifier is None or not _notifies_of(notifier, bus):
            raise can.CanInitializationError("the network is not connected")
        super().__init__(channel=name)
        self.channel_info = f"canopen.Network {name}"
        self.shared_bus = bus
        """The bus of the network itself."""
        self._name = name
        self._network = network
        self._notifier = notifier
        self._received: SimpleQueue[can.Message] = SimpleQueue()
        self._requested: set[int] = set()
        """Nodes whose last SDO request came from the network."""
        self._own_send: Any = vars(bus).get("send")
        self._send = bus.send
        self._hook = self._sent_by_network
        vars(bus)["send"] = self._hook
        self._listener = _Listener(self)
        notifier.add_listener(self._listener)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """See `can.BusABC`. Exceptions of the network's callbacks are logged."""
        self._check()
        with self._network.send_lock:
            self._send(msg, timeout)
        self._requested.discard(msg.arbitration_id - SDO_REQUEST)
        if not (msg.is_remote_frame or msg.arbitration_id in _SDO_ANSWERS):
            self._notify(msg.arbitration_id, msg.data)

    def queued(self, frame: Frame) -> None:
        """Notify the network of an SDO response that is about to be sent.

        The client gets it at the same time: later, the network would take it for the response to a
        request made since.
        """
        if frame.can_id in _SDO_ANSWERS:
            self._notify(frame.can_id, frame.data)

    def _notify(self, can_id: int, data: bytes | bytearray) -> None:
        try:
            self._network.notify(can_id, bytearray(data), steady_utc() / SECOND)
        except Exception:  # as in python-can's notifier
            log.exception("a callback of the canopen.Network %s failed", self._name)

    def _sent_by_network(self, msg: can.Message, timeout: float | None = None) -> None:
        node = msg.arbitration_id - SDO_REQUEST
        if node in _NODES and not msg.is_extended_id:
            self._requested.add(node)
        self._send(msg, timeout)
        self._received.put(copy.deepcopy(msg))

    def take(self, message: can.Message) -> None:
        """Process a message received by the network's notifier."""
        if message.arbitration_id - SDO_RESPONSE not in self._requested:
            self._received.put(message)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            return self._received.get(timeout != 0, timeout), True
        except Empty:
            self._check()
            return None, True

    def _check(self) -> None:
        if _REGISTRY.get(self._name) is not self._network:
            raise can.CanOperationError("the network is not shared any more")
        if self._network.bus is not self.shared_bus:
            raise can.CanOperationError("the network was disconnected")
        if self._notifier.exception is not None:
            raise can.CanOperationError(str(self._notifier.exception))

    @property
    def state(self) -> can.BusState:
        """See `can.BusABC`."""
        return self.shared_bus.state

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        self.shared_bus.state = new_state

    def shutdown(self) -> None:
        """Leave the network, whose bus stays open."""
        super().shutdown()
        if self._listener in self._notifier.listeners:
            self._notifier.remove_listener(self._listener)
        attributes = vars(self.shared_bus)
        if attributes.get("send") is self._hook:
            if self._own_send is None:
                del attributes["send"]
            else:
                attributes["send"] = self._own_send


def _notifies_of(notifier: can.Notifier, bus: can.BusABC) -> bool:
    """Return whether a notifier receives from a bus."""
    buses = notifier.bus
    return bus in (buses if isinstance(buses, list | tuple) else (buses,))


class _Listener(can.Listener):
    def __init__(self, bus: NetworkBus) -> None:
        self._bus = bus

    def on_message_received(self, msg: can.Message) -> None:
        self._bus.take(msg)

    def stop(self) -> None:
        """Called when the network is disconnected, which `NetworkBus` detects itself."""
