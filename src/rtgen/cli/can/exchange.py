"""Protocol machines at work on an open bus, until they are done."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from rtgen.cli.can.live import send
from rtgen.diagnostics import ToolError
from rtgen.runtime.canopen import sdo
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.frames import SECOND, Frame
from rtgen.runtime.canopen.python_can import OpenBus, frame_of
from rtgen.runtime.canopen.sdo import SdoAbort
from rtgen.runtime.canopen.sdo_client import SdoClient

_LONGEST = 0.1
"""Seconds that the bus is waited for at a time, so that Ctrl-C comes through."""
BLOCK_FROM = 64
"""Octets from which a value is written by block transfer, if the node has that."""


class Machine(Protocol):
    """A protocol machine without I/O, such as an SDO client or an LSS master."""

    @property
    def busy(self) -> bool:
        """Whether it is at work."""

    @property
    def deadline(self) -> int | None:
        """When `poll` is to be called."""

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """Takes a frame; gives what is to be sent."""

    def poll(self, now: int) -> Iterable[Frame]:
        """Does what is due; gives what is to be sent."""


class SilentError(Exception):
    """A node has not answered."""


class Exchange:
    """Lets machines work on a bus; `heard` is called with every frame that comes."""

    def __init__(
        self, bus: OpenBus, heard: Callable[[Frame], object] = lambda frame: None
    ) -> None:
        self._bus = bus
        self._heard = heard

    def send(self, frames: Iterable[Frame]) -> None:
        """Sends frames. Raises ToolError if the bus is gone."""
        for frame in frames:
            send(self._bus, frame)

    def run(self, machines: Sequence[Machine]) -> None:
        """Works until none of the machines is busy. Raises ToolError if the bus is gone."""
        while busy := [machine for machine in machines if machine.busy]:
            deadlines = [m.deadline for m in busy if m.deadline is not None]
            now = time.monotonic_ns()
            due = min(deadlines, default=now + SECOND)
            self._once(busy, (due - now) / SECOND)

    def listen(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Takes frames for a while, or until something holds. Raises ToolError."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0 and not until():
            self._once((), left)

    def _once(self, machines: Sequence[Machine], left: float) -> None:
        frame = self._receive(min(max(left, 0.0), _LONGEST))
        for machine in machines:
            if frame is not None:
                self.send(machine.receive(frame, time.monotonic_ns()))
            self.send(machine.poll(time.monotonic_ns()))

    def _receive(self, seconds: float) -> Frame | None:
        try:
            message = self._bus.receive(seconds)
        except LinkError as error:
            raise ToolError(f"the bus is gone: {error}") from error
        frame = None if message is None else frame_of(message)
        if frame is not None:
            self._heard(frame)
        return frame

    def upload(
        self, node_id: int, index: int, subindex: int, *, timeout: int, block: bool
    ) -> bytes:
        """The octets of a variable. Raises SdoAbort, SilentError and ToolError.

        `timeout` is for each answer, in ns. A node without block transfer is asked again without.
        """
        try:
            client = SdoClient(node_id, timeout=timeout)
            now = time.monotonic_ns()
            return self._transfer(
                client, client.upload(index, subindex, now, block=block)
            )
        except SdoAbort as abort:
            if not block or abort.code != sdo.COMMAND_UNKNOWN:
                raise
        return self.upload(node_id, index, subindex, timeout=timeout, block=False)

    def download(
        self, node_id: int, index: int, subindex: int, value: bytes, *, timeout: int
    ) -> None:
        """Writes a variable. Raises SdoAbort, SilentError and ToolError.

        `timeout` is for each answer, in ns. A node that knows no block transfer has taken nothing
        of it, so the long value is written by segments then.
        """
        for block in (True, False) if len(value) >= BLOCK_FROM else (False,):
            client = SdoClient(node_id, timeout=timeout)
            now = time.monotonic_ns()
            try:
                frames = client.download(index, subindex, value, now, block=block)
                self._transfer(client, frames)
            except SdoAbort as abort:
                if not block or abort.code != sdo.COMMAND_UNKNOWN:
                    raise
            else:
                return

    def _transfer(self, client: SdoClient, frames: list[Frame]) -> bytes:
        answered = _Answered(client)
        self.send(frames)
        self.run([answered])
        try:
            return client.result()
        except SdoAbort as abort:
            if abort.code == sdo.TIMED_OUT and not answered.heard:
                raise SilentError from abort
            raise


class _Answered:
    """An SDO client, and whether its server has said anything."""

    def __init__(self, client: SdoClient) -> None:
        self._client = client
        self.heard = False

    @property
    def busy(self) -> bool:
        return self._client.busy

    @property
    def deadline(self) -> int | None:
        return self._client.deadline

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        answers = self._client.receive(frame, now)
        self.heard |= bool(answers) or not self._client.busy
        return answers

    def poll(self, now: int) -> Iterable[Frame]:
        return self._client.poll(now)
