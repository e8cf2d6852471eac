"""Doors for profiles of components in XML and YAML, and those of systems."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from profiles import ProfileTarget

from doors import Door
from doors.definitions import of_target

WAYS = {"rtc-xml": 1, "rtc-yaml": 7, "rts-xml": 5}
"""The numbers by which the target selects the format of the octets."""


def _door(name: str) -> Callable[[Path], Door]:
    way = WAYS[name]

    def opened(folder: Path) -> Door:
        target = ProfileTarget(folder)

        def make(chance: Random) -> bytes:
            # The target takes the format from the number modulo 35.
            return target.make(chance.getrandbits(30) * 35 + way)

        return of_target(target, make, way)

    return opened


DOORS: dict[str, Callable[[Path], Door]] = {name: _door(name) for name in WAYS}
