"""Wakes a thread that waits for frames."""

from __future__ import annotations

import selectors
import socket
from typing import Final

_SELECTED: Final = 1024
"""Descriptors below this are taken by `select`, whose times are exact to a microsecond."""


class Bell:
    """Waits until a descriptor is readable or another thread rings."""

    def __init__(self, descriptor: int) -> None:
        self._heard, self._rung = socket.socketpair()
        for end in (self._heard, self._rung):
            end.setblocking(False)
        self._selector: selectors.BaseSelector | None = None
        self.join(descriptor)

    def join(self, descriptor: int) -> None:
        """Wait for this descriptor from now on."""
        self.leave()
        ends = self._heard.fileno(), descriptor
        small = max(ends) < _SELECTED
        selector = selectors.SelectSelector() if small else selectors.DefaultSelector()
        for end in ends:
            selector.register(end, selectors.EVENT_READ)
        self._selector = selector

    def leave(self) -> None:
        """Wait for nothing, before the descriptor is closed."""
        if self._selector is not None:
            self._selector.close()
            self._selector = None

    def ring(self) -> None:
        """End the wait in progress, or the next one. From any thread."""
        try:
            self._rung.send(b"\0")
        except OSError:
            return  # it has been rung very often, or is closed

    def wait(self, seconds: float) -> None:
        """Wait for at most that time, after `join`."""
        assert self._selector is not None
        for key, _ in self._selector.select(seconds):
            if key.fd == self._heard.fileno():
                self._heard.recv(4096)

    def close(self) -> None:
        """Free the sockets; nobody waits any more."""
        self.leave()
        self._heard.close()
        self._rung.close()
