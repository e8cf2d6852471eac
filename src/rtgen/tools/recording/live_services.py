"""Services of a live view: requests to components, and operations of their service ports."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.services.calls import Call, calls_of
from rtgen.runtime.services.ports import Provider
from rtgen.runtime.services.servants import ServiceError
from rtgen.runtime.system.json_printers import plain
from rtgen.runtime.system.system import System
from rtgen.tools.recording.json_values import NoJsonError, json_form

_MAX_LENGTH: Final = 1 << 20
"""Maximum length of a request in octets."""
_NOTHING: Final[dict[str, Any]] = {
    "type": "object",
    "properties": {},
    "additionalProperties": False,
}
_RESULT: Final[dict[str, Any]] = {
    "type": "object",
    "properties": {"result": {"type": "string"}},
    "required": ["result"],
}


class RefusedError(Exception):
    """A request that cannot be executed; the message says why."""


@dataclass(frozen=True, slots=True)
class LiveService:
    """A service: name, JSON Schemas of request and reply, and its implementation.

    `prepare` turns a request into an action that returns the reply. Both raise RefusedError.
    """

    name: str
    type: str
    request: dict[str, Any]
    reply: dict[str, Any]
    prepare: Callable[[bytes], Callable[[], bytes]]


def services_of(system: System) -> Iterator[LiveService]:
    """Yield the services of all components.

    Their names are `/INSTANCE/activate` and so on, and `/INSTANCE/PORT/INTERFACE/OPERATION` with
    the interface's instance name in the port.
    """
    for instance in system.instances:
        for request in ("activate", "deactivate", "reset"):
            prepare = partial(_life_cycle, getattr(system, request), instance)
            name = f"/{instance}/{request}"
            yield LiveService(name, f"rtgen/{request}", _NOTHING, _RESULT, prepare)
        for provider in system.component(instance).providers.values():
            yield from _operations(instance, provider)


def _life_cycle(
    request: Callable[[str], Any], instance: str, payload: bytes
) -> Callable[[], bytes]:
    if _object(payload):
        raise RefusedError("the request has no members")
    return lambda: _text({"result": request(instance).name})


def _operations(instance: str, provider: Provider[Any]) -> Iterator[LiveService]:
    """Yield the operations whose arguments and results have a JSON form."""
    try:
        calls = calls_of(provider.interface)
    except ServiceError:
        return
    for operation, call in calls.items():
        if call.refused or any((*call.request_objects, *call.reply_objects)):
            continue
        try:
            request, convert = _form(call.request)
            reply, _ = _form(call.reply)
        except NoJsonError:
            continue
        prepare = partial(_call, provider, operation, call, convert)
        name = f"/{instance}/{provider.port}/{provider.instance}/{operation}"
        type_ = f"{provider.interface._descriptor_.name}::{operation}"
        yield LiveService(name, type_, request, reply, prepare)


def _form(type_: Any) -> tuple[dict[str, Any], Callable[[Any], Any]]:
    if type_ is None:
        return _NOTHING, _no_members
    if any(member.name == "_context" for member in type_._descriptor_.members):
        raise NoJsonError("a context clause")
    return json_form(type_._descriptor_)


def _no_members(value: dict[str, Any]) -> None:
    if value:
        raise ValueError("the request has no members")


def _call(
    provider: Provider[Any],
    operation: str,
    call: Call,
    convert: Callable[[Any], Any],
    payload: bytes,
) -> Callable[[], bytes]:
    try:
        request = convert(_object(payload))
        arguments: tuple[object, ...] = ()
        if call.request is not None:
            request.to_cdr(True)  # raises CdrError for values out of range
            arguments = _values(request)
    except (CdrError, ValueError) as error:
        raise RefusedError(f"{operation}: {error}") from None

    def carry_out() -> bytes:
        try:
            result = provider.call(operation, arguments)
        except UserException as error:
            raise RefusedError(f"{type(error).__name__}: {error}") from error
        except ServiceError as error:
            raise RefusedError(str(error)) from error
        names = [] if call.reply is None else _member_names(call.reply)
        results = (result,) if len(names) == 1 else result
        values = results if isinstance(results, tuple) else ()
        return _text(dict(zip(names, map(plain, values), strict=False)))

    return carry_out


def _values(request: Any) -> tuple[object, ...]:
    members = request._descriptor_.members
    return tuple(getattr(request, member.attribute) for member in members)


def _member_names(type_: Any) -> list[str]:
    return [member.name for member in type_._descriptor_.members]


def _object(payload: bytes) -> dict[str, Any]:
    """Parse a request. Raises RefusedError unless it is a JSON object."""
    if len(payload) > _MAX_LENGTH:
        raise RefusedError(f"a request of {len(payload)} octets")
    try:
        value = json.loads(payload or b"{}")
    except (ValueError, RecursionError) as error:
        raise RefusedError(f"the request is not JSON: {error}") from None
    if not isinstance(value, dict):
        raise RefusedError("the request is not a JSON object")
    return value


def _text(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode()
