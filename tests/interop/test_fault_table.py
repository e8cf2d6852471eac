"""The table of faults in docs/canopen.md, with a hand-written slave over hub and pseudo-terminal.

If the environment variable RTGEN_CANOPEN_NODE names a program, its node replaces the slave in
further tests. It has the objects and PDOs of `slave_peer/hand_slave.eds` from 1000h to 2004h, and
is called as `PROGRAM NODE tcp HOST PORT CHANNEL` (socketcand's protocol) or as `PROGRAM NODE pty
PATH` (slcan). Lines of its standard input are `mute`, `unmute`, `reset` (by itself, as after a
watchdog), and `emcy CODE COUNT`; it ends with its input. It writes `running` at each boot.
"""

from __future__ import annotations

import os
import re
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import pytest
from test_hand_slave import NODE, Bench, hand, of

from rtgen.runtime import ACTIVE_STATE, ERROR_STATE, INACTIVE_STATE
from rtgen.runtime.canopen.master import node_control
from rtgen.runtime.canopen.wire.frames import SECOND
from rtgen.runtime.canopen.wire.nmt import NmtCommand

from hub_process import HubProcess  # isort: skip

__all__ = ["hand"]
PAGE = Path(__file__).parents[2] / "docs/canopen.md"
STATES = {"ACTIVE": ACTIVE_STATE, "ERROR": ERROR_STATE}
CHANNEL = "faults"


@dataclass(frozen=True, slots=True)
class Row:
    """A fault and its expected outcome."""

    proxy: str
    phase: str
    reason: str
    back: tuple[str, ...]


def table() -> dict[str, Row]:
    """Return the rows of the page, by the text before the colon of their first cell."""
    text = PAGE.read_text(encoding="utf-8").partition("\n## Faults\n")[2]
    rows = re.findall(
        r"^\| (.+?) \| (.+?) \| (.+?) \| (.*?) ?\| (.*?) ?\|$", text, re.M
    )
    found = {}
    for name, proxy, manager, _, back in rows[1 : 10 + 1]:
        phase, _, reason = manager.partition(": ")
        steps = tuple(filter(None, back.split("; ")))
        found[name.partition(":")[0]] = Row(proxy, phase, reason, steps)
    return found


TABLE = table()


class Node:
    """A hand-written slave with its own connection, in a thread; `cut` switches it off."""

    def __init__(self, connect: Callable[[], can.BusABC]) -> None:
        self._connect = connect
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def power(self) -> None:
        bus = self._connect()
        self.slave = of("hand_slave", "Slave")(bus, NODE)
        ended = self._ended = threading.Event()

        def serve() -> None:
            # Its bus may be closed, too.
            with suppress(can.CanError, OSError), bus:
                self.slave.reset()
                while not ended.is_set():
                    self.slave.step()

        self._thread = threading.Thread(target=serve)
        self._thread.start()

    def cut(self) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def reset(self) -> None:
        self.slave.obey(0x81)

    def mute(self, *, on: bool) -> None:
        self.slave.set(0x2006, int(on))

    def emergencies(self, *codes: int) -> None:
        for code in codes:
            data = code.to_bytes(2, "little") + bytes(6)
            self.slave.send(0x80 + NODE, data)


class Program:
    """The node of a program; `cut` kills it."""

    def __init__(self, program: str, connect: Callable[[], tuple[str, ...]]) -> None:
        self._program = program
        self._connect = connect
        self._process: subprocess.Popen[str] | None = None

    def power(self) -> None:
        self._process = subprocess.Popen(
            [self._program, str(NODE), *self._connect()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "running\n"

    def cut(self) -> None:
        if self._process is not None:
            process, self._process = self._process, None
            process.kill()
            process.communicate()

    def reset(self) -> None:
        self._say("reset")

    def mute(self, *, on: bool) -> None:
        self._say("mute" if on else "unmute")

    def emergencies(self, *codes: int) -> None:
        for code in codes:
            self._say(f"emcy {code:x} 1")

    def _say(self, line: str) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()


@dataclass
class Line:
    """The hub, the bench, and nodes on either kind of connection."""

    medium: str
    faults: tuple[str, ...] = ()
    program: str = ""
    hub: HubProcess = field(init=False)
    bench: Bench = field(init=False)

    def __enter__(self) -> Line:
        ptys = ("--slcan-pty", "--slcan-pty", "--slcan-channel", CHANNEL)
        self.options = (*(ptys if self.medium == "pty" else ()), *self.faults)
        self.hub = HubProcess(*self.options)
        self._used = iter(self.hub.ptys)
        self.node, self.second = self.made(), self.made()
        self.bench = Bench(manager=True, hub=self.hub, own_slave=True, channel=CHANNEL)
        return self

    def made(self) -> Node | Program:
        """Return a node without power."""
        if self.program:
            if self.medium == "pty":
                path = next(self._used)
                return Program(self.program, lambda: ("pty", path))
            port = str(self.hub.port)
            place = ("tcp", self.hub.host, port, CHANNEL)
            return Program(self.program, lambda: place)
        return Node(self.connection())

    def connection(self) -> Callable[[], can.BusABC]:
        """Return a function that opens a connection of a node: a pseudo-terminal, or a socket."""
        if self.medium == "pty":
            path = next(self._used)
            return lambda: can.Bus(interface="slcan", channel=path, sleep_after_open=0)
        return self.listener

    def listener(self) -> can.BusABC:
        """Return a connection by a socket."""
        return can.Bus(
            interface="socketcand",
            channel=CHANNEL,
            host=self.hub.host,
            port=self.hub.port,
            tcp_tune=True,
        )

    def __exit__(self, *exception: object) -> None:
        self.node.cut()
        self.second.cut()
        self.bench.close()
        self.hub.__exit__(None, None, None)

    def activate(self) -> None:
        for name in ("Manager0", "Proxy0"):
            self.bench.system.activate(name)

    def work(self) -> None:
        self.activate()
        self.bench.until(ACTIVE_STATE)

    def report(self) -> Any:
        (report,) = self.bench.manager.station.reports()
        return report

    def expect(self, row: Row) -> None:
        bench = self.bench
        bench.until(STATES[row.proxy])
        phases = [each.removeprefix("NODE_") for each in row.phase.split(" or ")]
        bench.wait(lambda: self.report().phase.name in phases)
        assert row.reason in self.report().reason


def received(bus: can.BusABC) -> Iterator[can.Message]:
    """Yield the frames that a connection has received by now."""
    while (message := bus.recv(0)) is not None:
        yield message


# The faults: each creates its own and returns a function that ends it.


def missing(line: Line) -> Callable[[], None]:
    line.activate()
    return line.node.power


def late(line: Line) -> Callable[[], None]:
    with line.listener() as bus:
        line.activate()
        line.bench.until(ERROR_STATE)
        # A pseudo-terminal buffers data sent before the node boots, including the proxy's stop.
        stop = bytes((NmtCommand.STOP, NODE))
        line.bench.wait(lambda: any(m.data == stop for m in received(bus)))
    line.node.power()
    return lambda: None


def working(line: Line) -> None:
    line.node.power()
    line.work()


def killed(line: Line) -> Callable[[], None]:
    working(line)
    line.node.cut()
    return line.node.power


def reset(line: Line) -> Callable[[], None]:
    working(line)
    line.node.reset()
    return lambda: None


def silent(line: Line) -> Callable[[], None]:
    working(line)
    line.node.mute(on=True)
    return lambda: line.node.mute(on=False)


def doubled(line: Line) -> Callable[[], None]:
    working(line)
    line.second.power()
    return line.second.cut


def storm_that_stops(line: Line) -> Callable[[], None]:
    working(line)
    line.node.emergencies(*range(0x2300, 0x2300 + 500))
    return lambda: None


def storm_that_reports(line: Line) -> Callable[[], None]:
    working(line)
    line.node.emergencies(*([0x8210] * 500))
    line.bench.wait(lambda: "8210h" in line.bench.proxy.reason)
    return lambda: None


def losses(line: Line) -> Callable[[], None]:
    working(line)
    line.bench.wait(lambda: len(line.bench.samples) > 100)
    return lambda: None


def bus_gone(line: Line) -> Callable[[], None]:
    working(line)
    port = line.hub.port
    line.hub.__exit__(None, None, None)

    def back() -> None:
        line.node.cut()
        line.hub = HubProcess(*line.options, port=port)
        line._used = iter(line.hub.ptys)
        line.node = line.made()
        line.node.power()
        link = line.bench.manager.station.link
        line.bench.wait(lambda: link.up)

    return back


FAULTS: dict[str, Callable[[Line], Callable[[], None]]] = {
    "missing": missing,
    "late": late,
    "killed": killed,
    "reset": reset,
    "silent": silent,
    "doubled": doubled,
    "storm of emergencies that stop": storm_that_stops,
    "storm of emergencies that report": storm_that_reports,
    "losses": losses,
    "bus gone": bus_gone,
}


def test_every_fault_of_the_page_is_done() -> None:
    assert list(TABLE) == list(FAULTS)


@contextmanager
def line_of(name: str, medium: str, program: str = "") -> Iterator[Line]:
    if medium == "pty":
        pytest.importorskip("serial", reason="pyserial, for slcan")
    lossy = ("--fault", "loss=0.02", "--seed", "1") if name == "losses" else ()
    with Line(medium, lossy, program) as line:
        yield line


@pytest.mark.sampled(4)
@pytest.mark.waits
@pytest.mark.parametrize("medium", ["hub", pytest.param("pty", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_has_the_state_and_the_way_back_of_the_page(
    name: str, medium: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name != "losses":
        # No command is lost, but on a busy machine a node takes its time for it.
        monkeypatch.setattr(node_control, "_MIN_TIMEOUT", 20 * SECOND)
    with line_of(name, medium) as line:
        fault(name, line)


@pytest.mark.waits
@pytest.mark.slow
@pytest.mark.parametrize("medium", ["hub", "pty"])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_the_node_of_a_program(name: str, medium: str) -> None:
    program = os.environ.get("RTGEN_CANOPEN_NODE")
    if not program:
        pytest.skip("RTGEN_CANOPEN_NODE names no program")
    with line_of(name, medium, program) as line:
        fault(name, line)


def fault(name: str, line: Line) -> None:
    """Check the fault, its effect, and the recovery."""
    row = TABLE[name]
    end = FAULTS[name](line)
    line.expect(row)
    system = line.bench.system
    for step in row.back:
        if step in ("power", "end of the fault"):
            end()
        elif step == "reset of the manager and the proxy":
            system.reset("Manager0")
            line.bench.until(INACTIVE_STATE, "Manager0")
            system.activate("Manager0")
            line.bench.until(ACTIVE_STATE, "Manager0")
            system.reset("Proxy0")
        else:
            assert step == "reset of the proxy"
            system.reset("Proxy0")
    line.bench.until(ACTIVE_STATE)
    seen = len(line.bench.samples)
    line.bench.wait(lambda: len(line.bench.samples) > seen + 5)
