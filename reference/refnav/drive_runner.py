"""Common part of the reference build's drives as CANopen devices."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from refnav.axis import Axis
from refnav.drive_402 import Drive
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t
from rtgen.runtime.canopen.description import ObjectValue
from rtgen.runtime.canopen.node.device import CanopenDevice

_CONTROLWORD: Final = 0x6040, 0


class DriveRunner:
    """Runs a drive with its device: it brakes when the node leaves OPERATIONAL.

    Time between callbacks is simulated by the next one.
    """

    def __init__(
        self, device: CanopenDevice, made: Callable[[Callable[[int], None]], Drive]
    ) -> None:
        self._device = device
        self._alarmed = 0
        self._ran = device.now()
        self.drive = made(self._alarm)
        self.drive.remote = False
        with device.bus_lock:
            device.node.on_write(*_CONTROLWORD, self._commanded)

    def start(self) -> None:
        """Called when the node becomes OPERATIONAL."""
        self.run()
        self.drive.remote = True

    def run(self) -> None:
        """Simulate the time since the last call."""
        for port in self._device.in_ports.values():
            # Received values are written to objects first.
            port.read_newest()
        now = self._device.now()
        self.drive.run((now - self._ran) / SECOND)
        self._ran = now

    def leave(self) -> None:
        """Called when the node leaves OPERATIONAL."""
        self.run()
        self.drive.leave()

    def restart(self) -> None:
        """Called when the node was reset."""
        self.run()
        self.drive.restart()

    def _commanded(self, value: ObjectValue) -> None:
        self.drive.take(int(value))

    def _alarm(self, code: int) -> None:
        """Send an emergency message for a fault, and for its reset."""
        node = self._device.node
        with self._device.bus_lock:
            if self._alarmed:
                node.remove_error(self._alarmed)
            if code:
                node.add_error(code)
        self._alarmed = code


class SimulatedDrive(CanopenDevice):
    """The callbacks of a device that is a drive; `on_initialize` must call `switch_on`.

    Its observables are `angle` [rad] and `speed` [rad/s] of the axis.
    """

    def switch_on(self, made: Callable[[Callable[[int], None]], Drive]) -> None:
        """Construct the drive with the function that receives faults."""
        self._runner = DriveRunner(self, made)
        axis = self._runner.drive.axis
        self.observables["angle"] = lambda: (axis.angle,)
        self.observables["speed"] = lambda: (axis.speed,)

    @property
    def axis(self) -> Axis:
        """The simulated axis of the drive."""
        return self._runner.drive.axis

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Obey the master from now on."""
        self._runner.start()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._runner.leave()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._runner.leave()
        return RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._runner.run()
        return RTC_OK

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Restart the drive's program."""
        self._runner.restart()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Execute the drive's control loop once."""
        self._runner.run()
        return RTC_OK
