"""Reads a console in a thread, so that no execution waits for a key."""

from __future__ import annotations

import codecs
import io
import os
import select
import threading
from collections import deque
from collections.abc import Callable
from typing import TextIO

WAITS = os.name == "posix"
"""Whether `select` waits for terminals and pipes, not only for sockets."""


class ConsoleReader:
    """Reads lines of a text stream in a thread of its own, until the end or `close`.

    A stream with a file descriptor (a terminal, a pipe) is waited for together with a wake-up
    pipe, so that `close` ends the thread at once; any other stream is read to its end. Where such
    descriptors cannot be waited for (Windows), `close` leaves a thread that waits for a line.
    """

    def __init__(self, stream: TextIO) -> None:
        self.failure = ""
        """Why reading ended early; empty if it did not."""
        self._lines: deque[str] = deque()
        self._ended = threading.Event()
        self._wake_read, self._wake_write = os.pipe()
        follows = WAITS and _descriptor(stream) is not None
        read = self._follow if follows else self._drain
        self._thread = threading.Thread(
            target=self._run, args=(read, stream), name="console", daemon=True
        )
        self._thread.start()

    @property
    def ended(self) -> bool:
        """Whether the stream is at its end and all its lines were taken."""
        return self._ended.is_set() and not self._lines

    def take(self) -> str | None:
        """Remove and return the oldest line, without its end; None if there is none."""
        return self._lines.popleft() if self._lines else None

    def wait_for_end(self) -> None:
        """Wait until the stream is at its end."""
        self._ended.wait()

    def close(self) -> None:
        """End the thread and wait for it."""
        os.write(self._wake_write, b"x")
        if WAITS:
            self._thread.join()
        os.close(self._wake_read)
        os.close(self._wake_write)

    def _run(self, read: Callable[[TextIO], None], stream: TextIO) -> None:
        try:
            read(stream)
        except (OSError, ValueError) as error:
            # A terminal that hung up, or a stream closed by its owner.
            self.failure = str(error)
        self._ended.set()

    def _drain(self, stream: TextIO) -> None:
        for line in stream:
            self._lines.append(line.rstrip("\n"))

    def _follow(self, stream: TextIO) -> None:
        descriptor = stream.fileno()
        decoder = codecs.getincrementaldecoder(stream.encoding or "utf-8")("replace")
        rest = ""
        while True:
            ready, _, _ = select.select([descriptor, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            data = os.read(descriptor, 4096)
            *lines, rest = (rest + decoder.decode(data, final=not data)).split("\n")
            self._lines.extend(lines)
            if not data:
                if rest:
                    self._lines.append(rest)
                return


def _descriptor(stream: TextIO) -> int | None:
    try:
        return stream.fileno()
    except io.UnsupportedOperation:
        return None
