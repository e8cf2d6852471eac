"""Connects a generated proxy to service ports: its channel, and the servant for its interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Self

from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.opaque_rpc.errors import E_OBJ, ChannelError
from rtgen.runtime.services.ports import Consumer
from rtgen.runtime.services.servants import Servant, ServiceError


class CommunicationChannel:
    """A channel over the service port of a communication RTC."""

    def __init__(self, port: Consumer[Any]) -> None:
        self._port = port
        self._service = port.object
        self._failed: type[Any] = port.interface.Failed

    def __str__(self) -> str:
        return str(self._port)

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`."""
        try:
            data: bytes = self._service.begin(request, first)
        except (self._failed, ServiceError) as error:
            raise self._error(error) from error
        return data

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        try:
            data: bytes = self._service.more(n)
        except (self._failed, ServiceError) as error:
            raise self._error(error) from error
        return data

    def end(self) -> None:
        """See `Channel`."""
        try:
            self._service.end()
        except ServiceError as error:
            raise self._error(error) from error

    def reset(self) -> None:
        """See `Channel`; no effect if the communication RTC is gone."""
        try:
            self._service.reset()
        except ServiceError:
            return

    def _error(self, error: Any) -> ChannelError:
        if isinstance(error, self._failed):
            return ChannelError(error.code, error.reason)
        return ChannelError(E_OBJ, str(error))


class ProxyServant:
    """Base class of generated servants; operations that they do not define call the proxy.

    `methods` maps an operation to the proxy's method, if the names differ.
    """

    def __init_subclass__(
        cls, methods: Mapping[str, str] | None = None, **options: Any
    ) -> None:
        super().__init_subclass__(**options)
        for base in cls.__mro__[1:]:
            if issubclass(base, Servant):
                for name, member in vars(base).items():
                    is_open = getattr(member, "__isabstractmethod__", False)
                    if is_open and name not in vars(cls):
                        method = (methods or {}).get(name, name)
                        setattr(cls, name, _forwarding(method))

    def __init__(self, proxy: Any) -> None:
        self._proxy = proxy

    @property
    def codec(self) -> Codec:
        """The codec of the proxy."""
        codec: Codec = self._proxy.codec
        return codec

    @classmethod
    def of(cls, proxy: Any) -> Self:
        """Return the servant for a proxy."""
        return cls(proxy)


def _forwarding(name: str) -> Callable[..., object]:
    def operation(self: Any, *arguments: object) -> object:
        return getattr(self._proxy, name)(*arguments)

    return operation
