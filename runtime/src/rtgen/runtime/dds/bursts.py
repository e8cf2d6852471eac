"""Samples that a writer writes in quick succession share datagrams.

Most of the time of a write is the system call that sends it. So a writer that writes without a
pause holds some samples until a datagram has several; a thread sends what is held when the writer
stops.
"""

from __future__ import annotations

import threading
import time
from queue import SimpleQueue
from typing import Any

from rtgen.runtime.dds import entities

_HOLD = 20e-6
"""Seconds after the last datagram during which samples are held."""
_PAUSE = 100e-6
"""Seconds without a datagram that end a burst."""
_FIRST = 8
"""Samples at the begin of a burst that are sent at once: some samples in a tick are no burst."""
_TOGETHER = 16
"""Maximum number of samples in a datagram."""


class Sender:
    """Sends held samples in a thread of its own, which the first one starts."""

    def __init__(self) -> None:
        self._waiting: SimpleQueue[Burst | None] = SimpleQueue()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def soon(self, burst: Burst) -> None:
        """Send what is held, as soon as the thread runs."""
        self._waiting.put(burst)
        if self._thread is None:
            self._start()

    def _start(self) -> None:
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._run, name="rtgen dds sender", daemon=True
                )
                self._thread.start()

    def _run(self) -> None:
        while (burst := self._waiting.get()) is not None:
            burst.send_held()

    def close(self) -> None:
        """End the thread."""
        self._waiting.put(None)
        if self._thread is not None:
            self._thread.join()


class Burst:
    """Decides when the samples of a batching writer are sent.

    `depth` is the number of samples that a reader keeps at least, None for all: a datagram has only
    a part of them, so that a reader has time to take the others.
    """

    def __init__(self, writer: Any, sender: Sender, depth: int | None) -> None:
        self._writer = writer
        self._sender = sender
        self._most = _TOGETHER if depth is None else min(_TOGETHER, depth // 4)
        self._sent = 0.0
        self._written = 0
        self._held = 0
        self._waits = False

    def written(self) -> None:
        """Send the sample that was written, or hold it for a moment."""
        since = time.monotonic() - self._sent
        if since > _PAUSE:
            self._written = 0
        self._written += 1
        self._held += 1
        if since >= _HOLD or self._written <= _FIRST or self._held >= self._most:
            self._send()
        elif not self._waits:
            self._waits = True
            self._sender.soon(self)

    def send_held(self) -> None:
        """Send what is held: the sender's thread."""
        # A sample that is written from here on calls the sender again.
        self._waits = False
        self._send()

    def _send(self) -> None:
        self._held = 0
        entities.flush(self._writer)
        self._sent = time.monotonic()
