"""Converts operations of an interface to omniORBpy's descriptors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rtgen.runtime.cdr import UserException
from rtgen.runtime.corba.wire_conversions import Convert, WireType
from rtgen.runtime.corba.wire_types import WireException, WireTypes
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.services.call_types import CONTEXT, Call
from rtgen.runtime.services.calls import calls_of
from rtgen.runtime.services.servants import BadOperation, MarshalError, Servant

Values: TypeAlias = tuple[Any, ...]


class Operation:
    """An operation: its `descriptor` for omniORBpy, and conversions of its values.

    It has `count` arguments. Values are converted when they leave or enter this process; None
    instead of a function if no value needs it.
    """

    def __init__(self, call: Call, types: WireTypes) -> None:
        given = _types(call.request, call.request_objects, types)
        got = _types(call.reply, call.reply_objects, types)
        # The strings of a context clause follow the arguments; they are never passed.
        context = [wire for name, wire in given if name == CONTEXT]
        arguments = [wire for name, wire in given if name != CONTEXT]
        results = [wire for _, wire in got]
        self.call = call
        self.count = len(arguments)
        self._exceptions: dict[str, WireException] = {}
        for _, class_ in call.raises:
            identity = class_._descriptor_.repository_id
            self._exceptions[identity] = types.exception(class_)
        raises = {identity: e.descriptor for identity, e in self._exceptions.items()}
        self.descriptor = (
            tuple(wire.descriptor for _, wire in given),
            None if call.oneway else tuple(wire.descriptor for wire in results),
            raises or None,
        )
        self.request = _converting([w.outgoing for w in arguments], [[]] * len(context))
        self.arguments = _converting([w.incoming for w in arguments], [])
        self.reply = _converting_result([w.outgoing for w in results])
        self.values = _converting_result([w.incoming for w in results])

    def raised(self, error: UserException) -> Any:
        """Convert an exception to omniORBpy's; None if the operation does not declare it."""
        for kind in type(error).__mro__:
            identity = getattr(kind, "_descriptor_", error._descriptor_).repository_id
            if identity in self._exceptions:
                return self._exceptions[identity].raised(error)
        return None

    def caught(self, error: Any) -> Exception:
        """Convert an exception raised by omniORBpy."""
        exception: Exception = self._exceptions[error._NP_RepositoryId].caught(error)
        return exception


class Operations:
    """The operations of an interface and its bases, by name.

    Raises ServiceError for a local interface. `refused` has the reasons of operations that cannot
    be marshalled.
    """

    def __init__(self, interface: type[Servant], types: WireTypes) -> None:
        self.of: dict[str, Operation] = {}
        self.refused: dict[str, str] = {}
        for name, call in calls_of(interface).items():
            try:
                if call.refused:
                    raise MarshalError(call.refused)
                self.of[name] = Operation(call, types)
            except MarshalError as error:
                self.refused[name] = str(error)

    def find(self, name: str) -> Operation:
        """Find an operation. Raises BadOperation, or MarshalError if it cannot be marshalled."""
        found = self.of.get(name)
        if found is not None:
            return found
        if name in self.refused:
            raise MarshalError(f"{name} is not marshalled: {self.refused[name]}")
        raise BadOperation(f"there is no operation {name}")


def _types(
    body: type[DataType] | None,
    interfaces: Sequence[type[Servant] | None],
    types: WireTypes,
) -> list[tuple[str, WireType]]:
    if body is None:
        return []
    members = body._descriptor_.members
    of = [*interfaces, *[None] * (len(members) - len(interfaces))]
    return [
        (member.name, types.of(member.type, interface))
        for member, interface in zip(members, of, strict=True)
    ]


def _converting(
    converts: Sequence[Convert | None], rest: Sequence[Any]
) -> Callable[[Values], Values] | None:
    """Return a function that converts values one by one and appends the rest.

    None if nothing is converted.
    """
    if not rest and not any(converts):
        return None
    pairs = tuple(converts)
    tail = tuple(rest)
    if len(pairs) == 1 and not tail:
        return _converting_one(*converts)

    def convert(values: Values) -> Values:
        return (
            *(
                value if c is None else c(value)
                for c, value in zip(pairs, values, strict=True)
            ),
            *tail,
        )

    return convert


def _converting_result(converts: Sequence[Convert | None]) -> Convert | None:
    """Return `_converting` of a result: a tuple of several values, or one value itself."""
    return converts[0] if len(converts) == 1 else _converting(converts, [])


def _converting_one(only: Any) -> Callable[[Values], Values]:
    """Return `_converting` of one value, which is faster."""

    def convert(values: Values) -> Values:
        (value,) = values
        return (only(value),)

    return convert
