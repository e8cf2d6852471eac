"""Table 4: generated proxy and device of one EDS exchange every data type, by PDO and by SDO."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import can
import pytest
import table_4
from hub_process import HubProcess
from patience import PATIENCE
from table_4 import Exchange

from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    LifeCycleState,
    RealClock,
    SimulatedClock,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand

pytestmark = pytest.mark.waits


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = table_4.generate(tmp_path_factory.mktemp("every_type"))
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


def check(exchange: Exchange) -> None:
    exchange.activate()
    for number, sent, got in exchange.pdos():
        assert got == sent, f"PDO {number}"
        assert [str(v) for row in got for v in row] == [
            str(v) for row in sent for v in row
        ], "the sign of zero, too"
    for name, wanted, got in exchange.objects():
        assert got == wanted, name
    assert exchange.system.statistics("Proxy0").lost == 0


def test_in_simulated_time(generated: Path) -> None:
    with Exchange(SimulatedClock(), {"node_id": 5, "master": True}) as exchange:
        device = table_4.configured(table_4.device("Device0"), {"node_id": 5})
        exchange.system.add(device, 200.0)
        check(exchange)


@pytest.fixture
def hub() -> Iterator[HubProcess]:
    with HubProcess() as hub:
        yield hub


class DeviceProcess:
    """A device in a process of its own, on a bus."""

    def __init__(self, generated: Path, bus: Mapping[str, object]) -> None:
        options = [f"{name}={value}" for name, value in bus.items()]
        command = [sys.executable, table_4.__file__, str(generated), *options]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self._read() == "ready"

    def __enter__(self) -> DeviceProcess:
        return self

    def __exit__(self, *exception: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        assert self._process.wait(PATIENCE) == 0
        assert self._process.stdout is not None
        self._process.stdout.close()

    def send_command(self, word: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()

    def state(self) -> list[str]:
        """Return the device's state, and its callbacks since the last call."""
        self.send_command("state")
        return self._read().replace("_STATE", "").split()

    def _read(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()


def bus_of(hub: HubProcess) -> dict[str, object]:
    return {
        "interface": "socketcand",
        "channel": "can0",
        "options": hub.options(),
        "node_id": 5,
    }


def test_in_two_processes(generated: Path, hub: HubProcess) -> None:
    """Over a hub, each end with a python-can bus of its own."""
    bus = bus_of(hub)
    with (
        DeviceProcess(generated, bus),
        Exchange(RealClock(), {**bus, "master": True}) as exchange,
    ):
        check(exchange)


class Observer:
    """Observes NMT commands and states on the bus, by python-can alone."""

    def __init__(self, hub: HubProcess) -> None:
        self._bus = can.Bus(
            interface="socketcand",
            channel="can0",
            host=hub.host,
            port=hub.port,
            tcp_tune=True,
        )
        self._states: list[int] = []

    def __enter__(self) -> Observer:
        return self

    def __exit__(self, *exception: object) -> None:
        self._bus.shutdown()

    def send(self, command: NmtCommand) -> None:
        data = (command, 5)
        self._bus.send(can.Message(arbitration_id=0, data=data, is_extended_id=False))

    def seen(self, last: int) -> list[str]:
        """Return frames up to the error control frame of state `last`, which is sent once."""
        found: list[str] = []
        limit = time.monotonic() + PATIENCE
        while time.monotonic() < limit:
            message = self._bus.recv(1.0)
            if message is None:
                continue
            can_id, data = message.arbitration_id, bytes(message.data)
            if can_id == 0x000:
                found.append(f"NMT {data[0]:02X}")
            elif can_id == 0x085:
                found.append(f"EMCY {data[1]:02X}{data[0]:02X}")
            elif can_id == 0x705 and self._states[-1:] != [data[0]]:
                self._states.append(data[0])
                found.append(f"{data[0]:02X}")
                if data[0] == last:
                    return found
        raise AssertionError(f"{last:02X} was not seen, but {found}")


@pytest.mark.sampled(0)
def test_life_cycle_in_two_processes(generated: Path, hub: HubProcess) -> None:
    """Each transition of figure 110 from both sides, with the frames on the bus."""
    bus = bus_of(hub)
    settings = {**bus, "master": True}
    with (
        Observer(hub) as observer,
        DeviceProcess(generated, bus) as device,
        Exchange(RealClock(), settings) as exchange,
    ):
        system = exchange.system

        def both(state: LifeCycleState, *wanted_calls: str) -> None:
            """Run until proxy and device are in the state; check the callbacks of the device.

            The state changes after `on_activated`, but before `on_aborting`.
            """
            wanted = state.name.removesuffix("_STATE")
            found, calls = "", list[str]()
            limit = system.time + 20 * SECOND
            assert system.run(
                limit, until=lambda s: s.state("Proxy0") is state
            ), exchange.proxy.reason
            while system.time < limit:
                found, *more = device.state()
                calls += more
                if found == wanted and len(calls) >= len(wanted_calls):
                    break
                time.sleep(0.01)
            assert (found, calls) == (wanted, [*wanted_calls])

        # 1, 2: created, and inactive.
        assert observer.seen(0x7F) == ["00", "7F"]
        both(INACTIVE_STATE)
        # 3, 4 from the proxy.
        system.activate("Proxy0")
        both(ACTIVE_STATE, "on_activated")
        assert observer.seen(0x05) == ["NMT 01", "05"]
        system.deactivate("Proxy0")
        both(INACTIVE_STATE, "on_deactivated")
        assert observer.seen(0x7F) == ["NMT 80", "7F"]
        # 4 from the device.
        system.activate("Proxy0")
        both(ACTIVE_STATE, "on_activated")
        device.send_command("deactivate")
        both(INACTIVE_STATE, "on_deactivated")
        assert observer.seen(0x05) == ["NMT 01", "05"]
        assert observer.seen(0x7F) == ["7F"]
        # 6 and 7, 8 from the proxy.
        system.context("Proxy0").fail_component(exchange.proxy, "on purpose")
        both(ERROR_STATE, "on_aborting")
        assert observer.seen(0x04) == ["NMT 02", "04"]
        system.reset("Proxy0")
        both(INACTIVE_STATE, "on_reset")
        assert observer.seen(0x7F) == ["NMT 81", "00", "7F"]
        # 5 from the proxy.
        system.activate("Proxy0")
        both(ACTIVE_STATE, "on_activated")
        system.context("Proxy0").fail_component(exchange.proxy, "on purpose")
        both(ERROR_STATE, "on_aborting")
        assert observer.seen(0x04) == ["NMT 01", "05", "NMT 02", "04"]
        system.reset("Proxy0")
        both(INACTIVE_STATE, "on_reset")
        assert observer.seen(0x7F) == ["NMT 81", "00", "7F"]
        # 6 from the device, 5 from the device.
        device.send_command("fail")
        both(ERROR_STATE, "on_aborting")
        assert "EMCY 6200" in observer.seen(0x04)
        assert "EMCY 6200h user software" in exchange.proxy.reason
        system.reset("Proxy0")
        both(INACTIVE_STATE, "on_reset")
        assert observer.seen(0x7F)[-3:] == ["NMT 81", "00", "7F"]
        system.activate("Proxy0")
        both(ACTIVE_STATE, "on_activated")
        assert observer.seen(0x05) == ["NMT 01", "05"]
        device.send_command("fail")
        both(ERROR_STATE, "on_aborting")
        assert "EMCY 6200" in observer.seen(0x04)
        system.reset("Proxy0")
        both(INACTIVE_STATE, "on_reset")
        # 3 from another station on the bus.
        observer.send(NmtCommand.START)
        both(ACTIVE_STATE, "on_activated")
        observer.send(NmtCommand.ENTER_PRE_OPERATIONAL)
        both(INACTIVE_STATE, "on_deactivated")
        observer.send(NmtCommand.STOP)
        both(ERROR_STATE, "on_aborting")
        assert exchange.proxy.reason == "node 5 was stopped"
        system.reset("Proxy0")
        both(INACTIVE_STATE, "on_reset")
        # 10 from the device.
        system.activate("Proxy0")
        both(ACTIVE_STATE, "on_activated")
        device.send_command("remove")
        limit = system.time + 20 * SECOND
        assert system.run(limit, until=lambda s: s.state("Proxy0") is ERROR_STATE)
