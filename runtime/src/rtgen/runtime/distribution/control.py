"""The control service of an instance for other processes: description, state and parameters.

Requests and replies are JSON. A request is an object with `do` and further members; a reply has
`result`, or `error` with the kind of error.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable, Hashable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import msgspec

from rtgen.facts.messages import from_json
from rtgen.runtime.distribution import descriptions
from rtgen.runtime.distribution.descriptions import Description, describe
from rtgen.runtime.distribution.medium import Medium, MediumError, Reply, Token
from rtgen.runtime.distribution.names import control_name
from rtgen.runtime.distribution.rpc_header import Doubles, serve_clients
from rtgen.runtime.errors import RtcError
from rtgen.runtime.failures import log
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.system.json_calls import (
    Arguments,
    CallError,
    JsonCall,
    Outcome,
    provider_of,
)

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System

_T = TypeVar("_T")

_MAX_SETS = 64
"""Maximum number of configuration sets that other processes can create in a component."""
_MAX_REQUEST = 1 << 20
"""Maximum length of a request [octets]."""
_FIRST = re.compile(rb'"do":\s*"(?:activate|deactivate|reset)"')
"""Requests for states, by which people stop a robot: they wait for no others."""
_CALL = b'{"do":"call",'
"""The beginning of a call of a service, which may take long, so that others do not wait for it."""
_MAX_FIRST = 1000
SHARE = 0.2
"""The part of the time for other requests."""
BURST = 0.5
"""Time that is saved up for them, such as for those at the start of a system [s]."""


class ControlError(RtcError):
    """No answer from another process, or a refusal; the message has the reason."""


class RefusedError(ControlError):
    """A refusal by the instance; the message has the reason."""


class State(msgspec.Struct, frozen=True):
    """The state of an instance in its own context, by RTC's name, and its counts."""

    state: str
    reason: str
    ticks: int
    overruns: int


class Parameters(msgspec.Struct, frozen=True):
    """The active configuration set, and the values of all sets as texts."""

    active: str
    sets: dict[str, dict[str, str]]


class _Request(msgspec.Struct):
    do: str
    arguments: dict[str, str] = {}


class _Call(msgspec.Struct):
    port: str
    operation: str
    arguments: list[tuple[str, Any]]


class _Answer(msgspec.Struct, omit_defaults=True):
    result: Any = None
    error: str = ""


class Work(Protocol):
    """Executes the requests of clients: those of each in turn."""

    def submit(
        self, work: Callable[[], None], client: Hashable, *, first: bool = False
    ) -> bool:
        """Execute work soon; return False if too much of the client waits."""


class Control:
    """Answers the requests of other processes for a component of this one.

    `calls` executes those that call services, `desk` the others. `system` returns the system of
    the component, None before it is known.
    """

    def __init__(
        self,
        desk: Work,
        calls: Work,
        component: Component,
        system: Callable[[], System | None],
    ) -> None:
        self._desk = desk
        self._calls = calls
        self._doubles = Doubles()
        self._component = component
        self._system = system

    def request(self, client: bytes, octets: bytes, reply: Reply) -> None:
        """Execute a request soon, and reply to it."""
        if octets.startswith(_CALL):
            work = partial(self._answer, octets, reply, self._called, client)
            accepted = self._calls.submit(work, client)
        else:
            first = len(octets) < _MAX_FIRST and _FIRST.search(octets) is not None
            work = partial(self._answer, octets, reply, self._result, client)
            accepted = self._desk.submit(work, client, first=first)
        if not accepted:
            reply(msgspec.json.encode(_Answer(error="too many requests wait")))

    def _answer(
        self,
        octets: bytes,
        reply: Reply,
        carry_out: Callable[[_Request, bytes], Any],
        client: bytes,
    ) -> None:
        instance = self._component.instance_name
        try:
            if len(octets) > _MAX_REQUEST:
                raise ValueError(f"a request of {len(octets)} octets")
            request = from_json(octets, _Request)
            answer = _Answer(carry_out(request, client))
        except RtcError as error:
            answer = _Answer(error=str(error))
        except (ValueError, KeyError) as error:
            log.warning("%s: a request cannot be carried out: %r", instance, error)
            answer = _Answer(error=f"the request is wrong: {error!r}")
        reply(_encoded(answer))

    def _called(self, request: _Request, client: bytes) -> Any:
        """Call an operation. Raises ControlError for a duplicate of a request."""
        values = request.arguments
        if request.do != "call" or self._doubles.is_double((client, int(values["id"]))):
            raise ControlError("a call that is made already")
        try:
            call = msgspec.json.decode(values["call"], type=_Call)
            provider = provider_of(self._component, call.port, call.operation)
            return JsonCall(provider, call.operation, call.arguments)()
        except CallError as error:
            return Outcome(refused=str(error))
        except RecursionError:
            return Outcome(refused="a value is nested too deep")

    def _result(self, request: _Request, client: bytes) -> Any:
        system = self._system()
        if request.do == "describe":
            name = self._component.instance_name
            known = system is not None and name in system.instances
            context = system.context(name) if system and known else None
            return describe(self._component, context)
        if system is None:
            raise ControlError("the process is not running its system yet")
        return _ACTIONS[request.do](
            system, self._component.instance_name, request.arguments
        )


def _encoded(answer: _Answer) -> bytes:
    """Return the octets of an answer; an error for texts that have none."""
    try:
        return msgspec.json.encode(answer)
    except UnicodeEncodeError as error:
        return msgspec.json.encode(_Answer(error=f"the answer is wrong: {error}"))


def _state(system: System, instance: str, _: Mapping[str, str]) -> State:
    statistics = system.statistics(instance)
    return State(
        statistics.state.name, statistics.reason, statistics.ticks, statistics.overruns
    )


def _parameters(system: System, instance: str, _: Mapping[str, str]) -> Parameters:
    sets = system.component(instance).configuration_sets
    return Parameters(sets.active, {name: dict(sets.texts(name)) for name in sets.ids})


def _set(system: System, instance: str, arguments: Mapping[str, str]) -> None:
    sets = system.component(instance).configuration_sets
    set_id = arguments.get("set", sets.active)
    if set_id not in sets.ids and len(sets.ids) >= _MAX_SETS:
        raise ControlError(f"{instance} has {_MAX_SETS} configuration sets already")
    system.configure(instance, arguments["parameter"], arguments["value"], set_id)


def serve(medium: Medium, control: Control, instance: str) -> Token:
    """Serve the control service of an instance. Raises MediumError."""
    return serve_clients(medium, control_name(instance), control.request)


_ACTIONS: dict[str, Callable[[System, str, Mapping[str, str]], Any]] = {
    "state": _state,
    "parameters": _parameters,
    "activate": lambda system, instance, _: system.activate(instance).name,
    "deactivate": lambda system, instance, _: system.deactivate(instance).name,
    "reset": lambda system, instance, _: system.reset(instance).name,
    "set": _set,
    "activate_set": lambda system, instance, arguments: system.activate_set(
        instance, arguments["set"]
    ),
}


class Asking(Protocol):
    """Sends requests to the control service of an instance."""

    def call(self, octets: bytes, timeout: float) -> bytes:
        """Return the reply to a request. Raises MediumError, CdrError."""

    def close(self) -> None:
        """Send no more requests."""


class Asker:
    """Client to monitor and control an instance of another process. Methods raise ControlError.

    `timeout` [s] of a request.
    """

    def __init__(self, client: Asking, instance: str, timeout: float) -> None:
        self.instance = instance
        self._client = client
        self._timeout = timeout

    def close(self) -> None:
        """Close the client."""
        self._client.close()

    def describe(self) -> Description:
        """Return the ports, types and interfaces of the instance."""
        return self._request("describe", Description)

    def state(self) -> State:
        """Return the state of the instance in its own context."""
        return self._request("state", State)

    def parameters(self) -> Parameters:
        """Return the configuration sets of the instance."""
        return self._request("parameters", Parameters)

    def activate(self) -> str:
        """Request ACTIVE; return the name of the return code (`System.activate`)."""
        return self._request("activate", str)

    def deactivate(self) -> str:
        """Request INACTIVE; return the name of the return code."""
        return self._request("deactivate", str)

    def reset(self) -> str:
        """Request INACTIVE after an ERROR; return the name of the return code."""
        return self._request("reset", str)

    def set(self, parameter: str, value: str, set_id: str | None = None) -> None:
        """Set a parameter, by default in the active configuration set."""
        chosen = {} if set_id is None else {"set": set_id}
        self._request("set", None, parameter=parameter, value=value, **chosen)

    def activate_set(self, set_id: str) -> None:
        """Activate a configuration set."""
        self._request("activate_set", None, set=set_id)

    def call(self, port: str, operation: str, arguments: Arguments) -> Outcome:
        """Call an operation of a provider with values as JSON, which are typed there.

        `port` is `PORT`, or `PORT.INTERFACE` if it has several.
        """
        call = msgspec.json.encode(_Call(port, operation, [*arguments])).decode()
        number = str(secrets.randbits(63))
        request = _Request("call", {"id": number, "call": call})
        return self._answered(request, Outcome)

    def _request(self, do: str, type_: type[_T] | None, **arguments: str) -> _T:
        return self._answered(_Request(do, arguments), type_)

    def _answered(self, request: _Request, type_: type[_T] | None) -> _T:
        try:
            octets = self._client.call(msgspec.json.encode(request), self._timeout)
            if len(octets) > descriptions.MAX_OCTETS:
                raise ControlError(
                    f"{self.instance}: an answer of {len(octets)} octets"
                )
            answer = from_json(octets, _Answer)
            if answer.error:
                raise RefusedError(self._named(answer.error))
            return msgspec.convert(answer.result, type_)
        except MediumError as error:
            raise ControlError(f"{self.instance}: {error}") from error
        except ValueError as error:
            message = f"{self.instance}: the answer is wrong: {error}"
            raise ControlError(message) from error

    def _named(self, reason: str) -> str:
        """Return a reason with the name of the instance, which it may begin with already."""
        if reason.startswith(f"{self.instance} "):
            return reason
        return f"{self.instance}: {reason}"
