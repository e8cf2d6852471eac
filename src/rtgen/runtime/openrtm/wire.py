"""Support of generated conversions: omniORB's classes of types, and types that are not plain data.

Classes are looked up by repository id among those that the stubs have registered with omniORB, in
any package.
"""

from __future__ import annotations

import copyreg
from collections.abc import Callable, Mapping, MutableSequence, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

import omniORB
from omniORB import CORBA, tcInternal

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.runtime.corba.faults import caught
from rtgen.runtime.corba.wire_conversions import octets as octets
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    Descriptor,
    PrimitiveDescriptor,
    StringDescriptor,
)
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.numeric import NumericArray
from rtgen.runtime.marshalling.numeric import listed as listed
from rtgen.runtime.openrtm.stubs import StubsMissingError
from rtgen.runtime.services.servants import ObjectNotExist
from rtgen.runtime.values import decoded, encoded

_T = TypeVar("_T")

Reference: TypeAlias = Callable[[], Any]
"""Function that returns the omniORB object that a stub calls, or None if there is none (yet)."""


if TYPE_CHECKING:

    def new(class_: type[_T]) -> _T:
        """Return an empty object of an omniORB class, to be filled."""

else:
    new = object.__new__


def class_of(repository_id: str) -> Any:
    """Return omniORB's class of a struct, union or exception. Raises StubsMissingError."""
    return _described(repository_id)[1]


def items_of(repository_id: str) -> tuple[Any, ...]:
    """Return omniORB's enumerators of an enum, by number. Raises StubsMissingError."""
    items: tuple[Any, ...] = _described(repository_id)[3]
    return items


def _described(repository_id: str) -> Any:
    found = omniORB.findType(repository_id)
    while found is not None and found[0] == tcInternal.tv__indirect:
        found = found[1][0]
    if not isinstance(found, tuple):
        raise StubsMissingError(repository_id)
    return found


def refill(
    wires: list[Any],
    values: Sequence[Any],
    fill: Callable[[Any, Any], None],
    to: Callable[[Any], Any],
) -> None:
    """Update the list of wire objects from the values, reusing existing objects."""
    count = len(wires)
    if count != len(values):
        del wires[len(values) :]
        wires += [to(value) for value in values[count:]]
    for wire, value in zip(wires, values):  # noqa: B905  (its cost is what counts here)
        fill(wire, value)


def as_list(numbers: Any, depth: int = 1) -> list[Any]:
    """Return numbers in any form as a list; a list unchanged."""
    return numbers if numbers.__class__ is list else listed(numbers, depth)


def to_array(numbers: list[Any], code: str) -> MutableSequence[Any]:
    """Return an array of many numbers, by their type code; a list of few."""
    return NumericArray(code, numbers) if len(numbers) > MAX_LIST_LENGTH else [*numbers]


def to_numpy(numbers: list[Any], code: str) -> Any:
    """Return a numpy array of a list of numbers, or of lists."""
    import numpy

    return numpy.array(numbers, code)


def structs_of(records: Any, class_: type[_T]) -> list[_T]:
    """Convert a structured numpy array to structs; a list of structs is unchanged."""
    if isinstance(records, list):
        return records
    from rtgen.runtime.marshalling.structured import values_of

    return values_of(records, cast("Any", class_)._descriptor_)


def to_records(structs: list[Any], class_: Any) -> Any:
    """Convert structs to a structured array."""
    from rtgen.runtime.marshalling.structured import records_of

    return records_of(structs, class_._descriptor_)


def to_fixed(value: Decimal, digits: int, scale: int) -> Any:
    """Return a fixed-point number. Raises CORBA.DATA_CONVERSION for one out of range."""
    return omniORB.fixed(digits, scale, f"{value:f}")


def _made_again(value: Any) -> tuple[Callable[[str], Any], tuple[str]]:
    return omniORB.fixed, (str(value),)


# OpenRTM makes deep copies of the values with which data ports are constructed.
copyreg.pickle(type(omniORB.fixed("0")), _made_again)


def from_fixed(wire: Any) -> Decimal:
    """Return the number of omniORB's fixed-point value."""
    return Decimal(str(wire))


class Octets:
    """Conversion via CDR, of values that contain types or objects: `any`, values, references.

    `code` is a type code of omniORB, or the repository id of a type in the stubs.
    """

    def __init__(self, descriptor: Descriptor, code: Any) -> None:
        self._descriptor: Any = descriptor
        self._code = omniORB.findTypeCode(code) if isinstance(code, str) else code
        if self._code is None:
            raise StubsMissingError(code)

    def to(self, value: Any) -> Any:
        """Return the wire object of a value. Raises CdrError or a CORBA system exception."""
        octets = encoded(self._descriptor, value, True)
        return omniORB.cdrUnmarshal(self._code, octets, 1)

    def of(self, wire: Any) -> Any:
        """Return the value of a wire object. Raises CdrError or a CORBA system exception."""
        octets = omniORB.cdrMarshal(self._code, wire, 1)
        return decoded(self._descriptor, octets, True)


class ExceptionOctets(Octets):
    """Encoding of an exception, preceded by its repository id as in a reply."""

    _ID = StringDescriptor()

    def to(self, value: Any) -> Any:
        """See `Octets`."""
        out = Output()
        writer = Writer(out, True)
        writer.value(self._ID, self._descriptor.repository_id)
        writer.value(self._descriptor, value)
        return omniORB.cdrUnmarshal(self._code, bytes(out), 1)

    def of(self, wire: Any) -> Any:
        """See `Octets`."""
        reader = Reader(omniORB.cdrMarshal(self._code, wire, 1), True)
        reader.value(self._ID)
        return reader.value(self._descriptor)


ANYTHING = Octets(ANY, CORBA.TC_any)
TYPE_CODE = Octets(PrimitiveDescriptor("CORBA::TypeCode"), CORBA.TC_TypeCode)
OBJECT = Octets(PrimitiveDescriptor("Object"), CORBA.TC_Object)
VALUE = Octets(PrimitiveDescriptor("ValueBase"), "IDL:omg.org/CORBA/ValueBase:1.0")
"""Conversions of the basic types that are not plain data."""


NO_CONTEXT = CORBA.Context("", None)
"""The context of calls, which is not used."""


class Objects:
    """Conversion of the objects of an interface in arguments and results of operations.

    `servant` is the generated class that serves an object of rtgen to omniORB, `stub` the one that
    calls an object of omniORB. An object that was passed once is served until the process ends.
    """

    def __init__(self, repository_id: str, servant: type[Any], stub: type[Any]) -> None:
        skeleton = omniORB.skeletonMapping.get(repository_id)
        if skeleton is None:
            raise StubsMissingError(repository_id)
        self._class = type(servant.__name__, (servant, skeleton), {})
        self._stub = stub
        self._served: dict[int, tuple[Any, Any]] = {}

    def to(self, value: Any) -> Any:
        """Return the omniORB reference to an object; nil for None."""
        if value is None:
            return None
        if isinstance(value, self._stub):
            return value._reference()
        if id(value) not in self._served:
            self._served[id(value)] = value, self._class(value)._this()
        return self._served[id(value)][1]

    def of(self, wire: Any) -> Any:
        """Return a stub for an omniORB reference; None for nil."""
        return None if wire is None else self._stub(lambda: wire)


def called(reference: Reference) -> Any:
    """Return the object to call. Raises ObjectNotExist if there is none."""
    found = reference()
    if found is None:
        raise ObjectNotExist("no provider is connected")
    return found


_NONE: Mapping[type[Any], Callable[[Any], Exception]] = {}


def raised(
    operation: str,
    error: Exception,
    declared: Mapping[type[Any], Callable[[Any], Exception]] = _NONE,
) -> Exception:
    """Return the exception that a call through a stub raises for one of omniORB.

    `declared` are the exceptions of the operation. An exception that is not CORBA's is returned
    unchanged.
    """
    convert = declared.get(type(error))
    if convert is not None:
        return convert(error)
    if isinstance(error, CORBA.SystemException):
        return caught(operation, error)
    raise error
