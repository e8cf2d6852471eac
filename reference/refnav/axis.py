"""Physics of a motor with its load, from current, voltage and inertia. SI units, at the axis."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import Final

AMBIENT: Final = 25.0
"""Temperature of a motor at rest for a long time [degrees Celsius]."""


@dataclass(frozen=True, slots=True)
class Motor:
    """Constants of an axis: motor with load.

    `inertia` [kg m^2] and `friction` [N m s/rad] include the load; `torque_constant` [N m/A],
    `speed_constant` [rad/s/V], `supply`: maximum voltage [V], `current`: continuous current [A],
    which warms the motor by `rise` [K] within about `warming` [s].
    """

    inertia: float
    friction: float
    torque_constant: float
    speed_constant: float
    supply: tuple[float, float]
    current: float
    rise: float = 50.0
    warming: float = 60.0


class Axis:
    """An axis turned by its motor; `angle` [rad], `speed` [rad/s], `torque` [N m].

    Inputs are `voltage` [V] and `load`, a further torque [N m].
    """

    def __init__(self, motor: Motor, voltage: float) -> None:
        self.motor = motor
        self.voltage = voltage
        self.load = 0.0
        self.angle = 0.0
        self.speed = 0.0
        self.torque = 0.0
        self.temperature = AMBIENT

    @property
    def current(self) -> float:
        """The current of the motor [A]."""
        return self.torque / self.motor.torque_constant

    @property
    def top_speed(self) -> float:
        """Maximum speed at the supply voltage [rad/s]."""
        return self.voltage * self.motor.speed_constant

    def torque_for(self, speed: float, dt: float) -> float:
        """Return the torque that gives an axis without load this speed [rad/s] after `dt` [s]."""
        motor = self.motor
        return motor.inertia * (speed - self.speed) / dt + motor.friction * self.speed

    def turn(self, torque: float, dt: float) -> None:
        """Simulate `dt` [s] with a torque."""
        motor = self.motor
        top = self.top_speed
        # The torque of the motor is limited by its voltage; a load may turn the axis faster.
        fastest, slowest = self.torque_for(top, dt), self.torque_for(-top, dt)
        torque = min(max(torque, min(slowest, 0.0)), max(fastest, 0.0))
        self.torque = torque
        gained = torque + self.load - motor.friction * self.speed
        self.speed += gained / motor.inertia * dt
        self.angle += self.speed * dt
        warmth = AMBIENT + motor.rise * (self.current / motor.current) ** 2
        self.temperature += (warmth - self.temperature) * min(dt / motor.warming, 1.0)


def approach(distance: float, deceleration: float, dt: float) -> float:
    """Return the speed that allows to stop after `distance`, in steps of `dt` [s].

    The sign is that of the distance. Any consistent units.
    """
    way = abs(distance)
    if deceleration == inf:
        speed = way / dt
    else:
        step = deceleration * dt
        speed = step * (sqrt(0.25 + 2.0 * way / (step * dt)) - 0.5) if step else 0.0
        speed = min(speed, way / dt)
    return speed if distance >= 0.0 else -speed


def ramped(value: float, target: float, gain: float, loss: float) -> float:
    """Return the next speed towards `target`; `gain` and `loss` limit the change of its amount."""
    if value * target < 0.0:
        target = 0.0
    step = gain if abs(target) > abs(value) else loss
    if target > value + step:
        return value + step
    if target < value - step:
        return value - step
    return target
