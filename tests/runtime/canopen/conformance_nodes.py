"""Nodes alone on a simulated line, and their reports of `rtgen conformance`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from can_nodes import SPECS, description

from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.can.decoding.node_index import read_node_index
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.canopen.testing import checked
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report, Verdict

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
