"""A device's component on a simulated bus: its states follow NMT, its ports the PDOs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest
from device_bench import DEVICE, NODE_ID

from refrobots import rtc
from rtgen.facts.value_checks import CheckValues
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    RTC_ERROR,
    RTC_OK,
    ComponentProfile,
    InitializationError,
    LifeCycleState,
    ParameterProfile,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import DeviceDescription, ObjectNumber
from rtgen.runtime.canopen.hooks import Getter, Incoming, Outgoing, Setter
from rtgen.runtime.canopen.node.device import CanopenDevice
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, command_frame

BOOT_UP = Frame(0x700 + NODE_ID, b"\0")
TPDO1 = 0x180 + NODE_ID
EMERGENCY = 0x80 + NODE_ID


@dataclass(slots=True)
class Configuration:
    interface: str = "virtual"
    channel: str = "can0"
    bitrate: int = 0
    options: str = ""
    node_id: int = NODE_ID
    merged_stop: bool = False
    parameter_file: str = ""


def _port(get: Getter, now: int, type_: type[Any], number: ObjectNumber) -> Any:
    sample = type_()
    sample.tm.sec, sample.tm.nsec = divmod(now, 10**9)
    sample.data = get(number)
    return sample


class Slave(CanopenDevice):
    """An implementation of the generated base, which records callbacks.

    `answers` are the codes that they return.
    """

    description: ClassVar[DeviceDescription] = DEVICE
    profile: ClassVar[ComponentProfile] = ComponentProfile(
        "Slave",
        configuration=tuple(
            ParameterProfile(name, name, type_, default)
            for name, type_, default in (
                ("interface", "string", "virtual"),
                ("channel", "string", "can0"),
                ("bitrate", "long", "0"),
                ("options", "string", ""),
                ("node_id", "long", str(NODE_ID)),
            )
        ),
    )

    def __init__(self, instance_name: str = "slave") -> None:
        super().__init__(instance_name)
        self.config = self.add_configuration(Configuration())
        self.control = self.add_in_port("control", rtc.TimedUShort)
        self.target = self.add_in_port("target", rtc.TimedLong)
        self.status = self.add_out_port("status", rtc.TimedUShort)
        self.position = self.add_out_port("position", rtc.TimedLong)
        self.called: list[str] = []
        self.answers: dict[str, ReturnCode_t] = {}

    def _incoming(self) -> Mapping[int, Incoming]:
        return {
            1: lambda get, now: (
                ("control", _port(get, now, rtc.TimedUShort, (0x6040, 0))),
                ("target", _port(get, now, rtc.TimedLong, (0x607A, 0))),
            )
        }

    def _outgoing(self) -> Mapping[str, Outgoing]:
        def status(sample: Any, set_: Setter) -> None:
            set_((0x6041, 0), sample.data)

        def position(sample: Any, set_: Setter) -> None:
            set_((0x6064, 0), sample.data)

        return {"status": status, "position": position}

    def _answer(self, name: str) -> ReturnCode_t:
        self.called.append(name)
        return self.answers.get(name, RTC_OK)

    def on_initialize(self) -> ReturnCode_t:
        return self._answer("on_initialize")

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        return self._answer("on_activated")

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        return self._answer("on_deactivated")

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        return self._answer("on_aborting")

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        return self._answer("on_reset")

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return self.answers.get("on_execute", RTC_OK)


class Listener:
    """Records all frames on the bus."""

    identifiers = None
    deadline = None

    def __init__(self) -> None:
        self.received: list[Frame] = []

    def receive(self, frame: Frame, now: int) -> tuple[Frame, ...]:
        self.received.append(frame)
        return ()

    def poll(self, now: int) -> tuple[Frame, ...]:
        return ()

    def link_changed(self, up: bool, now: int) -> tuple[Frame, ...]:
        return ()


class Setup:
    """A device in a system, and a listener on its bus that also acts as the master."""

    def __init__(self, device: Slave | None = None) -> None:
        clock = SimulatedClock()
        self.system = System(clock)
        self.device = device or Slave()
        self.link = self.bus = simulated_bus(clock.network)
        self.listener = Listener()
        self.link.attach(self.listener)
        self.system.add(self.device, 100.0)
        self.run()

    def run(self, milliseconds: int = 30) -> list[Frame]:
        """Advance the time; return the device's frames."""
        self.listener.received.clear()
        end = self.system.clock.elapsed() + milliseconds * MILLISECOND
        self.system.run(until_ns=end)
        return list(self.listener.received)

    def command(self, command: NmtCommand) -> list[Frame]:
        self.link.send([command_frame(command, NODE_ID)], self.listener)
        return self.run()

    def send(self, can_id: int, data: str) -> list[Frame]:
        self.link.send([Frame(can_id, bytes.fromhex(data))], self.listener)
        return self.run()

    @property
    def states(self) -> tuple[LifeCycleState, NmtState]:
        return self.system.state(self.device.instance_name), self.device.node.state

    def calls(self) -> list[str]:
        """Return the callbacks since the last call."""
        called = list(self.device.called)
        self.device.called.clear()
        return called


@pytest.fixture
def setup() -> Iterator[Setup]:
    setup = Setup()
    setup.calls()
    yield setup
    setup.system.close()


def test_boot_up() -> None:
    setup = Setup()
    assert setup.listener.received == [BOOT_UP]
    assert setup.calls() == ["on_initialize"]
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)


def test_start_and_pre_operational_drive_the_component(setup: Setup) -> None:
    frames = setup.command(NmtCommand.START)
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)
    assert setup.calls() == ["on_activated"]
    assert [frame.can_id for frame in frames] == [TPDO1]
    setup.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    assert setup.calls() == ["on_deactivated"]


@pytest.mark.parametrize("active", [False, True])
def test_stop_is_an_error(setup: Setup, active: bool) -> None:
    if active:
        setup.command(NmtCommand.START)
    setup.calls()
    setup.command(NmtCommand.STOP)
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    assert setup.calls() == ["on_aborting"]
    assert setup.device.reason == "stopped by the NMT master"


@pytest.mark.parametrize(
    "command", [NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION]
)
def test_resets_from_every_state(setup: Setup, command: NmtCommand) -> None:
    assert setup.command(command) == [BOOT_UP]
    assert setup.calls() == []
    setup.command(NmtCommand.START)
    setup.calls()
    assert setup.command(command)[-1] == BOOT_UP
    assert setup.calls() == ["on_deactivated"]
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    setup.command(NmtCommand.STOP)
    setup.calls()
    assert setup.command(command) == [BOOT_UP]
    assert setup.calls() == ["on_reset"]
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    assert setup.device.reason == ""


@pytest.mark.parametrize(
    "command", [NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION]
)
def test_a_reset_that_fails_ends_in_error_without_boot_up(
    setup: Setup, command: NmtCommand
) -> None:
    setup.command(NmtCommand.STOP)
    setup.device.answers["on_reset"] = RTC_ERROR
    setup.calls()
    frames = setup.command(command)
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    assert setup.calls() == ["on_reset"]
    assert [frame.can_id for frame in frames] == [EMERGENCY]
    assert frames[0].data[:3] == bytes.fromhex("006201")
    setup.device.answers.clear()
    assert setup.command(command) == [BOOT_UP]
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)


@pytest.mark.parametrize(
    ("command", "state", "called"),
    [
        (NmtCommand.START, ACTIVE_STATE, ["on_reset", "on_activated"]),
        (NmtCommand.ENTER_PRE_OPERATIONAL, INACTIVE_STATE, ["on_reset"]),
    ],
)
def test_a_master_may_leave_stopped_without_a_reset(
    setup: Setup, command: NmtCommand, state: LifeCycleState, called: list[str]
) -> None:
    setup.command(NmtCommand.STOP)
    setup.calls()
    setup.command(command)
    assert setup.states[0] is state
    assert setup.calls() == called


@pytest.mark.parametrize("callback", ["on_activated", "on_execute"])
def test_a_callback_that_fails_stops_the_node_with_an_emergency(
    setup: Setup, callback: str
) -> None:
    setup.device.answers[callback] = RTC_ERROR
    frames = setup.command(NmtCommand.START)
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    assert [frame.can_id for frame in frames][-1] == EMERGENCY
    assert frames[-1].data == bytes.fromhex("0062010000000000")


@pytest.mark.parametrize("by_parameter", [True, False])
def test_with_merged_stop_a_stop_ends_normally_and_error_is_left_by_reset(
    by_parameter: bool,
) -> None:
    device = Slave()
    (device.config if by_parameter else device).merged_stop = True
    setup = Setup(device)
    setup.command(NmtCommand.START)
    setup.command(NmtCommand.STOP)
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    setup.command(NmtCommand.START)
    device.answers["on_deactivated"] = RTC_ERROR
    setup.command(NmtCommand.STOP)
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    for command in (NmtCommand.START, NmtCommand.ENTER_PRE_OPERATIONAL):
        setup.command(command)
        assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    setup.command(NmtCommand.RESET_NODE)
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)


STOP, START = NmtCommand.STOP, NmtCommand.START
PRE_OPERATIONAL = NmtCommand.ENTER_PRE_OPERATIONAL


@pytest.mark.parametrize("active", [False, True])
@pytest.mark.parametrize(
    ("commands", "state", "last"),
    [
        ((STOP, NmtCommand.RESET_NODE), INACTIVE_STATE, "on_reset"),
        ((STOP, NmtCommand.RESET_COMMUNICATION), INACTIVE_STATE, "on_reset"),
        ((STOP, PRE_OPERATIONAL), INACTIVE_STATE, "on_reset"),
        ((STOP, START), ACTIVE_STATE, "on_activated"),
        ((STOP, PRE_OPERATIONAL, START), ACTIVE_STATE, "on_activated"),
        ((START, STOP, PRE_OPERATIONAL), INACTIVE_STATE, "on_reset"),
        ((START, PRE_OPERATIONAL, START), ACTIVE_STATE, "on_activated"),
        ((PRE_OPERATIONAL, START, STOP), ERROR_STATE, "on_aborting"),
    ],
)
def test_commands_within_one_tick_lead_to_the_state_of_the_last(
    setup: Setup,
    commands: tuple[NmtCommand, ...],
    state: LifeCycleState,
    last: str,
    active: bool,
) -> None:
    if active:
        setup.command(START)
    frames = [command_frame(command, NODE_ID) for command in commands]
    setup.calls()
    setup.link.send(frames, setup.listener)
    sent = setup.run(100)
    node = {
        INACTIVE_STATE: NmtState.PRE_OPERATIONAL,
        ACTIVE_STATE: NmtState.OPERATIONAL,
        ERROR_STATE: NmtState.STOPPED,
    }
    assert setup.states == (state, node[state])
    assert setup.calls()[-1] == last
    assert EMERGENCY not in [frame.can_id for frame in sent]


def test_a_stop_after_a_start_that_ends_an_error(setup: Setup) -> None:
    setup.command(STOP)
    frames = [command_frame(command, NODE_ID) for command in (PRE_OPERATIONAL, STOP)]
    setup.link.send(frames, setup.listener)
    assert BOOT_UP not in setup.run(100)
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)


def test_a_failure_after_a_stop_and_a_start_is_reported(setup: Setup) -> None:
    setup.device.answers["on_activated"] = RTC_ERROR
    frames = [command_frame(command, NODE_ID) for command in (STOP, START)]
    setup.link.send(frames, setup.listener)
    assert EMERGENCY in [frame.can_id for frame in setup.run(100)]
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)


def test_a_local_activate_waits_for_the_master(setup: Setup) -> None:
    assert setup.system.activate("slave") is RTC_OK
    setup.run()
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    assert "the NMT master" in setup.system.statistics("slave").awaited
    setup.command(NmtCommand.START)
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)
    assert setup.calls() == ["on_activated"]


def test_local_requests_move_the_node() -> None:
    device = Slave()
    device.self_start = True
    setup = Setup(device)
    setup.run()
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)
    setup.system.deactivate("slave")
    setup.run()
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    setup.system.activate("slave")
    setup.run()
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)
    setup.command(NmtCommand.STOP)
    setup.calls()
    setup.system.reset("slave")
    assert BOOT_UP in setup.run()
    assert setup.calls()[0] == "on_reset"


def test_rpdos_come_to_inports(setup: Setup) -> None:
    setup.command(NmtCommand.START)
    setup.send(0x200 + NODE_ID, "0f00feffffff")
    control, target = setup.device.control.read(), setup.device.target.read()
    assert control is not None
    assert control.data == 15
    assert control.tm.nsec > 0
    assert target is not None
    assert target.data == -2
    assert setup.device.get_object((0x607A, 0)) == -2


def test_inports_keep_the_newest_of_a_bounded_number_and_count_the_rest(
    setup: Setup,
) -> None:
    setup.command(NmtCommand.START)
    for value in range(70):
        setup.link.send(
            [Frame(0x205, value.to_bytes(2, "little") + bytes(4))], setup.listener
        )
    setup.run()
    first = setup.device.control.read()
    assert first is not None
    assert first.data == 6
    assert setup.device.lost == 12


def test_samples_of_outports_go_out_each_even_without_a_change(setup: Setup) -> None:
    setup.command(NmtCommand.START)
    for position in (7, 7, 8):
        sample = rtc.TimedLong()
        sample.data = position
        setup.device.position.write(sample)
    status = rtc.TimedUShort()
    status.data = 0x27
    setup.device.status.write(status)
    frames = setup.run()
    assert [frame.data.hex() for frame in frames] == [
        "270007000000",
        "270007000000",
        "270008000000",
    ]


def test_objects_that_are_set_in_a_tick_go_out_together_if_they_changed(
    setup: Setup,
) -> None:
    setup.command(NmtCommand.START)
    setup.device.set_object((0x6041, 0), 0x23)
    setup.device.set_object((0x6064, 0), 5)
    assert [frame.data.hex() for frame in setup.run()] == ["230005000000"]
    setup.device.set_object((0x6064, 0), 5)
    assert setup.run() == []


def test_a_sample_that_an_object_cannot_have_is_an_error(setup: Setup) -> None:
    setup.command(NmtCommand.START)
    setup.device.position.check_values(CheckValues.NEVER)
    sample = rtc.TimedLong()
    sample.data = 2**31
    setup.device.position.write(sample)
    setup.run()
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    assert setup.device.reason.startswith("position: 2147483648 is over")


def test_the_bus_is_left_at_the_end(setup: Setup) -> None:
    setup.system.remove("slave")
    assert setup.command(NmtCommand.START) == []
    assert not setup.device.control.connectors


def test_objects_are_there_before_the_bus() -> None:
    device = Slave()
    device.set_object((0x6041, 0), 1)
    assert device.get_object((0x6041, 0)) == 1


def test_inports_of_the_behaviour_are_left_alone() -> None:
    class Measuring(Slave):
        def __init__(self) -> None:
            super().__init__()
            self.voltage = self.add_in_port("voltage", rtc.TimedDouble)

    device = Measuring()
    Setup(device)
    assert not device.voltage.connectors
    assert device.control.connectors


def test_a_device_stops_by_itself_when_its_manager_is_lost(setup: Setup) -> None:
    with setup.device.bus_lock:
        setup.device.node.dictionary.put(
            (0x1016, 1), (127 << 16 | 50).to_bytes(4, "little")
        )
        setup.device.node.set(0x1029, 1, 2)
    setup.run()
    setup.command(NmtCommand.START)
    setup.send(0x77F, "05")
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)
    frames = setup.run(100)
    assert [frame.data[:2].hex() for frame in frames] == ["3081"]
    assert setup.states == (ERROR_STATE, NmtState.STOPPED)
    assert setup.device.reason == "node 127 is lost: it has no heartbeat"


def test_bus_off_and_return(setup: Setup) -> None:
    setup.command(NmtCommand.START)
    setup.calls()
    setup.bus.cut(setup.device.node)
    setup.run()
    assert setup.states == (INACTIVE_STATE, NmtState.PRE_OPERATIONAL)
    assert setup.calls() == ["on_deactivated"]
    setup.device.set_object((0x6041, 0), 1)
    setup.bus.mend(setup.device.node)
    frames = setup.run()
    assert [frame.data[:2].hex() for frame in frames] == ["4081"]
    setup.command(NmtCommand.START)
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)


def test_what_is_set_while_the_bus_is_off_is_no_error(setup: Setup) -> None:
    setup.device.node.dictionary.put((0x1029, 1), b"\1")
    setup.command(NmtCommand.START)
    setup.bus.cut(setup.device.node)
    setup.device.set_object((0x6041, 0), 1)
    setup.run()
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)


def test_two_devices_with_one_id_tell_it(caplog: pytest.LogCaptureFixture) -> None:
    setup = Setup()
    setup.system.add(Slave("other"), 100.0)
    frames = setup.run()
    assert [frame.data[:2].hex() for frame in frames if frame.can_id == EMERGENCY] == [
        "5081",
        "5081",
    ]
    assert "another node has the node-id 5" in caplog.text


@pytest.mark.parametrize("supported", [True, False])
def test_a_node_id_comes_by_lss(supported: bool) -> None:
    class Waiting(Slave):
        description = DeviceDescription(
            "Waiting", DEVICE.objects, DEVICE.pdos, lss=supported
        )

    device = Waiting()
    device.config.node_id = 255
    device.node.serial_number = 3
    setup = Setup(device)
    assert setup.listener.received == []
    setup.send(0x7E5, "0401000000000000")
    setup.send(0x7E5, "1105000000000000")
    assert BOOT_UP in setup.send(0x7E5, "0400000000000000")
    setup.command(NmtCommand.START)
    assert setup.states == (ACTIVE_STATE, NmtState.OPERATIONAL)


def test_a_bus_that_cannot_be_opened_keeps_the_device_out() -> None:
    device = Slave()
    device.config.bitrate = 500_000
    setup = Setup(Slave("first"))
    setup.bus.bit_rate = 125_000
    with pytest.raises(InitializationError, match="125000 bit/s"):
        setup.system.add(device, 100.0)


def test_a_behaviour_that_cannot_be_initialized_leaves_the_bus() -> None:
    device = Slave()
    device.answers["on_initialize"] = RTC_ERROR
    with pytest.raises(InitializationError):
        System(SimulatedClock()).add(device, 100.0)
    assert not device.control.connectors


def test_events_that_were_overwritten_in_the_inhibit_time_are_counted(
    setup: Setup,
) -> None:
    with setup.device.bus_lock:
        setup.device.node.dictionary.put((0x1800, 3), b"\xe8\3")
    setup.command(NmtCommand.START)
    for value in range(1, 4):
        setup.device.set_object((0x6064, 0), value)
        setup.run(10)
    assert setup.system.observable("slave.overwritten") == (2,)
    assert setup.device.lost == 0
    assert [frame.data[2] for frame in setup.run(100)] == [3]


def test_devices_of_one_kind_have_different_serial_numbers() -> None:
    """Without a serial number of its own or in the description, a device has its node-id."""
    with System(SimulatedClock()) as system:
        slaves = [Slave(f"slave{node_id}") for node_id in (5, 6)]
        for slave, node_id in zip(slaves, (5, 6), strict=True):
            slave.configuration_sets.set("node_id", str(node_id))
            system.add(slave, 100.0)
        slaves[1].node.serial_number = 1234
        system.run(1)
        assert [slave.node.serial_number for slave in slaves] == [5, 1234]
