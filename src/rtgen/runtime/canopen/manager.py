"""The component that runs a network: a manager's station, with a life cycle and ports."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from typing import Any, ClassVar, Final, Protocol

from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.links import open_link
from rtgen.runtime.canopen.managed_node import NodeReport
from rtgen.runtime.canopen.manager_station import ManagerStation
from rtgen.runtime.canopen.networks import UnknownNetworkError, load_network
from rtgen.runtime.canopen.nmt import NmtCommand
from rtgen.runtime.component import Component
from rtgen.runtime.data_ports import OutPort
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.service_ports import Provider

_UNSENT_REPORTS: Final = 4096
"""Reports that wait for the next tick at most; the oldest go first."""


class ManagerParameters(Protocol):
    """The parameters of every manager."""

    network: str
    interface: str
    channel: str
    bitrate: int
    options: str


class CanopenManager(ABC, Component):
    """The base of a project's generated manager.

    ACTIVE it runs the network. Deactivated, or reset, it has brought the nodes to pre-operational,
    and only its heartbeat goes on. It goes to ERROR when a mandatory node has failed for good, and
    still serves the others then.
    """

    networks: ClassVar[str] = ""
    """The package of the generated networks."""

    config: Any
    """Its `ManagerParameters`."""
    states: OutPort[Any]
    manager: Provider[Any]

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.station: ManagerStation | None = None
        """What runs the network; None before the first activation."""
        self._unsent: deque[NodeReport] = deque(maxlen=_UNSENT_REPORTS)
        self._bus: tuple[str, str, int, str] | None = None
        self._offset = 0

    # What the generated manager gives.

    @abstractmethod
    def _servant(self) -> Any:
        """The servant of the service port; asked once."""

    @abstractmethod
    def _sample(self, report: NodeReport, time: int) -> Any:
        """A node's state since a time (ns of the component's clock) as a sample."""

    # What its servant uses.

    def reports(self) -> list[Any]:
        """The states of all nodes as samples, by node-id."""
        station = self.station
        return [] if station is None else [self._told(r) for r in station.reports()]

    def refusal(self, command: NmtCommand, node_id: int) -> str:
        """Gives an NMT command to a node, or to all (0); why it cannot, empty if it did."""
        station = self.station
        if station is None or not station.running:
            return "the network does not run"
        if node_id and node_id not in station.nodes:
            return f"the network {station.network.name} has no node {node_id}"
        station.request(command, node_id)
        return ""

    # Callbacks

    def on_initialize(self) -> ReturnCode_t:
        """Offers the service."""
        self.manager.set_servant(self._servant())
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Starts the network from the beginning."""
        try:
            self.station = self._joined()
            self.station.start()
        except (UnknownNetworkError, LinkError, RuntimeError) as error:
            self._leave()
            return self.fail(str(error))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Tells what has changed."""
        self._publish()
        station = self.station
        assert station is not None
        failure = station.failure
        return self.fail(failure) if failure else RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Tells what has changed: the other nodes work on."""
        self._publish()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brings the nodes to pre-operational."""
        return self._halt()

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Does the same; the next activation starts over."""
        return self._halt()

    def on_finalize(self) -> ReturnCode_t:
        """Leaves the bus."""
        self._leave()
        return RTC_OK

    # The rest

    def _joined(self) -> ManagerStation:
        """The station for the present parameters: the one that there is, if it fits."""
        config: ManagerParameters = self.config
        network = load_network(self.networks, config.network)
        bitrate = config.bitrate or network.bit_rate * 1000
        bus = (config.interface, config.channel, bitrate, config.options)
        station = self.station
        if station is not None and (self._bus, station.network) == (bus, network):
            return station
        self._leave()
        # Once for each station: the link is kept until it is attached.
        link = open_link(self, *bus)
        self._bus = bus
        self._offset = self.now() - link.now()
        return ManagerStation(link, network, self._unsent.append)

    def _halt(self) -> ReturnCode_t:
        if self.station is not None:
            self.station.halt()
        self._publish()
        return RTC_OK

    def _leave(self) -> None:
        station, self.station = self.station, None
        if station is not None:
            station.close()

    def _publish(self) -> None:
        unsent = self._unsent
        for _ in range(len(unsent)):
            self.states.write(self._told(unsent.popleft()))

    def _told(self, report: NodeReport) -> Any:
        return self._sample(report, report.since + self._offset)
