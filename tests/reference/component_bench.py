"""Test bench: one component alone, in simulated time, with a peer at every data port."""

from __future__ import annotations

from typing import Any

from rtgen.runtime import SECOND, Component, LifeCycleState, SimulatedClock, System


class Bench:
    """Sends samples to the component, and records those that it writes."""

    def __init__(self, component: Component, rate_hz: float) -> None:
        self.component = component
        self._period = 1.0 / rate_hz
        self.system = System(SimulatedClock())
        self.system.add(component, rate_hz)
        self._peer = Component("Peer0")
        for name, source in component.out_ports.items():
            self._peer.add_in_port(name, source.type)
        for name, target in component.in_ports.items():
            self._peer.add_out_port(name, target.type)
        self.system.add(self._peer, rate_hz)
        for name in component.out_ports:
            self._connect((component.instance_name, name), ("Peer0", name))
        for name in component.in_ports:
            self._connect(("Peer0", name), (component.instance_name, name))

    def _connect(self, source: tuple[str, str], target: tuple[str, str]) -> None:
        self.system.connect(source, target, {"dataport.inport.buffer.length": "100000"})

    def set(self, **parameters: str) -> None:
        """Set parameters by their outside names."""
        for name, text in parameters.items():
            self.system.configure(self.component.instance_name, name, text)

    def activate(self) -> None:
        """Activate the component; takes one execution period."""
        self.system.activate(self.component.instance_name)
        self.run(self._period)

    def deactivate(self) -> None:
        """Deactivate the component; takes one execution period."""
        self.system.deactivate(self.component.instance_name)
        self.run(self._period)

    @property
    def state(self) -> LifeCycleState:
        """The state of the component."""
        return self.system.state(self.component.instance_name)

    def run(self, seconds: float) -> None:
        """Advance simulated time; calls due at its end are left for later."""
        self.system.run(until_ns=self.system.time + round(seconds * SECOND))

    def send(self, port: str, *samples: Any) -> None:
        """Send samples to an InPort of the component."""
        for sample in samples:
            self._peer.out_ports[port].write(sample)

    def sent(self, port: str) -> list[Any]:
        """Return the samples that the component has sent since the last call."""
        in_port = self._peer.in_ports[port]
        samples = []
        while in_port.is_new():
            samples.append(in_port.read())
        return samples
