"""Opens links: one for each bus and process, shared by all who ask for it."""

from __future__ import annotations

from rtgen.runtime.canopen.link import Link, LinkError
from rtgen.runtime.canopen.simulated_bus import SimulatedCanBus
from rtgen.runtime.clocks import Clock
from rtgen.runtime.component import Component
from rtgen.runtime.simulated_network import SimulatedNetwork


def open_link(
    owner: Component | Clock,
    interface: str = "virtual",
    channel: str = "can0",
    bitrate: int = 0,
    options: str = "",
) -> Link:
    """The link of a component, or of whoever goes by a clock, to a bus.

    In real time the bus is python-can's: `interface`, `channel`, `bitrate` in bit/s (0: what the
    interface has) and further arguments as `options`, "host=127.0.0.1,port=29536". In simulated
    time the channel alone names it, and without bit rate frames take no time. The link is closed
    with its last station. Raises LinkError.
    """
    clock = owner if isinstance(owner, Clock) else owner._clock
    if clock.network is not None:
        return simulated_bus(clock.network, channel, bitrate)
    raise LinkError("no real time yet")


def simulated_bus(
    network: SimulatedNetwork, channel: str = "can0", bitrate: int = 0
) -> SimulatedCanBus:
    """The bus of a channel in simulated time; `bitrate` in bit/s, 0 takes any.

    Raises LinkError if it has another bit rate, or if no system runs on its clock.
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
