"""The ring buffer of a connector, and return codes of ports."""

from __future__ import annotations

import threading
from collections import deque
from typing import Any

from .properties import Properties


class DataPortStatus:
    PORT_OK = 0
    PORT_ERROR = 1
    BUFFER_ERROR = 2
    BUFFER_FULL = 3
    BUFFER_EMPTY = 4
    BUFFER_TIMEOUT = 5
    SEND_FULL = 6
    SEND_TIMEOUT = 7
    RECV_EMPTY = 8
    RECV_TIMEOUT = 9
    INVALID_ARGS = 10
    PRECONDITION_NOT_MET = 11
    CONNECTION_LOST = 12
    UNKNOWN_ERROR = 13


class RingBuffer:
    """Values in order of arrival; policies define the behaviour if it is full or empty."""

    def __init__(self, properties: Properties) -> None:
        """Initialize; `properties` is the node `buffer` of a connector."""
        self._changed = threading.Condition()
        self.init(properties)

    def init(self, properties: Properties) -> None:
        """Adopt length and policies of a connector; the content of the buffer is lost."""
        self._length = int(properties.getProperty("length", "8"))
        self._full = properties.getProperty("write.full_policy", "overwrite")
        self._write_timeout = float(properties.getProperty("write.timeout", "1.0"))
        self._empty = properties.getProperty("read.empty_policy", "readback")
        self._read_timeout = float(properties.getProperty("read.timeout", "1.0"))
        self._unread: deque[Any] = deque()
        self._last: list[Any] = []

    def length(self) -> int:
        return self._length

    def readable(self) -> int:
        return len(self._unread)

    def writable(self) -> int:
        return self._length - len(self._unread)

    def full(self) -> bool:
        return len(self._unread) >= self._length

    def empty(self) -> bool:
        return not self._unread

    def write(self, value: Any) -> int:
        with self._changed:
            if self.full():
                if self._full == "do_nothing":
                    return DataPortStatus.BUFFER_FULL
                if self._full == "block":
                    if not self._changed.wait_for(
                        lambda: not self.full(), self._write_timeout
                    ):
                        return DataPortStatus.BUFFER_TIMEOUT
                else:
                    self._unread.popleft()
            self._unread.append(value)
            self._changed.notify_all()
        return DataPortStatus.PORT_OK

    def read(self) -> tuple[int, Any]:
        """Return the oldest unread value; the last one again with `readback`, if there is one."""
        with self._changed:
            if not self._unread:
                if self._empty == "readback" and self._last:
                    return DataPortStatus.PORT_OK, self._last[0]
                if self._empty != "block":
                    return DataPortStatus.BUFFER_EMPTY, None
                if not self._changed.wait_for(
                    lambda: bool(self._unread), self._read_timeout
                ):
                    return DataPortStatus.BUFFER_TIMEOUT, None
            value = self._unread.popleft()
            self._last = [value]
            self._changed.notify_all()
        return DataPortStatus.PORT_OK, value

    def oldest(self) -> Any:
        """Return the oldest unread value, which stays; None if there is none."""
        with self._changed:
            return self._unread[0] if self._unread else None

    def forget(self, value: Any) -> None:
        """Remove a value, if it still is the oldest."""
        with self._changed:
            if self._unread and self._unread[0] is value:
                self._unread.popleft()
                self._changed.notify_all()

    def drop(self, count: int | None = None, keep: int = 0) -> int:
        """Remove the oldest values, at most `count`, all but `keep`; return their number."""
        with self._changed:
            most = max(0, len(self._unread) - keep)
            dropped = most if count is None else min(most, count)
            for _ in range(dropped):
                self._unread.popleft()
            self._changed.notify_all()
        return dropped
