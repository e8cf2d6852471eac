"""Simulation of the motor board of RH3: two wheels, their encoders, limits, and a watchdog."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from math import isfinite, tau
from typing import Protocol

from refnav.base_control import PlantSizes, true_wheels
from refnav.geometry import Pose
from refnav.messages import pose_message
from refnav.plant import Plant
from refrobots import rtc
from refrobots.rh3 import BoardEvent, BoardEventKind
from refrobots.tecs.board._types import WHEELS, tagWheelState
from refrobots.tecs.board.motor_board_server import MotorBoardTarget
from rtgen.runtime import SECOND
from rtgen.runtime.opaque_rpc import E_OK, E_PAR

NAME = "RH3 motor board, simulated"
_MILLISECOND = 1_000_000


class BoardParameters(PlantSizes, Protocol):
    """Parameters of the board; its watchdog in s, geometry in m."""

    watchdog: float
    GearRatio: float
    EncoderCount: int


class MotorBoard(MotorBoardTarget):
    """Executes the calls of board.cdl on a simulated base, by a clock of its own.

    `now` is the clock [ns]; `tell` is called for each entry of the log, by whichever thread. Calls
    and `turn` may come from different threads.
    """

    def __init__(
        self,
        parameters: BoardParameters,
        start: Pose,
        now: Callable[[], int],
        tell: Callable[[BoardEvent], None],
    ) -> None:
        self.base = Plant(true_wheels(parameters))
        self.base.place(start)
        self._parameters = parameters
        self._now = now
        self._tell = tell
        self._lock = threading.Lock()
        self._turned = now()
        self._commanded = 0
        self._driven = False
        self._stopped = False
        self._watchdog = False
        self._wanted = (0.0, 0.0)
        self._most = 0.0
        self._acceleration = 0.0

    # The loop of the board.

    def turn(self) -> None:
        """Simulate the wheels up to now, check the watchdog, and set their speeds."""
        parameters = self._parameters
        base = self.base
        with self._lock:
            now = self._now()
            dt = (now - self._turned) * 1e-9
            self._turned = now
            base.roll(dt)
            if self._driven and now - self._commanded >= parameters.watchdog * SECOND:
                self._driven = False
                self._watchdog = True
                base.halt()
                self._note(BoardEventKind.WATCHDOG)
            if self._driven and not self._stopped:
                base.drive(self._wanted, self._most, self._acceleration * dt)

    def note(self, kind: BoardEventKind) -> None:
        """Add an entry to the log."""
        with self._lock:
            self._note(kind)

    # The calls of the signature, under the names of the CDL file.

    def identify(self) -> tuple[int, str]:
        """Return the name and the version of the board."""
        return E_OK, NAME

    def setLimits(self, speed: float, acceleration: float) -> int:
        """Set the greatest speed [rad/s] and acceleration [rad/s^2] of a wheel."""
        if not (0.0 <= speed < tau * 1e6 and 0.0 <= acceleration < tau * 1e6):
            return E_PAR
        with self._lock:
            self._most = speed
            self._acceleration = acceleration
        return E_OK

    def drive(self, speed: Sequence[float], count: int) -> tuple[int, tagWheelState]:
        """Set the target speeds of the wheels [rad/s], and restart the watchdog."""
        with self._lock:
            if count != WHEELS or not all(map(isfinite, speed)):
                return E_PAR, self._state()
            self._wanted = (speed[0], speed[1])
            if not self._driven:
                self._note(BoardEventKind.DRIVING)
            self._commanded = self._now()
            self._driven = True
            self._watchdog = False
            return E_OK, self._state()

    def getState(self) -> tuple[int, tagWheelState]:
        """Return the state of the wheels."""
        with self._lock:
            return E_OK, self._state()

    def stop(self) -> None:
        """Hold the wheels, at once and until `release`."""
        with self._lock:
            if not self._stopped:
                self._stopped = True
                self.base.halt()
                self._note(BoardEventKind.STOPPED)

    def release(self) -> int:
        """Release the stopped wheels."""
        with self._lock:
            if self._stopped:
                self._stopped = False
                self._note(BoardEventKind.RELEASED)
        return E_OK

    def _state(self) -> tagWheelState:
        parameters = self._parameters
        base = self.base
        size = tau / (parameters.EncoderCount * parameters.GearRatio)
        return tagWheelState(
            time=self._now() // _MILLISECOND & 0xFFFF_FFFF,
            count=[_wrapped(angle // size) for angle in base.angles],
            speed=list(base.speeds),
            stopped=self._stopped,
            watchdog=self._watchdog,
        )

    def _note(self, kind: BoardEventKind) -> None:
        self._tell(
            BoardEvent(
                tm=_time(self._now()),
                kind=kind,
                command=_time(self._commanded),
                left=self.base.speeds[0],
                right=self.base.speeds[1],
                pose=pose_message(self.base.pose),
            )
        )


def _time(instant: int) -> rtc.Time:
    return rtc.Time(*divmod(instant, SECOND))


def _wrapped(count: float) -> int:
    """Return the value as a counter of 32 bits, which wraps around."""
    return (int(count) + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000
