"""Common base of the four joysticks, which differ in their response to the hand."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign
from typing import Generic, Protocol, TypeVar

from refnav.stick_script import Script, ScriptError, parse
from refrobots import iis, rtc
from rtgen.runtime import RTC_OK, SECOND, Component, OutPort, ReturnCode_t

_COLUMNS = 3
_LET_GO = (0.0, 0.0, 0.0)
_MAX_FILE = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Response:
    """Response of a stick: the deflection to this power, 0 below `dead`.

    `digital`: full from half deflection on. `sideways`: there is an axis for it.
    """

    power: float = 1.0
    dead: float = 0.05
    digital: bool = False
    sideways: bool = False

    def __call__(self, deflection: float) -> float:
        """Return the output for a deflection, both within [-1, 1]."""
        size = abs(deflection)
        if self.digital:
            return copysign(1.0, deflection) if size >= 0.5 else 0.0
        return copysign(size**self.power, deflection) if size >= self.dead else 0.0


class JoystickParameters(Protocol):
    """The parameters that all joysticks have [m/s, rad/s]."""

    script: str
    max_v: float
    max_w: float


P = TypeVar("P", bound=JoystickParameters)


class Joystick(Component, Generic[P]):
    """Sends the scripted deflections, in the interfaces of both phases."""

    config: P
    velocity: OutPort[rtc.TimedVelocity]
    moving_command: OutPort[iis.TimedVelocity]

    response = Response()

    def on_initialize(self) -> ReturnCode_t:
        """Create the messages, which are reused."""
        self._first = rtc.TimedVelocity()
        self._second = iis.TimedVelocity()
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start the script; without one the stick stays at rest."""
        self._begin = self.now()
        self._held = False
        self._script: Script | None = None
        if self.config.script:
            file = self.folder / self.config.script
            try:
                with file.open(encoding="utf-8") as stream:
                    text = stream.read(_MAX_FILE)
                self._script = parse(text, self.config.script, _COLUMNS)
            except (OSError, UnicodeDecodeError) as error:
                return self.fail(f"script: cannot read {self.config.script}: {error}")
            except ScriptError as error:
                return self.fail(f"script: {error}")
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the deflection, and once the release of the stick."""
        forward, left, turn = map(self.response, self._hand())
        if not self.response.sideways:
            left = 0.0
        held = (forward, left, turn) != _LET_GO
        if held or self._held:
            self._send(forward, left, turn)
        self._held = held
        return RTC_OK

    def _hand(self) -> tuple[float, ...]:
        if self._script is None:
            return _LET_GO
        return self._script.at((self.now() - self._begin) / SECOND) or _LET_GO

    def _send(self, forward: float, left: float, turn: float) -> None:
        config = self.config
        first, second = self._first, self._second
        first.v = second.vx = config.max_v * forward
        second.vy = config.max_v * left
        first.w = second.w = config.max_w * turn
        self.stamp(first)
        self.stamp(second)
        self.velocity.write(first)
        self.moving_command.write(second)
