"""Figure 110 with components at both ends: a proxy and a device, driven from either side."""

from __future__ import annotations

import pytest
from device_bench import DEVICE
from device_bench import NODE_ID as NODE
from stations import Recorder
from test_canopen_device import Slave
from test_proxy_and_node import SlaveProxy

from rtgen.runtime import RTC_ERROR, SECOND, System
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.wire.frames import EMERGENCY, ERROR_CONTROL, NMT
from rtgen.runtime.canopen.wire.nmt import NmtCommand, command_frame

START, STOP, PREOP, RESET = 0x01, 0x02, 0x80, 0x81
PROXY, DEVICE_NAME = "Slave0", "slave"


class Pair:
    """A proxy and a device on a simulated bus, with a record of its frames."""

    def __init__(self) -> None:
        self.system = System()
        self.link = open_link(self.system.clock)
        self.recorder = Recorder()
        self.link.attach(self.recorder)
        self.proxy = SlaveProxy()
        self.system.add(self.proxy, 100.0)
        self.device = Slave(DEVICE_NAME)
        self.system.add(self.device, 100.0)
        self.run(0.05)

    def __enter__(self) -> Pair:
        return self

    def __exit__(self, *exception: object) -> None:
        self.system.close()

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def both(self, state: str, seconds: float = 5.0) -> None:
        """Run until both are in that state."""

        def there(system: System) -> bool:
            return self.states == (state, state)

        self.system.run(self.system.time + round(seconds * SECOND), until=there)
        assert self.states == (state, state), self.proxy.reason

    @property
    def states(self) -> tuple[str, str]:
        """The states of the proxy and of the device."""
        names = [self.system.state(name).name for name in (PROXY, DEVICE_NAME)]
        return names[0].removesuffix("_STATE"), names[1].removesuffix("_STATE")

    @property
    def commands(self) -> list[int]:
        return [f.data[0] for f in self.recorder.frames if f.can_id == NMT]

    @property
    def error_control(self) -> list[int]:
        """States in the error control, without repetitions."""
        found: list[int] = []
        for frame in self.recorder.frames:
            if frame.can_id == ERROR_CONTROL + NODE and frame.data[0] not in found[-1:]:
                found.append(frame.data[0])
        return found

    @property
    def called(self) -> list[str]:
        """The device's callbacks since the last call."""
        calls, self.device.called[:] = list(self.device.called), []
        return calls


def active() -> Pair:
    pair = Pair()
    pair.system.activate(PROXY)
    pair.both("ACTIVE")
    pair.proxy.calls.clear()
    assert pair.called == ["on_initialize", "on_activated"]
    return pair


def in_error() -> Pair:
    pair = active()
    pair.system.context(PROXY).fail_component(pair.proxy, "on purpose")
    pair.both("ERROR")
    pair.proxy.calls.clear()
    assert pair.called == ["on_aborting"]
    return pair


def test_1_2_created_and_inactive() -> None:
    with Pair() as pair:
        assert pair.states == ("INACTIVE", "INACTIVE")
        assert pair.called == ["on_initialize"]
        assert pair.error_control == [0x00]


def test_3_from_the_proxy() -> None:
    with active() as pair:
        assert pair.commands == [START]
        pair.run(0.2)
        assert pair.error_control == [0x00, 0x7F, 0x05]


def test_4_from_the_proxy() -> None:
    with active() as pair:
        pair.system.deactivate(PROXY)
        pair.both("INACTIVE")
        assert pair.commands == [START, PREOP]
        assert pair.error_control[-1] == 0x7F
        assert (pair.called, pair.proxy.calls) == (["on_deactivated"],) * 2


def test_4_from_the_device() -> None:
    with active() as pair:
        pair.system.deactivate(DEVICE_NAME)
        pair.both("INACTIVE")
        assert pair.commands == [START]
        assert pair.error_control[-1] == 0x7F
        assert (pair.called, pair.proxy.calls) == (["on_deactivated"],) * 2


def test_5_from_the_proxy() -> None:
    with in_error() as pair:
        pair.run(0.2)
        assert pair.commands == [START, STOP]
        assert pair.error_control[-1] == 0x04
        assert pair.proxy.reason == "on purpose"
        assert pair.device.reason == "stopped by the NMT master"


def test_5_from_the_device() -> None:
    with active() as pair:
        pair.device.answers["on_execute"] = RTC_ERROR
        pair.both("ERROR")
        pair.run(0.2)
        assert pair.error_control[-1] == 0x04
        assert EMERGENCY + NODE in pair.recorder.ids
        assert pair.proxy.reason == (
            "node 5 reports EMCY 6200h user software (generic)"
        )
        assert (pair.called, pair.proxy.calls) == (["on_aborting"],) * 2


def test_6_from_the_proxy() -> None:
    with Pair() as pair:
        pair.system.context(PROXY).fail_component(pair.proxy, "on purpose")
        pair.both("ERROR")
        assert pair.commands == [STOP]
        assert pair.called == ["on_initialize", "on_aborting"]


def test_6_from_the_device() -> None:
    with Pair() as pair:
        pair.system.context(DEVICE_NAME).fail_component(pair.device, "check failed")
        pair.both("ERROR")
        assert pair.proxy.reason.startswith("node 5 reports EMCY 6200h")
        assert pair.called == ["on_initialize", "on_aborting"]


def test_7_8_from_the_proxy() -> None:
    with in_error() as pair:
        pair.system.reset(PROXY)
        pair.both("INACTIVE")
        assert pair.commands == [START, STOP, RESET]
        assert pair.error_control[-1] == 0x00
        assert (pair.called, pair.proxy.calls) == (["on_reset"],) * 2
        pair.system.activate(PROXY)
        pair.both("ACTIVE")


def test_7_8_from_the_device() -> None:
    """Its reset brings the device back; the proxy waits for its own."""
    with in_error() as pair:
        pair.system.reset(DEVICE_NAME)
        pair.run(0.5)
        assert pair.states == ("ERROR", "INACTIVE")
        assert pair.called == ["on_reset"]
        pair.system.reset(PROXY)
        pair.both("INACTIVE")


def test_9_a_reset_that_fails_in_the_device() -> None:
    with in_error() as pair:
        pair.device.answers["on_reset"] = RTC_ERROR
        pair.system.reset(PROXY)
        pair.run(3.0)
        assert pair.states == ("ERROR", "ERROR")
        assert pair.proxy.reason == "node 5: no boot-up message within 2 s"
        pair.device.answers.clear()
        pair.system.reset(PROXY)
        pair.both("INACTIVE")


def test_9_a_reset_that_fails_in_the_proxy() -> None:
    with in_error() as pair:
        pair.proxy.on_reset = lambda ec_id: RTC_ERROR  # type: ignore[method-assign]
        pair.system.reset(PROXY)
        pair.run(1.0)
        assert pair.states == ("ERROR", "INACTIVE")


def test_10_the_proxy_ends() -> None:
    with active() as pair:
        pair.system.remove(PROXY)
        pair.run(0.2)
        assert pair.commands == [START, PREOP]
        assert pair.called == ["on_deactivated"]


def test_10_the_device_ends() -> None:
    with active() as pair:
        pair.system.remove(DEVICE_NAME)
        pair.run(1.0)
        assert pair.system.state(PROXY).name == "ERROR_STATE"


@pytest.mark.parametrize(
    "command", [NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION]
)
def test_a_reset_while_active_by_somebody_else(command: NmtCommand) -> None:
    """The device ends its work and boots; that is an error of the proxy."""
    with active() as pair:
        pair.link.send([command_frame(command, NODE)])
        pair.run(0.05)
        assert pair.called[:1] == ["on_deactivated"]
        assert pair.states[0] == "ERROR"
        assert pair.proxy.reason == "node 5 booted while it was operational"
        pair.run(0.5)
        pair.system.reset(PROXY)
        pair.both("INACTIVE")


def test_a_device_that_cannot_activate() -> None:
    with Pair() as pair:
        pair.device.answers["on_activated"] = RTC_ERROR
        pair.system.activate(PROXY)
        pair.both("ERROR")
        assert pair.proxy.reason.startswith("node 5 reports EMCY 6200h user software")


def test_the_description_is_that_of_the_device() -> None:
    assert SlaveProxy.description is DEVICE
