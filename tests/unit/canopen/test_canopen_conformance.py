"""`rtgen conformance`: rtgen's nodes pass, and each check fails for a node that violates it."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from can_nodes import SPECS, description, nodes
from hub_process import HubProcess
from json_schemas import valid

from refnav.epos_drive_device import EposDriveDevice
from rtgen.cli import run
from rtgen.cli.can.decoding.node_index import read_node_index
from rtgen.cli.conformance.canopen.checks import CHECKS
from rtgen.cli.conformance.canopen.node import NodeUnderTest
from rtgen.cli.conformance.canopen.testing import checked
from rtgen.cli.conformance.check import Permission
from rtgen.cli.conformance.report import (
    Report,
    Verdict,
    as_html,
    as_json_text,
    as_junit,
    as_text,
)
from rtgen.runtime import RealClock, System
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtState

ID = 5
Alter = Callable[[Frame, list[Frame]], list[Frame]]


class SimulatedLine:
    """A node alone on a line, in simulated time; `alter` changes its frames."""

    remote_frames = True

    def __init__(self, node: DeviceNode, alter: Alter, latency: int = 100_000) -> None:
        self._node, self._alter, self._latency = node, alter, latency
        self._time = 0
        self._waiting: list[tuple[int, Frame]] = []
        self._put(Frame(0x7FF), node.boot(0))

    def now(self) -> int:
        return self._time

    def send(self, frame: Frame) -> None:
        self._put(frame, self._node.receive(frame, self._time))

    def receive(self, until: int) -> Frame | None:
        while True:
            deadline = self._node.deadline
            first = self._waiting[0][0] if self._waiting else until + 1
            if deadline is not None and deadline <= min(first, until):
                self._time = max(self._time, deadline)
                self._put(Frame(0x7FF), self._node.poll(self._time))
                continue
            if first > until:
                self._time = max(self._time, until)
                return None
            self._time = max(self._time, first)
            return self._waiting.pop(0)[1]

    def _put(self, cause: Frame, frames: Iterable[Frame]) -> None:
        due = self._time + self._latency
        self._waiting += [(due, frame) for frame in self._alter(cause, list(frames))]


def unaltered(cause: Frame, frames: list[Frame]) -> list[Frame]:
    return frames


def report_of(eds: Path, alter: Alter = unaltered, *, actuate: bool = True) -> Report:
    (described,) = read_node_index(None, [(ID, eds)]).nodes.values()
    line = SimulatedLine(DeviceNode(description(eds), ID, serial_number=1), alter)
    permissions = [Permission.ACTUATE, Permission.DEFAULTS] if actuate else []
    return checked(NodeUnderTest(described, line), eds.name, permissions)


def failed(report: Report) -> set[str]:
    return {o.check for o in report.outcomes if o.verdict is Verdict.FAILED}


NAMES = ("f_palette", "motor_core_unit", "ftmd", "epos_drive")


@pytest.mark.parametrize("name", NAMES)
def test_our_own_nodes_conform(name: str) -> None:
    report = report_of(SPECS / f"{name}.eds")
    assert report.passed, as_text(report)
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert skipped <= {"sdo.write-only", "guarding", "guarding.life", "pdo.synchronous"}


def test_configured_values_that_the_node_does_not_have(tmp_path: Path) -> None:
    text = (SPECS / "motor_core_unit.eds").read_text()
    head, begin, rest = text.partition("[1A00sub0]\n")
    assert begin
    path = tmp_path / "configured.dcf"
    path.write_text(f"{head}{begin}ParameterValue=1\n{rest}")
    report = report_of(path)
    assert report.passed, as_text(report)


def with_default(folder: Path, name: str, section: str, value: str) -> Path:
    """Return one of our EDS files with another default of an object."""
    head, begin, rest = (SPECS / name).read_text().partition(f"[{section}]\n")
    old, end, rest = rest.partition("\n[")
    new = re.sub("(?m)^DefaultValue=.*$", f"DefaultValue={value}", old)
    assert new != old
    path = folder / name
    path.write_text(head + begin + new + end + rest)
    return path


def test_a_node_without_emergencies(tmp_path: Path) -> None:
    eds = with_default(tmp_path, "f_palette.eds", "1014", "0x80000081")
    report = report_of(eds)
    assert report.passed, as_text(report)
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert {"emcy.entry", "emcy.reset", "heartbeat.consumer"} <= skipped


def test_tpdos_without_mapped_objects(tmp_path: Path) -> None:
    eds = with_default(tmp_path, "motor_core_unit.eds", "1A00sub0", "0")
    report = report_of(eds)
    assert report.passed, as_text(report)


def limited(folder: Path) -> Path:
    """Return f_palette with additions: limits, objects of other access, guarding, remote frames."""
    text = (SPECS / "f_palette.eds").read_text()
    for group, objects in (
        ("Optional", {0x100C: ("0x0006", "rw", ""), 0x100D: ("0x0005", "rw", "")}),
        (
            "Manufacturer",
            {
                0x2F00: ("0x0003", "ro", "LowLimit=-100\nHighLimit=100\n"),
                0x2F01: ("0x0006", "wo", ""),
                0x2F02: ("0x0006", "rw", "LowLimit=0\nHighLimit=10\n"),
                0x2F03: ("0x0007", "rw", "PDOMapping=1\n"),
            },
        ),
    ):
        head, count = f"[{group}Objects]\nSupportedObjects=", len(objects)
        start = text.index(head) + len(head)
        before = int(text[start:].split("\n", 1)[0])
        listed = "".join(
            f"{before + place}=0x{index:X}\n" for place, index in enumerate(objects, 1)
        )
        end = text.index("\n\n", start) + 1
        body = text[start:end].replace(str(before), str(before + count), 1)
        text = text[:start] + body + listed + text[end:]
        for index, (kind, access, limits) in objects.items():
            text += (
                f"\n[{index:X}]\nParameterName=Object {index:X}\nObjectType=0x7\n"
                f"DataType={kind}\nAccessType={access}\nDefaultValue=0\n{limits}"
            )
    # TPDO 1 may be requested by remote frames.
    assert "DefaultValue=$NODEID+0x40000180" in text
    text = text.replace("DefaultValue=$NODEID+0x40000180", "DefaultValue=$NODEID+0x180")
    path = folder / "limited.eds"
    path.write_text(text)
    return path


def test_a_node_with_everything_conforms(tmp_path: Path) -> None:
    report = report_of(limited(tmp_path))
    assert report.passed, as_text(report)


def test_without_actuate_the_node_stays_as_it_was(tmp_path: Path) -> None:
    eds = limited(tmp_path)
    sent: list[Frame] = []

    def alter(cause: Frame, out: list[Frame]) -> list[Frame]:
        sent.append(cause)
        return out

    report = report_of(eds, alter, actuate=False)
    assert report.passed
    skipped = {o.check for o in report.outcomes if o.verdict is Verdict.SKIPPED}
    assert skipped >= {check.name for check in CHECKS if check.needs is not None}
    assert Frame(0, bytes((1, ID))) not in sent
    written = {
        int.from_bytes(f.data[1:3], "little")
        for f in sent
        if f.can_id == 0x600 + ID and not f.remote and f.data[0] & 0xE0 == 0x20
    }
    read_only = {
        v.index
        for v in read_node_index(None, [(ID, eds)]).nodes[ID].device.variables
        if not v.access.writable
    }
    assert {i for i in written - read_only if i >= 0x2000} <= {0x5FFF, 0xFFFF}


# Mutants: each violates one check only.


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


def refusing(command: int, index: int, sub: int = 0, code: int = 0x08000000) -> Alter:
    return lambda cause, out: (
        sdo_abort(cause, code) if at(cause, command, index, sub) else out
    )


def accepting(command: int, index: int, sub: int = 0, most: int = 4) -> Alter:
    return lambda cause, out: (
        acknowledged(cause)
        if at(cause, command, index, sub) and 4 - (cause.data[0] >> 2 & 3) <= most
        else out
    )


def answering(index: int, sub: int, first: int, value: bytes) -> Alter:
    """Return another expedited value for an object."""
    return lambda cause, out: (
        [Frame(0x580 + ID, bytes((first,)) + cause.data[1:4] + value.ljust(4, b"\0"))]
        if out and at(cause, 0x40, index, sub)
        else out
    )


def changed(
    can_id: int, change: Callable[[bytes], bytes | None], *, of: Alter = unaltered
) -> Alter:
    """Change the data of the frames of an identifier; None drops the frame."""

    def alter(cause: Frame, out: list[Frame]) -> list[Frame]:
        made = []
        for frame in of(cause, out):
            data = change(frame.data) if frame.can_id == can_id else frame.data
            made += [] if data is None else [Frame(frame.can_id, data)]
        return made

    return alter


def to_command(first: int, answer: Callable[[Frame], list[Frame]]) -> Alter:
    return lambda cause, out: (
        answer(cause)
        if cause.can_id == 0x600 + ID and cause.data[:1] == bytes((first,))
        else out
    )


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


class RefusesItsOwnValue:
    """Refuses the values of digital outputs that it would store."""

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
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
            and cause.can_id == 0x600 + ID
            and cause.data[:1] == b"\x40"
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
        shown = changed(0x700 + ID, lambda data: state if data == b"\x7f" else data)
        return shown(cause, out)


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
        is_stopped = self.is_stopped
        shown = changed(0x700 + ID, lambda data: b"\4" if is_stopped else data)
        return shown(cause, out)


class IgnoresLong:
    """Answers reads of the application with older values after an RPDO 1 of three octets."""

    def __init__(self) -> None:
        self.values: dict[bytes, list[Frame]] = {}
        self.is_old = False

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
        if cause.can_id == 0x200 + ID:
            self.is_old = len(cause.data) == 3
        is_read = cause.can_id == 0x600 + ID and cause.data[:1] == b"\x40"
        if not is_read or cause.data[2] < 0x20:
            return out
        if not self.is_old:
            self.values[cause.data] = out
        return self.values.get(cause.data, out)


class TwoOctets:
    """Accepts values of the application with a wrong length, and does not store them."""

    def __call__(self, cause: Frame, out: list[Frame]) -> list[Frame]:
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
    code: int, answer: Callable[[Frame], list[Frame]], where: Callable[[Frame], bool]
) -> Alter:
    """Answer something else instead of an abort code."""
    octets = code.to_bytes(4, "little")
    return lambda cause, out: (
        answer(cause)
        if where(cause)
        and any(f.data[:1] + f.data[4:] == b"\x80" + octets for f in out)
        else out
    )


def plain(first: int) -> Callable[[Frame], list[Frame]]:
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


MUTANTS: dict[str, tuple[str, Alter]] = {
    "sdo.read": ("f_palette", refusing(0x40, 0x1018, 4)),
    "object.type": ("f_palette", answering(0x6000, 1, 0x4B, b"\0\0")),
    "object.limits": ("limited", answering(0x2F00, 0, 0x4B, b"\xff\x7f")),
    "object.constants": ("f_palette", answering(0x1000, 0, 0x43, b"\x99\0\0\0")),
    "object.defaults": ("limited", answering(0x2F02, 0, 0x4B, b"\5\0")),
    "pdo.parameters": ("f_palette", answering(0x1800, 3, 0x4B, b"\x99\0")),
    "sdo.read-only": ("f_palette", accepting(0x20, 0x1018, 1)),
    "sdo.write-only": ("limited", answering(0x2F01, 0, 0x4B, b"\0\0")),
    "sdo.unknown": ("f_palette", refusing(0x40, 0x5FFF)),
    "sdo.length": ("f_palette", accepting(0x20, 0x1017, most=1)),
    "sdo.command": ("f_palette", to_command(0xE0, lambda f: sdo_abort(f, 0x08000000))),
    "sdo.toggle": (
        "f_palette",
        instead_of_abort(0x05030000, plain(0x10), lambda f: f.data[:1] == b"\x70"),
    ),
    "sdo.abort": ("f_palette", AfterAbort()),
    "sdo.block": (
        "f_palette",
        lambda cause, out: (
            [Frame(f.can_id, f.data[:1] + b"?" + f.data[2:]) for f in out]
            if cause.data[:1] == b"\xa3"
            else out
        ),
    ),
    "sdo.segments": (
        "f_palette",
        instead_of_abort(0x05030000, plain(0x30), lambda f: f.data[:1] == b"\x1b"),
    ),
    "sdo.block-download": (
        "f_palette",
        instead_of_abort(0x05040004, plain(0xA1), lambda f: True),
    ),
    "sdo.block-sizes": (
        "f_palette",
        instead_of_abort(0x05040002, plain(0xC6), lambda f: True),
    ),
    "sdo.block-repeats": (
        "f_palette",
        lambda cause, out: (
            [Frame(f.can_id, f.data[:1] + b"\1" + f.data[2:]) for f in out]
            if cause.data[:1] == b"\x82" and cause.can_id == 0x600 + ID
            else out
        ),
    ),
    "emcy.history": (
        "f_palette",
        instead_of_abort(0x06090030, acknowledged, lambda f: at(f, 0x20, 0x1003)),
    ),
    "heartbeat": ("f_palette", EverySecondBeat()),
    "guarding": (
        "limited",
        lambda cause, out: (
            [Frame(f.can_id, bytes((f.data[0] & 0x7F,))) for f in out]
            if cause.remote
            else out
        ),
    ),
    "nmt.boot-up": ("f_palette", without_boot_up(0x82)),
    "nmt.parameters": ("f_palette", KeepsItsHeartbeat()),
    "nmt.stopped": ("f_palette", ServedWhenStopped()),
    "nmt.states": (
        "f_palette",
        changed(0x700 + ID, lambda data: b"\x7f" if data == b"\x05" else data),
    ),
    "sdo.range": ("limited", too_high_is_stored),
    "sdo.lengths": ("f_palette", TwoOctets()),
    "sdo.same-value": ("f_palette", RefusesItsOwnValue()),
    "pdo.synchronous": ("motor_core_unit", SilentAtSync()),
    "pdo.reception": ("f_palette", OldValues(synchronous=False)),
    "pdo.length": (
        "f_palette",
        changed(
            0x80 + ID,
            lambda data: b"\0\0" + data[2:] if data[:2] == b"\x10\x82" else data,
        ),
    ),
    "pdo.states": ("f_palette", SendsInPreOperational()),
    "pdo.content": ("limited", changed(0x180 + ID, lambda data: data[::-1])),
    "pdo.identifiers": (
        "f_palette",
        instead_of_abort(
            0x06090030,
            acknowledged,
            lambda f: writes(f, 0x1400, 0x19FF, 1) and not f.data[7] & 0x80,
        ),
    ),
    "pdo.mapping": (
        "f_palette",
        instead_of_abort(
            0x06040041, acknowledged, lambda f: f.data[4:] == b"\x20\0\0\x10"
        ),
    ),
    "pdo.transmission": (
        "f_palette",
        instead_of_abort(
            0x06090030, acknowledged, lambda f: writes(f, 0x1800, 0x19FF, 2)
        ),
    ),
    "pdo.times": ("f_palette", SlowTimer()),
    "pdo.synchronous-reception": ("f_palette", OldValues(synchronous=True)),
    "emcy.entry": ("f_palette", answering(0x1003, 1, 0x43, b"\x30\x81\0\0")),
    "emcy.reset": (
        "f_palette",
        changed(0x80 + ID, lambda data: None if data[:2] == b"\0\0" else data),
    ),
    "heartbeat.consumer": (
        "f_palette",
        changed(0x80 + ID, lambda data: None if data[:2] == b"\x30\x81" else data),
    ),
    "guarding.life": ("limited", LosesItsGuard()),
    "nmt.reset": ("f_palette", without_boot_up(0x81)),
    "lss.address": ("f_palette", selected_by_any_serial),
    "lss.identify": (
        "f_palette",
        changed(0x7E4, lambda data: None if data[:1] == b"\x4f" else data),
    ),
    "lss.identity": (
        "f_palette",
        changed(0x7E4, lambda data: b"\x5b\x63" if data[:1] == b"\x5b" else data),
    ),
    "lss.refusals": (
        "f_palette",
        changed(0x7E4, lambda data: b"\x11\0" if data[:1] == b"\x11" else data),
    ),
}
FURTHER: dict[str, tuple[str, str, Alter]] = {
    "nothing by remote frames": (
        "pdo.transmission",
        "limited",
        lambda cause, out: (
            [f for f in out if not 0x180 <= f.can_id < 0x580] if cause.remote else out
        ),
    ),
    "too many objects are mapped": (
        "pdo.mapping",
        "f_palette",
        instead_of_abort(0x06040042, acknowledged, lambda f: True),
    ),
    "a false count of segments": (
        "sdo.block-sizes",
        "f_palette",
        instead_of_abort(0x05040003, plain(0xC1), lambda f: True),
    ),
    "segments that are too long": (
        "sdo.segments",
        "f_palette",
        instead_of_abort(
            0x06070012, acknowledged, lambda f: f.data[:3] == b"\x21\x17\x10"
        ),
    ),
    "no bit of the error register": (
        "emcy.entry",
        "f_palette",
        answering(0x1001, 0, 0x4F, b"\0"),
    ),
    "another node with its LSS address": (
        "lss.address",
        "f_palette",
        lambda cause, out: [f for f in out for _ in range(1 + (f.can_id == 0x7E4))],
    ),
    "selected by another revision number": (
        "lss.address",
        "f_palette",
        selected_by_any_revision,
    ),
    "its own node-id is not accepted": (
        "lss.refusals",
        "f_palette",
        changed(0x7E4, lambda data: b"\x11\1" if data[:1] == b"\x11" else data),
    ),
    "an answer in the LSS state waiting": (
        "lss.address",
        "f_palette",
        lambda cause, out: (
            [Frame(0x7E4, bytes((0x5E, ID)) + bytes(6))]
            if cause.can_id == 0x7E5 and cause.data[:1] == b"\x5e"
            else out
        ),
    ),
    "a second boot-up message": (
        "nmt.boot-up",
        "f_palette",
        lambda cause, out: (
            out + [f for f in out if f.data == b"\0" and f.can_id == 0x700 + ID]
        ),
    ),
    "it starts by itself": (
        "nmt.boot-up",
        "f_palette",
        StartsItself(),
    ),
    "another error register in the emergency": (
        "emcy.entry",
        "f_palette",
        changed(0x80 + ID, lambda data: data[:2] + b"\x81" + data[3:]),
    ),
    "the older error first": (
        "emcy.entry",
        "f_palette",
        answering(0x1003, 2, 0x43, b"\x20\x82\0\0"),
    ),
    "a long RPDO is ignored": ("pdo.length", "f_palette", IgnoresLong()),
    "a limit is refused": (
        "sdo.range",
        "limited",
        lambda cause, out: (
            sdo_abort(cause, 0x06090031)
            if at(cause, 0x20, 0x2F02) and cause.data[4] == 10
            else out
        ),
    ),
    "types over 24 are refused": (
        "pdo.transmission",
        "f_palette",
        lambda cause, out: (
            sdo_abort(cause, 0x06090030)
            if writes(cause, 0x1800, 0x19FF, 2) and cause.data[4] == 240
            else out
        ),
    ),
    "its own type is refused": (
        "pdo.transmission",
        "f_palette",
        lambda cause, out: (
            sdo_abort(cause, 0x06090030)
            if writes(cause, 0x1800, 0x19FF, 2) and cause.data[4] == 255
            else out
        ),
    ),
    "an entry of a mapping in use": (
        "pdo.mapping",
        "f_palette",
        instead_of_abort(
            0x06010003, acknowledged, lambda f: writes(f, 0x1A00, 0x1BFF, 1)
        ),
    ),
    "an aborted transfer goes on": (
        "sdo.abort",
        "f_palette",
        AbortsNothing(),
    ),
    "a toggle bit of a download": (
        "sdo.segments",
        "f_palette",
        lambda cause, out: (
            [Frame(f.can_id, b"\x30" + f.data[1:]) for f in out]
            if out and out[0].data[:1] == b"\x20" and cause.can_id == 0x600 + ID
            else out
        ),
    ),
    "commands to other node-ids": (
        "nmt.states",
        "f_palette",
        ObeysOthers(),
    ),
    "a bit rate that does not exist": (
        "lss.refusals",
        "f_palette",
        changed(0x7E4, lambda data: b"\x13\0" if data[:1] == b"\x13" else data),
    ),
}
"""Mutants of other nodes: the check that has to fail, the node, and what it does."""


def test_each_check_has_a_mutant() -> None:
    assert list(MUTANTS) == [check.name for check in CHECKS]


@pytest.mark.parametrize("check", MUTANTS)
def test_a_check_finds_the_node_that_breaks_just_it(check: str, tmp_path: Path) -> None:
    name, alter = MUTANTS[check]
    eds = SPECS / f"{name}.eds" if name != "limited" else limited(tmp_path)
    report = report_of(eds, alter)
    assert failed(report) == {check}, as_text(report)


@pytest.mark.parametrize("what", FURTHER)
def test_a_check_finds_other_nodes_too(what: str, tmp_path: Path) -> None:
    check, name, alter = FURTHER[what]
    eds = SPECS / f"{name}.eds" if name != "limited" else limited(tmp_path)
    report = report_of(eds, alter)
    assert failed(report) == {check}, as_text(report)


def test_an_answer_that_is_not_valid_is_no_refusal() -> None:
    report = report_of(SPECS / "f_palette.eds", MUTANTS["sdo.block"][1])
    [outcome] = [o for o in report.outcomes if o.check == "sdo.block"]
    assert outcome.problems == ("an answer is not valid: 05040004h CRC error",)


@pytest.mark.parametrize("at", [10, 450, 600, 750, 900])
def test_a_node_is_left_in_pre_operational_after_sigterm(at: int) -> None:
    """At some frame of the checks, with the node in any state."""
    count = 0

    def interrupted(cause: Frame, frames: list[Frame]) -> list[Frame]:
        nonlocal count
        count += 1
        if count == at:
            signal.raise_signal(signal.SIGTERM)
        return frames

    eds = SPECS / "f_palette.eds"
    (described,) = read_node_index(None, [(ID, eds)]).nodes.values()
    node = DeviceNode(description(eds), ID, serial_number=1)
    subject = NodeUnderTest(described, SimulatedLine(node, interrupted))
    with pytest.raises(KeyboardInterrupt):
        checked(subject, eds.name, [Permission.ACTUATE])
    assert node.state is NmtState.PRE_OPERATIONAL
    assert node.get(0x1017) == DeviceNode(description(eds), ID).get(0x1017)


# Reports and the command.


@pytest.mark.waits
def test_a_component_in_real_time_conforms(capfd: pytest.CaptureFixture[str]) -> None:
    """The states of a component follow its node's within a tick, and commands are faster.

    A busy machine may be late for the periods of the checks.
    """
    with HubProcess() as hub, System(RealClock()) as system:
        device = EposDriveDevice("device")
        for name, value in (
            ("interface", "socketcand"),
            ("options", hub.options()),
            ("node_id", str(ID)),
        ):
            device.configuration_sets.set(name, value)
        system.add(device, 200.0)
        system.run(1)
        where = [*("--interface", "socketcand"), *("--option", f"port={hub.port}")]
        eds = str(SPECS / "epos_drive.eds")
        run(["conformance", eds, "--node", str(ID), *where, "--actuate", "--json"])
        outcomes = json.loads(capfd.readouterr().out)["outcomes"]
        wrong = {
            o["check"]: o["problems"] for o in outcomes if o["verdict"] == "failed"
        }
        assert wrong.keys() <= {"heartbeat", "pdo.times"}, wrong
        assert device.node.state is NmtState.PRE_OPERATIONAL


def broken() -> Report:
    return report_of(SPECS / "f_palette.eds", refusing(0x40, 0x5FFF), actuate=False)


def test_reports_in_each_form() -> None:
    report = broken()
    text = as_text(report)
    assert "failed   sdo.unknown" in text
    assert "- 5FFFh: it was refused with 08000000h, not with 06020000h" in text
    content = valid(as_json_text(report), "conformance.schema.json")
    assert content["passed"] is False
    assert [o["check"] for o in content["outcomes"]] == [c.name for c in CHECKS]
    suite = ElementTree.fromstring(as_junit(report))
    assert suite.get("failures") == "1"
    (failure,) = suite.findall("testcase/failure")
    assert failure.text is not None
    assert failure.text.startswith("5FFFh")
    page = as_html(report)
    assert page.count("<tr class=") == len(CHECKS)
    assert "<script" not in page


def test_texts_of_a_definition_are_data_in_reports() -> None:
    hostile = "<script>alert(1)</script>\x00]]>&\"'"
    outcome = replace(broken().outcomes[0], problems=(hostile,), verdict=Verdict.FAILED)
    report = Report(hostile, hostile, (outcome,))
    assert "<script" not in as_html(report)
    suite = ElementTree.fromstring(as_junit(report))
    shown = hostile.replace("\x00", "\N{REPLACEMENT CHARACTER}")
    assert suite.get("name") == shown
    assert [e.text for e in suite.iter("failure")] == [shown]
    assert json.loads(as_json_text(report))["subject"] == hostile


def test_the_command_on_a_bus(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    eds, page = str(SPECS / "f_palette.eds"), tmp_path / "report.html"
    suite = tmp_path / "report.xml"
    arguments = ["conformance", eds, "--node", str(ID), "--timeout", "0.5"]
    arguments += ["--connect", "virtual:conformance"]
    with nodes("conformance", {ID: "f_palette"}):
        code = run([*arguments, "--json", "--html", str(page), "--junit", str(suite)])
    said = capfd.readouterr()
    assert code == 0, said
    assert valid(said.out, "conformance.schema.json")["passed"]
    assert ElementTree.parse(suite).getroot().get("failures") == "0"
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert run(arguments) == 3
    assert "node 5 does not answer" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["board.txt"], "is not an EDS, a DCF, a CDL file or"),
        (["f_palette.eds", "--connect", "can0"], "not INTERFACE:CHANNEL"),
        (["f_palette.eds", "--connect", "virtual:x"], "--node N"),
        (["nothing.eds", "--node", "1", "--connect", "virtual:x"], "nothing.eds"),
    ],
)
def test_what_the_command_refuses(
    arguments: list[str],
    word: str,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(SPECS)
    assert run(["conformance", *arguments]) == 2
    assert word in capfd.readouterr().err
