"""Interfaces at work: abstract servants, client stubs and the skeletons that call servants."""

from __future__ import annotations

import logging
from abc import ABC
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, TypeAlias, TypeVar, cast

from rtgen.runtime.descriptors import InterfaceDescriptor

log = logging.getLogger("rtgen.runtime")

_T = TypeVar("_T")

Invoker: TypeAlias = Callable[[str, tuple[object, ...]], object]
"""Carries a call: operation name (`_get_x`, `_set_x` for an attribute), `in` and `inout`
arguments; gives the result, a tuple where there are several (return value first)."""


class ServiceError(RuntimeError):
    """A call that did not reach its end, whatever the interface says."""


class ObjectNotExist(ServiceError):
    """Nobody serves the object: not connected, or the provider is not active."""


class UnknownException(ServiceError):
    """The servant raised what the operation does not declare; that is its cause."""


class BadOperation(ServiceError):
    """The interface has no such operation, or it takes other arguments."""


class MarshalError(ServiceError):
    """What came over the wire, or what was to go over it, is not what the interface says."""


class CommunicationFailure(ServiceError):
    """The servant's process cannot be reached, or was lost; the call may have been carried out."""


class CallTimeout(CommunicationFailure):
    """There was no answer in time; the call may have been carried out, or be at work still."""


class Servant(ABC):
    """The base of generated interfaces: what a servant implements, and what a client sees."""

    _descriptor_: ClassVar[InterfaceDescriptor]
    _stub_: ClassVar[type[Any]]
    _skeleton_: ClassVar[type[Any]]
    _calls_: ClassVar[str]


class Stub:
    """The base of generated stubs: each operation is handed to the invoker."""

    def __init__(self, invoker: Invoker) -> None:
        self._invoker = invoker

    def _invoke_(self, operation: str, *arguments: object) -> None:
        self._invoker(operation, arguments)

    # What the invoker gives is of the type that the generated method declares.
    def _obtain_(self, operation: str, *arguments: object) -> _T:  # type: ignore[type-var]
        return cast(_T, self._invoker(operation, arguments))


class Skeleton:
    """The base of generated skeletons: calls a servant by operation name."""

    def __init__(self, servant: Any) -> None:
        self._servant = servant

    def dispatch(self, operation: str, arguments: tuple[object, ...]) -> object:
        """The result of the operation.

        Raises what the operation declares, UnknownException for anything else that the servant
        raises, BadOperation for a name or a number of arguments that the interface has not.
        """
        raise BadOperation(f"there is no operation {operation}")

    def _call_(
        self,
        operation: str,
        method: Callable[..., object],
        arguments: tuple[object, ...],
        count: int,
        raises: tuple[type[Exception], ...] = (),
    ) -> object:
        _check_count(operation, arguments, count)
        declared: tuple[type[Exception], ...] = (*raises, ServiceError)
        try:
            return method(*arguments)
        except declared:
            raise
        except Exception as error:
            raise UnknownException(
                f"{operation}: {type(error).__name__}: {error}"
            ) from error

    def _send_(
        self,
        operation: str,
        method: Callable[..., object],
        arguments: tuple[object, ...],
        count: int,
    ) -> object:
        """A oneway operation: nobody waits for it, so its failure is logged only."""
        _check_count(operation, arguments, count)
        try:
            method(*arguments)
        except Exception as error:
            log.warning("oneway %s failed", operation, exc_info=error)
        return None

    def _get_(
        self,
        operation: str,
        attribute: str,
        arguments: tuple[object, ...],
        raises: tuple[type[Exception], ...] = (),
    ) -> object:
        get = partial(getattr, self._servant, attribute)
        return self._call_(operation, get, arguments, 0, raises)

    def _set_(
        self,
        operation: str,
        attribute: str,
        arguments: tuple[object, ...],
        raises: tuple[type[Exception], ...] = (),
    ) -> object:
        put = partial(setattr, self._servant, attribute)
        return self._call_(operation, put, arguments, 1, raises)


def _check_count(operation: str, arguments: tuple[object, ...], count: int) -> None:
    if len(arguments) != count:
        raise BadOperation(f"{operation} takes {count} arguments, not {len(arguments)}")
