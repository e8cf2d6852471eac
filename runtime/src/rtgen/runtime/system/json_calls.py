"""Calls of operations with arguments and results as JSON, typed by the IDL."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import msgspec

from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.errors import RtcError
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.call_types import CONTEXT, Call
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.ports import Provider
from rtgen.runtime.services.servants import ServiceError
from rtgen.runtime.system.json_printers import plain
from rtgen.runtime.system.json_values import Convert, NoJsonError, json_form

Arguments: TypeAlias = Sequence[tuple[str, Any]]
"""Values as JSON; each with the name of its parameter, empty for the next one."""

RESULT: Final = "_result"
"""The name of the return value among the members of a reply."""


class CallError(RtcError):
    """A call that does not fit its operation; the message says why, and what there is."""


class Outcome(msgspec.Struct, frozen=True, omit_defaults=True):
    """The outcome of a call as JSON.

    `result` is the return value, `out` has the results of `out` and `inout` parameters.
    `exception` is the name of the exception that was raised, with its members if the interface
    declares it; `message` is its text. `refused`: it was not made, for this reason.
    """

    result: Any = None
    out: dict[str, Any] = {}
    exception: str = ""
    members: dict[str, Any] = {}
    message: str = ""
    refused: str = ""


class JsonCall:
    """A call of a provider's operation, whose arguments are converted by the constructor.

    Raises CallError for an operation that cannot be called so, or for wrong arguments.
    """

    def __init__(
        self, provider: Provider[Any], operation: str, arguments: Arguments
    ) -> None:
        self._provider = provider
        self._operation = operation
        self._call = call_of(provider, operation)
        forms_of(self._call)  # raises CallError for a reply without a JSON form, too
        request = request_of(operation, self._call.request, arguments)
        self._arguments: tuple[object, ...] = (
            () if request is None else values_of(request)
        )

    def require_exception(self, name: str) -> None:
        """Raise CallError unless the operation may raise an exception of this name."""
        declared = [type_._descriptor_.name for _, type_ in self._call.raises]
        names = [
            *declared,
            *(each.rpartition("::")[2] for each in declared),
            *(each.__name__ for each in ServiceError.__subclasses__()),
        ]
        if name not in names:
            near = _near(name, names)
            raise CallError(f"{self._operation} raises no {name!r}: {near}")

    def __call__(self) -> Outcome:
        """Make the call; exceptions are part of the outcome."""
        try:
            result = self._provider.call(self._operation, self._arguments)
        except UserException as error:
            values = plain(error)
            members = values if isinstance(values, dict) else {}
            name = error._descriptor_.name
            return Outcome(exception=name, members=members, message=str(error))
        except (ServiceError, CdrError) as error:
            return Outcome(exception=type(error).__name__, message=str(error))
        names = members_of(self._call.reply)
        results = (result,) if len(names) == 1 else result
        values = results if isinstance(results, tuple) else ()
        out = dict(zip(names, map(plain, values), strict=False))
        return Outcome(out.pop(RESULT, None), out)


def request_of(operation: str, type_: Any, arguments: Arguments) -> Any:
    """Return the request of an operation, a value of `type_`; None if that is None.

    Raises CallError for arguments that are not those of the type, or are out of its ranges.
    """
    _, convert = _form(type_)
    try:
        request = convert(_named(arguments, members_of(type_)))
        if request is not None:
            request.to_xcdr1()  # raises CdrError for values out of range
    except CdrError as error:
        reason = str(error).removeprefix(f"{type_._descriptor_.name}.")
        raise CallError(f"{operation}: {reason}") from None
    except ValueError as error:
        raise CallError(f"{operation}: {error}") from None
    return request


def provider_of(component: Component, target: str, operation: str) -> Provider[Any]:
    """Return the provider of an operation: `PORT`, or `PORT.INTERFACE` if a port has several.

    Raises CallError.
    """
    instance = component.instance_name
    named = [
        each
        for (port, name), each in component.providers.items()
        if target in (port, f"{port}.{name}", f"{port}:{name}")
    ]
    if not named:
        ports = [*dict.fromkeys(port for port, _ in component.providers)]
        raise CallError(f"{instance} provides no {target!r}: {_near(target, ports)}")
    fitting = [each for each in named if operation in _calls(each)]
    if len(fitting) > 1:
        names = " or ".join(f"{each.port}.{each.instance}" for each in fitting)
        message = (
            f"{instance}.{target} has {operation!r} in several interfaces: {names}"
        )
        raise CallError(message)
    if not fitting:
        operations = [name for each in named for name in _calls(each)]
        near = _near(operation, operations)
        raise CallError(f"{instance}.{target} has no operation {operation!r}: {near}")
    return fitting[0]


def _near(name: str, names: Sequence[str]) -> str:
    from difflib import get_close_matches  # for an error only

    close = get_close_matches(name, names, n=1)
    if close:
        return f"did you mean {close[0]}?"
    return f"it has {', '.join(names) or 'none'}"


def _calls(provider: Provider[Any]) -> dict[str, Call]:
    try:
        return calls_of(provider.interface)
    except ServiceError as error:
        raise CallError(f"{provider}: {error}") from error


def call_of(provider: Provider[Any], operation: str) -> Call:
    """Return an operation that can be called with JSON. Raises CallError."""
    call = _calls(provider)[operation]
    if call.refused or any((*call.request_objects, *call.reply_objects)):
        why = call.refused or "objects are passed"
        raise CallError(f"{provider}.{operation} cannot be called with texts: {why}")
    return call


def forms_of(call: Call) -> tuple[dict[str, Any], dict[str, Any], Convert]:
    """Return the JSON Schemas of request and reply, and the converter of requests.

    The return value is the member RESULT of replies. Raises CallError for types without a JSON
    form.
    """
    request, convert = _form(call.request)
    reply, _ = _form(call.reply)
    return request, reply, convert


def _form(type_: Any) -> tuple[dict[str, Any], Convert]:
    if type_ is None:
        return NOTHING, _no_members
    if any(member.name == CONTEXT for member in type_._descriptor_.members):
        raise CallError(
            "an operation with a context clause cannot be called with texts"
        )
    try:
        return json_form(type_._descriptor_)
    except NoJsonError as error:
        raise CallError(f"there is no text for values of {error}") from None


NOTHING: Final[dict[str, Any]] = {
    "type": "object",
    "properties": {},
    "additionalProperties": False,
}
"""The JSON Schema of an empty request or reply."""


def _no_members(value: dict[str, Any]) -> None:
    if value:
        raise ValueError("the request has no members")


def _named(arguments: Arguments, names: Sequence[str]) -> dict[str, Any]:
    """Return the arguments by the names of their parameters. Raises ValueError."""
    pairs: dict[str, Any] = {}
    for number, (name, value) in enumerate(arguments):
        if name and name not in names:
            raise ValueError(f"no parameter {name!r}: {_near(name, names)}")
        if number >= len(names):
            known = ", ".join(names) or "none"
            raise ValueError(f"{len(arguments)} arguments; parameters: {known}")
        parameter = name or names[number]
        if parameter in pairs:
            raise ValueError(f"{parameter} is given twice")
        pairs[parameter] = value
    return pairs


def values_of(request: Any) -> tuple[object, ...]:
    """Return the values of the members of a request or reply."""
    members = request._descriptor_.members
    return tuple(getattr(request, member.attribute) for member in members)


def members_of(type_: Any) -> list[str]:
    """Return the names of the members of a request or reply; none for an empty one."""
    return [] if type_ is None else [m.name for m in type_._descriptor_.members]
