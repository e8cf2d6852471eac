"""Components of the tests, and a system like that of a separate process."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from patience import PATIENCE, until

from refrobots._idl.basic_data_type import Time, TimedDouble
from rtgen import runtime
from rtgen.runtime.distribution.medium import Medium
from rtgen.runtime.distribution.transport import DistributedTransport
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc, OpaqueRpcFailed


def sample(number: float) -> TimedDouble:
    """Return a sample with a number."""
    return TimedDouble(Time(1, 2), number)


class Servant(OpaqueRpc):
    """Replies with its argument; `wait` holds the operation `more`."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.held = threading.Event()
        self.wait = threading.Event()

    def begin(self, request: bytes, first: int) -> bytes:
        self.calls.append("begin")
        if not request:
            raise OpaqueRpcFailed(first, "nothing was given")
        if request == b"defect":
            raise KeyError(request)
        return request * first

    def more(self, count: int) -> bytes:
        self.held.set()
        self.wait.wait(PATIENCE)
        return bytes(count)

    def end(self) -> None:
        self.calls.append("end")

    def reset(self) -> None:
        self.calls.append("reset")


@dataclass
class NodeConfig:
    """The parameters of a Node."""

    gain: float = 1.0


class Node(runtime.Component):
    """An OutPort, an InPort, a provider and a consumer, and a parameter."""

    profile = runtime.ComponentProfile(
        "Node",
        rate=100.0,
        configuration=(runtime.ParameterProfile("gain", "gain", "double", "1.0"),),
    )

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.config = self.add_configuration(NodeConfig())
        self.fails = False
        self.out = self.add_out_port("out", TimedDouble)
        self.inward = self.add_in_port("in", TimedDouble)
        self.provider = self.add_provider("given", "rpc", OpaqueRpc)
        self.consumer = self.add_consumer("taken", "rpc", OpaqueRpc)
        self.servant = Servant()
        self.received: list[float] = []

    def on_initialize(self) -> runtime.ReturnCode_t:
        self.provider.set_servant(self.servant)
        return runtime.RTC_OK

    def on_execute(self, ec_id: int) -> runtime.ReturnCode_t:
        return self.fail("it is to fail") if self.fails else runtime.RTC_OK

    def take(self) -> list[float]:
        """Return the numbers received so far."""
        while self.inward.is_new():
            value = self.inward.read()
            assert value is not None
            self.received.append(value.data)
        return self.received


def arrived(node: Node, numbers: list[float]) -> None:
    """Wait until a component has received these numbers, and check that it received no others."""
    until(lambda: len(node.take()) >= len(numbers))
    assert node.take() == numbers


class Process:
    """A system in real time over a medium; its components tick after `run`."""

    def __init__(self, medium: Medium, *instances: str, timeout: float = 10.0) -> None:
        self._stack = ExitStack()
        self.medium = medium
        self.transport = DistributedTransport(medium, timeout=timeout)
        self._stack.callback(self.transport.close)
        self.system = runtime.System(runtime.RealClock(), self.transport)
        self._stack.callback(self.system.close)
        self.nodes = {name: Node(name) for name in instances}
        for node in self.nodes.values():
            self.system.add(node)

    def __enter__(self) -> Process:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the system in order, then its transport."""
        self._stack.close()

    def node(self, name: str) -> Any:
        """Return a component of this process."""
        return self.nodes[name]

    def connect(self, source: str, target: str, **properties: str) -> Any:
        """Connect two ports, `INSTANCE.PORT`; `__` stands for a dot in a property."""
        texts = {
            f"dataport.{key.replace('__', '.')}": value
            for key, value in properties.items()
        }
        one, other = source.split("."), target.split(".")
        return self.system.connect((one[0], one[1]), (other[0], other[1]), texts)

    def ready(self) -> None:
        """Wait for the other processes."""
        self.transport.await_others(PATIENCE)

    def activate(self, instance: str) -> None:
        """Make a component ACTIVE."""
        self.system.activate(instance)
        active = runtime.LifeCycleState.ACTIVE_STATE
        self.system.run(PATIENCE * 1_000_000_000, lambda s: s.state(instance) is active)
        assert self.system.state(instance) is active
