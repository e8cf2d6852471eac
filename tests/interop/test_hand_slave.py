"""A generated proxy and the generated manager with a hand-written slave, in real time.

The slave (`slave_peer/hand_slave.py`) uses struct and python-can alone.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import can
import pytest
from patience import PATIENCE

from rtgen.cli import run
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    Component,
    LifeCycleState,
    RealClock,
    SampleRecord,
    System,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.library import canopen

sys.path.insert(0, str(Path(__file__).parents[1] / "runtime" / "canopen"))
from hub_process import HubProcess

pytestmark = pytest.mark.waits

FOLDER = Path(__file__).with_name("slave_peer")
CHANNELS = count()
NODE = 5


@pytest.fixture(scope="module", autouse=True)
def hand(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Make the generated package `hand` and the slave importable."""
    work = tmp_path_factory.mktemp("hand")
    shutil.copytree(FOLDER, work, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(work)
        assert run(["generate", "--no-cache", "--quiet"]) == 0
        patch.syspath_prepend(str(work / "generated"))
        patch.syspath_prepend(str(work))
        yield
    for name in list(sys.modules):
        if name.partition(".")[0] in ("hand", "hand_slave"):
            del sys.modules[name]


def of(module: str, name: str) -> Any:
    return getattr(importlib.import_module(module), name)


class Bench:
    """A system with a proxy, a manager unless the proxy is the master, and the slave."""

    def __init__(
        self,
        *,
        manager: bool,
        hub: HubProcess | None = None,
        own_slave: bool = False,
        channel: str = "",
    ) -> None:
        """Initialize; with `own_slave` the test creates the slave."""
        self.channel = channel or f"hand{next(CHANNELS)}"
        self.system = System(RealClock())
        self.proxy = of("hand.components.hand_slave_proxy", "HandSlaveProxy")("Proxy0")
        self.manager = of("hand.canopen.manager", "CanopenManager")("Manager0")
        parameters = self.proxy.configuration_sets
        for component in (self.proxy, self.manager):
            component.configuration_sets.set("channel", self.channel)
            if hub is not None:
                options = f"host={hub.host},port={hub.port},tcp_tune=true"
                component.configuration_sets.set("interface", "socketcand")
                component.configuration_sets.set("options", options)
        parameters.set("node_id", str(NODE))
        parameters.set("network", "hand" if manager else "")
        parameters.set("master", "0" if manager else "1")
        self.source = Component("Source0")
        self.targets = self.source.add_out_port("out", self.proxy.rpdo1.type)
        self.system.add(self.proxy, 200.0)
        self.system.add(self.source)
        if manager:
            self.system.add(self.manager, 100.0)
        self.system.connect(("Source0", "out"), ("Proxy0", "rpdo1"))
        self.samples: list[Any] = []
        self.system.add_listener(self._note)
        if own_slave:
            self.end_slave = lambda: None
        elif hub is None:
            self._begin_thread()
        else:
            self._begin_process(hub)

    def _begin_thread(self) -> None:
        bus = can.Bus(interface="virtual", channel=self.channel)
        self.slave = of("hand_slave", "Slave")(bus, NODE)
        ended = threading.Event()

        def serve() -> None:
            self.slave.reset()
            while not ended.is_set():
                self.slave.step()
            bus.shutdown()

        thread = threading.Thread(target=serve)
        thread.start()

        def end() -> None:
            ended.set()
            thread.join()

        self.end_slave = end

    def _begin_process(self, hub: HubProcess) -> None:
        options = (f"host={hub.host}", f"port={hub.port}", "tcp_tune=true")
        process = subprocess.Popen(
            [
                *(sys.executable, str(FOLDER / "hand_slave.py"), str(NODE)),
                *("socketcand", self.channel, *options),
            ],
            stdout=subprocess.PIPE,
        )
        assert process.stdout is not None
        with process.stdout as output:
            assert output.readline() == b"ready\n"

        def end() -> None:
            process.kill()
            process.wait()

        self.end_slave = end

    def _note(self, record: object) -> None:
        if isinstance(record, SampleRecord) and record.port == "tpdo1":
            self.samples.append(record.value)

    def close(self) -> None:
        self.system.close()
        self.end_slave()
        for thread in threading.enumerate():
            if f" {self.channel} " in thread.name:
                thread.join(PATIENCE)
                assert not thread.is_alive(), thread.name

    def wait(self, condition: Callable[[], bool]) -> None:
        limit = self.system.time + 20 * SECOND
        assert self.system.run(limit, until=lambda _: condition()), self.proxy.reason

    def until(self, state: LifeCycleState, instance: str = "Proxy0") -> None:
        self.wait(lambda: self.system.state(instance) is state)

    def call(self, operation: str, *arguments: object) -> Any:
        return self.proxy.sdo.call(operation, arguments)


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench(manager=True)
    yield bench
    bench.close()


def activated(bench: Bench) -> Bench:
    bench.system.activate("Manager0")
    bench.system.activate("Proxy0")
    bench.until(ACTIVE_STATE)
    return bench


def test_the_manager_sets_it_up_and_samples_go_both_ways(bench: Bench) -> None:
    activated(bench)
    slave = bench.slave
    assert slave.number(0x1017) == 200
    assert slave.number(0x1800, 2) == 1
    assert slave.number(0x1800, 1) == 0x40000185
    bench.wait(lambda: len(bench.samples) >= 20)
    counters = [sample.Counter for sample in bench.samples]
    assert counters == list(range(counters[0], counters[0] + len(counters)))
    for target in (-(2**31), 2**31 - 1, 0, -5):
        sample = bench.proxy.rpdo1.type()
        sample.Target, sample.Mode = target, 200
        bench.targets.write(sample)
        bench.wait(lambda: bench.samples[-1].Position == target)  # noqa: B023
    assert slave.number(0x2004) == 200
    bench.system.deactivate("Proxy0")
    bench.until(INACTIVE_STATE)
    assert slave.state == 127
    bench.system.activate("Proxy0")
    bench.until(ACTIVE_STATE)
    assert slave.state == 5


@pytest.mark.parametrize("size", [0, 1, 4, 5, 7, 8, 127, 128, 890, 5000])
def test_transfers_of_every_kind(bench: Bench, size: int) -> None:
    activated(bench)
    data = bytes(place * 31 % 251 for place in range(size))
    bench.call("set_Data", data)
    assert bench.slave.objects[0x2000, 0][2] == data
    assert bench.call("get_Data") == data


def test_objects_by_name(bench: Bench) -> None:
    activated(bench)
    assert bench.call("get_Manufacturer_device_name") == (
        "A slave that was written by hand"
    )
    assert bench.call("get_Vendor_ID") == 0x00FFFF02
    assert bench.call("get_Serial_number") == 4711
    bench.call("set_Target", -7)
    assert bench.slave.number(0x2003) == -7
    aborted = canopen.SdoAbort
    with pytest.raises(aborted) as refused:
        bench.call("read", 0x2005, 0)
    assert refused.value.code == 0x06010001
    with pytest.raises(aborted) as refused:
        bench.call("write", 0x1000, 0, bytes(4))
    assert refused.value.code == 0x06010002
    with pytest.raises(SdoAbort, match="06090011h"):
        bench.proxy.read_octets(0x1018, 9)


def test_an_emergency_leads_to_error_and_a_reset_back(bench: Bench) -> None:
    activated(bench)
    bench.call("set_Emergency", 0x2310)
    bench.until(ERROR_STATE)
    assert "2310h" in bench.proxy.reason
    bench.wait(lambda: bench.slave.state == 4)
    bench.system.reset("Proxy0")
    bench.wait(lambda: bench.system.state("Proxy0") is not ERROR_STATE)
    # The manager configures the node again, and starts it: the proxy follows.
    bench.until(ACTIVE_STATE)
    assert bench.slave.number(0x1800, 2) == 1


def test_a_slave_that_falls_silent(bench: Bench) -> None:
    activated(bench)
    bench.slave.set(0x2006, 1)
    bench.until(ERROR_STATE)
    bench.until(ERROR_STATE, "Manager0")
    expected = "hand (node 5): its heartbeat is lost: none for 1500 ms"
    assert bench.manager.reason == expected
    bench.slave.set(0x2006, 0)
    bench.system.reset("Manager0")
    bench.until(INACTIVE_STATE, "Manager0")
    bench.system.activate("Manager0")
    bench.until(ACTIVE_STATE, "Manager0")
    bench.system.reset("Proxy0")
    bench.until(ACTIVE_STATE)
    assert [s.phase.name for s in bench.manager.reports()] == ["NODE_RUNNING"]


def test_a_slave_that_boots_again_is_set_up_again(bench: Bench) -> None:
    activated(bench)
    bench.slave.obey(0x81)
    bench.wait(lambda: bench.slave.number(0x1800, 2) == 1)
    bench.until(ERROR_STATE)
    bench.system.reset("Proxy0")
    bench.until(ACTIVE_STATE)


def test_the_service_of_the_manager(bench: Bench) -> None:
    activated(bench)
    manager = bench.manager.manager

    def state() -> Any:
        (state,) = manager.call("states", ())
        return state

    running = state()
    assert (running.id, running.name, running.restarts) == (NODE, "hand", 0)
    assert (running.phase.name, running.nmt.name) == ("NODE_RUNNING", "NMT_OPERATIONAL")
    assert bench.manager.now() - running.tm.sec * SECOND - running.tm.nsec > 0
    manager.call("enter_pre_operational", (NODE,))
    bench.wait(lambda: state().nmt.name == "NMT_PRE_OPERATIONAL")
    assert state().phase.name == "NODE_HALTED"
    manager.call("start", (0,))
    bench.wait(lambda: state().phase.name == "NODE_RUNNING")
    for reset in ("reset_communication", "reset_node"):
        manager.call("stop", (NODE,))
        bench.wait(lambda: state().nmt.name == "NMT_STOPPED")
        # It requests another stop when it enters ERROR.
        bench.until(ERROR_STATE)
        manager.call(reset, (NODE,))
        bench.wait(lambda: state().phase.name == "NODE_RUNNING")
    refused = canopen.Refused
    with pytest.raises(refused) as raised:
        manager.call("start", (6,))
    assert raised.value.reason == "the network hand has no node 6"


def test_a_proxy_that_is_the_master() -> None:
    bench = Bench(manager=False)
    try:
        bench.system.activate("Proxy0")
        bench.until(ACTIVE_STATE)
        # By its EDS: the event timer sends.
        bench.wait(lambda: len(bench.samples) >= 5)
        bench.slave.obey(2)
        bench.until(ERROR_STATE)
        bench.system.reset("Proxy0")
        bench.until(INACTIVE_STATE)
        bench.system.activate("Proxy0")
        bench.until(ACTIVE_STATE)
    finally:
        bench.close()


@pytest.mark.nightly
def test_in_another_process_over_a_hub() -> None:
    with HubProcess() as hub:
        bench = Bench(manager=True, hub=hub)
        try:
            activated(bench)
            bench.wait(lambda: len(bench.samples) >= 20)
            counters = [sample.Counter for sample in bench.samples]
            assert counters == list(range(counters[0], counters[0] + len(counters)))
            sample = bench.proxy.rpdo1.type()
            sample.Target, sample.Mode = -123456, 3
            bench.targets.write(sample)
            bench.wait(lambda: bench.samples[-1].Position == -123456)
            assert bench.call("get_Mode") == 3
            data = bytes(range(256)) * 20
            bench.call("set_Data", data)
            assert bench.call("get_Data") == data
            bench.call("set_Emergency", 0x8130)
            bench.until(ERROR_STATE)
            assert "8130h heartbeat or guarding lost" in bench.proxy.reason
            bench.system.reset("Proxy0")
            bench.until(ACTIVE_STATE)
            bench.end_slave()
            bench.until(ERROR_STATE)
            bench.until(ERROR_STATE, "Manager0")
        finally:
            bench.close()


def test_it_needs_nothing_but_python_can() -> None:
    """The peer is independent: it imports neither rtgen nor the `canopen` package."""
    code = (
        "import sys; sys.path.insert(0, '.'); import hand_slave; "
        "print([m for m in sys.modules if m.partition('.')[0] in ('rtgen', 'canopen')])"
    )
    completed = subprocess.run(
        [sys.executable, "-c", code], cwd=FOLDER, capture_output=True, text=True
    )
    assert completed.stdout.strip() == "[]"
