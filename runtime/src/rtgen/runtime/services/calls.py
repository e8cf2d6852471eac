"""Marshalling of calls, for transports between a stub and a skeleton.

A stub passes a call to a `Client`, whose octets a transport sends to a `Server`, which calls the
servant and replies with octets. Bodies are those of GIOP (CORBA 3.3 part 2, 9.4): arguments in
order; return value and results in order; repository id and members of a user exception; repository
id, minor code and completion of a system exception. The transport transmits operation name, reply
status and byte order.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable
from enum import IntEnum
from importlib import import_module
from typing import Protocol, TypeAlias, TypeVar

import msgspec

from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.marshalling.errors import FAILURES
from rtgen.runtime.marshalling.octets import ObjectReference, text_value
from rtgen.runtime.services.call_types import (
    CONTEXT,
    Call,
    CallTypes,
    Interfaces,
)
from rtgen.runtime.services.servants import (
    BadOperation,
    CallTimeout,
    CommunicationFailure,
    Invoker,
    MarshalError,
    ObjectNotExist,
    Servant,
    ServiceError,
    UnknownException,
    operations_of,
)

S = TypeVar("S", bound=Servant)

log = logging.getLogger("rtgen.runtime")


class ReplyStatus(IntEnum):
    """The status of a reply (CORBA 3.3 part 2, 9.4.3.1, ReplyStatusType_1_2)."""

    NO_EXCEPTION = 0
    USER_EXCEPTION = 1
    SYSTEM_EXCEPTION = 2


class Reply(msgspec.Struct, frozen=True, gc=False):
    """The reply to a call; the transport transmits the byte order of the body."""

    status: ReplyStatus
    body: bytes
    little_endian: bool = True


Send: TypeAlias = Callable[[str, bytes, bool], Reply | None]
"""Function that sends a request: operation name, body, whether it is oneway (without reply)."""


class Objects(Protocol):
    """Object references of a transport, for objects passed in calls."""

    def reference(self, interface: type[S], servant: S) -> ObjectReference:
        """Return a reference to a servant, or to the object of a stub."""
        ...

    def resolve(self, interface: type[S], reference: ObjectReference) -> S:
        """Return a stub that calls the referenced object."""
        ...


def calls_of(interface: type[Servant]) -> dict[str, Call]:
    """Return the calls of an interface and its bases by operation name.

    Raises ServiceError for a local interface, and for one whose calls have no codecs.
    """
    name = interface._descriptor_.name
    if interface._descriptor_.local:
        raise ServiceError(f"{name} is local: its objects do not leave their process")
    calls: dict[str, Call] = {}
    for base in reversed(interface.__mro__):
        if "_calls_" in vars(base) and issubclass(base, Servant):
            calls |= _own_calls(base)
    if not calls and operations_of(interface):
        raise ServiceError(
            f"calls of {name} have no codecs; for a service of a TECS board set"
            " corba = true in the section [tecs] of rtgen.toml"
        )
    return calls


def _own_calls(base: type[Servant]) -> dict[str, Call]:
    calls: dict[str, Call] | None = vars(base).get("_own_calls_")
    if calls is None:
        package = base.__module__.rpartition(".")[0]
        described = base._descriptor_
        types: dict[str, CallTypes] = import_module(base._calls_, package)._CALLS[
            described.repository_id
        ]
        calls = {
            name: Call(f"{described.name}.{name}", each) for name, each in types.items()
        }
        base._own_calls_ = calls
    return calls


class Client:
    """An invoker for stubs, which marshals each call.

    A call raises CdrError if an argument cannot be marshalled, the declared exceptions, and
    ServiceError: ObjectNotExist, BadOperation, UnknownException or MarshalError as reported by the
    server, MarshalError also for an invalid reply.
    """

    def __init__(
        self,
        interface: type[Servant],
        send: Send,
        *,
        little_endian: bool = True,
        objects: Objects | None = None,
    ) -> None:
        self._calls = calls_of(interface)
        self._send = send
        self._little_endian = little_endian
        self._objects = objects

    def __call__(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call."""
        call = call_of(self._calls, operation)
        passed = references(arguments, call.request_objects, self._objects)
        body = encoded(operation, call.request, passed, self._little_endian)
        reply = self._send(operation, body, call.oneway)
        if call.oneway:
            return None
        if reply is None:
            raise MarshalError(f"{operation}: there is no reply")
        try:
            return self._result(operation, call, reply)
        except CdrError as error:
            raise MarshalError(f"{operation}: the reply is wrong: {error}") from error

    def _result(self, operation: str, call: Call, reply: Reply) -> object:
        match reply.status:
            case ReplyStatus.NO_EXCEPTION:
                values = decoded(call.reply, reply.body, reply.little_endian)
                results = _stubs(values, call.reply_objects, self._objects)
                return (results or (None,))[0] if len(results) < 2 else results
            case ReplyStatus.USER_EXCEPTION:
                raise _user_exception(operation, call, reply)
            case ReplyStatus.SYSTEM_EXCEPTION:
                raise _system_exception(operation, reply)


class Server:
    """Executes the requests of a `Client` on a servant."""

    def __init__(
        self,
        interface: type[S],
        servant: S,
        *,
        objects: Objects | None = None,
    ) -> None:
        self._calls = calls_of(interface)
        self._invoke: Invoker = interface._skeleton_(servant).dispatch
        self._objects = objects

    @classmethod
    def of(cls, interface: type[Servant], invoke: Invoker) -> Server:
        """Return a server that executes requests by an invoker. Raises as `calls_of` does."""
        server = cls.__new__(cls)
        server._calls = calls_of(interface)
        server._invoke = invoke
        server._objects = None
        return server

    def handle(
        self, operation: str, body: bytes, little_endian: bool = True
    ) -> Reply | None:
        """Execute a call; None if it is oneway. Invalid requests raise no exception."""
        call = self._calls.get(operation)
        try:
            reply = self._answer(operation, body, little_endian)
        except ServiceError as error:
            log.warning("%s: %s", operation, error, exc_info=error.__cause__)
            reply = failure(error, little_endian)
        return None if call is not None and call.oneway else reply

    def _answer(self, operation: str, body: bytes, little_endian: bool) -> Reply:
        call = call_of(self._calls, operation)
        try:
            values = decoded(call.request, body, little_endian)
        except CdrError as error:
            raise MarshalError(f"the request is wrong: {error}") from error
        arguments = _stubs(values, call.request_objects, self._objects)
        try:
            result = self._invoke(operation, arguments)
        except UserException as error:
            return self._raised(call, error, little_endian)
        try:
            results = references(
                as_tuple(call, result), call.reply_objects, self._objects
            )
            octets = encoded(operation, call.reply, results, little_endian)
        except CdrError as error:
            raise MarshalError(f"the result is wrong: {error}") from error
        return Reply(ReplyStatus.NO_EXCEPTION, octets, little_endian)

    def _raised(self, call: Call, error: UserException, little_endian: bool) -> Reply:
        for body, exception in call.raises:
            if isinstance(error, exception):
                values = (error._descriptor_.repository_id, *error._values())
                try:
                    octets = body(*values).to_cdr(little_endian)
                except CdrError as fault:
                    raise MarshalError(f"the exception is wrong: {fault}") from error
                return Reply(ReplyStatus.USER_EXCEPTION, octets, little_endian)
        raise UnknownException(f"{type(error).__name__} is not declared") from error


def call_of(calls: dict[str, Call], operation: str) -> Call:
    """Return the marshalling of an operation. Raises BadOperation, MarshalError."""
    call = calls.get(operation)
    if call is None:
        raise BadOperation(f"there is no operation {operation}")
    if call.refused:
        raise MarshalError(f"{operation} is not marshalled: {call.refused}")
    return call


def encoded_arguments(
    operation: str, call: Call, arguments: tuple[object, ...]
) -> bytes:
    """Return the body of a request without objects. Raises CdrError, BadOperation."""
    return encoded(operation, call.request, arguments, True)


def encoded(
    operation: str,
    type_: type[DataType] | None,
    values: tuple[object, ...],
    little_endian: bool,
) -> bytes:
    """Encode a body in CDR. Raises CdrError; BadOperation for a wrong number of values."""
    if type_ is None:
        return b""
    count = len(_fields(type_))
    if len(values) != count:
        raise BadOperation(f"{operation} takes {count} arguments, not {len(values)}")
    return type_(*values).to_cdr(little_endian)


def decoded(
    type_: type[DataType] | None, body: bytes, little_endian: bool
) -> tuple[object, ...]:
    """Decode a body. Raises CdrError."""
    if type_ is None:
        if body:
            raise CdrError("body", f"{len(body)} octets too many")
        return ()
    value = type_.from_cdr(body, little_endian)
    return tuple(getattr(value, name) for name in _fields(type_))


def _fields(type_: type[DataType]) -> tuple[str, ...]:
    """Return the members in order, without the strings of a context clause."""
    names: tuple[str, ...] = getattr(type_, "__match_args__", ())
    return tuple(name for name in names if name != CONTEXT)


def as_tuple(call: Call, result: object) -> tuple[object, ...]:
    """Return the values of a result. Raises UnknownException for a wrong number of them."""
    count = 0 if call.reply is None else len(_fields(call.reply))
    if count < 2:
        return (result,) * count
    if not isinstance(result, tuple) or len(result) != count:
        raise UnknownException(f"the servant gave {result!r} instead of {count} values")
    return result


def references(
    values: tuple[object, ...], interfaces: Interfaces, objects: Objects | None
) -> tuple[object, ...]:
    """Return values with references in place of objects. Raises MarshalError."""
    if not interfaces:
        return values
    return tuple(
        (
            _passed(interface, objects).reference(interface, value)
            if interface is not None and isinstance(value, interface)
            else value
        )
        for interface, value in zip(interfaces, values, strict=True)
    )


def _stubs(
    values: tuple[object, ...], interfaces: Interfaces, objects: Objects | None
) -> tuple[object, ...]:
    if not interfaces:
        return values
    return tuple(
        (
            _passed(interface, objects).resolve(interface, value)
            if interface is not None and isinstance(value, ObjectReference)
            else value
        )
        for interface, value in zip(interfaces, values, strict=True)
    )


def _passed(interface: type[Servant], objects: Objects | None) -> Objects:
    if objects is None:
        name = interface._descriptor_.name
        raise MarshalError(f"this transport passes no objects, here one of {name}")
    return objects


def _user_exception(operation: str, call: Call, reply: Reply) -> Exception:
    identity, _ = _identity(reply)
    for body, exception in call.raises:
        if exception._descriptor_.repository_id == identity:
            _, *values = decoded(body, reply.body, reply.little_endian)
            return exception(*values)
    return UnknownException(f"{operation} raised {identity}, which it does not declare")


REPORTED_AS: dict[type[ServiceError], str] = {
    BadOperation: "BAD_OPERATION",
    MarshalError: "MARSHAL",
    ObjectNotExist: "OBJECT_NOT_EXIST",
    UnknownException: "UNKNOWN",
    CallTimeout: "TIMEOUT",
    CommunicationFailure: "COMM_FAILURE",
}
"""The system exception of CORBA for each class of error."""

SYSTEM_EXCEPTIONS: dict[str, type[ServiceError]] = {
    **{f"IDL:omg.org/CORBA/{name}:1.0": type_ for type_, name in REPORTED_AS.items()},
    "IDL:omg.org/CORBA/BAD_PARAM:1.0": MarshalError,
    "IDL:omg.org/CORBA/DATA_CONVERSION:1.0": MarshalError,
    "IDL:omg.org/CORBA/INV_OBJREF:1.0": ObjectNotExist,
    "IDL:omg.org/CORBA/TRANSIENT:1.0": CommunicationFailure,
}
"""The error for the repository id of a system exception; ServiceError for others."""

_COMPLETIONS = ("completed", "not completed", "perhaps completed")
_MAYBE = 2


def kind_of(error: ServiceError) -> type[ServiceError]:
    """Return the class of error reported to clients; UnknownException if not in `REPORTED_AS`."""
    return next((k for k in REPORTED_AS if isinstance(error, k)), UnknownException)


def failure(error: ServiceError, little_endian: bool = True) -> Reply:
    """Return the reply for an error (CORBA 3.3 part 2, 9.4.3.2, SystemExceptionReplyBody)."""
    name = REPORTED_AS[kind_of(error)]
    identity = f"IDL:omg.org/CORBA/{name}:1.0\0".encode()
    order = "<" if little_endian else ">"
    padding = -len(identity) % 4
    form = f"{order}I{len(identity)}s{padding}xII"
    octets = struct.pack(form, len(identity), identity, 0, _MAYBE)
    return Reply(ReplyStatus.SYSTEM_EXCEPTION, octets, little_endian)


def _system_exception(operation: str, reply: Reply) -> ServiceError:
    identity, offset = _identity(reply)
    try:
        order = "<" if reply.little_endian else ">"
        minor, completion = struct.unpack_from(f"{order}II", reply.body, offset)
        completed = _COMPLETIONS[completion]
    except FAILURES as failure:
        raise CdrError("SystemException", str(failure)) from failure
    type_ = SYSTEM_EXCEPTIONS.get(identity, ServiceError)
    return type_(
        f"{operation}: the server reports {identity} (minor {minor}, {completed})"
    )


def _identity(reply: Reply) -> tuple[str, int]:
    """Return the repository id at the start of a reply, and the next offset aligned to 4."""
    try:
        order = "<I" if reply.little_endian else ">I"
        (length,) = struct.unpack_from(order, reply.body)
        if length > len(reply.body) - 4:
            raise ValueError(f"a length of {length}")
        identity = text_value(reply.body[4 : 4 + length])
    except FAILURES as failure:
        raise CdrError("Reply", str(failure)) from failure
    return identity, 4 + length + -length % 4
