"""The node under test: transfers, single messages and states over a line of frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

from rtgen.compiler.model.canopen import NodeRelative, resolved
from rtgen.facts.canopen import INVALID, SYNC
from rtgen.facts.cob_ids import COB_ID_SYNC
from rtgen.facts.write_order import OVERFLOW
from rtgen.runtime.canopen.description import ObjectNumber
from rtgen.runtime.canopen.values import encode
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import (
    ERROR_CONTROL,
    MILLISECOND,
    SDO_REQUEST,
    SDO_RESPONSE,
    CobId,
    Frame,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, command_frame
from rtgen.runtime.canopen.wire.sdo import ABORT_TEXTS, SdoAbort, Target
from rtgen.runtime.canopen.wire.sdo_client import SdoClient
from rtgen.tools.can.decoding.node_index import DescribedNode, DescribedObject
from rtgen.tools.conformance.check import SkipError

_EMERGENCY = (0x1014, 0)
_TOGGLE = 0x80


class Line(Protocol):
    """Frames to and from a bus; times in ns."""

    remote_frames: bool

    def now(self) -> int:
        """Return the time."""

    def send(self, frame: Frame, /) -> None:
        """Send a frame."""

    def receive(self, until: int, /) -> Frame | None:
        """Return the next frame, None if there is none by that time."""


class SilenceError(Exception):
    """The node did not respond in time."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Time-outs of a node in ns: response, boot-up, and the cycles of its application in which it
    takes an RPDO; and the tolerated part of a period.
    """

    answer: int = 1000 * MILLISECOND
    boot: int = 5000 * MILLISECOND
    cycles: int = 100 * MILLISECOND
    period_tolerance: float = 0.2


@dataclass(slots=True)
class NodeUnderTest:
    """A node with its description. Methods raise SilenceError if it does not respond in time."""

    faults: ClassVar[tuple[type[Exception], ...]] = (SilenceError, SdoAbort)

    described: DescribedNode
    line: Line
    bounds: Bounds = Bounds()
    values: dict[ObjectNumber, bytes] = field(default_factory=dict)
    """The values read by the first check."""
    syncs: int = 0
    """Number of SYNC messages sent so far."""
    _asked: ObjectNumber = (0, 0)

    def explained(self, fault: Exception) -> str:
        """See `Subject`."""
        silent = fault.__cause__ if isinstance(fault, SilenceError) else None
        if isinstance(silent, SdoAbort):
            return silent.explanation
        if isinstance(fault, SilenceError):
            return f"no answer within {self.bounds.answer // MILLISECOND} ms"
        return fault.explanation if isinstance(fault, SdoAbort) else str(fault)

    @property
    def id(self) -> int:
        """The node-id."""
        return self.described.id

    @property
    def emergencies(self) -> int | None:
        """The CAN identifier of its emergencies; None if it has no valid 1014h."""
        octets = self.values.get(_EMERGENCY)
        cob_id = CobId(INVALID if octets is None else int.from_bytes(octets, "little"))
        return cob_id.can_id if cob_id.valid else None

    def synchronise(self) -> None:
        """Send a SYNC as the node expects it, with a counter if it has one (1005h, 1019h)."""
        octets = self.values.get(COB_ID_SYNC)
        cob_id = CobId(SYNC if octets is None else int.from_bytes(octets, "little"))
        highest = int.from_bytes(self.values.get(OVERFLOW, b""), "little")
        data = bytes((self.syncs % highest + 1,)) if highest else b""
        self.syncs += 1
        sync = cob_id if cob_id.configurable else CobId(SYNC)
        self.line.send(sync.frame(data))

    def described_values(self, number: ObjectNumber) -> list[int | float | str]:
        """Return the values that the description gives an object after a reset.

        That is the default, or the configured value of a DCF, if the node has stored it (CiA 301,
        7.3.2.2.1; CiA 306, ParameterValue). An object without a default may have any value. A
        COB-ID may be the one in force in place of the described one.
        """
        variable = self.described.device.find(*number)
        if variable is None or variable.default is None:
            return []
        stated = (variable.default, variable.value)
        in_force = (variable.initial(self.id), variable.in_force(self.id))
        values = [resolved(v, self.id) for v in (*stated, *in_force)]
        return [
            v
            for v in dict.fromkeys(values)
            if not isinstance(v, bytes | NodeRelative | None)
        ]

    def upload(self, number: ObjectNumber, *, block: bool = False) -> bytes:
        """Return the octets of an object. Raises SdoAbort."""
        client = SdoClient(self.id, timeout=self.bounds.answer)
        return self._transfer(
            client, client.upload(*number, self.line.now(), block=block)
        )

    def download(self, number: ObjectNumber, value: bytes) -> None:
        """Write an object. Raises SdoAbort."""
        client = SdoClient(self.id, timeout=self.bounds.answer)
        self._transfer(client, client.download(*number, value, self.line.now()))

    def allows(self, number: ObjectNumber, value: int) -> bool:
        """Return whether the described limits of an object include a value."""
        thing = self.described.objects[number]
        return (thing.low is None or value >= thing.low) and (
            thing.high is None or value <= thing.high
        )

    def configure(self, number: ObjectNumber, value: int) -> None:
        """Write a setting that a check needs. Raises SdoAbort, and SkipError if the described
        limits exclude it.
        """
        thing = self.described.objects[number]
        if not self.allows(number, value):
            raise SkipError(f"the described limits of {thing} exclude {value}")
        self.download(number, encode(thing.kind, value))

    def read_code(self, number: ObjectNumber) -> int | None:
        """Read an object; return the abort code, or None after success."""
        return _code(lambda: self.upload(number))

    def write_code(self, number: ObjectNumber, value: bytes) -> int | None:
        """Write an object; return the abort code, or None after success."""
        return _code(lambda: self.download(number, value))

    def values_soon(
        self, things: Iterable[DescribedObject], expected: list[bytes]
    ) -> list[bytes]:
        """Return the values of objects, as soon as they are `expected`, or after some cycles."""
        end, numbers = self.line.now() + self.bounds.cycles, [t.number for t in things]
        while True:
            values = [self.upload(number) for number in numbers]
            if values == expected or self.line.now() >= end:
                return values

    def values_later(self, things: Iterable[DescribedObject]) -> list[bytes]:
        """Return the values of objects after some cycles."""
        end = self.line.now() + self.bounds.cycles
        while self.line.receive(end) is not None:
            pass
        return [self.upload(thing.number) for thing in things]

    def ask(self, data: bytes) -> bytes:
        """Return the response to a single SDO message, which may begin a transfer."""
        self._asked = int.from_bytes(data[1:3], "little"), data[3]
        self.line.send(Frame(SDO_REQUEST + self.id, data))
        return self.next_answer()

    def next_answer(self) -> bytes:
        """Return the next SDO message of the node; without one, the transfer is aborted."""
        frame = self.await_frame(SDO_RESPONSE + self.id, self.bounds.answer)
        if frame is None:
            self.abandon(self._asked)
            raise SilenceError
        return frame.data

    def abandon(self, number: ObjectNumber) -> None:
        """Abort the transfer of an object, which has no response."""
        data = Target(*number).abort(sdo.GENERAL_ERROR)
        self.line.send(Frame(SDO_REQUEST + self.id, data))

    def command(self, command: NmtCommand) -> None:
        """Send an NMT command."""
        self.line.send(command_frame(command, self.id))

    @contextmanager
    def operational(self) -> Iterator[None]:
        """Context in which the node is OPERATIONAL; afterwards it is in PRE-OPERATIONAL."""
        self.command(NmtCommand.START)
        try:
            yield
        finally:
            self.command(NmtCommand.ENTER_PRE_OPERATIONAL)

    def restart(
        self, command: NmtCommand = NmtCommand.RESET_COMMUNICATION
    ) -> int | None:
        """Reset the node; return the state of its boot-up, or another one seen by error control."""
        self.command(command)
        return self.await_state([NmtState.INITIALISING], self.bounds.boot)

    def await_frame(self, can_id: int, within: int) -> Frame | None:
        """Return the next frame of an identifier; None if there is none within that time."""
        end = self.line.now() + within
        while (frame := self.line.receive(end)) is not None:
            if frame.can_id == can_id and not frame.remote and not frame.extended:
                return frame
        return None

    def await_state(self, expected: Iterable[NmtState], within: int) -> int | None:
        """Return the last state shown by error control, at once if it is one of `expected`."""
        end, states, last = self.line.now() + within, set(expected), None
        while (remaining := end - self.line.now()) > 0:
            frame = self.await_frame(ERROR_CONTROL + self.id, remaining)
            if frame is None:
                break
            last = frame.data[0] & ~_TOGGLE if len(frame.data) == 1 else -1
            if last in states:
                break
        return last

    def has(self, index: int, subindex: int = 0) -> bool:
        """Return whether the description has an object."""
        return (index, subindex) in self.described.objects

    def _transfer(self, client: SdoClient, frames: list[Frame]) -> bytes:
        for frame in frames:
            self.line.send(frame)
        while client.busy:
            assert client.deadline is not None
            received = self.line.receive(client.deadline)
            now = self.line.now()
            answers = [] if received is None else client.receive(received, now)
            for frame in (*answers, *client.poll(now)):
                self.line.send(frame)
        try:
            return client.result()
        except SdoAbort as abort:
            if abort.code == sdo.TIMED_OUT:
                raise SilenceError from abort
            raise


def refusal(what: object, code: int | None, *expected: int) -> str | None:
    """Return the problem unless an access was rejected with one of these codes."""
    if code in expected:
        return None
    text = f"{expected[0]:08X}h, {ABORT_TEXTS[expected[0]]}"
    got = "it was accepted" if code is None else f"it was refused with {code:08X}h"
    return f"{what}: {got}, not with {text}"


def _code(transfer: Callable[[], object]) -> int | None:
    try:
        transfer()
    except SdoAbort as abort:
        return abort.code
    return None
