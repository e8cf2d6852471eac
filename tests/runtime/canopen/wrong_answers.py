"""Changes of the frames that a node sends, each a violation of CiA 301 or CiA 305."""

from __future__ import annotations

from collections.abc import Callable

from conformance_nodes import ID, Alter

from rtgen.runtime.canopen.wire.frames import Frame

Where = Callable[[Frame], bool]
Answer = Callable[[Frame], list[Frame]]


def sdo_abort(cause: Frame, code: int) -> list[Frame]:
    data = b"\x80" + cause.data[1:4] + code.to_bytes(4, "little")
    return [Frame(0x580 + ID, data)]


def acknowledged(cause: Frame) -> list[Frame]:
    return [Frame(0x580 + ID, b"\x60" + cause.data[1:4] + bytes(4))]


def at(cause: Frame, command: int, index: int, sub: int = 0) -> bool:
    """Return whether it is the first message of a transfer: 0x40 reads, 0x20 writes."""
    number = bytes((index & 0xFF, index >> 8, sub))
    is_sdo = cause.can_id == 0x600 + ID and not cause.remote
    return is_sdo and cause.data[0] & 0xE0 == command and cause.data[1:4] == number


def replaced(can_id: int, start: bytes, data: bytes | None) -> Alter:
    """Replace the messages of an identifier that begin with some octets; None drops them."""
    return changed(can_id, lambda sent: data if sent.startswith(start) else sent)


def answered(where: Where, answer: Answer) -> Alter:
    """Answer some frames otherwise."""
    return lambda cause, out: answer(cause) if where(cause) else out


def refused(where: Where, code: int) -> Alter:
    """Refuse some requests."""
    return answered(where, lambda cause: sdo_abort(cause, code))


def refusing(command: int, index: int, sub: int = 0) -> Alter:
    return refused(lambda cause: at(cause, command, index, sub), 0x08000000)


def accepting(command: int, index: int, sub: int = 0, most: int = 4) -> Alter:
    return answered(
        lambda cause: (
            at(cause, command, index, sub) and 4 - (cause.data[0] >> 2 & 3) <= most
        ),
        acknowledged,
    )


def answering(index: int, sub: int, first: int, value: bytes) -> Alter:
    """Return another expedited value for an object."""
    return lambda cause, out: (
        [Frame(0x580 + ID, bytes((first,)) + cause.data[1:4] + value.ljust(4, b"\0"))]
        if out and at(cause, 0x40, index, sub)
        else out
    )


def changed(can_id: int, change: Callable[[bytes], bytes | None]) -> Alter:
    """Change the data of the frames of an identifier; None drops the frame."""

    def alter(cause: Frame, out: list[Frame]) -> list[Frame]:
        made = []
        for frame in out:
            data = change(frame.data) if frame.can_id == can_id else frame.data
            made += [] if data is None else [Frame(frame.can_id, data)]
        return made

    return alter


def altered(
    where: Callable[[Frame, list[Frame]], bool], change: Callable[[bytes], bytes]
) -> Alter:
    """Change the data of the answers to some frames."""
    return lambda cause, out: (
        [Frame(f.can_id, change(f.data)) for f in out]
        if out and where(cause, out)
        else out
    )


def to_server(cause: Frame, first: int) -> bool:
    """Return whether it is a message to the SDO server with this first octet."""
    return cause.can_id == 0x600 + ID and cause.data[:1] == bytes((first,))


def with_octet(place: int, octet: bytes) -> Callable[[bytes], bytes]:
    """Return a change of one octet."""
    return lambda data: data[:place] + octet + data[place + 1 :]


class EverySecondBeat:
    """Drops every second heartbeat."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        def change(data: bytes) -> bytes | None:
            self.count += 1
            return data if data == b"\0" or self.count % 2 else None

        return changed(0x700 + ID, change)(cause, out)


class AfterAbort:
    """Returns another first segment of 1008h after the client has aborted a transfer."""

    def __init__(self) -> None:
        self.aborted = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if at(cause, 0x80, 0x1008):
            self.aborted = True
        is_segment = bool(out) and out[0].data[:1] != b"\x80"
        if self.aborted and cause.data[:1] == b"\x60" and is_segment:
            self.aborted = False
            return [Frame(f.can_id, f.data[:1] + b"?" + f.data[2:]) for f in out]
        return out


class ServedWhenStopped:
    """Answers reads of 1000h while it is stopped."""

    def __init__(self) -> None:
        self.stopped = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0:
            self.stopped = cause.data[0] == 2
        if self.stopped and at(cause, 0x40, 0x1000):
            return [Frame(0x580 + ID, b"\x43\x00\x10\x00" + bytes(4))]
        return out


def refuses_its_own_value(cause: Frame, out: list[Frame]) -> list[Frame]:
    """Refuse the values of digital outputs that the node would store."""
    stored = [f for f in out if f.data[:1] == b"\x60" and f.data[2] == 0x62]
    return sdo_abort(cause, 0x08000000) if stored else out


def writes(cause: Frame, first: int, last: int, sub: int) -> bool:
    """Return whether a frame starts writing a sub-index of an object in a range."""
    data = cause.data
    is_write = cause.can_id == 0x600 + ID and data[:1] > b"\x1f" and data[:1] < b"\x40"
    return is_write and first <= data[1] | data[2] << 8 <= last and data[3] == sub


class OldValues:
    """Answers reads of the application with the values that were read first.

    Either while RPDOs act at once, or while they wait for SYNC.
    """

    def __init__(self, *, synchronous: bool) -> None:
        self.values: dict[bytes, list[Frame]] = {}
        self.synchronous = synchronous
        self.waiting = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        self.waiting |= writes(cause, 0x1400, 0x15FF, 2) and cause.data[4] == 0
        self.waiting &= cause.can_id != 0 or cause.data[:1] != b"\x82"
        if (
            self.waiting == self.synchronous
            and to_server(cause, 0x40)
            and cause.data[2:3] >= b"\x20"
        ):
            return self.values.setdefault(cause.data, out)
        return out


class SilentAtSync:
    """Sends no PDO until their parameters are changed."""

    def __init__(self) -> None:
        self.changed = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        self.changed |= writes(cause, 0x1800, 0x19FF, 1)
        if self.changed:
            return out
        return [f for f in out if not 0x180 <= f.can_id < 0x580]


class SlowTimer:
    """Loses every second PDO after an event timer was set."""

    def __init__(self) -> None:
        self.is_on = False
        self.count = 0

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        self.is_on |= writes(cause, 0x1800, 0x19FF, 5)
        kept = []
        for frame in out:
            is_pdo = self.is_on and 0x180 <= frame.can_id < 0x580
            self.count += is_pdo
            kept += [frame] if not is_pdo or self.count % 2 else []
        return kept


class LosesItsGuard:
    """Does not report a lost guard, only a lost heartbeat."""

    def __init__(self) -> None:
        self.guarded = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        self.guarded |= writes(cause, 0x100C, 0x100C, 0)
        self.guarded &= not writes(cause, 0x1016, 0x1016, 1)
        if not self.guarded:
            return out
        return [f for f in out if f.data[:2] != b"\x30\x81"]


class AbortsNothing:
    """Answers one request for a segment of 1008h after the client has aborted."""

    def __init__(self) -> None:
        self.aborts = 0

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        self.aborts += at(cause, 0x80, 0x1008)
        if self.aborts == 1 and cause.data[:1] == b"\x60":
            self.aborts = 2
            return plain(0x01)(cause)
        return out


class StartsItself:
    """Shows OPERATIONAL from a reset until the next command."""

    def __init__(self) -> None:
        self.is_started = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0:
            self.is_started = cause.data[0] in (0x81, 0x82)
        state = b"\5" if self.is_started else b"\x7f"
        return replaced(0x700 + ID, b"\x7f", state)(cause, out)


class KeepsItsHeartbeat:
    """Has another heartbeat period after a reset of communication than before it."""

    def __init__(self) -> None:
        self.is_other = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if writes(cause, 0x1017, 0x1017, 0):
            self.is_other = cause.data[4] == 0x65
        other = answering(0x1017, 0, 0x4B, b"\x65\0")
        return other(cause, out) if self.is_other else out


class SendsInPreOperational:
    """Sends a PDO at each SYNC in PRE-OPERATIONAL."""

    def __init__(self) -> None:
        self.is_started = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0:
            self.is_started = cause.data[0] == 1
        is_sync = cause.can_id == 0x80 and not self.is_started
        return [*out, Frame(0x180 + ID, b"\0")] if is_sync else out


class ObeysOthers:
    """Shows that it is stopped after a command to node 255."""

    def __init__(self) -> None:
        self.is_stopped = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0:
            self.is_stopped = cause.data[1] == 255
        return replaced(0x700 + ID, b"", b"\4")(cause, out) if self.is_stopped else out


class IgnoresLong:
    """Answers reads of the application with older values after an RPDO 1 of three octets."""

    def __init__(self) -> None:
        self.values: dict[bytes, list[Frame]] = {}
        self.is_old = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0x200 + ID:
            self.is_old = len(cause.data) == 3
        if not to_server(cause, 0x40) or cause.data[2] < 0x20:
            return out
        if not self.is_old:
            self.values[cause.data] = out
        return self.values.get(cause.data, out)


def accepts_wrong_lengths(cause: Frame, out: list[Frame]) -> list[Frame]:
    """Accept values of the application with a wrong length, and store nothing."""
    refused = [f for f in out if f.data[:1] + f.data[5:8] == b"\x80\0\x07\6"]
    is_write = cause.can_id == 0x600 + ID and cause.data[0] >> 5 == 1
    is_application = is_write and cause.data[2] >= 0x20
    return acknowledged(cause) if refused and is_application else out


def without_boot_up(command: int) -> Alter:
    """Send no boot-up message after an NMT command."""
    return lambda cause, out: (
        [f for f in out if f.can_id != 0x700 + ID or f.data != b"\0"]
        if cause.can_id == 0 and cause.data[:1] == bytes((command,))
        else out
    )


def instead_of_abort(
    code: int, answer: Answer, where: Where = lambda cause: True
) -> Alter:
    """Answer something else instead of an abort code."""
    octets = code.to_bytes(4, "little")
    return lambda cause, out: (
        answer(cause)
        if where(cause)
        and any(f.data[:1] + f.data[4:] == b"\x80" + octets for f in out)
        else out
    )


def plain(first: int) -> Answer:
    """Return a server message with one significant octet, the first."""
    return lambda cause: [Frame(0x580 + ID, bytes((first,)) + bytes(7))]


def selected_by_any_serial(cause: Frame, out: list[Frame]) -> list[Frame]:
    if cause.can_id == 0x7E5 and cause.data[:1] == b"\x43":
        return [Frame(0x7E4, b"\x44" + bytes(7))]
    return out


def selected_by_any_revision(cause: Frame, out: list[Frame]) -> list[Frame]:
    """Select a node with serial number 1, whatever the other numbers are."""
    is_serial = cause.can_id == 0x7E5 and cause.data[:5] == b"\x43\1\0\0\0"
    return [Frame(0x7E4, b"\x44" + bytes(7))] if is_serial else out


def too_high_is_stored(cause: Frame, out: list[Frame]) -> list[Frame]:
    refused = [f for f in out if f.data[4:8] == (0x06090031).to_bytes(4, "little")]
    return acknowledged(cause) if refused else out
