"""Values, servants and stubs of OpenRTM's side: objects of the classes that omniidl generates.

Generated modules for OpenRTM, and their hosts, use it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property
from itertools import zip_longest
from types import new_class
from typing import Any, TypeAlias, TypeVar

import omniORB
from omniORB import CORBA

from rtgen.facts.omniidl import mangled
from rtgen.runtime.cdr import UserException
from rtgen.runtime.corba.faults import caught, raised
from rtgen.runtime.corba.wire_conversions import Convert
from rtgen.runtime.marshalling.descriptors import DataType, Descriptor
from rtgen.runtime.openrtm.conversions import (
    Signature,
    calling,
    conversions_of,
    serving,
)
from rtgen.runtime.openrtm.stubs import StubsMissingError
from rtgen.runtime.openrtm.wire_objects import class_of
from rtgen.runtime.services.call_types import CONTEXT, Call
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import (
    Invoker,
    MarshalError,
    ObjectNotExist,
    Servant,
    ServiceError,
    Skeleton,
    Stub,
    operations_of,
)

_S = TypeVar("_S", bound=Servant)

Reference: TypeAlias = Callable[[], Any]
"""Function that returns the omniORB object that a stub calls, or None if there is none (yet)."""

_NO_CONTEXT = CORBA.Context("", None)
"""The context of calls, which is not used."""


def new(type_: type[DataType]) -> Any:
    """Return a wire object with initial values that omniORB can marshal: those of the class.

    Raises StubsMissingError.
    """
    return conversions_of(type_._descriptor_).to(type_())


class _Operation:
    """An operation, or an accessor of an attribute: its method at omniORB, its conversions."""

    def __init__(self, name: str, call: Call) -> None:
        request = _parts(call.request, call.request_objects)
        types = [type_ for member, type_ in request if member != CONTEXT]
        self.refused = call.refused
        self.signature = Signature(
            name,
            mangled(name),
            types,
            [type_ for _, type_ in _parts(call.reply, call.reply_objects)],
            [_NO_CONTEXT] * (len(request) - len(types)),
        )
        self.raised: dict[type[Any], Convert] = {}
        self.caught: dict[type[Any], Convert] = {}
        for _, class_ in call.raises:
            conversions = conversions_of(class_._descriptor_)
            self.raised[class_] = conversions.to
            self.caught[class_of(class_._descriptor_.repository_id)] = conversions.of

    @cached_property
    def call(self) -> Callable[[Any, tuple[object, ...]], object]:
        """The function that calls an omniORB object."""
        return calling(self.signature)


@cache
def _operations(interface: type[Servant]) -> dict[str, _Operation]:
    return {name: _Operation(name, call) for name, call in calls_of(interface).items()}


def _parts(
    body: type[DataType] | None, interfaces: Sequence[type[Servant] | None]
) -> list[tuple[str, Descriptor | Objects]]:
    """Return the names of a body's members, with their types; those of objects are `Objects`."""
    members = () if body is None else body._descriptor_.members
    return [
        (member.name, member.type if interface is None else objects_of(interface))
        for member, interface in zip_longest(members, interfaces)
    ]


class Tie:
    """Base class of servants for omniORB: converts wire values, and calls an invoker.

    The skeleton of omniidl is another base, as in `class Lever_i(Tie, Relays__POA.Lever,
    interface=Lever)`.
    """

    def __init_subclass__(
        cls, interface: type[Servant] | None = None, **options: Any
    ) -> None:
        """Define the operations of `interface`."""
        super().__init_subclass__(**options)
        if interface is not None:
            for operation in _operations(interface).values():
                if not operation.refused:
                    setattr(cls, operation.signature.method, _tied(operation))

    def __init__(self, invoker: Invoker) -> None:
        self._invoker = invoker


def _tied(operation: _Operation) -> Callable[..., Any]:
    """Return the method of a tie."""
    serve = serving(operation.signature)

    def method(self: Tie, *arguments: Any) -> Any:
        try:
            return serve(self._invoker, *arguments)
        except UserException as error:
            for kind in type(error).__mro__:
                if kind in operation.raised:
                    raise operation.raised[kind](error) from error
            raise

    return method


class Remote:
    """Calls the omniORB object of a reference, which may change.

    Without one, calls raise ObjectNotExist; for errors of omniORB, other kinds of ServiceError.
    """

    def __init__(self, interface: type[Servant], reference: Reference) -> None:
        self.reference = reference
        self._operations = _operations(interface)

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """Make a call. Raises what the operation declares, CdrError and ServiceError."""
        entry = self._operations[operation]
        if entry.refused:
            raise MarshalError(f"{operation} is not marshalled: {entry.refused}")
        reference = self.reference()
        if reference is None:
            raise ObjectNotExist("no provider is connected")
        try:
            return entry.call(reference, arguments)
        except CORBA.SystemException as error:
            raise caught(operation, error) from error
        except CORBA.UserException as error:
            convert = entry.caught.get(type(error))
            if convert is None:
                raise
            raise convert(error) from error


def stub(interface: type[_S], reference: Reference) -> _S:
    """Return a stub that calls the object of a reference. Raises StubsMissingError."""
    proxy: _S = interface._stub_(Remote(interface, reference).call)
    return proxy


class Objects:
    """Conversion of the objects of an interface in arguments and results of operations.

    An object that was passed once is served until the process ends.
    """

    def __init__(self, interface: type[Servant]) -> None:
        self._interface = interface
        self._served: dict[int, tuple[Servant, Any]] = {}

    def to(self, value: Any) -> Any:
        """Return the omniORB reference to an object; nil for None. Raises StubsMissingError."""
        if value is None:
            return None
        if isinstance(value, Stub):
            remote = getattr(value._invoker, "__self__", None)
            if isinstance(remote, Remote):
                return remote.reference()
        if id(value) not in self._served:
            servant = self._class(_invoker_of(self._interface, value))
            self._served[id(value)] = value, servant._this()
        return self._served[id(value)][1]

    def of(self, wire: Any) -> Any:
        """Return a stub for an omniORB reference; None for nil."""
        return None if wire is None else stub(self._interface, lambda: wire)

    @cached_property
    def _class(self) -> type[Any]:
        identity = self._interface._descriptor_.repository_id
        skeleton = omniORB.skeletonMapping.get(identity)
        if skeleton is None:
            raise StubsMissingError(identity)
        return new_class(
            self._interface.__name__, (Tie, skeleton), {"interface": self._interface}
        )


@cache
def objects_of(interface: type[Servant]) -> Objects:
    """Return the conversion of the objects of an interface."""
    return Objects(interface)


def _invoker_of(interface: type[Servant], servant: Servant) -> Invoker:
    """Return the invoker of a servant; its exceptions are passed on."""
    operations = operations_of(interface)

    def invoke(name: str, arguments: tuple[object, ...]) -> object:
        operation = operations[name]
        if operation.kind == "set":
            setattr(servant, operation.python_name, *arguments)
            return None
        member = getattr(servant, operation.python_name)
        return member if operation.kind == "get" else member(*arguments)

    return invoke


def invoker_of_provider(provider: Provider[Any]) -> Invoker:
    """Return the invoker of a tie that calls a provider while its component is ACTIVE.

    Undeclared exceptions are raised as system exceptions of CORBA.
    """

    def invoke(operation: str, arguments: tuple[object, ...]) -> object:
        try:
            return provider.call(operation, arguments)
        except ServiceError as error:
            raise raised(error) from error

    return invoke


class RemoteProvider:
    """Makes a consumer's calls to the object that OpenRTM has connected.

    `reference` returns it, or None.
    """

    def __init__(self, consumer: Consumer[Any], reference: Reference) -> None:
        self._reference = reference
        interface = consumer.interface
        self._skeleton: Skeleton = interface._skeleton_(stub(interface, reference))

    @property
    def reachable(self) -> bool:
        """See `Carrier`."""
        return self._reference() is not None

    def call(self, operation: str, arguments: tuple[object, ...]) -> object:
        """See `Carrier`."""
        return self._skeleton.dispatch(operation, arguments)
