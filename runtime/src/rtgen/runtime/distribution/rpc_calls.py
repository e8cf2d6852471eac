"""Calls as requests and replies of DDS-RPC's basic mapping, at both ends."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.distribution.medium import Client, representation
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.distribution.rpc_header import (
    Identities,
    RemoteExceptionCode,
    ReplyHeader,
    SampleIdentity,
)
from rtgen.runtime.distribution.rpc_types import (
    OK,
    OperationTypes,
    interface_types,
)
from rtgen.runtime.failures import log
from rtgen.runtime.services.calls import (
    as_tuple,
    call_of,
    calls_of,
    decoded,
    encoded,
    kind_of,
)
from rtgen.runtime.services.servants import (
    BadOperation,
    CommunicationFailure,
    Invoker,
    MarshalError,
    ObjectNotExist,
    ServiceError,
    UnknownException,
)
from rtgen.runtime.xcdr import serialize

_CODES: dict[type[ServiceError], RemoteExceptionCode] = {
    ObjectNotExist: RemoteExceptionCode.REMOTE_EX_UNSUPPORTED,
    MarshalError: RemoteExceptionCode.REMOTE_EX_INVALID_ARGUMENT,
    CommunicationFailure: RemoteExceptionCode.REMOTE_EX_OUT_OF_RESOURCES,
    BadOperation: RemoteExceptionCode.REMOTE_EX_UNKNOWN_OPERATION,
    UnknownException: RemoteExceptionCode.REMOTE_EX_UNKNOWN_EXCEPTION,
}
_ERRORS = {code: kind for kind, code in _CODES.items()}
_NONE = 0
"""Discriminator of the default branch, for a union without content."""


class RpcServer:
    """The types of an interface at the serving end. Raises ServiceError as `calls_of`."""

    def __init__(self, interface: Any, invoke: Invoker) -> None:
        self._types = interface_types(interface)
        self._wire_names = {t.name: w for w, t in self._types.operations.items()}
        self._invoke = invoke

    def request(
        self, octets: bytes
    ) -> tuple[SampleIdentity, OperationTypes | None, Any]:
        """Return identity, operation (None: unknown) and value of a request. Raises CdrError."""
        value = received(self._types.request, octets)
        operation = self._types.labels.get(value.data.discriminator)
        return value.header.request_id, operation, value.data.value

    def answer(
        self, identity: SampleIdentity, operation: OperationTypes | None, value: Any
    ) -> bytes:
        """Execute a request; return the octets of its reply. Raises what ends the run."""
        try:
            if operation is None:
                raise BadOperation("there is no such operation")
            result = self._result(operation, value)
            answer = self._types.answer(operation.label, result)
            header = ReplyHeader(identity, RemoteExceptionCode.REMOTE_EX_OK)
            return _serialized(self._types.reply(header, answer), "result")
        except ServiceError as error:
            name = "a request" if operation is None else operation.name
            log.warning("%s: %s", name, error, exc_info=error.__cause__)
            return self.failure(identity, error)

    def failure(self, identity: SampleIdentity, error: ServiceError) -> bytes:
        """Return the octets of the reply for an error outside the interface."""
        code = _CODES.get(
            kind_of(error), RemoteExceptionCode.REMOTE_EX_OUT_OF_RESOURCES
        )
        nothing = self._types.answer(_NONE, 0)
        return _serialized(self._types.reply(ReplyHeader(identity, code), nothing), "")

    def _result(self, operation: OperationTypes, value: Any) -> Any:
        """Return the value of the union of results. Raises ServiceError."""
        call = operation.call
        try:
            arguments = _values(operation, value, call.request)
        except CdrError as error:
            raise MarshalError(f"the request is wrong: {error}") from error
        try:
            result = self._invoke(self._wire_names[operation.name], arguments)
        except UserException as error:
            return _raised(operation, error)
        results = as_tuple(call, result)
        try:
            out = _struct(operation, operation.reply, call.reply, results)
        except CdrError as error:
            raise MarshalError(f"the result is wrong: {error}") from error
        return operation.result(OK, out)


class RpcClient:
    """An invoker for stubs over a client of a medium; `timeout` [s] of a call.

    A call raises CdrError for an argument that cannot be marshalled, the declared exceptions,
    MediumError, and ServiceError as reported by the server.
    """

    def __init__(self, interface: Any, client: Client, timeout: float) -> None:
        self._calls = calls_of(interface)
        self._types = interface_types(interface)
        self._identities = Identities()
        self._client = client
        self._timeout = timeout

    def __call__(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Call an operation."""
        call = call_of(self._calls, operation)
        types = self._types.operations.get(operation)
        if types is None:
            raise MarshalError(f"{operation}: this transport passes no objects")
        value = _struct(types, types.request, call.request, arguments)
        data = self._types.call(types.label, value)
        request = self._types.request(self._identities.header(), data)
        octets = serialize(request, representation(self._types.request))
        if call.oneway:
            self._client.send(octets, self._timeout)
            return None
        answer = self._client.call(octets, self._timeout)
        try:
            return self._result(operation, types, answer)
        except CdrError as error:
            raise MarshalError(f"{operation}: the reply is wrong: {error}") from error

    def _result(self, operation: str, types: OperationTypes, octets: bytes) -> object:
        reply = received(self._types.reply, octets)
        code = reply.header.remote_ex
        if code is not RemoteExceptionCode.REMOTE_EX_OK:
            kind = _ERRORS.get(code, ServiceError)
            raise kind(f"{operation}: the server reports {code.name}")
        if reply.data.discriminator != types.label:
            raise CdrError("Reply", "it is the reply to another operation")
        result = reply.data.value
        if result.discriminator == OK:
            values = _values(types, result.value, types.call.reply)
            return (values or (None,))[0] if len(values) < 2 else values
        exception_type = types.exceptions.get(result.discriminator)
        if exception_type is None:
            raise UnknownException(f"{operation} raised an undeclared exception")
        _, exception = exception_type
        if types.octets:
            raise exception.from_cdr(bytes(result.value.octets))
        names = [m.attribute for m in exception._descriptor_.members]
        raise exception(*(getattr(result.value, name) for name in names))


def _serialized(reply: Any, what: str) -> bytes:
    """Return the octets of a reply. Raises MarshalError."""
    try:
        return serialize(reply, representation(type(reply)))
    except CdrError as error:
        raise MarshalError(f"the {what} is wrong: {error}") from error


def _raised(operation: OperationTypes, error: UserException) -> Any:
    """Return the value of the union of results for an exception. Raises ServiceError."""
    for label, (type_, exception) in operation.exceptions.items():
        if not isinstance(error, exception):
            continue
        if not operation.octets:
            return operation.result(label, type_(*error._values()))
        try:
            return operation.result(label, type_(error.to_cdr()))
        except CdrError as fault:
            raise MarshalError(f"the exception is wrong: {fault}") from error
    raise UnknownException(f"{type(error).__name__} is not declared") from error


def _struct(
    operation: OperationTypes, type_: Any, body: Any, values: tuple[object, ...]
) -> Any:
    """Return the struct of arguments or results. Raises CdrError, BadOperation."""
    if operation.octets:
        return type_(encoded(operation.name, body, values, True))
    count = 0 if body is None else len(type_.__struct_fields__)
    if len(values) != count:
        raise BadOperation(
            f"{operation.name} takes {count} arguments, not {len(values)}"
        )
    return type_(*values)


def _values(operation: OperationTypes, value: Any, body: Any) -> tuple[object, ...]:
    """Return the values of the struct of arguments or results. Raises CdrError."""
    if operation.octets:
        return decoded(body, bytes(value.octets), True)
    if body is None:
        return ()
    return tuple(getattr(value, name) for name in value.__struct_fields__)
