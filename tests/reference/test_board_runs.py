"""RH3 with its wheels on a TECS motor board: in simulated time, and with the board elsewhere."""

from __future__ import annotations

import io
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from math import hypot
from pathlib import Path
from typing import Any

import pytest
from board_line import SerialLine, TcpLine
from free_ports import free_port
from pipeline import MAX_DURATION, NAVIGATION, at_end, goal, profile

from refnav.geometry import Pose, wrap
from refnav.simulated_motor_board import SimulatedMotorBoard
from refrobots.rh3 import BoardEvent, BoardEventKind
from rtgen.compiler.project import load
from rtgen.compiler.systems.timeline import assignment, parse
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    SECOND,
    Clock,
    JsonLinesRecorder,
    RealClock,
    Record,
    SampleRecord,
    SimulatedClock,
    System,
)
from rtgen.tools.running.assembly import assemble
from rtgen.tools.running.factories import Factories

TECS = NAVIGATION.parent / "tecs"
BOARD = TECS / "rh3_board.xml"
WATCHDOG = 100_000_000
"""Time in which the board may stop without commands [ns]."""
CYCLE = SECOND // 1000
"""A parameter takes effect at the end of the board's cycle."""
CUT = """
[[at]]
t = {begin}
set = "SimulatedMotorBoard0.link=0"

[[at]]
t = {end}
set = "SimulatedMotorBoard0.link=1"
"""


def build(
    settings: Sequence[str] = (), timeline: str = "", clock: Clock | None = None
) -> System:
    system = profile(BOARD)
    values = [assignment(text, system) for text in settings]
    steps = parse(timeline, "timeline.toml", system)
    clock = clock or SimulatedClock()
    return assemble(system, Factories(load()), clock, values, steps)


def truth(system: System) -> Pose:
    return Pose(*system.observable("SimulatedMotorBoard0.truth"))


def assert_at(pose: Pose, x: float, y: float, theta: float) -> None:
    assert hypot(pose.x - x, pose.y - y) < 0.05
    assert abs(wrap(pose.theta - theta)) < 0.03


def nanoseconds(instant: Any) -> int:
    return int(instant.sec) * SECOND + int(instant.nsec)


class Log:
    """The entries of the board's log."""

    def __init__(self) -> None:
        self.events: list[BoardEvent] = []

    def __call__(self, record: Record) -> None:
        if isinstance(record, SampleRecord) and record.port == "events":
            self.events.append(record.value)

    @property
    def kinds(self) -> list[BoardEventKind]:
        return [event.kind for event in self.events]

    def only(self, kind: BoardEventKind) -> BoardEvent:
        [event] = [event for event in self.events if event.kind is kind]
        return event


def test_the_base_reaches_the_goal_of_the_reference_run() -> None:
    log = Log()
    with build() as system:
        system.add_listener(log)
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 3.4, 7.7, -1.57)
        answered, unanswered = system.observable("RefHardRh3Tecs0.calls")
        assert answered > 4000
        assert unanswered == 0
        assert {system.statistics(name).lost for name in system.instances} == {0}
    assert log.kinds == [BoardEventKind.DRIVING]


@pytest.mark.sampled(0)
def test_the_board_stops_without_its_line_and_the_run_goes_on() -> None:
    log = Log()
    trajectory: list[tuple[int, Pose]] = []
    with build(timeline=CUT.format(begin=12.0, end=13.0)) as system:
        system.add_listener(log)
        system.every(CYCLE, lambda: trajectory.append((system.time, truth(system))))
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 3.4, 7.7, -1.57)
        assert 95 <= system.observable("RefHardRh3Tecs0.calls")[1] <= 101
        states = [system.state(name) for name in system.instances]
        assert states.count(ACTIVE_STATE) == len(states) - 1
    assert log.kinds == [
        BoardEventKind.DRIVING,
        BoardEventKind.LINK_DOWN,
        BoardEventKind.WATCHDOG,
        BoardEventKind.LINK_UP,
        BoardEventKind.DRIVING,
    ]
    _, down, stop, up, again = log.events
    times = [nanoseconds(event.tm) for event in log.events]
    assert times[1] == 12 * SECOND + CYCLE
    assert min(down.left, down.right) > 1.0
    assert 0 < nanoseconds(stop.tm) - nanoseconds(down.tm) <= WATCHDOG
    assert nanoseconds(stop.tm) - nanoseconds(stop.command) <= WATCHDOG
    assert (stop.left, stop.right, up.left, up.right) == (0.0, 0.0, 0.0, 0.0)
    assert times[3] == 13 * SECOND + CYCLE
    still = {pose for time, pose in trajectory if times[2] < time <= times[4]}
    assert len(still) == 1
    assert nanoseconds(again.tm) - nanoseconds(up.tm) <= SECOND // 50
    ways = [hypot(b.x - a.x, b.y - a.y) for (_, a), (_, b) in pairwise(trajectory)]
    assert max(ways) < 0.001


@pytest.mark.sampled(0)
def test_two_runs_with_a_cut_give_the_same_bytes() -> None:
    logs = []
    for _ in range(2):
        stream = io.StringIO()
        with build(goal(0.5, 0.1, 0.5), CUT.format(begin=3.0, end=4.0)) as system:
            system.add_listener(JsonLinesRecorder(stream))
            assert system.run(MAX_DURATION, at_end)
            assert_at(truth(system), 0.5, 0.1, 0.5)
        logs.append(stream.getvalue())
    assert logs[0] == logs[1]
    assert logs[0].count('"kind": "WATCHDOG"') == 1


def test_a_board_at_a_serial_line() -> None:
    settings = [
        "SimulatedMotorBoard0.transport=serial",
        "SimulatedMotorBoard0.device=/dev/ttyS7",
        "OpaqueRpcCommunication0.type=SERIA",
        "OpaqueRpcCommunication0.port=/dev/ttyS7",
        "OpaqueRpcCommunication0.baudrate=115200",
    ]
    with build([*goal(0.3, 0.0, 0.5), *settings]) as system:
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 0.3, 0.0, 0.5)


def test_a_board_needs_an_address_of_its_own() -> None:
    with System(SimulatedClock()) as system:
        for name in ("First0", "Second0", "Third0"):
            system.add(SimulatedMotorBoard(name), 1000.0)
            system.configure(name, "link", "0" if name == "Third0" else "1")
            system.activate(name)
        system.run(SECOND // 100)
        assert system.state("First0") is system.state("Third0") is ACTIVE_STATE
        for name in ("Second0", "Third0"):
            system.configure(name, "link", "1")
            system.run(system.time + SECOND // 100)
            assert system.state(name) is ERROR_STATE
            assert "cannot listen" in system.statistics(name).reason
        assert system.observable("First0.truth") == (0.0, 0.0, 0.0)


def test_only_the_hardware_differs_from_the_reference_system() -> None:
    def contents(file: Path) -> tuple[set[Any], set[tuple[str, str]]]:
        system = profile(file)
        return (
            {(c.instance, c.id, c.rate, c.configuration) for c in system.components},
            {(str(c.source), str(c.target)) for c in system.connections},
        )

    components, connections = contents(NAVIGATION / "rh3_goal.xml")
    with_board, with_calls = contents(BOARD)
    assert {c[0] for c in components - with_board} == {"RefHardRh30"}
    renamed = {
        tuple(end.replace("RefHardRh30", "RefHardRh3Tecs0") for end in ends)
        for ends in connections
    }
    assert renamed < with_calls
    assert len(with_calls - renamed) == 2


# The board in another process.


class Board:
    """`rtgen run board.xml` in real time, in a process of its own."""

    def __init__(self, folder: Path, settings: dict[str, object]) -> None:
        self.log = folder / "board.jsonl"
        command = [sys.executable, "-m", "rtgen", "run", str(TECS / "board.xml")]
        command += ["--clock", "real", "--log", str(self.log)]
        for name, value in settings.items():
            command += ["--set", f"SimulatedMotorBoard0.{name}={value}"]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def wait_until_active(self) -> None:
        assert self.process.stderr is not None
        line = self.process.stderr.readline()
        assert "SimulatedMotorBoard0 ACTIVE" in line, line

    def end(self) -> str:
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=30)
        assert self.process.returncode == 0, err
        return out

    def events(self) -> list[dict[str, Any]]:
        lines = map(json.loads, self.log.read_text().splitlines())
        return [line["value"] for line in lines if line["event"] == "sample"]


@contextmanager
def tcp(folder: Path) -> Iterator[tuple[Board, TcpLine, list[str]]]:
    port = free_port()
    with TcpLine(port) as line:
        board = Board(folder, {"port": port})
        yield board, line, [f"OpaqueRpcCommunication0.port={line.port}"]


@contextmanager
def serial(folder: Path) -> Iterator[tuple[Board, SerialLine, list[str]]]:
    with SerialLine() as line:
        board = Board(folder, {"transport": "serial", "device": line.far})
        settings = ["type=SERIA", f"port={line.near}", "baudrate=115200"]
        yield board, line, [f"OpaqueRpcCommunication0.{text}" for text in settings]


@pytest.mark.nightly
@pytest.mark.waits
@pytest.mark.slow
@pytest.mark.parametrize("way", [tcp, serial], ids=["tcp", "pty"])
def test_a_board_in_another_process_stops_and_goes_on(way: Any, tmp_path: Path) -> None:
    with way(tmp_path) as (board, line, reach):
        board.wait_until_active()
        settings = ["SimulatedMotorBoard0.transport=none", *reach]
        with build([*goal(0.4, 0.0, 0.0), *settings], clock=RealClock()) as system:
            seen: list[float] = []
            system.add_listener(
                lambda r: (
                    seen.append(r.value.data.position.x)
                    if isinstance(r, SampleRecord) and r.port == "OdometryPosition"
                    else None
                )
            )
            assert system.run(30 * SECOND, lambda _: bool(seen) and seen[-1] > 0.1)
            line.cut()
            system.run(system.time + SECOND)
            line.mend()
            assert system.run(60 * SECOND, at_end)
            assert system.observable("RefHardRh3Tecs0.calls")[1] >= 1
        report = board.end()
    kinds = [event["kind"] for event in board.events()]
    assert kinds[:3] == ["DRIVING", "WATCHDOG", "DRIVING"]
    [stop, *_] = [event for event in board.events() if event["kind"] == "WATCHDOG"]
    assert (stop["left"], stop["right"]) == (0.0, 0.0)
    stopped, heard = (_milliseconds(stop[key]) for key in ("tm", "command"))
    print(f"stopped {stopped - heard:.1f} ms after the last speeds")
    [numbers] = re.findall(r"final pose\s+\((.*)\)", report)
    assert_at(Pose(*map(float, numbers.split(","))), 0.4, 0.0, 0.0)


def _milliseconds(instant: dict[str, int]) -> float:
    return instant["sec"] * 1e3 + instant["nsec"] * 1e-6
