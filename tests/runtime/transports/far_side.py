"""A system of one component on either side of a transport.

    python far_side.py ADDRESS [STEP]

runs the far side in a process of its own: it prints one line when its component is ACTIVE and its
connections are established, and ends with its input. Calls to its provider control it. With a step
it kills itself there.
"""

from __future__ import annotations

import os
import signal
import struct
import sys
import threading
from collections.abc import Callable, Collection
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from media import transport_at
from patience import PATIENCE

from refrobots._idl.basic_data_type import Time, TimedOctetSeq
from refrobots.tecs.board import MotorBoard
from rtgen import runtime
from rtgen.runtime import requests
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc, OpaqueRpcFailed

NEAR, FAR = "near", "far"
TIMEOUT = 10.0
"""Time-out of a call that is expected to return [s]."""
DATA: dict[tuple[str, str], dict[str, str]] = {
    ("many", "many"): {"buffer.length": "1000"},
    ("few", "oldest"): {"buffer.length": "2", "buffer.write.full_policy": "do_nothing"},
    ("few", "newest"): {"buffer.length": "2", "buffer.write.full_policy": "overwrite"},
    ("pulled", "pulled"): {"dataflow_type": "pull"},
}
"""Connections between an OutPort and an InPort, in both directions."""
STEPS = ("opened", "added", "connected", "active")
"""The steps of the far side's start, before it waits for the near side."""
OUT_PORTS = sorted({source for source, _ in DATA})


def sample(number: int, octets: bytes = b"") -> TimedOctetSeq:
    """Return a sample with a number and octets."""
    return TimedOctetSeq(Time(number, 0), octets)


class Turns(requests.Pace):
    """Counts the calls that ask for their turn."""

    def __init__(self) -> None:
        super().__init__(1.0)
        self.waits = self.charges = 0

    def wait(self) -> None:
        self.waits += 1

    def charge(self, seconds: float) -> None:
        assert seconds > 0.0
        self.charges += 1


class Asked(OpaqueRpc):
    """Executes the first word of a request."""

    def __init__(self, end: End) -> None:
        self._end = end
        self._carried_out = 0
        self._let_go = threading.Event()
        self._before = requests.overruns, requests.calls
        self._turns = Turns()

    def begin(self, request: bytes, first: int) -> bytes:
        name, _, rest = request.partition(b" ")
        reply: bytes = getattr(self, f"_{name.decode()}")(rest, first)
        return reply

    def _echo(self, octets: bytes, times: int) -> bytes:
        return octets * times

    def _refuse(self, reason: bytes, code: int) -> bytes:
        raise OpaqueRpcFailed(code, reason.decode())

    def _fail(self, reason: bytes, code: int) -> bytes:
        raise KeyError(reason)

    def _take(self, port: bytes, _: int) -> bytes:
        """Return the numbers of the received samples, and their octet counts."""
        pairs = [(s.tm.sec, len(s.data)) for s in self._end.take(port.decode())]
        return b"".join(struct.pack("<II", *pair) for pair in pairs)

    def _lost(self, port: bytes, _: int) -> bytes:
        return b"%d" % self._end.in_ports[port.decode()].lost

    def _write(self, port: bytes, number: int) -> bytes:
        status = self._end.out_ports[port.decode()].write(sample(number))
        return status.name.encode()

    def _counted(self, what: bytes, _: int) -> bytes:
        return b"%d" % (self._carried_out if what == b"holds" else self._end.stops)

    def _late(self, _: bytes, __: int) -> bytes:
        """Let ticks be left out from now on, and count the calls that wait because of them."""
        self._before = requests.overruns, requests.calls
        requests.overruns = requests.Overruns(lambda: 0.0)
        requests.overruns.report()
        requests.calls = self._turns = Turns()
        return b""

    def _turned(self, _: bytes, __: int) -> bytes:
        """End what `late` has begun; return how many calls have waited, and were counted."""
        requests.overruns, requests.calls = self._before
        return struct.pack("<II", self._turns.waits, self._turns.charges)

    def _release(self, _: bytes, __: int) -> bytes:
        self._let_go.set()
        return b""

    def more(self, count: int) -> bytes:
        """Hold the call until it is released."""
        self._carried_out += 1
        self._let_go.wait(PATIENCE)
        return bytes(count)

    def end(self) -> None:
        """Do nothing."""

    def reset(self) -> None:
        """Do nothing."""


class Board(MotorBoard):
    """Counts the oneway operation."""

    def __init__(self, end: End) -> None:
        self._end = end

    def stop(self) -> None:
        self._end.stops += 1

    def _unused(self, *_: object) -> Any:
        raise NotImplementedError

    identify = drive = release = _unused
    setLimits = getState = _unused  # noqa: N815 - as the interface has it


class End(runtime.Component):
    """A component with ports of each kind, controlled from outside."""

    profile = runtime.ComponentProfile("End", rate=100.0)

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.stops = 0
        for name in OUT_PORTS:
            self.add_out_port(name, TimedOctetSeq)
        for _, name in DATA:
            self.add_in_port(name, TimedOctetSeq)
        self._asked = self.add_provider("given", "rpc", OpaqueRpc)
        self._board = self.add_provider("given", "board", MotorBoard)
        self.rpc = self.add_consumer("taken", "rpc", OpaqueRpc)
        self.board = self.add_consumer("taken", "board", MotorBoard)

    def on_initialize(self) -> runtime.ReturnCode_t:
        self._asked.set_servant(Asked(self))
        self._board.set_servant(Board(self))
        return runtime.RTC_OK

    def take(self, port: str) -> list[TimedOctetSeq]:
        """Return the samples received since the last call."""
        in_port: Any = self.in_ports[port]
        found = []
        while in_port.is_new():
            found.append(in_port.read())
        return found


class Side:
    """A system with one component, over a transport that it owns."""

    def __init__(self, transport: Any, instance: str) -> None:
        self._stack = ExitStack()
        self.transport = self._stack.enter_context(transport)
        self.system = self._stack.enter_context(
            runtime.System(runtime.RealClock(), transport)
        )
        self.end = End(instance)
        self.system.add(self.end)

    def __enter__(self) -> Side:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self._stack.close()

    def connect_data(self) -> None:
        """Connect the data ports, in both directions."""
        for one, other in ((NEAR, FAR), (FAR, NEAR)):
            for (source, target), properties in DATA.items():
                stated = {f"dataport.{key}": text for key, text in properties.items()}
                self.system.connect((one, source), (other, target), stated)

    def activate(self) -> None:
        """Make the component ACTIVE."""
        name, active = self.end.instance_name, runtime.LifeCycleState.ACTIVE_STATE
        self.system.activate(name)
        self.system.run(round(PATIENCE * 1e9), lambda s: s.state(name) is active)
        assert self.system.state(name) is active


def far_side(
    transport: Any, reached: Callable[[str], object] = lambda step: None
) -> Side:
    """Return the far side, before its connections are established; `reached` gets `STEPS`."""
    reached("opened")
    side = Side(transport, FAR)
    reached("added")
    side.connect_data()
    reached("connected")
    side.activate()
    reached("active")
    return side


def _die_at(steps: Collection[str]) -> Callable[[str], None]:
    """Return a function that kills this process at one of the steps."""

    def reached(step: str) -> None:
        if step in steps:
            os.kill(os.getpid(), signal.SIGKILL)

    return reached


if __name__ == "__main__":
    address, *last = sys.argv[1:]
    with far_side(transport_at(address, TIMEOUT), _die_at(last)) as own:
        own.transport.await_others(PATIENCE)
        print("ready", flush=True)
        sys.stdin.read()
