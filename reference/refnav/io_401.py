"""Simulation of the f-palette board: inputs and outputs of CiA 401, and an angle reference.

Source: CiA 401-2, generic I/O modules; the angle reference is the board's own (2100h to 2103h).
"""

from __future__ import annotations

from enum import IntFlag
from math import isfinite
from typing import Any, Final

DIGITAL_BYTES: Final = 2
ANALOGUE_INPUTS: Final = 8
ANALOGUE_OUTPUTS: Final = 4
FULL_SCALE: Final = 5.0
"""The voltage of 7FFFh."""

_BITS: Final = ("1_to_8", "9_to_16")

INPUTS: Final = (
    *(f"Digital_inputs_{place}" for place in _BITS),
    *(f"Analogue_input_{number}" for number in range(1, ANALOGUE_INPUTS + 1)),
    "Angle_reference",
)
"""The names of the objects that may go out in TPDOs."""


class Trigger(IntFlag):
    """The conditions on which an analogue input makes an event (6421h)."""

    UPPER_LIMIT = 1
    LOWER_LIMIT = 2
    DELTA = 4
    FALLEN = 8
    RISEN = 16


class Board:
    """Reads and writes the objects of `f_palette.eds`, by `step`.

    `digital` are the levels at the inputs, a byte for each eight of them, `voltages` those at the
    analogue inputs [V]; `levels` and `output_voltages` are those at the outputs. `events` are the
    names of the objects that made an event in the last step.
    """

    def __init__(self, objects: Any) -> None:
        self._objects = objects
        self.digital = [0] * DIGITAL_BYTES
        self.voltages = [0.0] * ANALOGUE_INPUTS
        self.levels = [0] * DIGITAL_BYTES
        self.output_voltages = [0.0] * ANALOGUE_OUTPUTS
        self.events: dict[str, None] = {}
        self._transmitted: list[int | None] = [None] * ANALOGUE_INPUTS
        self._outside = [False] * ANALOGUE_INPUTS
        self.step()

    def step(self) -> None:
        """Read the inputs and drive the outputs."""
        self.events.clear()
        self._read_digital()
        self._read_analogue()
        self._refer()
        self._drive()

    def tells_first(self, name: str) -> bool:
        """Return whether an input's value is transmitted when the board becomes operational."""
        if name.startswith("Analogue"):
            return bool(self._objects.Analogue_input_global_interrupt_enable)
        if name.startswith("Digital"):
            return bool(self._objects.Global_interrupt_enable_digital)
        return True

    def leave(self) -> None:
        """Set outputs with an error mode to their error values, because the master is gone."""
        objects = self._objects
        for place in _BITS:
            mode = getattr(objects, f"Error_mode_of_outputs_{place}")
            value = getattr(objects, f"Error_value_of_outputs_{place}")
            name = f"Digital_outputs_{place}"
            kept = getattr(objects, name) & ~mode
            setattr(objects, name, kept | value & mode)
        for number in range(1, ANALOGUE_OUTPUTS + 1):
            if getattr(objects, f"Error_mode_of_analogue_output_{number}"):
                value = getattr(objects, f"Error_value_of_analogue_output_{number}")
                name = f"Analogue_output_{number}"
                setattr(objects, name, min(max(value, -0x8000), 0x7FFF))
        self._drive()

    def _read_digital(self) -> None:
        objects = self._objects
        for level, place in zip(self.digital, _BITS, strict=True):
            name = f"Digital_inputs_{place}"
            value = (level ^ getattr(objects, f"Polarity_of_inputs_{place}")) & 0xFF
            changed = getattr(objects, name) ^ value
            mask = getattr(objects, f"Mask_of_inputs_{place}")
            if objects.Global_interrupt_enable_digital and changed & mask:
                self.events[name] = None
            setattr(objects, name, value)

    def _read_analogue(self) -> None:
        objects = self._objects
        enabled = objects.Analogue_input_global_interrupt_enable
        for number, voltage in enumerate(self.voltages, 1):
            name = f"Analogue_input_{number}"
            value = converted(voltage)
            if not enabled:
                self._transmitted[number - 1] = None
            elif self._triggered(number, value):
                self._transmitted[number - 1] = value
                self.events[name] = None
            setattr(objects, name, value)

    def _triggered(self, number: int, value: int) -> bool:
        """Return whether the input makes an event; its first value once enabled does."""
        objects = self._objects
        transmitted = self._transmitted[number - 1]
        trigger = getattr(objects, f"Trigger_of_analogue_input_{number}")
        upper = getattr(objects, f"Upper_limit_of_analogue_input_{number}")
        lower = getattr(objects, f"Lower_limit_of_analogue_input_{number}")
        delta = getattr(objects, f"Delta_of_analogue_input_{number}")
        # Two limits of 0 mean no limits.
        over = trigger & Trigger.UPPER_LIMIT and value >= upper
        under = trigger & Trigger.LOWER_LIMIT and value < lower
        outside = bool((upper or lower) and (over or under))
        entered = outside and not self._outside[number - 1]
        self._outside[number - 1] = outside
        if transmitted is None:
            return bool(trigger)
        kinds = Trigger.DELTA | (
            Trigger.RISEN if value > transmitted else Trigger.FALLEN
        )
        return entered or bool(
            trigger & kinds and abs(value - transmitted) >= max(delta, 1)
        )

    def _refer(self) -> None:
        """Compute the angle reference from its input."""
        objects = self._objects
        value = getattr(objects, f"Analogue_input_{objects.Angle_reference_input}")
        angle = objects.Angle_reference_offset + round(
            objects.Angle_reference_gain * value / 0x7FFF
        )
        angle = min(max(angle, -0x8000_0000), 0x7FFF_FFFF)
        if angle != objects.Angle_reference:
            self.events["Angle_reference"] = None
        objects.Angle_reference = angle

    def _drive(self) -> None:
        objects = self._objects
        for n, place in enumerate(_BITS):
            value = getattr(objects, f"Digital_outputs_{place}")
            polarity = getattr(objects, f"Polarity_of_outputs_{place}")
            self.levels[n] = (value ^ polarity) & 0xFF
        for number in range(1, ANALOGUE_OUTPUTS + 1):
            value = getattr(objects, f"Analogue_output_{number}")
            self.output_voltages[number - 1] = value / 0x7FFF * FULL_SCALE


def converted(voltage: float) -> int:
    """Return the converter's value for a voltage."""
    if not isfinite(voltage):
        raise ValueError(f"{voltage} is not a voltage")
    return min(max(round(voltage / FULL_SCALE * 0x7FFF), -0x8000), 0x7FFF)
