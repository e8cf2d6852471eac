"""Nodes that conform to CiA 301 in ways of their own pass `rtgen conformance`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from can_nodes import SPECS, description
from conformance_nodes import ID, SimulatedLine, failed, report_of, unaltered

from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import (
    MILLISECOND,
    SDO_REQUEST,
    Frame,
)
from rtgen.tools.can.decoding.node_index import read_node_index
from rtgen.tools.conformance.canopen.node import NodeUnderTest
from rtgen.tools.conformance.canopen.testing import checked
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report, Verdict

PALETTE = SPECS / "f_palette.eds"
_RPDO_CODES = (4, 6, 8, 10)
_ABORT = 0x80


class CyclicLine(SimulatedLine):
    """A node that takes RPDOs in a task with a cycle of 30 ms."""

    def __init__(self, node: DeviceNode) -> None:
        super().__init__(node, unaltered)
        self._late: list[tuple[int, Frame]] = []

    def send(self, frame: Frame) -> None:
        if frame.can_id & 0x7F == ID and frame.can_id >> 7 in _RPDO_CODES:
            self._late.append((self.now() + 30 * MILLISECOND, frame))
        else:
            super().send(frame)

    def receive(self, until: int) -> Frame | None:
        while self._late and self._late[0][0] <= until:
            frame = super().receive(self._late[0][0])
            if frame is not None:
                return frame
            _, late = self._late.pop(0)
            super().send(late)
        return super().receive(until)


class ListeningLine(SimulatedLine):
    """A line that notes the requests to the SDO server, and its answers."""

    def __init__(self, node: DeviceNode, alter: Callable[..., list[Frame]]) -> None:
        super().__init__(node, alter)
        self.requests: list[bytes] = []

    def send(self, frame: Frame) -> None:
        if frame.can_id == SDO_REQUEST + ID:
            self.requests.append(frame.data)
        super().send(frame)


def report_on(line: SimulatedLine, eds: Path) -> Report:
    (described,) = read_node_index(None, [(ID, eds)]).nodes.values()
    node = NodeUnderTest(described, line)
    return checked(node, eds.name, [Permission.ACTUATE, Permission.DEFAULTS])


def changed(tmp_path: Path, section: str, old: str, new: str) -> Path:
    """Return f_palette with another text in a section."""
    text = PALETTE.read_text()
    begin = text.index(f"[{section}]")
    end = text.index("\n\n", begin)
    body = text[begin:end]
    assert old in body
    path = tmp_path / "f_palette.eds"
    path.write_text(text[:begin] + body.replace(old, new) + text[end:])
    return path


def verdicts(report: Report, name: str) -> list[Verdict]:
    return [o.verdict for o in report.outcomes if o.check == name]


def test_a_node_that_takes_rpdos_in_a_task() -> None:
    line = CyclicLine(DeviceNode(description(PALETTE), ID, serial_number=1))
    assert failed(report_on(line, PALETTE)) == set()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("inhibit", [200, 1000, 5000])
def test_a_tpdo_with_an_inhibit_time(inhibit: int, tmp_path: Path) -> None:
    old, new = "DefaultValue=0", f"DefaultValue={inhibit}"
    eds = changed(tmp_path, "1800sub3", old, new)
    assert failed(report_of(eds)) == set()


def test_a_tpdo_whose_inhibit_time_cannot_be_changed(tmp_path: Path) -> None:
    eds = changed(tmp_path, "1800sub3", "rw\nDefaultValue=0", "ro\nDefaultValue=5000")
    assert failed(report_of(eds)) == set()


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("section", "check"),
    [
        ("1016sub1", "heartbeat.consumer"),
        ("1017", "heartbeat"),
        ("1800sub5", "pdo.times"),
        ("1800sub3", "pdo.times"),
    ],
)
def test_settings_with_narrow_limits(section: str, check: str, tmp_path: Path) -> None:
    old = "DefaultValue=100" if section == "1017" else "DefaultValue=0"
    limits = "DefaultValue=0\nLowLimit=0\nHighLimit=20"
    eds = changed(tmp_path, section, old, limits)
    report = report_of(eds)
    assert failed(report) == set()
    assert verdicts(report, check) != [Verdict.FAILED]


def test_a_description_that_leaves_the_identity_open(tmp_path: Path) -> None:
    eds = changed(
        tmp_path, "1018sub1", "DefaultValue=0x00FFFF01", "DefaultValue=0x00000000"
    )
    line = SimulatedLine(
        DeviceNode(description(PALETTE), ID, serial_number=1), unaltered
    )
    assert failed(report_on(line, eds)) == set()


def test_a_transfer_that_has_no_answer_is_aborted_before_the_next() -> None:
    answers = 0
    swallowed: list[int] = []

    def alter(cause: Frame, frames: list[Frame]) -> list[Frame]:
        """Swallow each tenth answer of the SDO server."""
        nonlocal answers
        if cause.can_id != SDO_REQUEST + ID or not frames:
            return frames
        answers += 1
        if answers % 10:
            return frames
        swallowed.append(len(line.requests))
        return []

    line = ListeningLine(DeviceNode(description(PALETTE), ID, serial_number=1), alter)
    report_on(line, PALETTE)
    assert len(swallowed) > 10
    following = [line.requests[number] for number in swallowed[:-1]]
    assert {request[0] for request in following} == {_ABORT}
