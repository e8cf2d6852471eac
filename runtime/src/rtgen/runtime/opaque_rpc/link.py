"""A channel with settings that can change, for the communication RTC."""

from __future__ import annotations

import logging
import threading
from typing import TYPE_CHECKING, Protocol

import msgspec

from rtgen.facts.opaque_rpc import FIRST_PORT, TIMEOUT
from rtgen.runtime.opaque_rpc.channel import Channel
from rtgen.runtime.opaque_rpc.ends import checked_timeout
from rtgen.runtime.opaque_rpc.errors import E_NOEXS, E_TMOUT, ChannelError
from rtgen.runtime.timing.stepping_aside import step_aside

if TYPE_CHECKING:
    from rtgen.runtime.timing.simulated_network import SimulatedNetwork

log = logging.getLogger("rtgen.runtime.opaque_rpc")

NONE = "none"
"""Value of an unused parameter, because OpenRTM cannot bind empty texts."""
_SERIAL = ("SERIA", "SERIAL")
_TCP = "TCP"
_FASTEST = 100_000_000


class ClosableChannel(Channel, Protocol):
    """A channel that can be closed and replaced."""

    def close(self) -> None:
        """Close the connection."""


class LinkSettings(msgspec.Struct, gc=False):
    """The configuration of a communication RTC, as texts; `timeout` in seconds.

    `type` is `TCP`, or `SERIA` (`SERIAL`) for a serial line, whose device is `port`. `tap` is the
    local address or network interface to use.
    """

    type: str = _TCP
    ipaddr: str = "127.0.0.1"
    port: str = str(FIRST_PORT)
    baudrate: str = NONE
    tap: str = NONE
    timeout: float = TIMEOUT

    @property
    def is_serial(self) -> bool:
        """Whether the board is at a serial line. Raises ValueError for an unknown type."""
        if self.type not in (*_SERIAL, _TCP):
            raise ValueError(f"type is {self.type!r}: it is SERIA (or SERIAL) or TCP")
        return self.type in _SERIAL

    def open(self, network: SimulatedNetwork | None = None) -> ClosableChannel:
        """Return the channel; in simulated time, of the system's network. Raises ValueError."""
        checked_timeout(self.timeout)
        place = self._device() if self.is_serial else self._address()
        if network is not None:
            from rtgen.runtime.opaque_rpc.simulated import SimulatedChannel

            return SimulatedChannel(network, place)
        if self.is_serial:
            from rtgen.runtime.opaque_rpc.serial import SerialChannel

            baudrate = _number("baudrate", self.baudrate, _FASTEST)
            return SerialChannel(place, baudrate, self.timeout)
        from rtgen.runtime.opaque_rpc.tcp_channel import TcpChannel

        port = _number("port", self.port, 65535)
        bind = "" if self.tap == NONE else self.tap
        return TcpChannel(self.ipaddr, port, self.timeout, bind)

    def _device(self) -> str:
        if self.port in ("", NONE):
            raise ValueError("port names no device")
        return self.port

    def _address(self) -> str:
        if self.ipaddr in ("", NONE):
            raise ValueError("ipaddr names no address")
        return f"{self.ipaddr}:{_number('port', self.port, 65535)}"


def _number(name: str, text: str, most: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 12):
        raise ValueError(f"{name} is {text!r}: it is a number")
    if not 0 < int(text) <= most:
        raise ValueError(f"{name} is {text}: it is at most {most}, and above 0")
    return int(text)


class Link:
    """A channel that follows changes of its settings. See `Channel`.

    A change waits for the end of the current call; the next call reconnects.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._settings: LinkSettings | None = None
        self._change = threading.Lock()
        self._next_channel: ClosableChannel | None = None
        self._channel: ClosableChannel | None = None

    def use(
        self, settings: LinkSettings, network: SimulatedNetwork | None = None
    ) -> None:
        """Apply these settings. Raises ValueError if they describe no channel."""
        if settings == self._settings:
            return
        channel = settings.open(network)
        with self._change:
            self._next_channel = channel
        self._settings = settings
        if self._lock.acquire(blocking=False):
            self._release()

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`. Waits for the current call, at most as long as a call may take."""
        step_aside()
        settings = self._settings
        seconds = 0.0 if settings is None else settings.timeout
        if not self._lock.acquire(timeout=seconds):
            raise ChannelError(E_TMOUT, "in use by another call")
        try:
            return self._chosen().begin(request, first)
        except BaseException:
            self._release()
            raise

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        return self._open().more(n)

    def end(self) -> None:
        """See `Channel`."""
        try:
            self._open().end()
        finally:
            self._release()

    def reset(self) -> None:
        """See `Channel`."""
        try:
            self._open().reset()
        finally:
            self._release()

    def close(self) -> None:
        """Close the connection after the current call; a later call reconnects."""
        channel = self._channel
        if channel is not None:
            channel.close()

    def _open(self) -> ClosableChannel:
        if self._channel is None or not self._lock.locked():
            raise ChannelError(E_NOEXS, "no call is under way")
        return self._channel

    def _chosen(self) -> ClosableChannel:
        """Return the channel for the latest settings; the lock must be held."""
        with self._change:
            channel, self._next_channel = self._next_channel, None
        if channel is not None:
            old, self._channel = self._channel, channel
            if old is not None:
                old.close()
                log.info("the channel is %s now", self._channel)
        if self._channel is None:
            raise ChannelError(E_NOEXS, "the channel has no settings yet")
        return self._channel

    def _release(self) -> None:
        """Free the channel, and apply the latest settings."""
        try:
            if self._next_channel is not None:
                self._chosen()
        finally:
            self._lock.release()
