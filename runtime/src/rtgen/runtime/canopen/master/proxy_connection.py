"""A proxy's connection to its bus: settings, plan and parts."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.configuration import ProxyConfiguration
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Network,
    NodeDescription,
)
from rtgen.runtime.canopen.hooks import Sender
from rtgen.runtime.canopen.master.node_control import NodeControl, NodeError
from rtgen.runtime.canopen.master.proxied_node import (
    ProxiedNode,
    Wiring,
    transmitter_of,
    wiring,
)
from rtgen.runtime.canopen.master.proxy_location import (
    BOOT_TIMEOUT,
    default_boot_timeout,
)
from rtgen.runtime.canopen.master.recovery import Recovery
from rtgen.runtime.canopen.pdo import PdoError
from rtgen.runtime.canopen.wire.emergency import DEFAULT_STOPS, EmergencyPolicy
from rtgen.runtime.canopen.wire.pdo_transmission import TpdoTransmitter


def settings_of(config: ProxyConfiguration) -> ProxyConfiguration:
    """Return the settings in the configuration of a proxy, without those of its device."""
    names = ProxyConfiguration.__struct_fields__
    return ProxyConfiguration(**{name: getattr(config, name) for name in names})


class ProxyPlan(msgspec.Struct, frozen=True):
    """The parameters of a connection, merged from settings, network and description.

    `bit_rate` is in bit/s, `boot_timeout` in ms.
    """

    wiring: Wiring
    transmitters: Mapping[int, TpdoTransmitter]
    bit_rate: int
    boot_timeout: int
    emergencies: EmergencyPolicy
    recoveries: int

    def sent(
        self, senders: Mapping[int, Sender]
    ) -> tuple[tuple[int, Sender, TpdoTransmitter], ...]:
        """Return the PDOs that the proxy sends."""
        transmitters = self.transmitters
        return tuple(
            (n, s, transmitters[n]) for n, s in senders.items() if n in transmitters
        )

    def unsent(
        self, senders: Mapping[int, Sender]
    ) -> tuple[tuple[int, Sender, str], ...]:
        """Return the PDOs that the proxy does not send, with the reasons."""
        reasons = self.wiring.unsent
        return tuple(
            (n, s, reasons.get(n, "the network has no such PDO"))
            for n, s in senders.items()
            if n not in self.wiring.sent
        )


def planned(
    description: DeviceDescription,
    settings: ProxyConfiguration,
    network: Network | None,
    placed: NodeDescription | None,
) -> ProxyPlan:
    """Return the plan; settings override the network, which overrides the description.

    `placed` is the node in the network. Raises NodeError.
    """
    wired = wiring(description, settings.node_id, network)
    boot_timeout = settings.boot_timeout
    if boot_timeout == BOOT_TIMEOUT:
        boot_timeout = default_boot_timeout(description, placed)
    policy = settings.emergency_stop or (placed.emergency_stop if placed else "")
    try:
        emergencies = EmergencyPolicy(policy or DEFAULT_STOPS)
    except ValueError as error:
        raise NodeError(f"emergency_stop: {error}") from None
    return ProxyPlan(
        wired,
        {n: transmitter_of(pdo, settings.node_id) for n, pdo in wired.sent.items()},
        settings.bitrate or (network.bit_rate * 1000 if network else 0),
        boot_timeout,
        emergencies,
        settings.recoveries or (placed.recoveries if placed else 0),
    )


class ProxyConnection(msgspec.Struct, frozen=True):
    """A proxy's connection to its bus; `offset` is the component's time minus the link's."""

    settings: ProxyConfiguration
    link: Link
    node: ProxiedNode
    control: NodeControl
    senders: tuple[tuple[int, Sender, TpdoTransmitter], ...]
    unsent: tuple[tuple[int, Sender, str], ...]
    offset: int
    recovery: Recovery

    def deliver(self) -> None:
        """Write the received PDOs to the ports, in order of arrival.

        Those with a value that its port cannot have are dropped, counted and reported.
        """
        queue, offset = self.node.queue, self.offset
        for _ in range(len(queue)):
            pdo, data, time = queue.popleft()
            try:
                pdo.receiver(data, time + offset)
            except PdoError as error:
                self.node.refuse(pdo, error)
            else:
                pdo.unusable = False

    def pause(self) -> None:
        """Stop sending PDOs."""
        with self.link.lock:
            self.node.pause()
            self.link.refresh(self.node)
