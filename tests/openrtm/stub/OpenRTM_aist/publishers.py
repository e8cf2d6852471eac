"""Publishers of a pushing connector: at once, by a thread, at a rate."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from .buffers import DataPortStatus, RingBuffer
from .properties import Properties

Send = Callable[[bytes], int]


class PublisherFlush:
    """A publisher whose `write` is the remote call."""

    def __init__(self, send: Send, properties: Properties) -> None:
        self._send = send

    def write(self, octets: bytes) -> int:
        return self._send(octets)

    def close(self) -> None:
        """Do nothing."""


class PublisherNew:
    """A thread sends the values that `write` puts in a buffer, by the push policy."""

    def __init__(self, send: Send, properties: Properties) -> None:
        self._send = send
        self._buffer = RingBuffer(properties.getNode("buffer"))
        self._policy = properties.getProperty("publisher.push_policy", "new")
        self._skip = int(properties.getProperty("publisher.skip_count", "0"))
        self._skipped = 0
        self._written = False
        self._status = DataPortStatus.PORT_OK
        self._wake = threading.Condition()
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def write(self, octets: bytes) -> int:
        """Store a value; BUFFER_FULL if the receiver was full the last time."""
        if self._status == DataPortStatus.CONNECTION_LOST:
            return self._status
        full = self._status == DataPortStatus.SEND_FULL
        status = self._buffer.write(octets)
        with self._wake:
            self._written = True
            self._wake.notify()
        return DataPortStatus.BUFFER_FULL if full else status

    def close(self) -> None:
        with self._wake:
            self._running = False
            self._wake.notify()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        while self._wait():
            self._push()

    def _wait(self) -> bool:
        with self._wake:
            self._wake.wait_for(lambda: not self._running or self._written)
            self._written = False
            return self._running

    def _push(self) -> None:
        if self._policy == "fifo":
            if self._send_oldest() and self._buffer.readable():
                with self._wake:
                    self._written = True
        elif self._policy == "all":
            while self._send_oldest():
                continue
        elif self._policy == "skip":
            while self._drop(self._skip - self._skipped) and self._send_oldest():
                self._skipped = 0
        else:
            self._buffer.drop(keep=1)
            self._send_oldest()

    def _drop(self, count: int) -> bool:
        """Skip values; return whether there were `count`."""
        self._skipped += self._buffer.drop(count=count)
        return self._skipped == self._skip

    def _send_oldest(self) -> bool:
        """Send a value, and remove it if it was accepted; return whether one was."""
        waiting = self._buffer.oldest()
        if waiting is None:
            return False
        self._status = self._send(waiting)
        if self._status != DataPortStatus.PORT_OK:
            return False
        self._buffer.forget(waiting)
        return True


class PublisherPeriodic(PublisherNew):
    """The same, at `publisher.push_rate` [Hz]."""

    def __init__(self, send: Send, properties: Properties) -> None:
        self._period = 1.0 / float(
            properties.getProperty("publisher.push_rate")
            or properties.getProperty("push_rate", "1000")
        )
        super().__init__(send, properties)

    def _wait(self) -> bool:
        with self._wake:
            return not self._wake.wait_for(lambda: not self._running, self._period)


PUBLISHERS: dict[str, Any] = {
    "flush": PublisherFlush,
    "block": PublisherFlush,
    "new": PublisherNew,
    "nonblock": PublisherNew,
    "periodic": PublisherPeriodic,
}
