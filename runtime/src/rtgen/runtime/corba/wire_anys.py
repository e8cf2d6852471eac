"""Values of `any` and type codes in omniORBpy: unions that switch on their type and on its kind.

A type code consists of its kind and the parameters of this kind, an `any` of a type code and a
value of this type (CORBA 3.3 part 2, 9.3.5). So they have the octets of unions, and omniORBpy
marshals them as unions: it parses no type codes, and constructs values as it does elsewhere.
Types that operations do not support are refused: octets of a peer can make omniORB crash while it
reads a valuetype by its type code.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from omniORB import CORBA, tcInternal

from rtgen.runtime.corba.wire_conversions import Convert, WireType, WireUnion
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    FixedDescriptor,
    Named,
    SequenceDescriptor,
)
from rtgen.runtime.marshalling.dynamic.direct import has_empty_elements
from rtgen.runtime.marshalling.errors import FAILURES, Fault
from rtgen.runtime.marshalling.type_codes import (
    ENCAPSULATED,
    FIXED,
    STRINGS,
    simple_type,
    type_code_octets,
    type_of_code,
)
from rtgen.runtime.services.servants import MarshalError
from rtgen.runtime.values import AnyValue

_MAX_CONTENTS = 256
"""Maximum number of cached types; a full table is cleared."""

_OCTETS = tcInternal.tv_sequence, tcInternal.tv_octet, 0
_DIGITS = (
    *(tcInternal.tv_struct, FixedDescriptor, "", ""),
    *("digits", tcInternal.tv_ushort, "scale", tcInternal.tv_short),
)
_PARAMETERS = {
    **{kind: (kind, "", _OCTETS) for kind in ENCAPSULATED},
    **{kind: (kind, "", tcInternal.tv_ulong) for kind in STRINGS},
    FIXED: (FIXED, "", _DIGITS),
}
"""The branches of a type code: the encapsulation, the bound, or the digits."""


_BRANCHES: dict[float, Any] = {}
"""The branches of all `any`: omniORBpy copies values between the objects of one process."""
_numbers = itertools.count(1)


class _Content(float):
    """A type of values of `any`, as the discriminator by which omniORBpy finds its descriptor.

    It is a number, so that the table of branches does not keep it alive: a branch exists as long
    as a value that is being marshalled needs it. Unlike an int, a float can have slots, which
    omniORBpy finds faster.
    """

    __slots__ = ("_d", "_v", "incoming", "outgoing", "type")

    type: Descriptor
    outgoing: Convert | None
    incoming: Convert | None
    _d: int
    _v: Any

    def __del__(self, branches: dict[float, Any] = _BRANCHES) -> None:
        del branches[float(self)]


class Anys:
    """The `any` of one ORB; `make` returns the type of values, or raises MarshalError."""

    def __init__(self, make: Callable[[Descriptor], WireType]) -> None:
        self._make = make
        self._contents: dict[Any, _Content] = {}
        self._simple = lru_cache(self._simple_content)
        content = _union(self._content, tcInternal.tv_ulong, _PARAMETERS)
        self.type = WireType(_union(_value, content, _BRANCHES), self._outgoing)

    def _outgoing(self, value: Any) -> WireUnion:
        if not isinstance(value, AnyValue):
            raise TypeError(f"an AnyValue is needed, not {type(value).__name__}")
        type_ = value.type
        content = self._contents.get(id(type_)) or self._content_of(type_)
        outgoing = content.outgoing
        inner = value.value if outgoing is None else outgoing(value.value)
        return WireUnion(content, inner)

    def _content(self, kind: int, parameters: Any) -> _Content:
        """Return the discriminator of a type code. Raises omniORB's MARSHAL."""
        try:
            if isinstance(parameters, bytes):
                type_ = type_of_code(kind, parameters)
                return self._contents.get(id(type_)) or self._content_of(type_)
            return self._simple(kind, parameters)
        except (MarshalError, *FAILURES) as error:
            raise _refused("type code", error) from error

    def _simple_content(self, kind: int, parameters: Any) -> _Content:
        return self._content_of(_read_type(kind, parameters))

    def _content_of(self, type_: Descriptor) -> _Content:
        key = _key(type_)
        found = self._contents.get(key)
        if found is None:
            found = self._new_content(type_)
            if len(self._contents) >= _MAX_CONTENTS:
                self._contents.clear()
            self._contents[key] = self._contents[id(type_)] = found
        return found

    def _new_content(self, type_: Descriptor) -> _Content:
        code = _code(type_)
        if has_empty_elements(type_):
            raise Fault("an array of elements without octets")
        wire = self._make(type_)
        content = _Content(next(_numbers))
        _BRANCHES[float(content)] = (float(content), "", wire.descriptor)
        content.type = type_
        content.outgoing, content.incoming = wire.outgoing, wire.incoming
        content._d, content._v = code._d, code._v
        return content


def _read_type(kind: int, parameters: Any) -> Descriptor:
    numbers = [parameters]
    if isinstance(parameters, FixedDescriptor):
        numbers = [parameters.scale, parameters.digits]
    simple = simple_type(kind, lambda _: numbers.pop())
    return type_of_code(kind, parameters) if simple is None else simple


def _type_of(kind: int, parameters: Any) -> Descriptor:
    """Return the type of a type code. Raises omniORB's MARSHAL."""
    try:
        return _read_type(kind, parameters)
    except FAILURES as error:
        raise _refused("type code", error) from error


def _refused(what: str, error: Exception) -> Any:
    """Return the exception for octets that only rtgen refuses, and log the reason."""
    log.warning("a received %s is wrong: %s", what, error)
    return CORBA.MARSHAL(0, CORBA.COMPLETED_MAYBE)


def _code(type_: Any) -> WireUnion:
    """Return the type code of a type for omniORBpy to read."""
    kind, octets = type_code_octets(type_, True)
    parameters: Any = octets[4:]
    if kind in STRINGS:
        parameters = type_.bound or 0
    elif kind == FIXED:
        parameters = type_
    return WireUnion(kind, parameters)


def _value(content: _Content, value: Any) -> AnyValue:
    """Return the value of an `any`. Raises omniORB's MARSHAL."""
    incoming = content.incoming
    if incoming is None:
        return AnyValue(content.type, value)
    try:
        return AnyValue(content.type, incoming(value))
    except FAILURES as error:
        raise _refused("value of an any", error) from error


def _key(type_: Descriptor) -> Any:
    """Return a key that differs for types with different values: named types by identity."""
    match type_:
        case SequenceDescriptor(element, bound, numeric=numeric):
            return "sequence", _key(element), bound, numeric
        case ArrayDescriptor(element, dimensions, numeric=numeric):
            return "array", _key(element), dimensions, numeric
        case Named():
            return id(type_)
    return type_


def _union(class_: Callable[..., Any], switch: Any, branches: Mapping[Any, Any]) -> Any:
    """Return a descriptor of a union without default; omniORBpy reads the table only."""
    return tcInternal.tv_union, class_, "", "", switch, -1, (), None, branches


TYPE_CODE = WireType(_union(_type_of, tcInternal.tv_ulong, _PARAMETERS), _code)
"""`CORBA::TypeCode`."""
