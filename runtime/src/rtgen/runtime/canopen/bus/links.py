"""Opens links: one for each bus and process, shared by all callers."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.shared_link import SharedLink
from rtgen.runtime.canopen.bus.simulated_bus import SimulatedCanBus
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.timing.clocks import Clock
from rtgen.runtime.timing.simulated_network import SimulatedNetwork

if TYPE_CHECKING:
    from rtgen.runtime.canopen.bus.real_link import RealLink


def open_link(
    owner: Component | Clock,
    interface: str = "virtual",
    channel: str = "can0",
    bitrate: int = 0,
    options: str = "",
) -> Link:
    """Return the link of a component, or of the owner of a clock, to a bus.

    In real time the bus is python-can's: `interface`, `channel`, `bitrate` in bit/s (0: the
    interface's default) and further arguments as `options`, "host=127.0.0.1,port=29536". In
    simulated time only the channel identifies the bus, and without a bit rate frames take no time.
    The link stays open until a station is attached, and is closed with its last station; then it
    must be opened again. Raises LinkError.
    """
    clock = owner if isinstance(owner, Clock) else owner._clock
    link: SharedLink
    if clock.network is not None:
        link = simulated_bus(clock.network, channel, bitrate)
    else:
        link = _REGISTRY.open(interface, channel, bitrate, options)
    link.report_to(clock.traffic, channel)
    return link


def simulated_bus(
    network: SimulatedNetwork, channel: str = "can0", bitrate: int = 0
) -> SimulatedCanBus:
    """Return the bus of a channel in simulated time; `bitrate` in bit/s, 0 accepts any.

    Raises LinkError if the bus has another bit rate, or if no system runs on its clock.
    """
    bus = network.device(
        SimulatedCanBus, channel, lambda: SimulatedCanBus(network.clock, channel)
    )
    if bitrate and bus.bit_rate not in (0, bitrate):
        raise LinkError(
            f"{bus.bus} runs at {bus.bit_rate} bit/s, and not at {bitrate} bit/s"
        )
    bus.bit_rate = bus.bit_rate or bitrate
    return bus


class _Registry:
    """The links of this process in real time, with the number of users of each.

    `_lock` may be acquired while holding a link's lock, never the other way round, and only
    briefly: buses are opened without it.
    """

    def __init__(self) -> None:
        self._opening = threading.Lock()
        self._lock = threading.Lock()
        self._links: dict[object, RealLink] = {}
        self._kept: dict[object, int] = {}

    def open(
        self, interface: str, channel: str, bitrate: int, options: str
    ) -> RealLink:
        from rtgen.runtime.canopen.bus.python_can import bus_address
        from rtgen.runtime.canopen.bus.real_link import RealLink

        address = bus_address(interface, channel, bitrate, options)
        key = address.key
        with self._opening:
            link = self._open_link(key, bitrate)
            if link is None:
                link = RealLink(
                    address, lambda: self._attached(key), lambda: self._may_close(key)
                )
                with self._lock:
                    self._links[key], self._kept[key] = link, 1
        return link

    def _open_link(self, key: object, bitrate: int) -> RealLink | None:
        with self._lock:
            link = self._links.get(key)
            if link is None or link.closed:
                return None
            if bitrate and link.address.bitrate not in (0, bitrate):
                raise LinkError(
                    f"{link.bus} is open at {link.address.bitrate} bit/s, "
                    f"and not at {bitrate} bit/s"
                )
            self._kept[key] += 1
            return link

    def _attached(self, key: object) -> None:
        with self._lock:
            self._kept[key] = max(0, self._kept[key] - 1)

    def _may_close(self, key: object) -> bool:
        with self._lock:
            if self._kept[key] or self._links[key].has_stations:
                return False
            del self._links[key], self._kept[key]
            return True


_REGISTRY = _Registry()
