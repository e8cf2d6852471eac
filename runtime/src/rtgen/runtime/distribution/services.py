"""Service calls over a medium: providers of this process, and carriers to those of others."""

from __future__ import annotations

import threading
from _thread import interrupt_main
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.distribution.descriptions import Description, Interface
from rtgen.runtime.distribution.medium import (
    Client,
    Medium,
    MediumError,
    NotServedError,
    PeerLostError,
    Reply,
    ReplyTimeoutError,
    Token,
)
from rtgen.runtime.distribution.names import service_name
from rtgen.runtime.distribution.rpc_calls import RpcClient, RpcServer
from rtgen.runtime.distribution.rpc_header import (
    Doubles,
    SampleIdentity,
    identity_of,
)
from rtgen.runtime.distribution.rpc_types import (
    OperationTypes,
    interface_types,
    lineage_types,
)
from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.errors import PortTypeError, TransportError
from rtgen.runtime.failures import described, ends_run, log
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.remote_connectors import fitting_provider
from rtgen.runtime.services.servants import (
    CallTimeout,
    CommunicationFailure,
    ObjectNotExist,
    ServiceError,
    UnknownException,
)
from rtgen.runtime.services.transports import RemotePort


class ServedProvider:
    """A provider of this process as a service. Raises MediumError, ServiceError."""

    def __init__(
        self, medium: Medium, workers: Workers, provider: Provider[Any]
    ) -> None:
        self._workers = workers
        self._server = RpcServer(provider.interface, provider.carry_out)
        self._doubles = Doubles()
        self._name = str(provider)
        name = service_name(provider.owner, provider.port, provider.instance)
        types = lineage_types(provider.interface)
        self._token: Token = medium.serve(name, types, self._on_request)

    def close(self) -> None:
        """Stop serving."""
        self._token.close()

    def _on_request(self, octets: bytes, reply: Reply) -> None:
        try:
            identity, operation, value = self._server.request(octets)
            client, number = identity_of(octets)
            if self._doubles.is_double((client, number)):
                return
        except CdrError as error:
            log.warning("%s: a request cannot be read: %s", self._name, error)
            return
        oneway = operation is not None and operation.call.oneway
        work = partial(self._answer, identity, operation, value, reply)
        accepted = self._workers.submit(work, client)
        if not accepted:
            log.warning("%s: too many calls wait", self._name)
        if oneway or not accepted:
            # An engine of queries waits for the reply to a oneway request, too.
            failure = CommunicationFailure("too many calls wait")
            reply(self._server.failure(identity, failure))

    def _answer(
        self,
        identity: SampleIdentity,
        operation: OperationTypes | None,
        value: Any,
        reply: Reply,
    ) -> None:
        try:
            answer = self._server.answer(identity, operation, value)
        except BaseException as error:
            if not ends_run(error):
                raise
            # Not a thread of the run; the run ends in the main thread.
            interrupt_main()
            failure = UnknownException(described(error))
            answer = self._server.failure(identity, failure)
        if operation is None or not operation.call.oneway:
            reply(answer)


class RemoteCalls:
    """Calls of one interface to one service; every client has an identity of its own."""

    def __init__(
        self, medium: Medium, interface: Any, service: str, timeout: float
    ) -> None:
        types = interface_types(interface)
        self._client: Client = medium.client(service, types)
        self._call = RpcClient(interface, self._client, timeout)

    def close(self) -> None:
        """Close the client; running calls raise CommunicationFailure."""
        self._client.close()

    def invoke(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Call an operation. Raises declared exceptions, CdrError and ServiceError."""
        try:
            return self._call(operation, arguments)
        except NotServedError as error:
            raise ObjectNotExist(f"{operation}: {error}") from error
        except PeerLostError as error:
            raise CommunicationFailure(f"{operation}: {error}") from error
        except ReplyTimeoutError as error:
            raise CallTimeout(f"{operation}: {error}") from error
        except MediumError as error:
            raise CommunicationFailure(f"{operation}: {error}") from error


class RemoteProvider(msgspec.Struct, eq=False):
    """The provider in another process that is connected with a consumer.

    It is looked up at the first call, and again after its process was lost, since it may have been
    restarted. A call that may have been executed is not repeated.
    """

    _medium: Medium
    _described: Callable[[str], Description | None]
    _timeout: float
    consumer: Consumer[Any]
    port: RemotePort
    selected: str | None
    alone: bool
    _calls: RemoteCalls | None = None
    _chosen: str | None = None
    _looking: threading.Lock = msgspec.field(default_factory=threading.Lock)

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return True

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Call an operation. Raises declared exceptions, CdrError and ServiceError."""
        try:
            interface = self.find()
        except (TransportError, PortTypeError) as error:
            raise CommunicationFailure(f"{operation}: {error}") from error
        carrier = self._calls
        if not interface or carrier is None:
            raise ObjectNotExist(
                f"{operation}: nobody serves {self.port}, to which {self.consumer} is connected"
            )
        return carrier.invoke(operation, arguments)

    def find(self) -> bool:
        """Look up the provider; return whether it exists. Raises TransportError, PortTypeError."""
        description = self._described(self.port.instance)
        if description is None:
            return False
        with self._looking:
            chosen = self._choice(description)
            if chosen is None:
                return False
            if chosen.instance != self._chosen:
                self.close()
                service = service_name(
                    self.port.instance, self.port.port, chosen.instance
                )
                try:
                    self._calls = RemoteCalls(
                        self._medium, self.consumer.interface, service, self._timeout
                    )
                except (MediumError, ServiceError) as error:
                    raise TransportError(str(error)) from error
                self._chosen = chosen.instance
            return True

    def close(self) -> None:
        """Forget the provider."""
        if self._calls is not None:
            self._calls.close()
        self._calls = None
        self._chosen = None

    def _choice(self, description: Description) -> Interface | None:
        """Return the matching provider; None if the port has none at all. Raises PortTypeError."""
        providers = {
            p.instance: p for p in description.providers if p.port == self.port.port
        }
        if not providers:
            return None
        return fitting_provider(
            self, providers, lambda p, id_: id_ in p.lineage, lambda p: p.operations
        )
