"""RefHardRh3Tecs: drives the base by a TECS motor board, which it calls through a service port."""

from __future__ import annotations

import logging
from math import tau

from refnav.base_control import BaseControl, TravelSwitch
from refrobots import rtc
from refrobots.components.ref_hard_rh3_tecs import RefHardRh3TecsBase
from refrobots.tecs.board import WHEELS, tagWheelState
from refrobots.tecs.board.motor_board_marshaller import MotorBoardClientBase
from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError
from rtgen.runtime.opaque_rpc import E_OK, E_RPC, MERCD

log = logging.getLogger("refnav.ref_hard_rh3_tecs")


class LinkError(Exception):
    """The board is unreachable; whether it carried out the request is unknown."""


class RefHardRh3Tecs(RefHardRh3TecsBase, MotorBoardClientBase):
    """RefHardRh3 with the wheels on a board: the ports of both definitions.

    While the board is unreachable, no angles are sent, and the board itself holds the wheels. The
    observable `calls` counts the answered and the unanswered calls.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Offer the services."""
        self._angles = rtc.TimedDoubleSeq(data=[0.0, 0.0])
        self._switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(self._switch)
        self.BumpRefHard.set_servant(self._switch.bumper)
        self._control = BaseControl(self.InTargetVelocity, self.config, self._switch)
        self._answered = self._unanswered = 0
        self.observables["calls"] = lambda: (self._answered, self._unanswered)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest; the board may be missing yet."""
        self._control.start(self.now())
        self._met = False
        self._held = False
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Hold the wheels; if the board is unreachable, its watchdog does."""
        self._hold()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Hold the wheels; if the board is unreachable, its watchdog does."""
        self._hold()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the board its wheel speeds, and send the angles of its answer."""
        left, right = self._control.wheel_speeds(self.now())
        try:
            if not self._met:
                self._meet()
            state = self._drive(left, right)
        except (LinkError, ServiceError) as error:
            if self._met or not self._unanswered:
                log.warning("%s: no motor board: %s", self.instance_name, error)
            self._met = False
            self._unanswered += 1
            return RTC_OK
        self._answered += 1
        config = self.config
        count = tau / (config.EncoderCount * config.GearRatio)
        angles = self._angles
        angles.data[0] = state.count[0] * count * config.EncoderConstant_L
        angles.data[1] = state.count[1] * count * config.EncoderConstant_R
        self.stamp(angles)
        self.OutWheelAngle.write(angles)
        return RTC_OK

    def _meet(self) -> None:
        """Identify a board that is connected or reconnected, and set its limits."""
        config = self.config
        board = self.motor_board.object
        code, name = board.identify()
        _check("identify", code)
        limits = config.Velocity_limit, config.Acceleration_limit
        _check("setLimits", board.setLimits(*limits))
        self._held = not self._switch.stopped
        self._met = True
        log.info("%s: %s", self.instance_name, name)

    def _drive(self, left: float, right: float) -> tagWheelState:
        board = self.motor_board.object
        if self._switch.stopped != self._held:
            self._held = self._switch.stopped
            if self._held:
                board.stop()
            else:
                _check("release", board.release())
        code, state = board.drive([left, right], WHEELS)
        _check("drive", code)
        return state

    def _hold(self) -> None:
        try:
            self.motor_board.object.stop()
        except ServiceError as error:
            log.info("%s: stop did not reach the board: %s", self.instance_name, error)


def _check(function: str, code: int) -> None:
    """Raise LinkError if the call did not get through, RuntimeError if the board refused it."""
    if code == E_OK:
        return
    if MERCD(code) == E_RPC:
        raise LinkError(f"{function} failed ({code})")
    raise RuntimeError(f"the board refuses {function} ({code})")
