"""Tests a node on a python-can bus."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.canopen.bus.messages import frame_of
from rtgen.runtime.canopen.bus.python_can import OpenBus
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import SECOND, Frame
from rtgen.tools.can.decoding.node_index import NoNodeIdError, read_node_index
from rtgen.tools.can.live.live_bus import opened, send
from rtgen.tools.can.project_bus import project_buses
from rtgen.tools.conformance.canopen.checks import CHECKS
from rtgen.tools.conformance.canopen.node import Bounds, NodeUnderTest, SilenceError
from rtgen.tools.conformance.check import Permission
from rtgen.tools.conformance.report import Report
from rtgen.tools.conformance.subject import Subject
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.signals import terminable

_DEVICE_TYPE = (0x1000, 0)
"""The object that every node has (CiA 301, 7.5.2.1)."""
_POLL_INTERVAL = 0.1
"""Longest wait for a frame in seconds, so that Ctrl-C is noticed."""


class BusLine:
    """The frames of an open bus. Methods raise ToolError if the bus is lost."""

    def __init__(self, bus: OpenBus) -> None:
        self._bus = bus
        self.remote_frames = bus.carries_remote_frames

    def now(self) -> int:
        """Return the time in ns."""
        return time.monotonic_ns()

    def send(self, frame: Frame) -> None:
        """Send a frame."""
        send(self._bus, frame)

    def receive(self, until: int) -> Frame | None:
        """Return the next frame, None if there is none by that time."""
        while True:
            remaining = (until - self.now()) / SECOND
            try:
                message = self._bus.receive(min(max(remaining, 0.0), _POLL_INTERVAL))
            except LinkError as error:
                raise ToolError(f"the bus is gone: {error}") from error
            frame = None if message is None else frame_of(message)
            if frame is not None or remaining <= 0:
                return frame


def of_project(subject: Subject, console: Console) -> tuple[Path, Subject]:
    """Return the description of a node of the project's bus, the only one without a node-id.

    The subject is that node, on the bus with the bit rate of its file. Raises InputError, Refusal,
    ReportedError.
    """
    indices = [read_node_index(file, ()) for file in project_buses(console)]
    nodes = [
        (index, node)
        for index in indices
        if index.bus is not None
        for node in index.bus.nodes
        if subject.node_id in (None, node.id)
    ]
    if len(nodes) != 1:
        names = ", ".join(f"{node.id} ({node.name})" for _, node in nodes)
        of = (
            f"one of {names}"
            if nodes
            else "that of a node in a bus file of the project"
        )
        raise Refusal(f"which node? Give FILE, or --node N: {of}")
    [(index, node)] = nodes
    access = subject.access.on(index)
    file = Path(node.kind.device.file)
    return file, replace(subject, node_id=node.id, access=access)


def tested(file: Path, subject: Subject) -> Report:
    """Return the report of all checks. Raises InputError, Refusal and ToolError."""
    try:
        node_index = read_node_index(None, [(subject.node_id, file)])
    except NoNodeIdError:
        raise Refusal(f"{file} has no node-id; --node N names it") from None
    (described,) = node_index.nodes.values()
    bounds = Bounds(round(subject.timeout * SECOND), round(subject.boot * SECOND))
    with opened(subject.access) as bus:
        node = NodeUnderTest(described, BusLine(bus), bounds)
        return checked(node, file.as_posix(), subject.permissions)


def checked(
    node: NodeUnderTest, definition: str, permissions: Collection[Permission]
) -> Report:
    """Return the report of all checks of a node. Raises ToolError if the node is not there.

    They begin with a reset of communication, which reverts what a manager has written. After Ctrl-C
    and SIGTERM, too, the node is left in PRE-OPERATIONAL.
    """
    try:
        node.read_code(_DEVICE_TYPE)
    except SilenceError:
        raise ToolError(
            f"node {node.id} does not answer",
            hint="`rtgen can scan` lists the nodes of the bus; a stopped node has no SDO",
        ) from None
    try:
        with terminable():
            node.restart()
            outcomes = tuple(check.outcome(node, permissions) for check in CHECKS)
    except KeyboardInterrupt:
        node.restart()
        raise
    return Report(f"{node.described.name} (node {node.id})", definition, outcomes)
