"""Connects service ports of OpenRTM to the providers and consumers of a behaviour."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import ServiceError, Skeleton


def servant_of(provider: Provider[Any]) -> Any:
    """Return a CORBA servant that calls the provider's while its component is ACTIVE.

    Undeclared exceptions are raised as system exceptions of CORBA.
    """

    def call(operation: str, arguments: tuple[object, ...]) -> object:
        try:
            return provider.call(operation, arguments)
        except ServiceError as error:
            from rtgen.runtime.corba.faults import raised

            raise raised(error) from error

    return provider.interface._stub_(call)


class RemoteProvider:
    """Makes a consumer's calls to the object that OpenRTM has connected.

    `stub` constructs a stub from a function that returns the object's reference, or None.
    """

    def __init__(
        self,
        consumer: Consumer[Any],
        reference: Callable[[], Any],
        stub: Callable[[Callable[[], Any]], Any],
    ) -> None:
        self._reference = reference
        self._skeleton: Skeleton = consumer.interface._skeleton_(stub(reference))

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return self._reference() is not None

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """See `Carrier`."""
        return self._skeleton.dispatch(operation, arguments)
