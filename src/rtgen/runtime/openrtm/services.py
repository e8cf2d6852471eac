"""Service ports of OpenRTM behind the providers and consumers of a behaviour."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtgen.runtime.service_ports import Consumer, Provider
from rtgen.runtime.services import ServiceError, Skeleton


def servant_of(provider: Provider[Any]) -> Any:
    """A servant that calls the provider's, while its component is ACTIVE.

    What the IDL does not allow is raised as a system exception of CORBA.
    """

    def call(operation: str, arguments: tuple[object, ...]) -> object:
        try:
            return provider.call(operation, arguments)
        except ServiceError as error:
            from rtgen.runtime.corba.faults import raised

            raise raised(error) from error

    return provider.interface._stub_(call)


class RemoteProvider:
    """Carries a consumer's calls to the object that OpenRTM has connected it to.

    `stub` makes a servant of a function that gives the object's reference, or None.
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
