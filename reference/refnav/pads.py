"""Game pads: scripted, or a real one through pygame."""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Any, NamedTuple, Protocol

from refnav.stick_script import Script

BUTTONS = 12


class PadError(Exception):
    """A game pad that is not connected."""


class Sticks(NamedTuple):
    """Sticks from -1 to 1, positive to the right and towards the hand; buttons as bits."""

    lx: float = 0.0
    ly: float = 0.0
    rx: float = 0.0
    ry: float = 0.0
    buttons: int = 0


class Pad(Protocol):
    """A game pad."""

    def read(self, seconds: float) -> Sticks | None:
        """Return the sticks at a time after the start [s]; None while the pad is disconnected."""

    def close(self) -> None:
        """Let go of the device."""


class ScriptedPad:
    """Replays a script; after its end the pad is disconnected."""

    def __init__(self, script: Script) -> None:
        self._script = script

    def read(self, seconds: float) -> Sticks | None:
        """Return the sticks of the script."""
        held = self._script.at(seconds)
        if held is None:
            return None
        lx, ly, rx, ry, buttons = held
        return Sticks(lx, ly, rx, ry, round(buttons))

    def close(self) -> None:
        """Do nothing: there is no device."""


class RealPad:
    """A game pad of this machine, by SDL. Raises PadError if there is none of that number."""

    def __init__(self, port: str) -> None:
        digits = re.search(r"(\d+)$", port)
        number = int(digits[1]) if digits else 0
        try:
            import pygame
        except ImportError as error:
            raise PadError(
                "a real game pad needs pygame: the extra joystick of rtgen"
            ) from error
        self._pygame: Any = pygame
        pygame.display.init()
        pygame.joystick.init()
        found = pygame.joystick.get_count()
        if number >= found:
            self.close()
            raise PadError(f"there is no game pad {port}; {found} found")
        self._pad = pygame.joystick.Joystick(number)

    def read(self, seconds: float) -> Sticks | None:
        """Return the present sticks."""
        pygame = self._pygame
        with suppress(pygame.error):
            pygame.event.pump()
            if self._pad.get_init() and self._pad.get_numaxes() >= 4:
                lx, ly, rx, ry = (self._pad.get_axis(i) for i in range(4))
                count = min(BUTTONS, self._pad.get_numbuttons())
                bits = (self._pad.get_button(i) << i for i in range(count))
                return Sticks(lx, ly, rx, ry, sum(bits))
        return None

    def close(self) -> None:
        """Let go of the device."""
        self._pygame.joystick.quit()
        self._pygame.display.quit()
