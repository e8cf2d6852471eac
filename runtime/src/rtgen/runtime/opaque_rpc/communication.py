"""The communication RTC: sends requests of any signature to a TECS board."""

from __future__ import annotations

from time import perf_counter_ns
from typing import ClassVar

from msgspec.structs import replace

from rtgen.facts import opaque_rpc as facts
from rtgen.facts.opaque_rpc import CommunicationParameter
from rtgen.runtime import (
    RTC_OK,
    Component,
    ComponentProfile,
    ParameterProfile,
    PortProfile,
    ReturnCode_t,
)
from rtgen.runtime.opaque_rpc.errors import ChannelError
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc, OpaqueRpcFailed
from rtgen.runtime.opaque_rpc.link import Link, LinkSettings
from rtgen.runtime.timing.traffic import BoardCall

_GIVEN_UP = "given up by the caller"


class _Servant(OpaqueRpc):
    """Executes calls of `OpaqueRpc` through a link, and reports each completed one."""

    def __init__(self, link: Link, owner: Component) -> None:
        self._link = link
        self._owner = owner
        self._request = b""
        self._reply = bytearray()
        self._error = ""
        self._begun = 0

    def begin(self, request: bytes, first: int) -> bytes:
        self._begun = perf_counter_ns()
        try:
            data = self._link.begin(request, first)
        except ChannelError as error:
            self._report(request, b"", error.reason)
            raise OpaqueRpcFailed(error.sub, error.reason) from error
        self._request, self._reply, self._error = request, bytearray(data), ""
        return data

    def more(self, count: int) -> bytes:
        try:
            data = self._link.more(count)
        except ChannelError as error:
            self._error = error.reason
            raise OpaqueRpcFailed(error.sub, error.reason) from error
        self._reply += data
        return data

    def end(self) -> None:
        self._report(self._request, bytes(self._reply), "")
        self._link.end()

    def reset(self) -> None:
        self._report(self._request, bytes(self._reply), self._error or _GIVEN_UP)
        self._link.reset()

    def _report(self, request: bytes, reply: bytes, error: str) -> None:
        traffic = self._owner._clock.traffic
        if traffic.watchers:
            name, duration = self._owner.instance_name, perf_counter_ns() - self._begun
            traffic.report(BoardCall(name, request, reply, error, duration))


def _profile(parameter: CommunicationParameter) -> ParameterProfile:
    return ParameterProfile(
        name=parameter.name,
        python_name=parameter.name,
        type="string" if isinstance(parameter.default, str) else "double",
        default=str(parameter.default),
        unit=parameter.unit,
        constraint=parameter.constraint,
        description=parameter.description,
    )


class OpaqueRpcCommunication(Component):
    """Sends requests of any signature to a TECS board, over TCP or a serial line.

    A change of the configuration, or of the active set, applies from the next call on.
    """

    profile: ClassVar[ComponentProfile] = ComponentProfile(
        facts.COMPONENT,
        category=facts.CATEGORY,
        vendor=facts.VENDOR,
        description=facts.DESCRIPTION,
        rate=facts.RATE,
        max_instances=0,
        ports=(
            PortProfile(
                name=facts.PORT,
                python_name="service",
                kind="provider",
                type=OpaqueRpc._descriptor_.name,
                repository_id=OpaqueRpc._descriptor_.repository_id,
                port=facts.PORT,
                instance=facts.INSTANCE,
                description=facts.PORT_DESCRIPTION,
            ),
        ),
        configuration=tuple(map(_profile, facts.PARAMETERS)),
    )

    def __init__(self, instance_name: str | None = None) -> None:
        super().__init__(instance_name)
        self.config = self.add_configuration(LinkSettings())
        self.service = self.add_provider(facts.PORT, facts.INSTANCE, OpaqueRpc)
        """The channel, for one marshaller."""
        self.service.limit = 1
        self._link = Link()

    def on_initialize(self) -> ReturnCode_t:
        """Provide the link at the service port."""
        self.service.set_servant(_Servant(self._link, self))
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Apply the settings; the first call connects."""
        return self._use_settings()

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Apply changed settings."""
        return self._use_settings()

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Close the connection."""
        self._link.close()
        return RTC_OK

    def _use_settings(self) -> ReturnCode_t:
        try:
            self._link.use(replace(self.config), self.network)
        except ValueError as error:
            return self.fail(str(error))
        return RTC_OK
