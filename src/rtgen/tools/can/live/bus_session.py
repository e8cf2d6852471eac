"""Runs protocol machines (SDO client, LSS master) on an open bus until they have finished."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

import msgspec

from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.canopen.bus.messages import frame_of
from rtgen.runtime.canopen.bus.python_can import OpenBus
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SECOND, CobId, Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.tools.can.live.live_bus import send

_POLL_INTERVAL = 0.1
"""Longest wait for a frame in seconds, so that Ctrl-C is noticed."""
BLOCK_FROM = 64
"""Length in octets from which a value is written by block transfer, if the node supports it."""


class Machine(Protocol):
    """A protocol machine without I/O, such as an SDO client or an LSS master."""

    @property
    def busy(self) -> bool:
        """Whether the machine has work in progress."""

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll` [ns]."""

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """Process a received frame; return the frames to send."""

    def poll(self, now: int) -> Iterable[Frame]:
        """Process what is due at `now`; return the frames to send."""


class SilentError(Exception):
    """A node has not answered in time."""


class BusSession(msgspec.Struct, eq=False):
    """Runs protocol machines on a bus; `on_frame` is called with every received frame."""

    _bus: OpenBus
    _on_frame: Callable[[Frame], object] = lambda frame: None

    def send(self, frames: Iterable[Frame]) -> None:
        """Send frames. Raises ToolError if the bus is lost."""
        for frame in frames:
            send(self._bus, frame)

    def run(self, machines: Sequence[Machine]) -> None:
        """Run until no machine is busy. Raises ToolError if the bus is lost."""
        while busy := [machine for machine in machines if machine.busy]:
            deadlines = [m.deadline for m in busy if m.deadline is not None]
            now = time.monotonic_ns()
            due = min(deadlines, default=now + SECOND)
            self._once(busy, (due - now) / SECOND)

    def listen(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Receive frames for some seconds, or until `until()` holds.

        Raises ToolError if the bus is lost.
        """
        end = time.monotonic() + seconds
        while (remaining := end - time.monotonic()) > 0 and not until():
            self._once((), remaining)

    def _once(self, machines: Sequence[Machine], remaining: float) -> None:
        frame = self._receive(min(max(remaining, 0.0), _POLL_INTERVAL))
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
            self._on_frame(frame)
        return frame

    def upload(
        self,
        node_id: int,
        index: int,
        subindex: int,
        *,
        timeout: int,
        block: bool,
        cob_ids: tuple[CobId, CobId] | None = None,
        longest: int = sdo.MAX_SIZE,
    ) -> bytes:
        """Read an object by SDO upload. Raises SdoAbort, SilentError and ToolError.

        `timeout` is for each response, in ns. A server without block transfer is asked again by
        segments. `cob_ids` are those of a further server. A value of more than `longest` octets is
        aborted. Ctrl-C ends the transfer at the
        server too.
        """
        try:
            client = SdoClient(
                node_id, timeout=timeout, cob_ids=cob_ids, max_size=longest
            )
            now = time.monotonic_ns()
            return self._transfer(
                client, client.upload(index, subindex, now, block=block)
            )
        except SdoAbort as abort:
            if not block or abort.code != sdo.COMMAND_UNKNOWN:
                raise
        return self.upload(
            node_id,
            index,
            subindex,
            timeout=timeout,
            block=False,
            cob_ids=cob_ids,
            longest=longest,
        )

    def download(
        self,
        node_id: int,
        index: int,
        subindex: int,
        value: bytes,
        *,
        timeout: int,
        cob_ids: tuple[CobId, CobId] | None = None,
    ) -> None:
        """Write an object by SDO download. Raises SdoAbort, SilentError and ToolError.

        `timeout` is for each response, in ns. Long values go by block transfer; a server that
        rejects it has stored nothing yet, so the value is sent again by segments.
        """
        for block in (True, False) if len(value) >= BLOCK_FROM else (False,):
            client = SdoClient(node_id, timeout=timeout, cob_ids=cob_ids)
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
        try:
            self.send(frames)
            self.run([answered])
        except KeyboardInterrupt:
            self.send(client.cancel(time.monotonic_ns()))
            raise
        try:
            return client.result()
        except SdoAbort as abort:
            if abort.within and not (answered.heard or abort.foreign):
                raise SilentError from abort
            raise


class _Answered:
    """An SDO client that records whether its server has answered at all."""

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
