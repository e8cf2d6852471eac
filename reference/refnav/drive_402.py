"""A simulated drive of CiA 402: its automaton, its modes of operation, and its axis."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from math import ceil, inf
from typing import Final

from refnav.axis import Axis, Motor, approach, ramped
from refnav.cia402 import Command, Control, Mode, PowerState, Status
from refnav.drive_objects import DriveObjects, EposObjects, HomingObjects, Units
from refnav.power_machine import Braking, PowerMachine

OVER_VOLTAGE: Final = 0x3210
UNDER_VOLTAGE: Final = 0x3220
TOO_HOT: Final = 0x4310
FOLLOWING_ERROR: Final = 0x8611

_WARNING_TEMPERATURE: Final = 85.0
"""Temperature from which a drive warns [degrees Celsius]."""
_HOT: Final = 100.0
_MAX_STEP: Final = 0.01
"""Maximum length of a step [s]; of a long pause only the last steps are simulated."""
_MAX_STEPS: Final = 1000
_KEPT: Final = 64


class Drive:
    """Simulates a drive (CiA 402) on its objects, by `step`.

    `alarm` is called with the code of a fault, and with 0 once it is reset. While `remote` is not
    set, the drive ignores commands; it brakes if it was enabled.
    """

    def __init__(
        self,
        objects: DriveObjects,
        motor: Motor,
        alarm: Callable[[int], None] = lambda code: None,
    ) -> None:
        self.axis = Axis(motor, objects.DC_link_circuit_voltage / 1000.0)
        self.machine = PowerMachine(self._taken)
        self.remote = True
        self._objects = objects
        self._words: deque[int] = deque(maxlen=_KEPT)
        self._alarm = alarm
        self._units = Units(objects)
        self._zero = 0.0
        self._position = 0.0
        self._speed = 0.0
        self._torque = 0.0
        self._mode = int(Mode.NONE)
        self._bits = 0
        self._limited = False
        self._behind = 0.0
        self._settled = 0.0
        self._goal: float | None = None
        self._next: float | None = None
        self._asked = False
        self._modes: dict[int, Callable[[float], float]] = {
            Mode.PROFILE_POSITION: self._profile_position,
            Mode.PROFILE_VELOCITY: self._profile_velocity,
            Mode.PROFILE_TORQUE: self._profile_torque,
            Mode.CYCLIC_SYNCHRONOUS_POSITION: self._synchronous_position,
        }
        supported = objects.Supported_drive_modes
        for mode in [m for m in self._modes if not supported >> m - 1 & 1]:
            del self._modes[mode]
        self.machine.initialised()
        self._publish()

    def run(self, seconds: float) -> None:
        """Simulate the time since the last call [s]."""
        steps = min(ceil(seconds / _MAX_STEP), _MAX_STEPS)
        for _ in range(steps):
            self.step(min(seconds / steps, _MAX_STEP))

    def take(self, controlword: int) -> None:
        """Store a controlword; several may arrive between two steps."""
        self._words.append(controlword)

    def restart(self) -> None:
        """Restart the drive's program; the axis keeps its angle and its speed."""
        self._words.clear()
        self._switch(Mode.NONE)
        self._objects.Error_code = 0
        self._alarm(0)
        self.machine = PowerMachine(self._taken)
        self.machine.initialised()
        self._publish()

    def leave(self) -> None:
        """Brake as for a quick stop, because the master is gone."""
        self.remote = False
        if self.machine.state is PowerState.OPERATION_ENABLED:
            self.machine.command(Command.QUICK_STOP)

    def fail(self, code: int) -> None:
        """Enter the fault state for a reason from outside."""
        if self.machine.state not in (
            PowerState.FAULT_REACTION_ACTIVE,
            PowerState.FAULT,
        ):
            self._objects.Error_code = code
            self._alarm(code)
            self.machine.fault()

    def step(self, dt: float) -> None:
        """Execute the drive's control loop once, `dt` [s] after the previous step."""
        objects = self._objects
        machine = self.machine
        machine.quick_stop_code = objects.Quick_stop_option_code
        machine.disable_code = objects.Disable_operation_option_code
        machine.fault_code = objects.Fault_reaction_option_code
        cause = self._cause()
        if cause:
            self.fail(cause)
        if self.remote:
            while self._words:
                machine.command(self._words.popleft(), faultless=not cause)
            machine.command(objects.Controlword, faultless=not cause)
            if objects.Modes_of_operation != self._mode:
                self._switch(objects.Modes_of_operation)
        self._bits = 0
        self._limited = False
        self.axis.turn(self._wanted(dt), dt)
        self._supervise(dt)
        self._publish()

    # Set-points of the modes.

    def _wanted(self, dt: float) -> float:
        """Return the torque for the next step [N m]."""
        machine = self.machine
        if not machine.powered:
            self._follow_axis()
            return 0.0
        if machine.braking is not None:
            torque = self._brake(machine.braking, dt)
            if self._speed == 0.0 and self._stands():
                machine.at_rest()
            return torque
        objects = self._objects
        if objects.Controlword & Control.HALT or self._mode not in self._modes:
            braking = Braking(objects.Halt_option_code)
            torque = self._brake(braking, dt)
            if self._speed == 0.0 and self._stands():
                self._bits |= Status.TARGET_REACHED
            return torque
        return self._modes[self._mode](dt)

    def _switch(self, mode: int) -> None:
        """Switch to a mode; for an unsupported one, the displayed mode does not change."""
        if mode in self._modes or mode == Mode.NONE:
            self._mode = mode
            self._goal = self._next = None
            self._settled = 0.0

    def _follow_axis(self) -> None:
        """Let the demand values follow the axis while the drive is disabled."""
        self._position = self.axis.angle
        self._speed = self.axis.speed
        self._torque = 0.0
        self._goal = self._next = None
        self._settled = self._behind = 0.0

    def _brake(self, braking: Braking, dt: float) -> float:
        objects = self._objects
        deceleration = inf
        if braking is Braking.SLOW_DOWN:
            deceleration = objects.Profile_deceleration * self._units.velocity
        elif braking is Braking.QUICK:
            deceleration = objects.Quick_stop_deceleration * self._units.velocity
        self._settled = self._behind = 0.0
        return self._turned(ramped(self._speed, 0.0, 0.0, deceleration * dt), dt)

    def _profile_position(self, dt: float) -> float:
        """Mode 1: a trapezoidal profile to the set-point; a second set-point may wait."""
        objects = self._objects
        control = objects.Controlword
        asked = bool(control & Control.NEW_SET_POINT)
        if asked and not self._asked and self._next is None:
            target = objects.Target_position * self._sign(0x80) * self._units.position
            at_once = control & Control.CHANGE_AT_ONCE or self._goal is None
            if control & Control.RELATIVE:
                before = None if at_once else self._goal
                target += self._position if before is None else before
            else:
                target += self._zero
            self._settled = 0.0
            if at_once:
                self._goal = target
            else:
                self._next = target
            self._asked = True
        elif not asked:
            self._asked = False
        if self._asked or self._next is not None:
            self._bits |= Status.SET_POINT_ACKNOWLEDGE
        goal = self._position if self._goal is None else self._within(self._goal)
        velocity = self._units.velocity
        deceleration = objects.Profile_deceleration * velocity
        fastest = min(objects.Profile_velocity, objects.Max_profile_velocity) * velocity
        speed = approach(goal - self._position, deceleration, dt)
        speed = ramped(
            self._speed,
            min(max(speed, -fastest), fastest),
            objects.Profile_acceleration * velocity * dt,
            deceleration * dt,
        )
        torque = self._moved(self._position + speed * dt, speed, dt)
        if self._goal is not None and self._reached(
            goal - self._measured,
            objects.Position_window * self._units.position,
            objects.Position_window_time,
            dt,
        ):
            if self._next is None:
                self._bits |= Status.TARGET_REACHED
            else:
                self._goal, self._next = self._next, None
                self._settled = 0.0
        return torque

    def _profile_velocity(self, dt: float) -> float:
        """Mode 3."""
        objects = self._objects
        velocity = self._units.velocity
        target = objects.Target_velocity * self._sign(0x40) * velocity
        fastest = objects.Max_profile_velocity * velocity
        if abs(target) > fastest:
            self._limited = True
            target = min(max(target, -fastest), fastest)
        torque = self._turned(
            ramped(
                self._speed,
                target,
                objects.Profile_acceleration * velocity * dt,
                objects.Profile_deceleration * velocity * dt,
            ),
            dt,
        )
        window = objects.Velocity_window * velocity
        away = target - self.axis.speed
        if self._reached(away, window, objects.Velocity_window_time, dt):
            self._bits |= Status.TARGET_REACHED
        if self._stands():
            self._bits |= Status.SPEED_ZERO
        return torque

    def _profile_torque(self, dt: float) -> float:
        """Mode 4."""
        objects = self._objects
        rated = objects.Motor_rated_torque / 1000.0
        step = objects.Torque_slope / 1000.0 * rated * dt
        target = objects.Target_torque / 1000.0 * rated
        torque = min(max(target, self._torque - step), self._torque + step)
        if torque == target:
            self._bits |= Status.TARGET_REACHED
        return self._given(torque, dt)

    def _synchronous_position(self, dt: float) -> float:
        """Mode 8: the sender of the targets generates the profile; the drive's limits apply."""
        objects = self._objects
        self._bits |= Status.FOLLOWS
        return self._direct_position(objects.Target_position, dt)

    def _direct_position(self, target: int, dt: float) -> float:
        angle = target * self._sign(0x80) * self._units.position + self._zero
        angle = self._within(angle)
        fastest = self._objects.Max_profile_velocity * self._units.velocity
        speed = (angle - self._position) / dt
        if abs(speed) > fastest:
            self._limited = True
            speed = min(max(speed, -fastest), fastest)
        return self._moved(self._position + speed * dt, speed, dt)

    # Torques from demand values.

    def _moved(self, position: float, speed: float, dt: float) -> float:
        """Return the torque for a position that is passed at a speed."""
        self._position = position
        self._speed = speed
        axis = self.axis
        ahead = position - axis.angle - speed * dt
        # Compensate the lag of an axis at its torque limit, without overshoot.
        strongest = 0.8 * self._strongest() / axis.motor.inertia
        return self._limit(
            axis.torque_for(speed + approach(ahead, strongest, dt), dt), dt
        )

    def _turned(self, speed: float, dt: float) -> float:
        """Return the torque for a speed."""
        self._speed = speed
        self._position = self.axis.angle
        return self._limit(self.axis.torque_for(speed, dt), dt)

    def _given(self, torque: float, dt: float) -> float:
        """Return a commanded torque, limited so that the axis keeps its maximum speed."""
        axis = self.axis
        self._position = axis.angle
        self._speed = axis.speed
        fastest = self._objects.Max_profile_velocity * self._units.velocity
        most, least = axis.torque_for(fastest, dt), axis.torque_for(-fastest, dt)
        self._torque = torque
        within = min(max(torque, min(least, 0.0)), max(most, 0.0))
        self._limited |= within != torque
        return self._limit(within, dt, demanded=torque)

    def _limit(self, torque: float, dt: float, demanded: float | None = None) -> float:
        strongest = self._strongest()
        within = min(max(torque, -strongest), strongest)
        self._limited |= within != torque
        self._torque = within if demanded is None else demanded
        return within

    def _strongest(self) -> float:
        objects = self._objects
        torque = objects.Max_torque * objects.Motor_rated_torque * 1e-6
        current = objects.Max_current * objects.Motor_rated_current * 1e-6
        return min(torque, current * self.axis.motor.torque_constant)

    def _within(self, angle: float) -> float:
        """Return the angle within the software's limits."""
        objects = self._objects
        sign = self._sign(0x80)
        ends = objects.Min_position_limit, objects.Max_position_limit
        low, high = sorted(
            sign * end * self._units.position + self._zero for end in ends
        )
        if low <= angle <= high:
            return angle
        self._limited = True
        return min(max(angle, low), high)

    def _sign(self, bit: int) -> int:
        """Return the sign that the polarity gives to positions (80h) or velocities (40h)."""
        return -1 if self._objects.Polarity & bit else 1

    # Actual values.

    @property
    def _measured(self) -> float:
        """The angle by the encoder [rad]."""
        return self.axis.angle // self._units.count * self._units.count

    def _stands(self) -> bool:
        window = self._objects.Velocity_window * self._units.velocity
        return abs(self.axis.speed) <= window

    def _reached(self, away: float, window: float, time: int, dt: float) -> bool:
        self._settled = self._settled + dt if abs(away) <= window else 0.0
        return self._settled * 1000.0 >= time and abs(away) <= window

    def _cause(self) -> int:
        """Return the code of a present fault, 0 for none."""
        low, high = self.axis.motor.supply
        if self.axis.voltage > high:
            return OVER_VOLTAGE
        if self.axis.voltage < low:
            return UNDER_VOLTAGE
        return TOO_HOT if self.axis.temperature >= _HOT else 0

    def _supervise(self, dt: float) -> None:
        objects = self._objects
        behind = abs(self._position - self._measured)
        if not self.machine.powered or behind <= (
            objects.Following_error_window * self._units.position
        ):
            self._behind = 0.0
            return
        self._behind += dt
        self._bits |= Status.FOLLOWING_ERROR
        if self._behind * 1000.0 > objects.Following_error_time_out:
            self.fail(FOLLOWING_ERROR)

    def _taken(self, number: int) -> None:
        if number == 15:
            self._objects.Error_code = 0
            self._alarm(0)

    def _publish(self) -> None:
        """Write the actual values to the objects."""
        objects = self._objects
        units = self._units
        axis = self.axis
        turned = self._sign(0x80)
        position = (self._measured - self._zero) * turned
        objects.Position_actual_value = wrapped(position / units.position)
        objects.Following_error_actual_value = wrapped(
            (self._position - self._measured) * turned / units.position
        )
        way = self._sign(0x40) / units.velocity
        objects.Velocity_actual_value = wrapped(axis.speed * way)
        objects.Velocity_demand_value = wrapped(self._speed * way)
        rated = objects.Motor_rated_torque / 1e6
        objects.Torque_demand = _short(self._torque / rated)
        objects.Torque_actual_value = _short(axis.torque / rated)
        objects.Current_actual_value = _short(
            axis.current / objects.Motor_rated_current * 1e6
        )
        low, high = axis.motor.supply
        # Values outside the range of the drive's own sensor are clipped.
        voltage = min(max(axis.voltage, low), high)
        objects.DC_link_circuit_voltage = round(voltage * 1000.0)
        objects.Modes_of_operation_display = self._mode
        status = self.machine.state.bits | self._bits
        status |= Status.VOLTAGE_ENABLED * (axis.voltage > 0.0)
        status |= Status.REMOTE * self.remote
        status |= Status.WARNING * (axis.temperature >= _WARNING_TEMPERATURE)
        status |= Status.INTERNAL_LIMIT * self._limited
        objects.Statusword = int(status)


class HomingDrive(Drive):
    """A drive with homing at the present position (methods 35 and 37)."""

    _objects: HomingObjects

    def __init__(
        self,
        objects: HomingObjects,
        motor: Motor,
        alarm: Callable[[int], None] = lambda code: None,
    ) -> None:
        super().__init__(objects, motor, alarm)
        self._homed = 0
        self._modes[Mode.HOMING] = self._homing

    def _switch(self, mode: int) -> None:
        super()._switch(mode)
        self._homed = 0

    def _homing(self, dt: float) -> float:
        """Mode 6."""
        objects = self._objects
        if not objects.Controlword & Control.HOMING_START:
            self._asked = False
        elif not self._asked:
            self._asked = True
            if objects.Homing_method in (35, 37) and self._stands():
                offset = objects.Home_offset * self._sign(0x80) * self._units.position
                self._zero = self._measured - offset
                self._homed = Status.HOMING_ATTAINED
            else:
                self._homed = Status.HOMING_ERROR
        self._bits |= self._homed | Status.TARGET_REACHED
        return self._turned(0.0, dt)


class EposDrive(HomingDrive):
    """A drive with EPOS's own modes: position, velocity and current, each without a profile."""

    _objects: EposObjects

    def __init__(
        self,
        objects: EposObjects,
        motor: Motor,
        alarm: Callable[[int], None] = lambda code: None,
    ) -> None:
        super().__init__(objects, motor, alarm)
        self._modes[Mode.EPOS_POSITION] = lambda dt: self._direct_position(
            self._objects.Position_mode_setting_value, dt
        )
        self._modes[Mode.EPOS_VELOCITY] = self._direct_velocity
        self._modes[Mode.EPOS_CURRENT] = self._direct_current

    def _direct_velocity(self, dt: float) -> float:
        target = self._objects.Velocity_mode_setting_value * self._sign(0x40)
        fastest = self._objects.Max_profile_velocity
        self._limited |= abs(target) > fastest
        target = min(max(target, -fastest), fastest)
        return self._turned(target * self._units.velocity, dt)

    def _direct_current(self, dt: float) -> float:
        current = self._objects.Current_setting_value / 1000.0
        return self._given(current * self.axis.motor.torque_constant, dt)


def wrapped(value: float) -> int:
    """Return the value as INTEGER32, which wraps around."""
    return (round(value) + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000


def _short(value: float) -> int:
    return min(max(round(value), -0x8000), 0x7FFF)
