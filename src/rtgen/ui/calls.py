"""Service calls and samples from a page, as octets of XCDR."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

from rtgen.runtime import xcdr
from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.ports.data_ports import DataConnector, OutPort
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.ports import Provider
from rtgen.runtime.services.servants import Invoker, Servant, ServiceError
from rtgen.runtime.system.json_calls import values_of
from rtgen.runtime.system.system import System
from rtgen.ui.errors import BAD_VALUE, CALL_FAILED, UNKNOWN, CommandError
from rtgen.ui.protocol import ui

MAX_VALUE_SIZE = 1 << 20
"""Maximum size of a request or sample [octets]."""


def call(system: System, call_command: ui.Call) -> bytes:
    """Call an operation of a provider; return the reply with its encapsulation header."""
    provider = _provider(system, call_command)
    return carried_out(provider.interface, provider.call, call_command)


def carried_out(interface: type[Servant], invoke: Invoker, command: ui.Call) -> bytes:
    """Call an operation of an interface; return the reply with its encapsulation header."""
    try:
        calls = calls_of(interface)
    except ServiceError as error:
        raise CommandError(CALL_FAILED, str(error)) from error
    if command.operation not in calls:
        names = ", ".join(calls)
        raise CommandError(
            UNKNOWN, f"there is no operation {command.operation!r}; known: {names}"
        )
    form = calls[command.operation]
    if form.refused:
        raise CommandError(CALL_FAILED, form.refused)
    arguments: tuple[object, ...] = ()
    if form.request is not None:
        request = decoded(form.request, command.arguments)
        arguments = values_of(request)
    try:
        result: Any = invoke(command.operation, arguments)
    except UserException as error:
        name = error._descriptor_.name
        raise CommandError(CALL_FAILED, f"{name}: {error}") from error
    except (ServiceError, CdrError) as error:
        raise CommandError(CALL_FAILED, str(error)) from error
    if form.reply is None:
        return b""
    type_: Any = form.reply
    parts = result if isinstance(result, tuple) else (result,)
    reply = type_(*parts[: len(type_._descriptor_.members)])
    return xcdr.serialize(reply, xcdr.representation_of(type_, 1))


def decoded(type_: Any, data: bytes) -> Any:
    """Decode a payload. Raises CommandError."""
    if len(data) > MAX_VALUE_SIZE:
        raise CommandError(BAD_VALUE, f"{len(data)} octets are too many")
    try:
        return xcdr.deserialize(type_, data)
    except CdrError as error:
        raise CommandError(BAD_VALUE, str(error)) from error


def _provider(system: System, command: ui.Call) -> Provider[Any]:
    providers = system.component(command.port.instance).providers
    key = command.port.port, command.interface_name
    if key not in providers:
        names = ", ".join(f"{port}:{name}" for port, name in providers) or "none"
        raise CommandError(
            UNKNOWN,
            f"{command.port.instance} provides no {':'.join(key)}; known: {names}",
        )
    return providers[key]


class Injector:
    """Injects samples into ports as if components had written them."""

    def __init__(self) -> None:
        self._outlets: WeakKeyDictionary[System, dict[tuple[str, str], OutPort[Any]]]
        self._outlets = WeakKeyDictionary()

    def put(self, system: System, command: ui.Inject) -> None:
        """Write a sample to an OutPort, or to an InPort as a connection would."""
        instance, name = command.port.instance, command.port.port
        component = system.component(instance)
        port = component.out_ports.get(name) or component.in_ports.get(name)
        if port is None:
            raise CommandError(UNKNOWN, f"{instance} has no data port {name!r}")
        value = decoded(port.type, command.data)
        if isinstance(port, OutPort):
            port.write(value)
            return
        outlets = self._outlets.setdefault(system, {})
        key = instance, name
        outlet = outlets.get(key)
        if outlet is None or outlet.connectors[0].target is not port:
            outlet = outlets[key] = OutPort(name, port.type, "page")
            title = f"page_{instance}.{name}"
            DataConnector(title, outlet, port, {}, system.clock.guard).attach()
        outlet.write(value)
