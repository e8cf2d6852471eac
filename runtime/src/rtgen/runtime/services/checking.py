"""Checks the values of calls in one process, where nothing marshals them."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.cdr import CdrError, UserException
from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.services.calls import as_tuple, calls_of, encoded, references
from rtgen.runtime.services.servants import MarshalError, Servant, ServiceError


class _UnresolvedObjects:
    """References to objects, of which only the interface is checked."""

    def reference(self, interface: type[Any], servant: Any) -> ObjectReference:
        return ObjectReference()

    def resolve(self, interface: type[Any], reference: ObjectReference) -> Any:
        raise NotImplementedError


_OBJECTS = _UnresolvedObjects()


class CallChecks:
    """Checks the calls of an interface; `place` names the provider in errors."""

    def __init__(self, interface: type[Servant], place: str) -> None:
        self._place = place
        try:
            self._calls = calls_of(interface)
        except ServiceError:  # its calls never leave a process
            self._calls = {}

    def arguments(self, operation: str, values: tuple[object, ...]) -> None:
        """Raise CdrError for arguments that could not be sent to another process."""
        call = self._calls.get(operation)
        if call is not None and call.request is not None:
            self._encode(operation, call.request, values, call.request_objects)

    def result(self, operation: str, value: object) -> None:
        """Raise MarshalError for a result that could not be sent, as a server does."""
        call = self._calls.get(operation)
        if call is not None and call.reply is not None:
            try:
                values = as_tuple(call, value)
                self._encode(operation, call.reply, values, call.reply_objects)
            except CdrError as error:
                raise MarshalError(f"the result is wrong: {error}") from None

    def exception(self, operation: str, error: UserException) -> None:
        """Raise MarshalError for a declared exception that could not be sent."""
        call = self._calls.get(operation)
        for body, declared in () if call is None else call.raises:
            if isinstance(error, declared):
                identity = error._descriptor_.repository_id
                try:
                    self._encode(operation, body, (identity, *error._values()), ())
                except CdrError as fault:
                    raise MarshalError(f"the exception is wrong: {fault}") from error

    def _encode(
        self,
        operation: str,
        type_: type[Any],
        values: tuple[object, ...],
        interfaces: Any,
    ) -> None:
        try:
            passed = references(values, interfaces, _OBJECTS)
            encoded(operation, type_, passed, True)
        except CdrError as error:
            raise CdrError(f"{self._place}: {error.path}", error.message) from None
