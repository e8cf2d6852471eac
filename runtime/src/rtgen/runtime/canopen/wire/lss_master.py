"""LSS master (CiA 305): selects slaves by address, scans for them, assigns node-ids.

A procedure is a generator: it yields requests and receives their responses, None for a time-out.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from typing import Any, Final, NamedTuple, TypeAlias, TypeVar

import msgspec

from rtgen.runtime.canopen.wire import lss
from rtgen.runtime.canopen.wire.frames import (
    LSS_REQUEST,
    LSS_RESPONSE,
    MILLISECOND,
    Frame,
    checked_node_id,
)
from rtgen.runtime.canopen.wire.lss import LssAddress, LssCommand

TIMEOUT: Final = 50 * MILLISECOND
"""Default time to wait for a response, in ns."""
SETTLE: Final = 10 * MILLISECOND
"""Time in which several slaves may answer the same fastscan message, in ns."""

PartialAddress: TypeAlias = tuple[int | None, int | None, int | None, int | None]
"""An address with unknown parts."""

T = TypeVar("T")


class LssError(RuntimeError):
    """A slave is missing, does not answer, or rejects a request."""


class Request(msgspec.Struct, frozen=True, gc=False):
    """A request; `answer` is the command of its response, None if there is none.

    With `many`, several slaves may answer, and the next request waits for them.
    """

    message: bytes
    answer: LssCommand | None = None
    many: bool = False


Procedure: TypeAlias = Generator[Request, bytes | None, T]


class Assigned(NamedTuple):
    """Result of `assign`: address, previous node-id, whether the slave stores the new one."""

    address: LssAddress
    before: int
    stored: bool


_SELECTION: Final = (
    LssCommand.SWITCH_VENDOR,
    LssCommand.SWITCH_PRODUCT,
    LssCommand.SWITCH_REVISION,
    LssCommand.SWITCH_SERIAL,
)


def switch(state: int) -> Request:
    """Switch all slaves to WAITING or CONFIGURATION."""
    return Request(lss.message(LssCommand.SWITCH_GLOBAL, state, 1))


def select(address: LssAddress) -> Procedure[bool]:
    """Switch one slave to CONFIGURATION; return whether a slave has this address."""
    for command, number in zip(_SELECTION[:3], address[:3], strict=True):
        yield Request(lss.message(command, number))
    last = lss.message(LssCommand.SWITCH_SERIAL, address.serial)
    return (yield Request(last, LssCommand.SWITCHED)) is not None


def scan(
    partial_address: PartialAddress = (None, None, None, None),
) -> Procedure[LssAddress | None]:
    """Find an unconfigured slave by fastscan, leaving it in CONFIGURATION.

    Of several slaves, the one with the lowest numbers is found. Known parts are not searched.
    """
    if not (yield _scanned(0, lss.START_OF_SCAN, 0, 0)):
        return None
    identity = []
    for part, number in enumerate(partial_address):
        if number is None:
            number = 0
            for bit in range(31, -1, -1):
                if not (yield _scanned(number, bit, part, part)):
                    number |= 1 << bit
        if not (yield _scanned(number, 0, part, (part + 1) % 4)):
            return None
        identity.append(number)
    return LssAddress(*identity)


def _scanned(number: int, bit: int, part: int, following: int) -> Request:
    message = lss.fastscan_message(number, bit, part, following)
    return Request(message, LssCommand.IDENTIFIED, many=True)


def find(partial_address: PartialAddress) -> Procedure[LssAddress]:
    """Switch the slave of an address to CONFIGURATION, all others to WAITING.

    If parts are unknown the slave must be unconfigured. Raises LssError.
    """
    yield switch(lss.WAITING)
    vendor, product, revision, serial = partial_address
    if None not in (vendor, product, revision, serial):
        address = LssAddress(vendor or 0, product or 0, revision or 0, serial or 0)
        if (yield from select(address)):
            return address
        identity = None
    else:
        identity = yield from scan(partial_address)
    if identity is None:
        raise LssError(
            f"no node answers to the LSS address {address_text(partial_address)}"
        )
    return identity


def assign(partial_address: PartialAddress, node_id: int) -> Procedure[Assigned]:
    """Assign a node-id to a slave, effective immediately, or after reset communication.

    A slave without one boots at the end. Raises LssError.
    """
    checked_node_id(node_id)
    address = yield from find(partial_address)
    answer = yield from inquire(LssCommand.INQUIRE_NODE_ID)
    before = answer & 0xFF
    message = lss.message(LssCommand.CONFIGURE_NODE_ID, node_id, 1)
    error = yield from _configured(LssCommand.CONFIGURE_NODE_ID, message)
    if error:
        raise LssError(f"node-id {node_id} is refused: {_reason(error)}")
    stored = yield from store()
    yield switch(lss.WAITING)
    return Assigned(address, before, stored)


def inquire(what: LssCommand) -> Procedure[int]:
    """Read a number of the slave in CONFIGURATION with an INQUIRE command. Raises LssError."""
    answer = yield Request(lss.message(what), what)
    if answer is None:
        raise LssError(f"{what.name} is not answered")
    return lss.first_number(answer)


def store() -> Procedure[bool]:
    """Make slaves in CONFIGURATION store their settings, if they can. Raises LssError."""
    error = yield from _configured(LssCommand.STORE, lss.message(LssCommand.STORE))
    if error == lss.STORING_UNSUPPORTED:
        return False
    if error:
        failed = error == lss.STORING_FAILED
        raise LssError("storing failed" if failed else f"storing: {_reason(error)}")
    return True


def set_bit_rate(
    partial_address: PartialAddress, bit_rate: int | None, *, delay: int | None = None
) -> Procedure[bool]:
    """Set a slave's bit rate in kbit/s, None for automatic; return whether the slave stores it.

    It takes effect after a restart. With `delay`, in ms, all slaves in CONFIGURATION switch that
    long after the end, and no station may send for another such time. Raises LssError, KeyError for
    a bit rate unknown to CiA 305.
    """
    index = lss.AUTOMATIC_BIT_RATE if bit_rate is None else lss.BIT_RATES[bit_rate]
    yield from find(partial_address)
    message = lss.message(LssCommand.CONFIGURE_BIT_TIMING, index << 8, 2)
    error = yield from _configured(LssCommand.CONFIGURE_BIT_TIMING, message)
    if error:
        raise LssError(f"bit rate {bit_rate} is refused: {_reason(error)}")
    stored = yield from store()
    if delay is not None:
        yield Request(lss.message(LssCommand.ACTIVATE_BIT_TIMING, delay, 2))
    else:
        yield switch(lss.WAITING)
    return stored


def _configured(command: LssCommand, message: bytes) -> Procedure[int]:
    """Return the error code in the response to a message. Raises LssError."""
    answer = yield Request(message, command)
    if answer is None:
        raise LssError(f"{command.name} is not answered")
    return answer[1]


def _reason(error: int) -> str:
    return "out of range" if error == lss.OUT_OF_RANGE else f"error {error}"


def address_text(address: PartialAddress) -> str:
    """Return an address as text, with "any" for unknown parts."""
    return " ".join("any" if part is None else f"{part:08X}h" for part in address)


class LssMaster:
    """Runs procedures one at a time, in the order of submission.

    Frames and the time are passed in; `deadline` is the time of the next call of `poll`.
    """

    def __init__(self, timeout: int = TIMEOUT, settle: int = SETTLE) -> None:
        self._timeout = timeout
        self._settle = settle
        self._waiting: deque[tuple[Procedure[Any], Callable[[Any], None]]] = deque()
        self._procedure: Procedure[Any] | None = None
        self._done: Callable[[Any], None] = _ignore
        self._request = Request(b"")
        self._answer: bytes | None = None
        self.deadline: int | None = None

    @property
    def busy(self) -> bool:
        """Whether a procedure is in progress."""
        return self._procedure is not None

    def submit(
        self, procedure: Procedure[T], done: Callable[[T | LssError], None], now: int
    ) -> list[Frame]:
        """Queue a procedure; `done` receives its result or its error."""
        self._waiting.append((procedure, done))
        return self._begin_next(now)

    def receive(self, frame: Frame, now: int) -> list[Frame]:
        """Process a frame; return the frames to send."""
        if frame.can_id != LSS_RESPONSE or frame.extended or frame.remote:
            return []
        data = frame.data
        if self._procedure is None or len(data) != lss.MESSAGE:
            return []
        if data[0] != self._request.answer or self._answer is not None:
            return []
        if not self._request.many:
            return self._advance(data, now)
        self._answer, self.deadline = data, now + self._settle
        return []

    def poll(self, now: int) -> list[Frame]:
        """Process the expiry of a time-out of responses; return the frames to send."""
        if self.deadline is None or now < self.deadline:
            return []
        return self._advance(self._answer, now)

    def cancel(self) -> None:
        """Drop all procedures without calling `done`."""
        self._procedure, self.deadline = None, None
        self._waiting.clear()

    def _begin_next(self, now: int) -> list[Frame]:
        if self._procedure is not None or not self._waiting:
            return []
        self._procedure, self._done = self._waiting.popleft()
        return self._advance(None, now)

    def _advance(self, answer: bytes | None, now: int) -> list[Frame]:
        """Send messages up to the next one with a response, or to the end of the procedure."""
        procedure = self._procedure
        assert procedure is not None
        self._answer, self.deadline = None, None
        frames = []
        try:
            while True:
                asked = procedure.send(answer)
                answer = None
                frames.append(Frame(LSS_REQUEST, asked.message))
                if asked.answer is not None:
                    self._request, self.deadline = asked, now + self._timeout
                    return frames
        except StopIteration as end:
            outcome = end.value
        except LssError as error:
            outcome = error
        done, self._procedure = self._done, None
        done(outcome)
        return [*frames, *self._begin_next(now)]


def _ignore(_: object) -> None:
    return None
