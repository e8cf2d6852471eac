"""Values of `any` and type codes in omniORBpy: unions that switch on their type and on its kind.

A type code consists of its kind and the parameters of this kind, an `any` of a type code and a
value of this type (CORBA 3.3 part 2, 9.3.5). So they have the octets of unions, and omniORBpy
marshals them as unions: it parses no type codes, and constructs values of generated types as it
does elsewhere. Valuetypes, and other types that rtgen does not describe to omniORBpy, are converted
by octets.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import omniORB
from omniORB import CORBA, tcInternal

from rtgen.runtime.corba.wire_conversions import WireType
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    ArrayDescriptor,
    BoxDescriptor,
    Descriptor,
    FixedDescriptor,
    Named,
    PrimitiveDescriptor,
    SequenceDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.direct import has_empty_elements
from rtgen.runtime.marshalling.errors import FAILURES, Fault
from rtgen.runtime.marshalling.layouts.trees import parts
from rtgen.runtime.marshalling.type_codes import (
    ENCAPSULATED,
    FIXED,
    STRINGS,
    simple_type,
    type_code_octets,
    type_of_code,
)
from rtgen.runtime.services.servants import MarshalError
from rtgen.runtime.values import AnyValue, decoded, encoded

_WCHAR = PrimitiveDescriptor("wchar")
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


_BRANCHES: dict[int, Any] = {}
"""The branches of all `any`: omniORBpy copies values between the objects of one process."""
_numbers = itertools.count(1)


class _Content(int):
    """A type of values of `any`, as the discriminator by which omniORBpy finds its descriptor.

    It is a number, so that the table of branches does not keep it alive: a branch exists as long
    as a value that is being marshalled needs it.
    """

    type: Descriptor
    wire: WireType
    _d: int
    _v: Any

    def __del__(self) -> None:
        del _BRANCHES[int(self)]


class Anys:
    """The `any` of one ORB; `make` returns the type of values, or raises MarshalError."""

    def __init__(self, make: Callable[[Descriptor], WireType]) -> None:
        self._make = make
        self._contents: dict[Any, _Content] = {}
        self._simple = lru_cache(self._simple_content)
        content = _union(self._content, tcInternal.tv_ulong, _PARAMETERS)
        self.type = WireType(_union(_value, content, _BRANCHES), self._outgoing)

    def _outgoing(self, value: Any) -> SimpleNamespace:
        if getattr(value, "_descriptor_", None) is not ANY:
            raise TypeError(f"an AnyValue is needed, not {type(value).__name__}")
        content = self._content_of(value.type)
        outgoing = content.wire.outgoing
        inner = value.value if outgoing is None else outgoing(value.value)
        return SimpleNamespace(_d=content, _v=inner)

    def _content(self, kind: int, parameters: Any) -> _Content:
        """Return the discriminator of a type code. Raises omniORB's MARSHAL."""
        try:
            if isinstance(parameters, bytes):
                return self._content_of(type_of_code(kind, parameters))
            return self._simple(kind, parameters)
        except FAILURES as error:
            raise _refused("type code", error) from error

    def _simple_content(self, kind: int, parameters: Any) -> _Content:
        return self._content_of(_read_type(kind, parameters))

    def _content_of(self, type_: Descriptor) -> _Content:
        return self._contents.get(id(type_)) or self._found(type_)

    def _found(self, type_: Descriptor) -> _Content:
        key = _key(type_)
        found = self._contents.get(key)
        if found is None:
            found = self._made(type_)
            if len(self._contents) >= _MAX_CONTENTS:
                self._contents.clear()
            self._contents[key] = self._contents[id(type_)] = found
        return found

    def _made(self, type_: Descriptor) -> _Content:
        code = _code(type_)
        if has_empty_elements(type_):
            raise Fault("an array of elements without octets")
        try:
            wire = self._make(type_)
        except MarshalError:
            wire = _by_octets(type_)
        content = _Content(next(_numbers))
        _BRANCHES[int(content)] = (int(content), "", wire.descriptor)
        content.type, content.wire = type_, wire
        content._d, content._v = code._d, code._v
        return content


def _read_type(kind: int, parameters: Any) -> Descriptor:
    if isinstance(parameters, bytes):
        return type_of_code(kind, parameters)
    numbers = [parameters]
    if isinstance(parameters, FixedDescriptor):
        numbers = [parameters.scale, parameters.digits]
    simple = simple_type(kind, lambda _: numbers.pop())
    assert simple is not None
    return simple


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


def _code(type_: Any) -> SimpleNamespace:
    """Return the type code of a type for omniORBpy to read."""
    kind, octets = type_code_octets(type_, True)
    parameters: Any = octets[4:]
    if kind in STRINGS:
        parameters = type_.bound or 0
    elif kind == FIXED:
        parameters = type_
    return SimpleNamespace(_d=kind, _v=parameters)


def _value(content: _Content, value: Any) -> AnyValue:
    """Return the value of an `any`. Raises omniORB's MARSHAL."""
    incoming = content.wire.incoming
    if incoming is None:
        return AnyValue(content.type, value)
    try:
        return AnyValue(content.type, incoming(value))
    except FAILURES as error:
        raise _refused("value of an any", error) from error


def _key(type_: Descriptor) -> Any:
    """Return a key that differs for types with different values: named types by identity."""
    match type_:
        case SequenceDescriptor(element, bound, numeric):
            return "sequence", _key(element), bound, numeric
        case ArrayDescriptor(element, dimensions, numeric):
            return "array", _key(element), dimensions, numeric
        case Named():
            return id(type_)
    return type_


def _by_octets(type_: Descriptor) -> WireType:
    """Return the type that omniORBpy constructs from the type code. Raises Fault.

    omniORBpy 4.3.3 misreads unions that switch on a wchar, and ends the process for a union whose
    first branch is the default.
    """
    for union in _unions(type_):
        first = union.branches[0]
        if plain(union.switch) == _WCHAR or (first.default and not first.labels):
            raise Fault(f"omniORBpy cannot read {union} from a type code")
    kind, octets = type_code_octets(type_, True)
    code = omniORB.cdrUnmarshal(
        CORBA._tc_TypeCode, kind.to_bytes(4, "little") + octets, 1
    )

    def outgoing(value: Any) -> Any:
        octets = encoded(ANY, AnyValue(type_, value), True)
        return omniORB.cdrUnmarshal(CORBA._tc_any, octets, 1).value()

    def incoming(value: Any) -> Any:
        octets = omniORB.cdrMarshal(CORBA._tc_any, CORBA.Any(code, value), 1)
        return decoded(ANY, octets, True).value

    return WireType(code._d, outgoing, incoming)


def _unions(type_: Descriptor) -> Iterator[UnionDescriptor]:
    """Yield the unions in a type, also those in the states of valuetypes."""
    waiting = [type_]
    seen: set[int] = set()
    while waiting:
        for part in parts(waiting.pop()):
            if id(part) in seen:
                continue
            seen.add(id(part))
            match part:
                case UnionDescriptor():
                    yield part
                case ValueDescriptor():
                    waiting += [member.type for member in part.all_members()]
                case BoxDescriptor(target=target):
                    waiting.append(target)


def _union(class_: Callable[..., Any], switch: Any, branches: dict[int, Any]) -> Any:
    """Return a descriptor of a union without default; omniORBpy reads the table only."""
    return tcInternal.tv_union, class_, "", "", switch, -1, (), None, branches


TYPE_CODE = WireType(_union(_type_of, tcInternal.tv_ulong, _PARAMETERS), _code)
"""`CORBA::TypeCode`."""
