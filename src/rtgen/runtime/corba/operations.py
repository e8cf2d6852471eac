"""The operations of an interface as omniORBpy takes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rtgen.runtime.calls import Call, calls_of
from rtgen.runtime.cdr import UserException
from rtgen.runtime.corba.wire_types import WireException, WireType, WireTypes
from rtgen.runtime.descriptors import DataType
from rtgen.runtime.services import BadOperation, MarshalError, Servant

Values: TypeAlias = tuple[Any, ...]
_CONTEXT = "_context"


class Operation:
    """One operation: `descriptor` for omniORBpy, and the values on their ways.

    `count` arguments, `results` results. A value is converted on its way out of this process and
    into it; None instead of a function where all travel as they are.
    """

    def __init__(self, call: Call, types: WireTypes) -> None:
        given = _types(call.request, call.request_objects, types)
        got = _types(call.reply, call.reply_objects, types)
        # The strings of a context follow the arguments; nobody passes any.
        context = [wire for name, wire in given if name == _CONTEXT]
        arguments = [wire for name, wire in given if name != _CONTEXT]
        results = [wire for _, wire in got]
        self.call = call
        self.count = len(arguments)
        self.results = len(results)
        self._exceptions: dict[str, WireException] = {}
        for _, class_ in call.raises:
            identity = class_._descriptor_.repository_id
            self._exceptions[identity] = types.exception(class_)
        told = {identity: e.descriptor for identity, e in self._exceptions.items()}
        self.descriptor = (
            tuple(wire.descriptor for _, wire in given),
            None if call.oneway else tuple(wire.descriptor for wire in results),
            told or None,
        )
        self.request = _converting([w.outgoing for w in arguments], [[]] * len(context))
        self.arguments = _converting([w.incoming for w in arguments], [])
        self.reply = _converting([w.outgoing for w in results], [])
        self.values = _converting([w.incoming for w in results], [])

    def raised(self, error: UserException) -> Any:
        """omniORBpy's exception for one of ours; None if the operation does not declare it."""
        for kind in type(error).__mro__:
            identity = getattr(kind, "_descriptor_", error._descriptor_).repository_id
            if identity in self._exceptions:
                return self._exceptions[identity].raised(error)
        return None

    def caught(self, error: Any) -> Exception:
        """Ours for an exception that omniORBpy raised."""
        exception: Exception = self._exceptions[error._NP_RepositoryId].caught(error)
        return exception


class Operations:
    """The operations of an interface and its bases, by name.

    Raises ServiceError for a local interface. `refused` says why an operation cannot travel.
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
        """An operation. Raises BadOperation, MarshalError if it cannot travel."""
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
    converts: Sequence[Callable[[Any], Any] | None], rest: Sequence[Any]
) -> Callable[[Values], Values] | None:
    """What converts values one by one and appends the rest; None if there is nothing to do."""
    if not rest and not any(converts):
        return None
    pairs = tuple(converts)
    tail = tuple(rest)

    def convert(values: Values) -> Values:
        return (
            *(
                value if c is None else c(value)
                for c, value in zip(pairs, values, strict=True)
            ),
            *tail,
        )

    return convert
