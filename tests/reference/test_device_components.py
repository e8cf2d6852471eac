"""The simulated devices as components on a bus: commands by PDO and SDO, events, EMCY, resets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from struct import pack, unpack
from typing import Any

import pytest

from refnav.cia402 import PowerState, state_of
from refnav.epos_drive_device import EposDriveDevice
from refnav.f_palette_device import FPaletteDevice
from refnav.ftmd_device import FtmdDevice
from refnav.motor_core_unit_device import MotorCoreUnitDevice
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    SECOND,
    SimulatedClock,
    System,
)
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.node.device import CanopenDevice
from rtgen.runtime.canopen.wire.frames import Frame

NODE = 5


class Bench:
    """A device on a bus, and a station that receives and sends for the test."""

    identifiers = None
    deadline = None

    def __init__(self, device: CanopenDevice) -> None:
        self.device: Any = device
        self.frames: list[Frame] = []
        clock = SimulatedClock()
        self.system = System(clock)
        device.configuration_sets.set("node_id", str(NODE))
        device.configuration_sets.set("network", "")
        self.system.add(device, 100.0)
        self.link = open_link(clock)
        self.link.attach(self)
        self.run(0.1)

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.frames.append(frame)
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        return ()

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        return ()

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def send(self, can_id: int, data: bytes) -> None:
        self.link.send([Frame(can_id, data)], self)

    def nmt(self, command: int) -> None:
        self.send(0x000, bytes((command, NODE)))
        self.run(0.05)

    def control(self, *words: int, mode: int = 3) -> None:
        for word in words:
            self.send(0x200 + NODE, pack("<Hb", word, mode))
        self.run(0.05)

    def received(self, can_id: int) -> list[bytes]:
        found = [frame.data for frame in self.frames if frame.can_id == can_id]
        self.frames.clear()
        return found

    @property
    def power(self) -> PowerState | None:
        return state_of(self.device.objects.Statusword)

    @property
    def state(self) -> Any:
        return self.system.state(self.device.instance_name)


def bench(device: CanopenDevice) -> Iterator[Bench]:
    made = Bench(device)
    with made.system:
        yield made


@pytest.fixture(params=[EposDriveDevice, FtmdDevice, MotorCoreUnitDevice])
def drive(request: pytest.FixtureRequest) -> Iterator[Bench]:
    yield from bench(request.param("Drive0"))


@pytest.fixture
def ftmd() -> Iterator[Bench]:
    yield from bench(FtmdDevice("Drive0"))


@pytest.fixture
def palette() -> Iterator[Bench]:
    yield from bench(FPaletteDevice("Board0"))


def test_a_drive_is_enabled_by_pdo_and_turns(drive: Bench) -> None:
    assert drive.state is INACTIVE_STATE
    drive.nmt(0x01)
    assert drive.state is ACTIVE_STATE
    # Three controlwords between two ticks: each of them counts.
    drive.control(0x06, 0x07, 0x0F)
    assert drive.power is PowerState.OPERATION_ENABLED
    drive.send(0x400 + NODE, pack("<i", 100_000))
    drive.frames.clear()
    drive.run(1.0)
    drive.send(0x080, b"")
    drive.run(0.01)
    [sample] = drive.received(0x280 + NODE)
    position, velocity = unpack("<ii", sample)
    assert position > 0
    assert velocity == pytest.approx(100_000, rel=1e-3)
    assert drive.system.observable("Drive0.speed")[0] > 0.0


def test_a_drive_brakes_when_it_leaves_operational(drive: Bench) -> None:
    for command, state in ((0x80, INACTIVE_STATE), (0x02, ERROR_STATE)):
        drive.nmt(0x01)
        drive.control(0x06, 0x0F)
        drive.send(0x400 + NODE, pack("<i", 100_000))
        drive.run(0.5)
        assert abs(drive.system.observable("Drive0.speed")[0]) > 0.1
        drive.nmt(command)
        assert drive.state is state
        drive.run(0.5)
        if state is ERROR_STATE:
            drive.nmt(0x81)
        drive.nmt(0x01)
        assert drive.system.observable("Drive0.speed") == (0.0,)
        assert drive.power is PowerState.SWITCH_ON_DISABLED


def test_controlwords_by_sdo_in_pre_operational_are_kept(drive: Bench) -> None:
    number = bytes.fromhex("2b406000")
    drive.send(0x600 + NODE, number + pack("<I", 6))
    drive.run(0.05)
    assert drive.received(0x580 + NODE) == [bytes.fromhex("6040600000000000")]
    drive.nmt(0x01)
    assert drive.power is PowerState.READY_TO_SWITCH_ON
    drive.send(0x600 + NODE, number + pack("<I", 15))
    drive.run(0.05)
    assert drive.power is PowerState.OPERATION_ENABLED


def test_faults_are_reported_as_emergencies(ftmd: Bench) -> None:
    ftmd.nmt(0x01)
    axis = ftmd.device._runner.drive.axis
    axis.voltage = 5.0
    ftmd.frames.clear()
    ftmd.run(0.1)
    [emergency] = ftmd.received(0x080 + NODE)
    assert emergency[:2] == b"\x20\x32"
    assert ftmd.power is PowerState.FAULT
    assert ftmd.device.objects.Error_code == 0x3220
    assert ftmd.device.objects.DC_link_circuit_voltage == 10_000
    axis.voltage = 24.0
    ftmd.frames.clear()
    ftmd.control(0x00, 0x80)
    ftmd.run(0.1)
    [gone] = ftmd.received(0x080 + NODE)
    assert gone[:3] == b"\0\0\0"
    assert ftmd.power is PowerState.SWITCH_ON_DISABLED


def test_a_reset_ends_a_fault(ftmd: Bench) -> None:
    ftmd.nmt(0x01)
    ftmd.device._runner.drive.fail(0x5000)
    ftmd.run(0.05)
    ftmd.nmt(0x02)
    ftmd.nmt(0x81)
    ftmd.nmt(0x01)
    assert ftmd.power is PowerState.SWITCH_ON_DISABLED
    assert ftmd.device.objects.Error_code == 0
    assert ftmd.device.objects.Error_register == 0


def test_encoders_of_the_motor_core_unit() -> None:
    for made in bench(MotorCoreUnitDevice("Motor0")):
        made.nmt(0x01)
        axis = made.device._runner.drive.axis
        axis.angle = -3.141592653589793 / 2
        made.run(0.05)
        objects = made.device.objects
        assert objects.Gear_encoder_angle == 3 << 15
        assert objects.Position_actual_internal_value == pytest.approx(-102_400, abs=1)
        assert objects.Position_actual_value == pytest.approx(-90_000, abs=2)
        assert objects.Motor_temperature == 250


def test_analogue_inputs_are_silent_until_they_are_enabled(palette: Bench) -> None:
    board = palette.device._board
    palette.nmt(0x01)
    board.voltages[0] = 1.0
    palette.run(0.1)
    assert palette.received(0x280 + NODE) == []
    palette.device.objects.Analogue_input_global_interrupt_enable = True
    palette.device.objects.Delta_of_analogue_input_1 = 1000
    palette.run(0.1)
    [first] = palette.received(0x280 + NODE)
    assert unpack("<hhhh", first)[0] == round(0x7FFF / 5)
    board.voltages[0] = 1.1
    palette.run(0.1)
    assert palette.received(0x280 + NODE) == []
    board.voltages[0] = 1.3
    palette.run(0.1)
    assert len(palette.received(0x280 + NODE)) == 1


def test_digital_inputs_and_outputs(palette: Bench) -> None:
    board = palette.device._board
    palette.nmt(0x01)
    palette.frames.clear()
    board.digital[0] = 0x81
    palette.run(0.05)
    assert palette.received(0x180 + NODE) == [b"\x81\x00"]
    palette.send(0x200 + NODE, b"\x0f\xf0")
    palette.run(0.05)
    assert board.levels == [0x0F, 0xF0]
    palette.nmt(0x80)
    # The error values: all outputs off.
    assert board.levels == [0x00, 0x00]
