"""Types of calls: what a generated module declares, and the classes of bodies made from it.

A request is the `in` and `inout` parameters in order, a reply the return value and then the `inout`
and `out` parameters, a user exception its repository id and its members (CORBA 3.3 part 2, 9.4.2.2
and 9.4.3.2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import msgspec
from msgspec.structs import replace

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, UserException
from rtgen.runtime.marshalling.descriptors import NEXT, DataType, Descriptor
from rtgen.runtime.services.servants import Servant

Interfaces: TypeAlias = tuple[type[Servant] | None, ...]

CONTEXT = "_context"
"""The member of a request with the strings of a context clause, which are not used."""


class CallTypes(msgspec.Struct, frozen=True, kw_only=True):
    """The types of an operation; `refused` is the reason if it cannot be marshalled.

    `request` and `reply` have the members of the bodies by attribute, as `idl.struct` takes them;
    `*_objects` the interface of each member that is an object; `*_version` the version of XCDR of
    the body, 0 for classic CDR. `raises` has the exceptions in the order of the definition.
    """

    request: Mapping[str, Any] = {}
    reply: Mapping[str, Any] = {}
    request_objects: Interfaces = ()
    reply_objects: Interfaces = ()
    request_version: int = 0
    reply_version: int = 0
    raises: tuple[type[UserException], ...] = ()
    oneway: bool = False
    refused: str = ""


class Call:
    """Marshalling of an operation, by its types."""

    def __init__(self, name: str, types: CallTypes) -> None:
        """`name` is the scoped name of the operation, such as `Lamp.dim`."""
        self._name = name
        self._types = types
        self.request_objects = types.request_objects
        self.reply_objects = types.reply_objects
        self.oneway = types.oneway
        self.refused = types.refused

    @cached_property
    def request(self) -> type[DataType] | None:
        """The class of requests; None if they are empty."""
        types = self._types
        if not types.request:
            return None
        return _body(f"{self._name} request", types.request, types.request_version)

    @cached_property
    def reply(self) -> type[DataType] | None:
        """The class of replies with results; None if they are empty."""
        types = self._types
        if not types.reply:
            return None
        return _body(f"{self._name} reply", types.reply, types.reply_version)

    @cached_property
    def raises(self) -> tuple[tuple[type[DataType], type[UserException]], ...]:
        """The classes of replies with an exception, each with the exception."""
        return tuple((raised_body(each), each) for each in self._types.raises)


def raised_body(exception: type[UserException]) -> type[DataType]:
    """Return the class of replies with an exception: its repository id and its members."""
    known: type[DataType] | None = vars(exception).get("_raised_")
    if known is not None:
        return known
    described = exception._descriptor_
    members = {"_id": idl.STRING} | {
        member.attribute: replace(member, id=NEXT) for member in described.members
    }
    name = f"{described.name.replace('::', '.')} raised"
    body = _body(name, members, described.representation)
    exception._raised_ = body
    return body


def _body(name: str, members: Mapping[str, Any], version: int) -> type[DataType]:
    fields: list[tuple[str, Any, Any]] = [
        (key, Any, msgspec.field(default_factory=list) if key == CONTEXT else None)
        for key in members  # values always have the others
    ]
    traits = idl.traits(representation=version)
    body: type[DataType] = aggregate(name, fields, idl.struct(name, traits, **members))
    return body


def aggregate(
    name: str, fields: Sequence[Any], descriptor: Descriptor, base: Any = Aggregated
) -> Any:
    """Return the class of a struct or union; `fields` as those of `msgspec.defstruct`."""
    return msgspec.defstruct(
        name.replace("::", "_"),
        fields,
        bases=(base,),
        namespace={"_descriptor_": descriptor},
        gc=False,
    )
