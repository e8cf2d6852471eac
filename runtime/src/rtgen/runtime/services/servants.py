"""Servants, stubs and skeletons of generated interfaces."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Iterator, Mapping
from functools import cache, wraps
from inspect import signature
from typing import Any, ClassVar, TypeAlias, TypeVar

import msgspec

from rtgen.runtime.errors import EndOfRunError
from rtgen.runtime.failures import described, ends_run, log
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor

_F = TypeVar("_F", bound=Callable[..., object])

Invoker: TypeAlias = Callable[[str, tuple[object, ...]], object]
"""Function that makes a call, given operation name and `in` and `inout` arguments.

The name is `_get_x` or `_set_x` for an attribute. The result is a tuple if there are several values
(return value first).
"""


class ServiceError(RuntimeError):
    """A call that failed for a reason outside its interface."""


class ObjectNotExist(ServiceError):
    """The object does not exist: not connected, or the provider is not active."""


class UnknownException(ServiceError):
    """The servant raised an undeclared exception, which is the cause."""


class BadOperation(ServiceError):
    """The interface has no such operation, or its arguments differ."""


class MarshalError(ServiceError):
    """Data that were received or are to be sent violate the interface."""


class CommunicationFailure(ServiceError):
    """The servant's process is unreachable, or was lost; the call may have been executed."""


class CallEnded(CommunicationFailure, EndOfRunError):
    """The run ended while the call waited for its response."""


class CallTimeout(CommunicationFailure):
    """No response in time; the call may have been executed, or be in progress."""


class Servant(ABC):
    """The base class of generated interfaces, for servants and clients."""

    _descriptor_: ClassVar[InterfaceDescriptor]
    _stub_: ClassVar[type[Any]]
    _skeleton_: ClassVar[type[Any]]
    _calls_: ClassVar[str]
    _own_calls_: ClassVar[dict[str, Any]]


class Operation(msgspec.Struct, frozen=True):
    """How to call an operation, or to read or write an attribute.

    `python_name` is the method or property, `count` the number of arguments, `raises` are the
    declared exceptions. `kind` is `call`, `get` or `set`.
    """

    python_name: str
    count: int
    raises: tuple[type[Exception], ...] = ()
    oneway: bool = False
    kind: str = "call"


def operation(
    name: str = "",
    *,
    raises: tuple[type[Exception], ...] = (),
    oneway: bool = False,
) -> Callable[[_F], _F]:
    """Return a decorator with properties of an operation that annotations cannot express.

    `name` is the name in IDL, if it differs from the method's.
    """

    def marked(function: _F) -> _F:
        function._operation_ = (name, raises, oneway)  # type: ignore[attr-defined]
        return function

    return marked


@cache
def operations_of(interface: type[Servant]) -> Mapping[str, Operation]:
    """Return the operations of an interface and its bases, by their names on the wire.

    These are the abstract methods and properties of the interface's classes.
    """
    operations: dict[str, Operation] = {}
    for base in reversed(interface.__mro__):
        if "_descriptor_" in vars(base):
            for name, member in vars(base).items():
                operations.update(_declared(name, member))
    return operations


def _declared(python_name: str, member: Any) -> Iterator[tuple[str, Operation]]:
    if not getattr(member, "__isabstractmethod__", False):
        return
    if not isinstance(member, property):
        name, raises, oneway = getattr(member, "_operation_", ("", (), False))
        count = member.__code__.co_argcount - 1
        yield name or python_name, Operation(python_name, count, raises, oneway)
        return
    for kind, function in (("get", member.fget), ("set", member.fset)):
        if function is not None:
            name, raises, _ = getattr(function, "_operation_", ("", (), False))
            key = f"_{kind}_{name or python_name}"
            yield key, Operation(python_name, int(kind == "set"), raises, False, kind)


class Stub:
    """The base class of generated stubs: delegates each operation to the invoker."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Define the operations of the interface that the class does not define."""
        super().__init_subclass__(**options)
        if not issubclass(cls, Servant):
            return
        interface: Any = next(b for b in cls.__mro__ if "_descriptor_" in vars(b))
        if "_stub_" not in vars(interface):
            interface._stub_ = cls
        attributes: dict[str, dict[str, Callable[..., Any]]] = {}
        for key, operation in operations_of(cls).items():
            member = getattr(cls, operation.python_name)
            if not getattr(member, "__isabstractmethod__", False):
                continue
            if operation.kind == "call":
                setattr(cls, operation.python_name, _calling(key, member))
            else:
                accessors = attributes.setdefault(operation.python_name, {})
                accessors[operation.kind] = _accessor(key)
        for name, accessors in attributes.items():
            setattr(cls, name, property(accessors.get("get"), accessors.get("set")))

    def __init__(self, invoker: Invoker) -> None:
        self._invoker = invoker


def _calling(key: str, declared: Callable[..., object]) -> Callable[..., object]:
    """Return the method of a stub; `declared` is that of the interface."""

    @wraps(declared)
    def method(self: Stub, /, *arguments: object, **named: object) -> object:
        if named:
            bound = signature(declared).bind(self, *arguments, **named)
            arguments = bound.args[1:]
        return self._invoker(key, arguments)

    method.__isabstractmethod__ = False  # type: ignore[attr-defined]
    return method


def _accessor(key: str) -> Callable[..., object]:
    def access(self: Stub, *value: object) -> object:
        return self._invoker(key, value)

    return access


class Skeleton:
    """The base class of generated skeletons: calls a servant by operation name."""

    _operations: ClassVar[Mapping[str, Operation]]

    def __init_subclass__(
        cls, interface: type[Servant] | None = None, **options: Any
    ) -> None:
        """Make this the skeleton of `interface`."""
        super().__init_subclass__(**options)
        if interface is not None:
            cls._operations = operations_of(interface)
            interface._skeleton_ = cls

    def __init__(self, servant: Any) -> None:
        self._servant = servant
        self._report: Callable[[str, BaseException], None] = _log_failure
        """Function called with undeclared exceptions of the servant."""

    def dispatch(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Call the operation.

        Raises what the operation declares, UnknownException for other exceptions of the servant,
        BadOperation for an unknown operation or a wrong number of arguments. KeyboardInterrupt and
        the debugger's quit are not caught, since they end the run.
        """
        entry = self._operations.get(operation)
        if entry is None:
            raise BadOperation(f"there is no operation {operation}")
        if len(arguments) != entry.count:
            counts = f"{entry.count} arguments, not {len(arguments)}"
            raise BadOperation(f"{operation} takes {counts}")
        try:
            if entry.kind == "get":
                return getattr(self._servant, entry.python_name)
            if entry.kind == "set":
                setattr(self._servant, entry.python_name, *arguments)
                return None
            return getattr(self._servant, entry.python_name)(*arguments)
        except BaseException as error:
            is_declared = isinstance(error, (*entry.raises, ServiceError))
            if ends_run(error) or (is_declared and not entry.oneway):
                raise
            self._report(operation, error)
            if entry.oneway:
                return None  # no client waits for the result
            raise UnknownException(f"{operation}: {described(error)}") from error


def _log_failure(operation: str, error: BaseException) -> None:
    log.error("%s failed: %s", operation, described(error), exc_info=error)
