"""Services of a live view: requests to components, and operations of their service ports."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.ports import Provider
from rtgen.runtime.services.servants import ServiceError
from rtgen.runtime.system.json_calls import (
    NOTHING,
    RESULT,
    CallError,
    JsonCall,
    call_of,
    forms_of,
)
from rtgen.runtime.system.system import System
from rtgen.tools.kit.json_text import parse_json

_MAX_LENGTH: Final = 1 << 20
"""Maximum length of a request in octets."""
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
            yield LiveService(name, f"rtgen/{request}", NOTHING, _RESULT, prepare)
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
    for operation in calls:
        try:
            request, reply, _ = forms_of(call_of(provider, operation))
        except CallError:
            continue
        prepare = partial(_call, provider, operation)
        name = f"/{instance}/{provider.port}/{provider.instance}/{operation}"
        type_ = f"{provider.interface._descriptor_.name}::{operation}"
        yield LiveService(name, type_, request, reply, prepare)


def _call(
    provider: Provider[Any], operation: str, payload: bytes
) -> Callable[[], bytes]:
    try:
        call = JsonCall(provider, operation, [*_object(payload).items()])
    except CallError as error:
        raise RefusedError(str(error)) from None

    def carry_out() -> bytes:
        outcome = call()
        if outcome.exception:
            raise RefusedError(f"{outcome.exception}: {outcome.message}")
        returned = {} if outcome.result is None else {RESULT: outcome.result}
        return _text(returned | outcome.out)

    return carry_out


def _object(payload: bytes) -> dict[str, Any]:
    """Parse a request. Raises RefusedError unless it is a JSON object."""
    if len(payload) > _MAX_LENGTH:
        raise RefusedError(f"a request of {len(payload)} octets")
    try:
        value = parse_json(payload or b"{}")
    except (ValueError, RecursionError) as error:
        raise RefusedError(f"the request is not JSON: {error}") from None
    if not isinstance(value, dict):
        raise RefusedError("the request is not a JSON object")
    return value


def _text(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode()
