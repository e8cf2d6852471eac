"""GamePad: positions of sticks and buttons, also as velocities."""

from __future__ import annotations

from refnav.map_text import MapError, text_of
from refnav.pads import Pad, PadError, RealPad, ScriptedPad, Sticks
from refnav.stick_script import ScriptError, parse
from refrobots import iis, rtc
from refrobots.components.game_pad import GamePadBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

COLUMNS = 5
MAX_VALUE = 4095.0
"""Greatest value of a script: twelve buttons as bits."""


class GamePad(GamePadBase):
    """Sends while the game pad is connected; once disconnected, sends released sticks once."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Open the game pad."""
        config = self.config
        self._begin = self.now()
        self._there = False
        self._pad: Pad | None = None
        try:
            if config.script:
                text = text_of(self.folder, config.script)
                self._pad = ScriptedPad(parse(text, config.script, COLUMNS, MAX_VALUE))
            else:
                self._pad = RealPad(config.str_port)
        except (MapError, ScriptError) as error:
            return self.fail(f"script: {error}")
        except PadError as error:
            return self.fail(f"str_port: {error}")
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Close the game pad."""
        self._close()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Close the game pad."""
        self._close()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the positions of the sticks."""
        assert self._pad is not None, "opened on activation"
        sticks = self._pad.read((self.now() - self._begin) / SECOND)
        if sticks is not None:
            self._send(sticks)
            self._send_velocity(sticks)
        elif self._there:
            self._send(Sticks())
        self._there = sticks is not None
        return RTC_OK

    def _close(self) -> None:
        if self._pad is not None:
            self._pad.close()
            self._pad = None

    def _send(self, sticks: Sticks) -> None:
        time = rtc.Time(*divmod(self.now(), SECOND))
        self.Button.write(rtc.TimedULong(time, sticks.buttons))
        for value, single, double in (
            (sticks.lx, self.StickLX, self.StickLXd),
            (sticks.ly, self.StickLY, self.StickLYd),
            (sticks.rx, self.StickRX, self.StickRXd),
            (sticks.ry, self.StickRY, self.StickRYd),
        ):
            single.write(rtc.TimedFloat(time, value))
            double.write(rtc.TimedDouble(time, value))
        vx, vy, va = self._velocity(sticks)
        self.Velocity.write(rtc.TimedVelocity(time, vx, va))
        self.VelocityIIS.write(iis.TimedVelocity(time, [], vx, vy, va, []))

    def _send_velocity(self, sticks: Sticks) -> None:
        sample = iis.TimedVelocity2D(data=rtc.Velocity2D(*self._velocity(sticks)))
        self.stamp(sample)
        self.Velocity2DIIS.write(sample)

    def _velocity(self, sticks: Sticks) -> tuple[float, float, float]:
        config = self.config
        return (
            0.0 - config.Kly * sticks.ly,
            0.0 - config.Klx * sticks.lx,
            0.0 - config.Krx * sticks.rx,
        )
