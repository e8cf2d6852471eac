"""Connections to service ports of other processes, with providers looked up by name."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

import msgspec
from omniORB import CORBA

from rtgen.runtime.corba.faults import caught, is_inactive, is_lost, is_unsent
from rtgen.runtime.corba.naming import Naming, is_alive
from rtgen.runtime.corba.objects import Objects, Remote, signatures
from rtgen.runtime.errors import PortTypeError, TransportError
from rtgen.runtime.services.ports import Consumer, ServicePort
from rtgen.runtime.services.remote_connectors import (
    RemoteServiceConnector,
    fitting_provider,
)
from rtgen.runtime.services.servants import (
    CommunicationFailure,
    ObjectNotExist,
    ServiceError,
)
from rtgen.runtime.services.transports import RemotePort

_RETRY_INTERVAL = 0.2
"""Seconds between two attempts to reach a provider that did not respond."""


class RemoteProvider(msgspec.Struct, eq=False):
    """The provider that a consumer is connected to, looked up at the first call.

    A lost provider is looked up again, since its process may have been restarted. A call that may
    have been executed is not repeated.
    """

    _objects: Objects
    _naming: Naming
    consumer: Consumer[Any]
    port: RemotePort
    selected: str | None
    alone: bool
    _remote: Remote | None = None
    _looking: threading.Lock = msgspec.field(default_factory=threading.Lock)
    _lost: float = 0.0
    _failure: ServiceError | None = None

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return True

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call. Raises what the operation declares, CdrError and ServiceError."""
        remote = self._remote or self._find_remote(operation)
        try:
            return remote.attempt(operation, arguments)
        except CORBA.SystemException as error:
            if is_inactive(error) or not is_lost(error):
                raise caught(operation, error) from error
            self._remote = None
            another = self._another(remote, error)
            if another is None:
                raise self._fail(caught(operation, error)) from error
            return another.call(operation, arguments)

    def find(self) -> bool:
        """Look up the provider; return whether it exists. Raises TransportError, PortTypeError."""
        with self._looking:
            if self._remote is None:
                try:
                    reference = self._reference()
                except CORBA.SystemException:
                    return False
                if reference is None:
                    return False
                self._remote = self._objects.remote(self.consumer.interface, reference)
            return True

    @property
    def is_served(self) -> bool:
        """Whether some process has the port, with any provider."""
        try:
            return self.find()
        except PortTypeError:
            return True
        except TransportError:
            return False

    @property
    def exists(self) -> bool:
        """Whether the provider is ACTIVE."""
        try:
            if not self.find():
                return False
            remote = self._remote
            return remote is not None and not remote.reference._non_existent()
        except (CORBA.SystemException, TransportError, PortTypeError):
            self._remote = None
            return False

    def _find_remote(self, operation: str) -> Remote:
        failure = self._failure
        if failure is not None and time.monotonic() < self._lost + _RETRY_INTERVAL:
            raise type(failure)(
                f"{operation}: not tried again so soon after: {failure}"
            )
        try:
            there = self.find()
        except (TransportError, PortTypeError) as error:
            raise self._fail(CommunicationFailure(f"{operation}: {error}")) from error
        remote = self._remote
        if not there or remote is None:
            why = f"{operation}: nobody serves {self.port}, to which {self.consumer} is connected"
            raise self._fail(ObjectNotExist(why))
        self._failure = None
        return remote

    def _another(self, remote: Remote, error: Any) -> Remote | None:
        """Return another provider for a call that did not arrive; None if there is none."""
        if not is_unsent(error):
            return None
        try:
            if not self.find() or self._remote is None:
                return None
        except (TransportError, PortTypeError):
            return None
        if self._remote.reference._is_equivalent(remote.reference):
            self._remote = None
        return self._remote

    def _fail(self, error: ServiceError) -> ServiceError:
        self._lost, self._failure = time.monotonic(), error
        return error

    def _reference(self) -> Any:
        """Return the reference in the naming service; None if no process provides the port."""
        served = self._naming.providers((self.port.instance, self.port.port))
        # omniORB answers `_is_a` locally if it can, even for lost objects.
        found = {name: r for name, r in served.items() if is_alive(r)}
        if not found:
            return None
        return fitting_provider(self, found, lambda r, id_: r._is_a(id_), signatures)


class RemoteConnector(RemoteServiceConnector[RemoteProvider]):
    """A connection between a local service port and one of another process, by omniORB."""

    def __init__(
        self,
        name: str,
        source: ServicePort,
        target: RemotePort,
        properties: Mapping[str, str],
        objects: Objects,
        naming: Naming,
    ) -> None:
        def made(
            consumer: Consumer[Any], selected: str | None, alone: bool
        ) -> RemoteProvider:
            return RemoteProvider(
                objects, naming, consumer, target, selected, alone=alone
            )

        where = f"by the naming service {naming.address}"
        super().__init__(name, source, target, properties, made, where)
