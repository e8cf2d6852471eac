"""The manager component: a manager station with life cycle and ports."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from typing import Any, ClassVar, Final, Protocol

from rtgen.facts.canopen_parameters import COMPONENT_FACTS
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.master.managed_node import NodeReport
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.networks import UnknownNetworkError, load_network
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import Provider

_UNSENT_REPORTS: Final = 4096
"""Maximum number of reports queued for the next tick; the oldest are dropped."""


class ManagerParameters(Protocol):
    """Configuration parameters of every manager."""

    network: str
    interface: str
    channel: str
    bitrate: int
    options: str


class CanopenManager(ABC, Component, **COMPONENT_FACTS):
    """Base class of a project's generated manager.

    It runs the network while ACTIVE. When deactivated or reset, it switches the nodes to
    pre-operational and keeps only its own heartbeat. It enters ERROR when a mandatory node has
    finally failed, and continues to manage the other nodes.
    """

    networks: ClassVar[str] = ""
    """The package of the generated networks."""

    config: Any
    """The `ManagerParameters`."""
    states: OutPort[Any]
    manager: Provider[Any]

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.station: ManagerStation | None = None
        """The station that runs the network; None before the first activation."""
        self._unsent: deque[NodeReport] = deque(maxlen=_UNSENT_REPORTS)
        self._bus: tuple[str, str, int, str] | None = None
        self._offset = 0

    # Implemented by the generated manager

    @abstractmethod
    def _servant(self) -> Any:
        """Return the servant of the service port; called once."""

    @abstractmethod
    def _sample(self, report: NodeReport, time: int) -> Any:
        """Convert a report to a sample; `time` is in ns of the component's clock."""

    # Used by its servant

    def reports(self) -> list[Any]:
        """Return the states of all nodes as samples, by node-id."""
        station = self.station
        return (
            [] if station is None else [self._to_sample(r) for r in station.reports()]
        )

    def refusal(self, command: NmtCommand, node_id: int) -> str:
        """Send an NMT command to a node, or to all (0); return why it was refused, or ""."""
        station = self.station
        if station is None or not station.running:
            return "the network does not run"
        if node_id and node_id not in station.nodes:
            return f"the network {station.network.name} has no node {node_id}"
        station.request(command, node_id)
        return ""

    # Callbacks

    def on_initialize(self) -> ReturnCode_t:
        """Provide the service."""
        self.manager.set_servant(self._servant())
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start the network."""
        try:
            self.station = self._joined()
            self.station.start()
        except (UnknownNetworkError, LinkError, RuntimeError) as error:
            self._leave()
            return self.fail(str(error))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Publish changed states."""
        self._publish()
        station = self.station
        assert station is not None
        failure = station.failure
        return self.fail(failure) if failure else RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Publish changed states; the other nodes remain managed."""
        self._publish()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Switch the nodes to pre-operational."""
        return self._halt()

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Switch the nodes to pre-operational; the next activation starts over."""
        return self._halt()

    def on_finalize(self) -> ReturnCode_t:
        """Leave the bus."""
        self._leave()
        return RTC_OK

    # Private methods

    def _joined(self) -> ManagerStation:
        """Return the station for the current parameters; an existing one is reused if it fits."""
        config: ManagerParameters = self.config
        network = load_network(self.networks, config.network)
        bitrate = config.bitrate or network.bit_rate * 1000
        bus = (config.interface, config.channel, bitrate, config.options)
        station = self.station
        if station is not None and (self._bus, station.network) == (bus, network):
            return station
        self._leave()
        # Once per station: the link stays open until the station is attached.
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
            self.states.write(self._to_sample(unsent.popleft()))

    def _to_sample(self, report: NodeReport) -> Any:
        return self._sample(report, report.since + self._offset)
