"""What programs that are attached to a run ask of `rtgen run` itself: buses, and recordings."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Final

import msgspec

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.messages import from_msgpack
from rtgen.runtime.errors import RtcError
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SimulatedClock
from rtgen.tools.running.recording_options import RecordingOptions, longest_chunk

if TYPE_CHECKING:
    from rtgen.tools.recording.recorder import Recorder
    from rtgen.tools.running.bus_access import BusAccess

FRAME: Final = "frame"
READ: Final = "read"
WRITE: Final = "write"
RECORD: Final = "record"
STOP: Final = "stop"
"""Ends the recording."""


class SendFrame(msgspec.Struct, frozen=True):
    """See `BusAccess.send`."""

    bus: str
    can_id: int
    data: bytes
    remote: bool
    extended: bool
    period: float


class Transfer(msgspec.Struct, frozen=True):
    """See `BusAccess.read` and `write`; `octets` are those to write."""

    bus: str
    node: int
    number: tuple[int, int]
    octets: bytes = b""


class RefusedError(RtcError):
    """A request cannot be carried out."""


class Attached:
    """Carries out requests, see `local_requests.Doing`; `tell` is told how recordings end."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._buses: BusAccess | None = None
        self._recordings: dict[Hashable, _Recording] = {}
        self._lock = threading.Lock()
        self.tell: Callable[[str, str, str], None] = lambda kind, instance, text: None

    def do(self, client: Hashable, what: str, octets: bytes) -> bytes:
        """Carry out a request of a client. Raises ValueError, or RtcError if it is refused."""
        match what:
            case "frame" | "read" | "write":
                return self._on_bus(what, octets)
            case "stop":
                self.left(client)
                return b""
            case "record":
                options = from_msgpack(octets, RecordingOptions)
                self._record(client, options)
                return b""
            case _:
                pass
        raise RefusedError(f"this run cannot do that: {what}")

    def left(self, client: Hashable) -> None:
        """End the recording of a client."""
        with self._lock:
            recording = self._recordings.pop(client, None)
        if recording is not None:
            recording.end(through=True)

    def end(self, *, through: bool) -> None:
        """End all recordings with the run; see `Recorder.end`."""
        with self._lock:
            recordings = [*self._recordings.values()]
            self._recordings.clear()
        for each in recordings:
            each.end(through=through)

    def _on_bus(self, what: str, octets: bytes) -> bytes:
        from rtgen.runtime.canopen.errors import LinkError
        from rtgen.runtime.canopen.wire.frames import Frame
        from rtgen.runtime.canopen.wire.sdo import SdoAbort
        from rtgen.tools.running.bus_access import BusAccess

        if self._buses is None:
            self._buses = BusAccess(self._system)
        try:
            if what == FRAME:
                sent = from_msgpack(octets, SendFrame)
                frame = Frame(sent.can_id, sent.data, sent.remote, sent.extended)
                self._buses.send(sent.bus, frame, sent.period)
                return b""
            asked = from_msgpack(octets, Transfer)
            if what == READ:
                return self._buses.read(asked.bus, asked.node, asked.number)
            self._buses.write(asked.bus, asked.node, asked.number, asked.octets)
        except (SdoAbort, LinkError) as error:
            raise RefusedError(str(error)) from error
        return b""

    def _record(self, client: Hashable, options: RecordingOptions) -> None:
        with self._lock:
            if client in self._recordings:
                raise RefusedError("this run is recorded already")
            try:
                self._recordings[client] = _Recording(self._system, options, self.tell)
            except ToolError as error:
                raise RefusedError(str(error)) from error


class _Recording:
    """A recording of a run that is under way, which goes on if the file cannot be written."""

    def __init__(
        self,
        system: System,
        options: RecordingOptions,
        tell: Callable[[str, str, str], None],
    ) -> None:
        self._files = ExitStack()
        self._options, self._tell = options, tell
        longest = longest_chunk(system)
        writer = options.writer(self._files, options.file or "", longest)
        from rtgen.tools.recording.lasting_writer import LastingWriter
        from rtgen.tools.recording.recorder import Recorder

        self._writer = LastingWriter(writer, self._failed)
        self._recorder: Recorder = Recorder(system, self._writer, under_way=True)
        self._simulated = isinstance(system.clock, SimulatedClock)

    def end(self, *, through: bool) -> None:
        """End the recording, and tell what is missing in it."""
        self._recorder.close()
        self._recorder.end(through=through)
        for message in self._recorder.missing.messages():
            self._tell("lost", "", f"{self._options.file}: {message}")
        self._writer.close(self._files)

    def _failed(self, error: Exception) -> None:
        self._tell("error", "", f"the recording has ended: {error}")
