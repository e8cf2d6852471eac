"""Fault injection of a hub: lost and delayed frames, and bus-off."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Sequence
from typing import Final, Literal

import msgspec

from rtgen.facts.canopen import MAX_EXTENDED_ID
from rtgen.runtime.canopen.wire.frames import Frame

_NUMBER: Final = r"([0-9]*\.?[0-9]+)"
_FORM: Final = re.compile(
    rf"(?:(loss|delay)={_NUMBER}(?:@([0-9A-Fa-f]{{1,8}}))?|bus-off={_NUMBER}:{_NUMBER})"
)
_MAX_SECONDS: Final = 86400.0
"""Maximum time of a fault, in seconds."""


class Fault(msgspec.Struct, frozen=True, gc=False):
    """`value`: probability of a loss, a delay in s, or the start of bus-off in s.

    `identifier` limits losses and delays to its frames; `duration` is that of bus-off in s.
    """

    kind: Literal["loss", "delay", "bus-off"]
    value: float
    identifier: int | None = None
    duration: float = 0.0


def fault_of(text: str) -> Fault:
    """Parse `loss=P[@ID]`, `delay=MS[@ID]` or `bus-off=AT:FOR`. Raises ValueError."""
    match = _FORM.fullmatch(text)
    if match is None:
        raise ValueError(
            f"{text!r} is not a fault; there are loss=P[@ID], delay=MS[@ID], bus-off=AT:FOR"
        )
    kind, number, identifier, at, duration = match.groups()
    if kind is None:
        fault = Fault("bus-off", float(at), duration=float(duration))
    else:
        value = float(number) if kind == "loss" else float(number) / 1000
        fault = Fault(
            "loss" if kind == "loss" else "delay",
            value,
            None if identifier is None else int(identifier, 16),
        )
    if fault.identifier is not None and fault.identifier > MAX_EXTENDED_ID:
        raise ValueError(f"{text!r}: an identifier is at most {MAX_EXTENDED_ID:X}")
    if kind == "loss" and fault.value > 1:
        raise ValueError(f"{text!r}: a probability is at most 1")
    if max(fault.value, fault.duration) > _MAX_SECONDS:
        raise ValueError(f"{text!r}: a fault takes a day at most")
    return fault


class Faults:
    """Applies faults to frames; deterministic for the same seed and frames."""

    def __init__(self, faults: Iterable[Fault] = (), seed: int = 0) -> None:
        self._faults = tuple(fault for fault in faults if fault.kind != "bus-off")
        self._random = random.Random(seed)

    def delay(self, frame: Frame) -> float | None:
        """Return the delay of a frame in s; None if it is lost."""
        delay = 0.0
        for fault in self._faults:
            if fault.identifier in (None, frame.can_id):
                if fault.kind == "delay":
                    delay += fault.value
                elif self._random.random() < fault.value:
                    return None
        return delay


def times_off(faults: Sequence[Fault]) -> list[tuple[float, float]]:
    """Return start and end of each bus-off, in s after the start."""
    return [(f.value, f.value + f.duration) for f in faults if f.kind == "bus-off"]
