"""Interface of transports of service calls, within a process and between processes.

Every transport guarantees the following, which tests verify for each
(`tests/runtime/transports/test_whole_transports.py`, `test_lost_processes.py`):

- the samples of a connection arrive in the order in which they were written, each at most once;
  buffers and full policies are those of the receiving end, and `InPort.lost` counts what did not
  reach the reader; a late reader finds the samples waiting at a pull connection;
- samples and arguments of 10 MB are transferred; a sample that cannot be decoded is lost;
- calls are executed at most once, also oneway ones, and return, raise what their operation
  declares, or raise a ServiceError within the time-out of the transport;
- when another process is killed, or stops for longer than the time-out, calls and writes end in
  time; when it is back, calls and connections resume by themselves.

Topics, histories, deadlines and presence are concepts of messaging engines, with a contract of
their own: `rtgen.runtime.distribution.medium`. CORBA has none of them: a connection has two ports,
a write is a call of the other one, and a loss is detected by the next call.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol, runtime_checkable

import msgspec

from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.return_codes import LifeCycleState
from rtgen.runtime.services.ports import Carrier, PortOwner, Provider, ServicePort
from rtgen.runtime.timing.guards import Guard


class RemotePort(msgspec.Struct, frozen=True, gc=False):
    """A port of a component in another process."""

    instance: str
    port: str

    def __str__(self) -> str:
        return f"{self.instance}.{self.port}"


class ForeignComponent(msgspec.Struct, frozen=True, gc=False):
    """A component of a system that rtgen does not run.

    `path` is the `pathUri` of an RtsProfile (`HOST[:PORT]/HOST.host_cxt/NAME.rtc`), or an address
    that CORBA knows (`corbaname:`, `corbaloc:`, `IOR:`). `configuration` maps sets to values.
    """

    instance: str
    path: str = ""
    configuration: Mapping[str, Mapping[str, str]] = msgspec.field(default_factory=dict)
    active_set: str = "default"


class LinkReport(msgspec.Struct, frozen=True, gc=False):
    """The failures of a connection with another process; `name` includes its ports.

    `lost` samples did not arrive, at least; `not_received` of them were sent to this process, and
    count for its InPort. The connection has ended `breaks` times without a
    request of this process, and was made again `renewals` times.
    """

    name: str
    there: RemotePort
    lost: int
    not_received: int
    breaks: int
    renewals: int
    reason: str


class RemoteConnector(Protocol):
    """A connection to a service port of another process."""

    name: str
    source: ServicePort
    target: RemotePort
    connected: bool

    def attach(self) -> None:
        """Establish the connection. Raises ConnectError."""

    def detach(self) -> None:
        """Remove the connection; later calls raise ObjectNotExist."""


class Transport(Protocol):
    """Transports the calls of a system's service ports. Methods raise RtcError."""

    def serve(self, component: PortOwner) -> None:
        """Publish the providers of a component."""

    def withdraw(self, component: PortOwner) -> None:
        """Withdraw the providers of a component."""

    def carrier_of(self, consumer_interface: Any, provider: Provider[Any]) -> Carrier:
        """Return the carrier of calls from a consumer's interface to a provider of this process."""

    def connector(
        self,
        name: str,
        here: ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteConnector:
        """Return an unestablished connection to another process's port. Raises ConnectError."""


class RemoteDataConnector(Protocol):
    """A connection from an OutPort of this process to an InPort of another one."""

    name: str
    source: OutPort[Any]
    target: RemotePort
    properties: Mapping[str, str]
    connected: bool

    def attach(self) -> None:
        """Establish the connection."""

    def detach(self) -> None:
        """Remove the connection."""


@runtime_checkable
class ControlTransport(Protocol):
    """A transport through which other processes observe and control a system."""

    def allow_control(self, system: Any) -> None:
        """Let other processes observe and control a system, of class `System`."""


@runtime_checkable
class PublishingTransport(Protocol):
    """A transport that publishes components as objects, to which other processes connect."""

    def publishing(self) -> AbstractContextManager[None]:
        """Publish the components served meanwhile at the end. Raises TransportError.

        Until then, the process declares its own connections: one that another process makes first
        would take the name of its counterpart.
        """


@runtime_checkable
class DataTransport(ControlTransport, Protocol):
    """A transport that also transports samples between processes."""

    def sending(
        self,
        name: str,
        here: OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
    ) -> RemoteDataConnector:
        """Return an unestablished connection to another process's InPort. Raises ConnectError."""

    def receiving(
        self,
        name: str,
        here: InPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> DataConnector[Any] | RemoteDataConnector:
        """Return an unestablished connection from another process's OutPort.

        Buffers and policies of the connection are at this end. Raises ConnectError.
        """


class ProcessTransport(Transport, Protocol):
    """A transport for `rtgen run`, also for a system divided among processes."""

    def await_others(self, seconds: float) -> None:
        """Wait until all connected providers are there.

        Raises TransportError after that many seconds, PortTypeError if a provider is incompatible.
        """

    def is_ready(self, instance: str, before: Collection[str]) -> bool:
        """Return whether an instance's providers that other processes activate first are ACTIVE.

        `before` are the names of the instances that are activated before it.
        """


@runtime_checkable
class ForeignTransport(Protocol):
    """A transport to components that rtgen does not run. Methods raise TransportError."""

    def add_foreign(self, component: ForeignComponent) -> None:
        """Look for a component, configure it, and connect it again after a loss."""

    def is_foreign(self, instance: str) -> bool:
        """Return whether rtgen does not run a component, and looks for it."""

    def activate_foreign(self, instance: str) -> None:
        """Request ACTIVE of a component."""

    def deactivate_foreign(self, instance: str) -> None:
        """Deactivate a component that `activate_foreign` has activated; a failure is logged.

        One that was ACTIVE before remains ACTIVE. It is not activated again.
        """

    def foreign_states(self) -> Mapping[str, LifeCycleState | None]:
        """Return the last known states of the foreign components; None: it does not answer."""

    def link_reports(self) -> Sequence[LinkReport]:
        """Return the failures of connections with other processes."""

    def release_foreign(self) -> None:
        """Deactivate all of them, the last one first; in a bounded time, from any thread."""


@runtime_checkable
class AwaitingTransport(Protocol):
    """A transport that knows which components of other processes are missing."""

    @property
    def missing(self) -> list[str]:
        """The instances that `await_others` waits for, sorted. Can be used from any thread."""
