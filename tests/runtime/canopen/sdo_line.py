"""A client and a server on a line that loses and doubles frames, with a dictionary."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.runtime.canopen.wire.sdo_server import SdoServer

LOST, ONCE, TWICE = range(3)
MS = 1_000_000


class Values:
    """2000h is a variable; 2001h read-only, 2002h write-only, 2003h has four octets."""

    def __init__(self, value: bytes = b"old") -> None:
        self.value = value
        self.limit = 5000
        self.writes: list[bytes] = []

    def read(self, index: int, subindex: int) -> bytes:
        self._check(index, subindex)
        if index == 0x2002:
            raise SdoAbort(sdo.WRITE_ONLY)
        return self.value

    def writable_size(self, index: int, subindex: int) -> int:
        self._check(index, subindex)
        if index == 0x2001:
            raise SdoAbort(sdo.READ_ONLY)
        return 4 if index == 0x2003 else self.limit

    def write(self, index: int, subindex: int, value: bytes) -> None:
        if value == b"BAD!":
            raise SdoAbort(sdo.VALUE_INVALID)
        self.value = value
        self.writes.append(value)

    @staticmethod
    def _check(index: int, subindex: int) -> None:
        if not 0x2000 <= index <= 0x2003:
            raise SdoAbort(sdo.NO_OBJECT)
        if subindex:
            raise SdoAbort(sdo.NO_SUBINDEX)


class Line:
    """Carries frames in order; `fates` are the fates of the first frames, later ones all arrive."""

    def __init__(
        self, client: SdoClient, server: SdoServer, fates: Iterable[int] = ()
    ) -> None:
        self.client = client
        self.server = server
        self.now = 0
        self.frames: list[Frame] = []
        self._fates = deque(fates)
        self._waiting: deque[Frame] = deque()

    def run(self, frames: list[Frame]) -> bytes:
        """Carry frames until the client is ready again; return its result."""
        self._send(frames)
        while self._waiting or not self.client.ready:
            if self._waiting:
                self._deliver(self._waiting.popleft())
                continue
            deadlines = (self.client.deadline, self.server.deadline)
            self.now = max(self.now, min(d for d in deadlines if d is not None))
            self._send(self.client.poll(self.now))
            self._send(self.server.poll(self.now))
        return self.client.result()

    def _deliver(self, frame: Frame) -> None:
        self.now += MS // 10
        self._send(self.client.receive(frame, self.now))
        self._send(self.server.receive(frame, self.now))

    def _send(self, frames: list[Frame]) -> None:
        for frame in frames:
            self.frames.append(frame)
            fate = self._fates.popleft() if self._fates else ONCE
            self._waiting.extend([frame] * fate)


def line(values: Values, fates: Iterable[int] = (), block_size: int = 127) -> Line:
    """Return a line with both ends of node 5."""
    return Line(
        SdoClient(5, block_size=block_size),
        SdoServer(5, values, block_size=block_size),
        fates,
    )
