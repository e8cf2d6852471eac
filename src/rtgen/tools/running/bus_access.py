"""Sends frames and transfers objects on the simulated buses of a run, for those who watch it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.bus.simulated_bus import SimulatedCanBus
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.errors import RtcError
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND

MAX_CYCLIC_FRAMES: Final = 64
"""Maximum number of cyclic frames per bus."""
MIN_PERIOD: Final = 0.001


class RealBusError(RtcError):
    """The bus is not simulated."""


class CyclicFramesError(RtcError):
    """Too many cyclic frames are sent."""


class BusAccess:
    """The buses of a system; used in the thread of its run. Methods raise RealBusError."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._cyclic: dict[str, dict[tuple[int, bool], Callable[[], None]]] = {}

    def send(self, bus: str, frame: Frame, period: float) -> None:
        """Send a frame once, or from now on with a period [s]; a period 0 ends that.

        Raises LinkError; ValueError for the period, CyclicFramesError.
        """
        link = self._link(bus)
        cyclic = self._cyclic.setdefault(bus, {})
        key = frame.can_id, frame.extended
        if key in cyclic:
            cyclic.pop(key)()
            if not period:
                return
        if not period:
            link.send([frame])
            return
        if not period >= MIN_PERIOD:
            raise ValueError(f"a period of {period:g} s")
        if len(cyclic) >= MAX_CYCLIC_FRAMES:
            raise CyclicFramesError(
                f"{MAX_CYCLIC_FRAMES} cyclic frames are sent already"
            )
        cyclic[key] = self._system.every(
            round(period * SECOND), lambda: link.send([frame])
        )

    def read(self, bus: str, node: int, number: tuple[int, int]) -> bytes:
        """Read an object of a node by index and subindex. Raises SdoAbort, LinkError."""
        octets: bytes = self._link(bus).sdo(node).upload(*number)
        return octets

    def write(
        self, bus: str, node: int, number: tuple[int, int], octets: bytes
    ) -> None:
        """Write an object of a node. Raises SdoAbort, LinkError."""
        self._link(bus).sdo(node).download(*number, octets)

    def _link(self, name: str) -> SimulatedCanBus:
        network = self._system.clock.network
        if network is None:
            raise RealBusError("pages send on simulated buses only")
        return simulated_bus(network, name)
