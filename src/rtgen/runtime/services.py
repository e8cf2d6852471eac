"""Interfaces at work: abstract servants, client stubs and the skeletons that call servants."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, wraps
from inspect import signature
from typing import Any, ClassVar, TypeAlias, TypeVar, cast

from rtgen.runtime.descriptors import InterfaceDescriptor
from rtgen.runtime.failures import described, ends_run, log

_F = TypeVar("_F", bound=Callable[..., object])

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


@dataclass(frozen=True, slots=True)
class Operation:
    """How an operation is called, or an attribute read or written.

    `python_name` is the method or property, `count` how many arguments a call takes, `raises` are
    the exceptions that the interface declares. `kind` is `call`, `get` or `set`.
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
    """What the annotations of a method do not say of its operation.

    `name` is the name in IDL where it is not the method's.
    """

    def marked(function: _F) -> _F:
        function._operation_ = (name, raises, oneway)  # type: ignore[attr-defined]
        return function

    return marked


@cache
def operations_of(interface: type[Servant]) -> Mapping[str, Operation]:
    """The operations of an interface and its bases, by the name that invokers get.

    They are the abstract methods and properties that the interface's classes declare.
    """
    found: dict[str, Operation] = {}
    for base in reversed(interface.__mro__):
        if "_descriptor_" in vars(base):
            for name, member in vars(base).items():
                found.update(_declared(name, member))
    return found


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
    """The base of generated stubs: each operation is handed to the invoker."""

    def __init_subclass__(cls, **options: Any) -> None:
        """Defines the operations that the interface declares and the class does not define."""
        super().__init_subclass__(**options)
        if not issubclass(cls, Servant):
            return
        interface: Any = next(b for b in cls.__mro__ if "_descriptor_" in vars(b))
        if "_stub_" not in vars(interface):
            interface._stub_ = cls
        attributes: dict[str, dict[str, Callable[..., Any]]] = {}
        for key, found in operations_of(cls).items():
            member = getattr(cls, found.python_name)
            if not getattr(member, "__isabstractmethod__", False):
                continue
            if found.kind == "call":
                setattr(cls, found.python_name, _calling(key, member))
            else:
                accessors = attributes.setdefault(found.python_name, {})
                accessors[found.kind] = _accessor(key)
        for name, accessors in attributes.items():
            setattr(cls, name, property(accessors.get("get"), accessors.get("set")))

    def __init__(self, invoker: Invoker) -> None:
        self._invoker = invoker


def _calling(key: str, declared: Callable[..., object]) -> Callable[..., object]:
    """The method of a stub; `declared` is that of the interface."""

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
    """The base of generated skeletons: calls a servant by operation name."""

    _interface_: ClassVar[type[Servant]]

    def __init_subclass__(
        cls, interface: type[Servant] | None = None, **options: Any
    ) -> None:
        """Makes this the skeleton of `interface`."""
        super().__init_subclass__(**options)
        if interface is not None:
            cls._interface_ = interface
            interface._skeleton_ = cls

    def __init__(self, servant: Any) -> None:
        self._servant = servant
        self._report: Callable[[str, BaseException], None] = _log_failure
        """Notified of what the servant raises and the operation does not declare."""

    def dispatch(self, operation: str, arguments: tuple[object, ...]) -> object:
        """The result of the operation.

        Raises what the operation declares, UnknownException for anything else that the servant
        raises, BadOperation for a name or a number of arguments that the interface has not.
        KeyboardInterrupt and the debugger's quit pass, since they end the run.
        """
        found = operations_of(self._interface_).get(operation)
        if found is None:
            raise BadOperation(f"there is no operation {operation}")
        _check_count(operation, arguments, found.count)
        try:
            if found.kind == "get":
                return cast(object, getattr(self._servant, found.python_name))
            if found.kind == "set":
                setattr(self._servant, found.python_name, *arguments)
                return None
            return cast(object, getattr(self._servant, found.python_name)(*arguments))
        except BaseException as error:
            is_declared = isinstance(error, (*found.raises, ServiceError))
            if ends_run(error) or (is_declared and not found.oneway):
                raise
            self._report(operation, error)
            if found.oneway:
                return None  # nobody waits for it
            raise UnknownException(f"{operation}: {described(error)}") from error


def _log_failure(operation: str, error: BaseException) -> None:
    log.error("%s failed: %s", operation, described(error), exc_info=error)


def _check_count(operation: str, arguments: tuple[object, ...], count: int) -> None:
    if len(arguments) != count:
        raise BadOperation(f"{operation} takes {count} arguments, not {len(arguments)}")
