"""Live view of a run: a server of Foxglove's WebSocket protocol (`foxglove-sdk`).

Clients see the channels of a recording, set parameters and call services. Calls are executed in
the thread of the run, between its steps; the run never waits for a client.
"""

from __future__ import annotations

import json
import logging
import socket
import time
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from decimal import Decimal
from enum import Enum
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rtgen.facts.extras import installation
from rtgen.facts.parameter_texts import text_of
from rtgen.runtime.errors import RtcError
from rtgen.runtime.requests import Allowance, Queues, Requests
from rtgen.runtime.rtc.configuration import ACTIVE_SET, ConfigurationSets
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import Event, ParameterChange
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.live_channels import LiveChannels
from rtgen.tools.recording.live_relay import Relay
from rtgen.tools.recording.live_services import LiveService, RefusedError, services_of
from rtgen.tools.recording.recorder import Recorder

if TYPE_CHECKING:
    from foxglove import Parameter, ServiceRequest, StatusLevel
    from foxglove.websocket import Client, ServerListener

LOOPBACK: Final = "127.0.0.1"
PORT: Final = 8765
"""Default port of Foxglove's WebSocket protocol."""

_PERIOD: Final = SECOND // 50
"""Period of executing requests, in the system's time [ns]."""
_MAX_WAITING: Final = 16
"""Maximum number of waiting requests of a client."""
_SHARE: Final = 0.2
"""The part of the time for calls, except those for states, and for reading parameters."""
_BURST: Final = 0.2
"""Time that is saved up for them [s]."""
_LONGEST: Final = 0.01
"""Time for calls between two steps of the run, if so many wait [s]."""
_REFUSAL: Final = 0.02
"""Time after which a client learns that too many of its calls wait [s]."""
_STATES: Final = frozenset(("rtgen/activate", "rtgen/deactivate", "rtgen/reset"))
"""Types of services by which people stop a robot: they wait for no others."""
_BACKLOG: Final = 1024
"""Maximum number of messages waiting for a client before the oldest are dropped."""
_CALL_TIMEOUT: Final = 5.0
"""Seconds after which a call that the run has not executed fails."""


def _is_own(host: str) -> bool:
    """Return whether the address is one of this machine, on which a server can listen."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            host, 0, type=socket.SOCK_STREAM
        )[0]
        with socket.socket(family, kind) as probe:
            probe.bind(address)
    except (OSError, UnicodeError):
        return False
    return True


def _quiet() -> None:
    """Leave out what the server logs of clients' errors, unless the user has chosen a level.

    Each message that is no request would be a line.
    """
    logger = logging.getLogger("foxglove")
    if logger.level == logging.NOTSET:
        logger.setLevel(logging.CRITICAL)


def _unheard(host: str, port: int, error: Exception) -> RecordingError:
    """Return the error of an address at which the live view cannot listen."""
    return RecordingError(
        f"the live view cannot listen at {host}:{port}: {error}",
        hint=(
            "another port, or 0 for any that is free"
            if _is_own(host)
            else f"{host} is not this machine's; 127.0.0.1 is, 0.0.0.0 means all"
        ),
    )


class LiveView:
    """Shows a system to clients until it is closed.

    Must be created before the first `run`. Raises RecordingError if the server cannot be started,
    or without the package `foxglove-sdk`.
    """

    def __init__(
        self, system: System, name: str, host: str = LOOPBACK, port: int = PORT
    ) -> None:
        if find_spec("foxglove") is None:
            raise RecordingError(
                "the live view needs foxglove-sdk, which is not installed",
                hint=installation("foxglove"),
            )
        from foxglove import Context, start_server
        from foxglove.websocket import Capability

        self._system = system
        self._waiting = Requests(_SHARE, _BURST)
        self._queues = Queues(self._waiting, _MAX_WAITING, 1)
        self._allowance = Allowance(_SHARE, _BURST)
        self._closed = False
        _quiet()
        context = Context()
        self.recorder = Recorder(system, LiveChannels(context))
        try:
            self._relay = Relay(host, port)
        except (OSError, OverflowError) as error:
            raise _unheard(host, port, error) from error
        try:
            self._server = start_server(
                name=name,
                host=LOOPBACK,
                port=0,
                capabilities=[
                    Capability.Parameters,
                    Capability.Services,
                    Capability.Time,
                ],
                supported_encodings=["json"],
                services=[self._service(each) for each in services_of(system)],
                server_listener=_listener(self),
                context=context,
                message_backlog_size=_BACKLOG,
            )
        except (OSError, RuntimeError, ValueError) as error:
            self._relay.close()
            raise _unheard(LOOPBACK, 0, error) from error
        self._relay.start(LOOPBACK, self._server.port)
        self.address = f"ws://{host}:{self._relay.port}"
        system.clock.traffic.watch(self._on_event)
        self._end = system.every(_PERIOD, self._carry_out)

    def close(self) -> None:
        """Stop the server. Waiting requests are rejected."""
        if self._closed:
            return
        self._closed = True
        self._end()
        while self._waiting.carry_out_one(limited=False):
            pass  # each is rejected
        self._relay.close()
        self._server.stop()

    # Called in the thread of the run

    def _carry_out(self) -> None:
        self._server.broadcast_time(self.recorder.now)
        self._waiting.carry_out(_LONGEST)

    def _on_event(self, event: Event) -> None:
        if isinstance(event, ParameterChange) and not self._closed:
            parameter = self._parameter(event.instance, event.parameter)
            self._server.publish_parameter_values([parameter])

    # Parameters; called in threads of the server

    def for_client(
        self, client: int, action: Callable[[], list[Parameter]]
    ) -> list[Parameter]:
        """Return the result of a client's request; nothing for one that takes too much time."""
        if not self._allowance.allows(client):
            return []
        begun = time.perf_counter()
        try:
            return action()
        finally:
            self._allowance.charge(client, time.perf_counter() - begun)

    def parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return the parameters of these names (all without names), except unknown ones."""
        selection = frozenset(names)
        return [
            self._parameter(instance, name)
            for instance in self._system.instances
            for name in (*self._sets(instance).texts(), ACTIVE_SET)
            if not selection or f"{instance}.{name}" in selection
        ]

    def set_parameters(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        """Set the valid ones of the parameters; return their values afterwards."""
        changed: list[Parameter] = []
        for parameter in parameters:
            instance, _, name = parameter.name.partition(".")
            try:
                text = text_of(parameter.get_value())
                changed.append(self._set(instance, name, text))
            except (RtcError, RefusedError, ValueError) as error:
                self._warn(f"{parameter.name}: {error}")
                changed += self.parameters([parameter.name])
        return changed

    def _set(self, instance: str, name: str, text: str) -> Parameter:
        """Set a parameter, which takes effect between two cycles; return its new value."""
        if self._closed:
            raise RefusedError("the run is over")
        if name == ACTIVE_SET:
            self._system.activate_set(instance, text)
        else:
            active = self._sets(instance).active
            self._system.configure(instance, name, text, active)
        return self._parameter(instance, name)

    def _parameter(self, instance: str, name: str) -> Parameter:
        from foxglove import Parameter

        sets = self._sets(instance)
        if name == ACTIVE_SET:
            value: Any = sets.active
        else:
            value = _native(sets.value(name, sets.texts(sets.active)[name]))
        return Parameter(f"{instance}.{name}", value=value)

    def _sets(self, instance: str) -> ConfigurationSets:
        return self._system.component(instance).configuration_sets

    def _warn(self, message: str) -> None:
        from foxglove.websocket import StatusLevel

        level: StatusLevel = StatusLevel.Warning
        self._server.publish_status(message, level)

    # Services; called in threads of the server

    def _service(self, service: LiveService) -> Any:
        from foxglove import MessageSchema, Schema, Service, ServiceSchema

        def message(name: str, schema: dict[str, Any]) -> MessageSchema:
            data = json.dumps(schema).encode()
            return MessageSchema(
                encoding="json",
                schema=Schema(name=name, encoding="jsonschema", data=data),
            )

        schema = ServiceSchema(
            service.type,
            request=message(f"{service.type}_Request", service.request),
            response=message(f"{service.type}_Reply", service.reply),
        )

        def handle(request: ServiceRequest) -> bytes:
            return self._called(service, request.payload, request.client_id)

        return Service(service.name, schema=schema, handler=handle)

    def _called(self, service: LiveService, payload: bytes, client: int = 0) -> bytes:
        """Return the reply of a service to a client. Raises RefusedError."""
        first = service.type in _STATES
        reply = self._submit(service.prepare(payload), client, first=first)
        try:
            octets: bytes = reply.result(_CALL_TIMEOUT)
            return octets
        except CancelledError:
            raise RefusedError("the run is over") from None
        except FutureTimeoutError:
            reply.cancel()
            message = (
                f"{service.name}: the run did not answer within {_CALL_TIMEOUT:g} s"
            )
            raise RefusedError(message) from None

    def _submit(
        self, action: Callable[[], Any], client: int = 0, *, first: bool = False
    ) -> Future[Any]:
        """Submit an action to the thread of the run. Raises RefusedError."""
        if self._closed:
            raise RefusedError("the run is over")
        request = _Request(action, Future())

        def carry_out() -> None:
            if self._closed:
                request.reply.cancel()
            else:
                request.carry_out()

        if not self._queues.put(client, carry_out, first=first):
            time.sleep(_REFUSAL)
            raise RefusedError("too many requests wait")
        return request.reply


class _Request(NamedTuple):
    """An action for the thread of the run, with its result."""

    action: Callable[[], Any]
    reply: Future[Any]

    def carry_out(self) -> None:
        """Execute the action, unless its client has given up."""
        if not self.reply.set_running_or_notify_cancel():
            return
        try:
            self.reply.set_result(self.action())
        except (RtcError, RefusedError) as error:
            self.reply.set_exception(RefusedError(str(error)))
        except BaseException as error:
            self.reply.set_exception(RefusedError(f"the call failed: {error!r}"))
            raise


def _listener(view: LiveView) -> ServerListener:
    """Return the callbacks of the server."""
    from foxglove.websocket import ServerListener

    class Listener(ServerListener):
        def on_get_parameters(
            self, client: Client, param_names: list[str], request_id: str | None = None
        ) -> list[Parameter]:
            return view.for_client(client.id, lambda: view.parameters(param_names))

        def on_set_parameters(
            self,
            client: Client,
            parameters: list[Parameter],
            request_id: str | None = None,
        ) -> list[Parameter]:
            return view.for_client(client.id, lambda: view.set_parameters(parameters))

    return Listener()


def _native(value: Any) -> Any:
    """Return the value of a parameter in JSON."""
    match value:
        case Enum():
            return value.name
        case Decimal():
            return str(value)
        case bytes():
            return [*value]
        case list() | tuple():
            return [_native(item) for item in value]
    return value
