"""Adapter for python-can buses: clear errors on opening, and detection of a lost bus.

python-can is imported when a bus is opened.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar

import msgspec

from rtgen.facts.extras import installation
from rtgen.runtime.canopen.bus.messages import frame_of, message_of
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame

if TYPE_CHECKING:
    import can

    from rtgen.runtime.canopen.bus.socketcand_bus import SocketcandBus

_T = TypeVar("_T")
Option: TypeAlias = bool | int | float | str

Event: TypeAlias = Frame | bool | None
"""A frame, bus-off (True), the return from bus-off (False), or a message without effect."""

SOCKETCAND_PORT: Final = 29536
"""Default port of socketcand."""
_HUB_OPTIONS: Final = ("host", "port", "tcp_tune")
"""Options of socketcand; `tcp_tune` is python-can's, and has no effect here."""
_SEND_TIMEOUT: Final = 2.0
"""Time-out in seconds of sending a frame to an interface."""
_BUS_OFF: Final = 0x40
_RESTARTED: Final = 0x100
"""Error classes of SocketCAN."""
_SOCKETCAN_ERRORS: Final = frozenset(("socketcan", "socketcand"))


class BusAddress(msgspec.Struct, frozen=True, gc=False):
    """Identifies a python-can bus. `bitrate` is in bit/s, 0 for the interface's default."""

    interface: str
    channel: str
    bitrate: int = 0
    options: tuple[tuple[str, Option], ...] = ()

    @property
    def key(self) -> tuple[str, str, tuple[tuple[str, Option], ...]]:
        """The key of the bus, without its bit rate."""
        return self.interface, self.channel, self.options

    @property
    def hub(self) -> tuple[str, int] | None:
        """Host and port of the hub, for interface `socketcand`."""
        if self.interface != "socketcand":
            return None
        options = dict(self.options)
        unknown = next((name for name in options if name not in _HUB_OPTIONS), None)
        if unknown is not None:
            names = ", ".join(_HUB_OPTIONS)
            raise LinkError(f"socketcand has no option {unknown!r}; known: {names}")
        host = options.get("host", "127.0.0.1")
        port = options.get("port", SOCKETCAND_PORT)
        if not isinstance(port, int) or not 0 < port < 65536:
            raise LinkError(f"{port!r} is not a port")
        return str(host), port

    def __str__(self) -> str:
        hub = self.hub
        return f"{self.interface} {self.channel}" + (
            f" at {hub[0]}:{hub[1]}" if hub else ""
        )


def bus_address(
    interface: str, channel: str, bitrate: int = 0, options: str = ""
) -> BusAddress:
    """Parse the address in a component's parameters; options: "name=value,name=value"."""
    if bitrate < 0:
        raise LinkError(f"{bitrate} is not a bit rate")
    arguments: dict[str, Option] = {}
    for part in filter(None, (part.strip() for part in options.split(","))):
        name, equals, text = (word.strip() for word in part.partition("="))
        if not equals or not name.isidentifier():
            raise LinkError(
                f"{part!r} is not an option; options are NAME=VALUE,NAME=VALUE"
            )
        if name in ("interface", "channel", "bitrate"):
            raise LinkError(f"{name} is a parameter of its own, and no option")
        arguments[name] = option(text)
    address = BusAddress(interface, channel, bitrate, tuple(sorted(arguments.items())))
    if not channel or not channel.isprintable():
        raise LinkError(f"{channel!r} is not a channel")
    # An invalid host or port of the hub raises here.
    str(address)
    return address


class OpenBus:
    """An open bus. After a failure, all methods raise LinkError.

    `on_queued` is to be called with each frame queued for `send`.
    """

    def __init__(
        self,
        bus: can.BusABC,
        address: BusAddress,
        on_queued: Callable[[Frame], None] | None = None,
    ) -> None:
        # Imported once: at each frame it would take the time of an import.
        import can

        self.bus = bus
        self.on_queued = on_queued
        self._address = address
        self._hub = _hub_client(bus) if address.hub else None
        self._errors = (can.CanError, OSError, ValueError)

    def receive(self, timeout: float) -> can.Message | None:
        """Return the next message, None if there is none within `timeout` s. Raises LinkError."""
        messages = self.receive_some(timeout, 1)
        return messages[0] if messages else None

    def receive_some(self, timeout: float, most: int) -> list[can.Message]:
        """Like `receive`, but return up to `most` messages that are already available."""
        return self._available(self.bus.recv, timeout, most)

    def receive_events(self, timeout: float, most: int) -> list[Event]:
        """Like `receive_some`, but return only what is relevant to a link."""
        if self._hub is None:
            return [
                self._event(message) for message in self.receive_some(timeout, most)
            ]
        received = self._available(self._hub.receive, timeout, most)
        return [
            event if isinstance(event, Frame) else _bus_off(event)
            for event, _ in received
        ]

    def _available(
        self, receive: Callable[[float], _T | None], timeout: float, most: int
    ) -> list[_T]:
        """Return what comes within the time-out, and up to `most` that has come. As `receive`."""
        items: list[_T] = []
        try:
            item = receive(timeout)
            while item is not None:
                items.append(item)
                if len(items) >= most:
                    break
                item = receive(0)
        except (*self._errors, LookupError) as error:
            if not items:
                raise LinkError(f"{self._address}: {_reason(error)}") from error
        return items

    @property
    def descriptor(self) -> int | None:
        """The descriptor that is readable when frames come; None if the interface has none."""
        if self._hub is None and self._address.interface != "socketcan":
            return None
        return self.bus.fileno()

    @property
    def has_received(self) -> bool:
        """Whether frames that were read are waiting."""
        return self._hub is not None and self._hub.has_received

    def _event(self, message: can.Message) -> Event:
        if message.is_error_frame:
            return self.went_off(message)
        return frame_of(message)

    def send(self, frame: Frame) -> bool:
        """Send a frame; False if the interface's queue is full. Raises LinkError."""
        try:
            if self._hub is not None:
                self._hub.transmit(frame)
            else:
                self.bus.send(message_of(frame), timeout=_SEND_TIMEOUT)
        except self._errors as error:
            if _is_full(error):
                return False
            raise LinkError(f"{self._address}: {_reason(error)}") from error
        return True

    def went_off(self, message: can.Message) -> bool | None:
        """Return whether an error frame reports bus-off (True) or its end (False)."""
        if self._address.interface in _SOCKETCAN_ERRORS:
            return _bus_off(message.arbitration_id)
        return True if self._is_off else None

    @property
    def has_returned(self) -> bool:
        """Whether the controller reports that it is not bus-off.

        SocketCAN uses error frames instead.
        """
        return self._address.interface not in _SOCKETCAN_ERRORS and not self._is_off

    @property
    def _is_off(self) -> bool:
        import can

        try:
            return self.bus.state is can.BusState.ERROR
        except (can.CanError, NotImplementedError, OSError):
            return False

    @property
    def carries_remote_frames(self) -> bool:
        """Whether remote frames are transmitted: socketcand's protocol has none."""
        bus = getattr(self.bus, "shared_bus", self.bus)
        return "socketcand" not in type(bus).__module__

    def interrupt(self) -> None:
        """Interrupt a blocking transmission in another thread."""
        if self._hub is not None:
            self._hub.interrupt()

    def close(self) -> None:
        """Close the bus; a disconnected peer is not an error."""
        import can

        try:
            self.bus.shutdown()
        except (can.CanError, OSError):
            logging.getLogger(__name__).debug("%s: closed late", self._address)


def open_bus(address: BusAddress) -> OpenBus:
    """Open a bus. Raises LinkError with the reason."""
    try:
        import can
    except ImportError as error:
        raise LinkError(
            f"{address}: CAN buses need python-can: {installation('can')}"
        ) from error
    from can.interfaces import BACKENDS

    from rtgen.runtime.canopen.bus.canopen_network import INTERFACE, NetworkBus

    if address.interface == INTERFACE:
        try:
            network = NetworkBus(address.channel)
        except can.CanError as error:
            raise LinkError(f"{address}: {_reason(error)}") from error
        return OpenBus(network, address, network.queued)
    if address.interface not in BACKENDS:
        raise LinkError(
            f"python-can has no interface {address.interface!r}; "
            f"known: {', '.join(sorted((*BACKENDS, INTERFACE)))}"
        )
    try:
        bus = _opened(address)
    except ConnectionRefusedError as error:
        hint = "; is `rtgen can hub` running?" if address.hub else ""
        raise LinkError(f"{address}: {_reason(error)}{hint}") from error
    except (
        can.CanError, OSError, ValueError, TypeError, NotImplementedError
    ) as error:  # fmt: skip
        raise LinkError(f"{address}: {_reason(error)}") from error
    return OpenBus(bus, address)


def _opened(address: BusAddress) -> can.BusABC:
    import can

    hub = address.hub
    if hub is not None:
        from rtgen.runtime.canopen.bus.socketcand_bus import SocketcandBus

        return SocketcandBus(address.channel, *hub)
    arguments: dict[str, Option] = dict(address.options)
    if address.bitrate:
        arguments["bitrate"] = address.bitrate
    return can.Bus(
        interface=address.interface,
        channel=address.channel,
        ignore_config=True,
        **arguments,  # type: ignore[arg-type]
    )


def _hub_client(bus: can.BusABC) -> SocketcandBus | None:
    from rtgen.runtime.canopen.bus.socketcand_bus import SocketcandBus

    return bus if isinstance(bus, SocketcandBus) else None


def _bus_off(kind: int) -> bool | None:
    """Return whether an error class means bus-off (True) or its end (False)."""
    if kind & _RESTARTED:
        return False
    return True if kind & _BUS_OFF else None


def _is_full(error: Exception) -> bool:
    """Return whether the error is temporary: a full queue (ENOBUFS, or a time-out)."""
    import errno

    code = getattr(error, "error_code", None) or getattr(error, "errno", None)
    return code in (errno.ENOBUFS, errno.EAGAIN) or "buffer full" in str(error)


def _reason(error: Exception) -> str:
    """Return the reason of an error as one line."""
    number = getattr(error, "errno", None)
    text = os.strerror(number) if isinstance(number, int) else str(error)
    return " ".join(text.split()) or type(error).__name__


def option(text: str) -> Option:
    """Parse the value of an option: a boolean, a number, else text."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (lambda word: int(word, 0), float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
