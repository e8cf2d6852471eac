"""When a pushing connector sends what was written: at once, from a thread, at a rate."""

from __future__ import annotations

import threading
from collections.abc import Callable

from .buffers import DataPortStatus, RingBuffer
from .properties import Properties

Send = Callable[[bytes], int]


class PublisherFlush:
    """`write` is the remote call."""

    def __init__(self, send: Send, properties: Properties) -> None:
        self._send = send

    def write(self, octets: bytes) -> int:
        return self._send(octets)

    def close(self) -> None:
        """There is nothing to end."""


class PublisherNew:
    """A thread sends what `write` left in a buffer, by the push policy."""

    def __init__(self, send: Send, properties: Properties) -> None:
        self._send = send
        self._buffer = RingBuffer(properties.getNode("buffer"))
        self._policy = properties.getProperty("publisher.push_policy", "new")
        self._skip = int(properties.getProperty("publisher.skip_count", "0"))
        self._skipped = self._skip
        self._status = DataPortStatus.PORT_OK
        self._wake = threading.Condition()
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def write(self, octets: bytes) -> int:
        if self._status == DataPortStatus.CONNECTION_LOST:
            return self._status
        status = self._buffer.write(octets)
        with self._wake:
            self._wake.notify()
        return status

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
            self._wake.wait_for(lambda: not self._running or self._buffer.readable())
            return self._running

    def _push(self) -> None:
        for octets in self._due():
            status = self._send(octets)
            if status == DataPortStatus.CONNECTION_LOST:
                self._status = status
                return

    def _due(self) -> list[bytes]:
        if self._policy == "fifo":
            status, octets = self._buffer.read()
            return [octets] if status == DataPortStatus.PORT_OK else []
        written = self._buffer.take()
        if self._policy == "all":
            return written
        if self._policy == "skip":
            return [octets for octets in written if self._not_skipped()]
        return written[-1:]

    def _not_skipped(self) -> bool:
        self._skipped = (self._skipped + 1) % (self._skip + 1)
        return self._skipped == 0


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

    def _due(self) -> list[bytes]:
        return super()._due() if self._buffer.readable() else []


PUBLISHERS = {
    "flush": PublisherFlush,
    "block": PublisherFlush,
    "new": PublisherNew,
    "nonblock": PublisherNew,
    "periodic": PublisherPeriodic,
}
