"""A base with CiA 402 drives, reached through the ports of their proxies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

from refnav.base_control import (
    BaseControl,
    BaseParameters,
    PlantSizes,
    PlantStart,
    start_of,
    true_wheels,
)
from refnav.cia402 import Command, DriveMaster, Mode, PowerState
from refnav.plant import Plant
from refrobots import rtc
from rtgen.runtime import SECOND, InPort, OutPort

_FAULTS: Final = (PowerState.FAULT_REACTION_ACTIVE, PowerState.FAULT)
_COASTING: Final = 1.0
"""Maximum time that a wheel may coast after its drive is lost [s]."""


class PlantParameters(BaseParameters, PlantSizes, PlantStart, Protocol):
    """The parameters of a simulated base with drives [m, rad, s]."""

    Velocity_limit: float
    EncoderConstant_L: float
    EncoderConstant_R: float
    DriveTimeout: float


@dataclass(frozen=True, slots=True)
class WheelPorts:
    """The ports that lead to a drive's proxy, and the types of the commands sent through them.

    `unit` is the unit of their angles [rad] and speeds [rad/s].
    """

    name: str
    status: InPort[Any]
    motion: InPort[Any]
    control: OutPort[Any]
    target: OutPort[Any]
    control_type: Callable[..., Any]
    target_type: Callable[..., Any]
    unit: float = 1.0


class Wheel:
    """A wheel with its drive: `angle` [rad] since the first position, `speed` [rad/s]."""

    def __init__(self, ports: WheelPorts) -> None:
        self.name = ports.name
        self.angle = 0.0
        self.speed = 0.0
        self.heard: int | None = None
        """Time of the last position [ns]; None before the first one."""
        self.master = DriveMaster()
        self._ports = ports
        self._position = 0.0
        self._lost = False

    def listen(self, now: int, parameters: PlantParameters) -> None:
        """Read the samples received from the drive."""
        status = (
            self._ports.status.read_newest() if self._ports.status.is_new() else None
        )
        motion = (
            self._ports.motion.read_newest() if self._ports.motion.is_new() else None
        )
        if status is not None:
            self.master.take(status.Statusword)
        if motion is not None:
            unit = self._ports.unit
            position = motion.Position_actual_value * unit
            self._move(position, now, parameters.Velocity_limit)
            self.speed = motion.Velocity_actual_value * unit
        elif not self.there(now, parameters.DriveTimeout):
            self.master.forget()
            self.speed = 0.0
            self._lost = True

    def there(self, now: int, timeout: float) -> bool:
        """Return whether the drive sent a position within the last `timeout` [s]."""
        return self.heard is not None and now - self.heard <= timeout * SECOND

    def drive(self, speed: float) -> None:
        """Enable the drive step by step, and command a speed [rad/s]."""
        ports = self._ports
        self._command(self.master.controlword)
        target = speed / ports.unit if self.master.enabled else 0.0
        ports.target.write(ports.target_type(Target_velocity=target))

    def stop(self) -> None:
        """Command a quick stop."""
        self._command(Command.QUICK_STOP)

    def _command(self, word: int) -> None:
        ports = self._ports
        mode = int(Mode.PROFILE_VELOCITY)
        ports.control.write(
            ports.control_type(Controlword=int(word), Modes_of_operation=mode)
        )

    def _move(self, position: float, now: int, limit: float) -> None:
        moved = position - self._position
        if self.heard is None:
            moved = 0.0
        elif self._lost:
            # A drive that was switched off counts from 0 again; the angle is kept.
            most = limit * min((now - self.heard) / SECOND, _COASTING)
            if position == 0.0 or abs(moved) > most:
                moved = 0.0
        self._lost = False
        self._position = position
        self.angle += moved
        self.heard = now


class CanopenBase:
    """Drives the wheels of both sides, and moves the simulated base by their encoders."""

    def __init__(
        self,
        left: Sequence[WheelPorts],
        right: Sequence[WheelPorts],
        parameters: PlantParameters,
        control: BaseControl,
    ) -> None:
        self.plant = Plant(true_wheels(parameters))
        self._left = [Wheel(ports) for ports in left]
        self._right = [Wheel(ports) for ports in right]
        self._wheels = [*self._left, *self._right]
        self._parameters = parameters
        self._control = control
        self._running = False

    @property
    def wheels(self) -> tuple[float, ...]:
        """The speeds of the wheels [rad/s], those of the left side first."""
        return tuple(wheel.speed for wheel in self._wheels)

    def start(self, now: int) -> None:
        """Start at rest at the time `now` [ns]; the base stays at its place."""
        self.plant.start(start_of(self._parameters))
        self._running = False
        self._control.start(now)

    def stop(self) -> None:
        """Stop all wheels."""
        for wheel in self._wheels:
            wheel.stop()

    def step(self, now: int) -> tuple[float, float] | None:
        """Command the drives; return the angles of both sides [rad], None while a drive is missing.

        Raises RuntimeError if a drive has a fault while the base is driven.
        """
        parameters = self._parameters
        timeout = parameters.DriveTimeout
        for wheel in self._wheels:
            wheel.listen(now, parameters)
        there = [wheel for wheel in self._wheels if wheel.there(now, timeout)]
        self._check(there)
        whole = len(there) == len(self._wheels)
        self._running = whole and all(wheel.master.enabled for wheel in there)
        left, right = self._control.wheel_speeds(now)
        most = parameters.Velocity_limit if self._running else 0.0
        for side, speed in ((self._left, left), (self._right, right)):
            for wheel in side:
                if wheel in there:
                    wheel.drive(min(max(speed, -most), most))
        return self._turned() if whole else None

    def _check(self, wheels: Sequence[Wheel]) -> None:
        """Reset the faults that existed before the start; report a new one."""
        for wheel in wheels:
            if self._running and wheel.master.state in _FAULTS:
                self._running = False
                raise RuntimeError(f"the {wheel.name} drive has a fault")

    def _turned(self) -> tuple[float, float]:
        parameters = self._parameters
        left, right = _mean(self._left), _mean(self._right)
        plant = self.plant
        plant.turn((left - plant.angles[0], right - plant.angles[1]))
        return left * parameters.EncoderConstant_L, right * parameters.EncoderConstant_R


def _mean(wheels: Sequence[Wheel]) -> float:
    return sum(wheel.angle for wheel in wheels) / len(wheels)


def sample(angles: tuple[float, float]) -> rtc.TimedDoubleSeq:
    """Return a message with the wheel angles."""
    return rtc.TimedDoubleSeq(data=list(angles))
