"""Adapter for python-can buses: clear errors when opening, and detection of a lost bus.

python-can is imported when a bus is opened.
"""

from __future__ import annotations

import logging
import os
import select
import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import MAX_DATA, Frame

if TYPE_CHECKING:
    import can

Option: TypeAlias = bool | int | float | str

SOCKETCAND_PORT: Final = 29536
"""Default port of socketcand."""
_HELLO: Final = b"< hi >"
_PATIENCE: Final = 2.0
"""Seconds to wait for a hub's answer, and for an interface to accept a frame."""
_BUS_OFF: Final = 0x40
_RESTARTED: Final = 0x100
"""Error classes of SocketCAN."""
_SOCKETCAN_ERRORS: Final = frozenset(("socketcan", "socketcand"))


@dataclass(frozen=True)
class BusAddress:
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
        host = options.get("host", "127.0.0.1")
        port = options.get("port", SOCKETCAND_PORT)
        if not isinstance(port, int) or not 0 < port < 65536:
            raise LinkError(f"{port!r} is no port")
        return str(host), port

    def __str__(self) -> str:
        hub = self.hub
        return f"{self.interface} {self.channel}" + (
            f" at {hub[0]}:{hub[1]}" if hub else ""
        )


def bus_address(
    interface: str, channel: str, bitrate: int = 0, options: str = ""
) -> BusAddress:
    """The address in a component's parameters; options: "name=value,name=value".

    `bitrate` is in bit/s, 0 for the interface's default. Raises LinkError.
    """
    if bitrate < 0:
        raise LinkError(f"{bitrate} is no bit rate")
    found: dict[str, Option] = {}
    for part in filter(None, (part.strip() for part in options.split(","))):
        name, equals, text = (word.strip() for word in part.partition("="))
        if not equals or not name.isidentifier():
            raise LinkError(f"{part!r} is no option; options are NAME=VALUE,NAME=VALUE")
        if name in ("interface", "channel", "bitrate"):
            raise LinkError(f"{name} is a parameter of its own, and no option")
        found[name] = option(text)
    address = BusAddress(interface, channel, bitrate, tuple(sorted(found.items())))
    if not channel or not channel.isprintable():
        raise LinkError(f"{channel!r} is no channel")
    # An invalid host or port of the hub is reported here.
    str(address)
    return address


class OpenBus:
    """An open bus. Once it has failed, all methods raise LinkError.

    `on_queued` is to be called with each frame when it is queued for `send`.
    """

    def __init__(
        self,
        bus: can.BusABC,
        address: BusAddress,
        on_queued: Callable[[Frame], None] | None = None,
    ) -> None:
        self.bus = bus
        self.on_queued = on_queued
        self._address = address
        self._stream = _stream_of(bus)
        self._more = False

    def receive(self, timeout: float) -> can.Message | None:
        """The next message, None if none arrives within `timeout` s. Raises LinkError."""
        found = self.receive_some(timeout, 1)
        return found[0] if found else None

    def receive_some(self, timeout: float, most: int) -> list[can.Message]:
        """Like `receive`, but returns up to `most` messages that are already available."""
        import can

        found: list[can.Message] = []
        try:
            message = self._receive(timeout)
            while message is not None:
                found.append(message)
                if len(found) >= most:
                    break
                message = self.bus.recv(0)
                self._more = message is not None
        except (can.CanError, OSError, ValueError, LookupError) as error:
            if not found:
                raise LinkError(f"{self._address}: {_reason(error)}") from error
        return found

    def send(self, frame: Frame) -> bool:
        """Send a frame; False if the interface's queue is full. Raises LinkError."""
        import can

        try:
            self.bus.send(message_of(frame), timeout=_PATIENCE)
        except (can.CanError, OSError, ValueError) as error:
            if _is_full(error):
                return False
            raise LinkError(f"{self._address}: {_reason(error)}") from error
        return True

    def went_off(self, message: can.Message) -> bool | None:
        """Whether an error frame reports bus-off (True) or the return from bus-off (False)."""
        if self._address.interface in _SOCKETCAN_ERRORS:
            kind = message.arbitration_id
            if kind & _RESTARTED:
                return False
            return True if kind & _BUS_OFF else None
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
        return ".socketcand." not in type(bus).__module__

    def interrupt(self) -> None:
        """Interrupt a transmission that blocks another thread."""
        if self._stream is not None:
            try:
                self._stream.shutdown(socket.SHUT_RDWR)
            except OSError:
                # The other end has disconnected, so nothing blocks.
                return

    def close(self) -> None:
        """Close the bus; a disconnected other end is no error."""
        import can

        try:
            self.bus.shutdown()
        except (can.CanError, OSError):
            logging.getLogger(__name__).debug("%s: closed late", self._address)

    def _receive(self, timeout: float) -> can.Message | None:
        if self._stream is None:
            return self.bus.recv(timeout)
        if self._more:
            # python-can reads several messages at once and buffers them.
            message = self.bus.recv(0)
            if message is not None:
                return message
            self._more = False
        if not select.select([self._stream], [], [], timeout)[0]:
            return None
        # python-can's own `recv` spins when the other end has disconnected.
        if not self._stream.recv(1, socket.MSG_PEEK):
            raise LinkError("the other end has closed the connection")
        message = self.bus.recv(0)
        self._more = message is not None
        return message


def open_bus(address: BusAddress) -> OpenBus:
    """Open a bus. Raises LinkError with the reason."""
    try:
        import can
    except ImportError as error:
        raise LinkError(
            f"{address}: CAN buses need python-can: pip install 'rtgen[can]'"
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
    arguments: dict[str, Option] = dict(address.options)
    hub = address.hub
    if hub is not None:
        _check_hub(address, hub)
        arguments = {"tcp_tune": True, **arguments, "host": hub[0], "port": hub[1]}
        # Its log records are about partial messages, which are no errors, and tracebacks.
        logger = logging.getLogger("can.interfaces.socketcand.socketcand")
        if logger.level == logging.NOTSET:
            logger.setLevel(logging.CRITICAL)
    if address.bitrate:
        arguments["bitrate"] = address.bitrate
    try:
        bus = can.Bus(
            interface=address.interface,
            channel=address.channel,
            ignore_config=True,
            **arguments,  # type: ignore[arg-type]
        )
    except (
        can.CanError, OSError, ValueError, TypeError, NotImplementedError
    ) as error:  # fmt: skip
        raise LinkError(f"{address}: {_reason(error)}") from error
    return OpenBus(bus, address)


def frame_of(message: can.Message) -> Frame | None:
    """Convert a message to a frame; None if it is no frame of classical CAN."""
    if message.is_error_frame or message.is_fd or message.dlc > MAX_DATA:
        return None
    data = b"" if message.is_remote_frame else bytes(message.data)
    try:
        return Frame(
            message.arbitration_id,
            data,
            message.is_remote_frame,
            message.is_extended_id,
        )
    except ValueError:
        return None


def message_of(frame: Frame) -> can.Message:
    """Convert a frame to a message."""
    import can

    return can.Message(
        arbitration_id=frame.can_id,
        data=None if frame.remote else frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_rx=False,
        check=False,
    )


def _check_hub(address: BusAddress, hub: tuple[str, int]) -> None:
    """Check that a hub exists and has the channel: python-can would try for ten seconds."""
    try:
        with socket.create_connection(hub, _PATIENCE) as end:
            end.settimeout(_PATIENCE)
            answer = end.recv(256)
            if answer == _HELLO:
                end.sendall(f"< open {address.channel} >".encode())
                answer = end.recv(256)
    except TimeoutError as error:
        raise LinkError(f"{address}: no answer") from error
    except OSError as error:
        hint = "; is `rtgen can hub` running?" if _refused(error) else ""
        raise LinkError(f"{address}: {_reason(error)}{hint}") from error
    if answer != b"< ok >":
        said = answer.decode("ascii", "replace") or "nothing"
        raise LinkError(f"{address}: the hub says {said!r}")


def _refused(error: OSError) -> bool:
    return isinstance(error, ConnectionRefusedError)


def _stream_of(bus: can.BusABC) -> socket.socket | None:
    """The TCP connection of a bus such as `socketcand`, None if it has none."""
    for value in vars(bus).values():
        if isinstance(value, socket.socket) and value.type is socket.SOCK_STREAM:
            return value
    return None


def _is_full(error: Exception) -> bool:
    """Whether the error is temporary: the interface's queue is full (ENOBUFS, or a time-out)."""
    import errno

    code = getattr(error, "error_code", None) or getattr(error, "errno", None)
    return code in (errno.ENOBUFS, errno.EAGAIN) or "buffer full" in str(error)


def _reason(error: Exception) -> str:
    """The reason of an error, in one line."""
    number = getattr(error, "errno", None)
    text = os.strerror(number) if isinstance(number, int) else str(error)
    return " ".join(text.split()) or type(error).__name__


def option(text: str) -> Option:
    """Parse a further argument: a boolean, a number, else text."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (lambda word: int(word, 0), float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
