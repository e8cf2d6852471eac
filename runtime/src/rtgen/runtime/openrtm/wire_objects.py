"""Parts of compiled conversions: omniORB's classes, and types that are not plain data.

Classes are looked up by repository id among those that the stubs have registered with omniORB, in
any package.
"""

from __future__ import annotations

import copyreg
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any, Final

import omniORB
from omniORB import CORBA, tcInternal

from rtgen.facts.primitives import Primitive
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    Descriptor,
    PrimitiveDescriptor,
    StringDescriptor,
)
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.numeric import listed
from rtgen.runtime.openrtm.stubs import StubsMissingError
from rtgen.runtime.values import decoded, encoded


def class_of(repository_id: str) -> Any:
    """Return omniORB's class of a struct, union or exception. Raises StubsMissingError."""
    return _described(repository_id)[1]


def items_of(repository_id: str) -> tuple[Any, ...]:
    """Return omniORB's enumerators of an enum, by number. Raises StubsMissingError."""
    items: tuple[Any, ...] = _described(repository_id)[3]
    return items


def _described(repository_id: str) -> Any:
    description = omniORB.findType(repository_id)
    while description is not None and description[0] == tcInternal.tv__indirect:
        description = description[1][0]
    if not isinstance(description, tuple):
        raise StubsMissingError(repository_id)
    return description


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


BASIC: Final[dict[str, Octets]] = {
    Primitive.ANY: Octets(ANY, CORBA.TC_any),
    Primitive.TYPE_CODE: Octets(
        PrimitiveDescriptor(Primitive.TYPE_CODE), CORBA.TC_TypeCode
    ),
    Primitive.OBJECT: Octets(PrimitiveDescriptor(Primitive.OBJECT), CORBA.TC_Object),
    Primitive.VALUE_BASE: Octets(
        PrimitiveDescriptor(Primitive.VALUE_BASE), "IDL:omg.org/CORBA/ValueBase:1.0"
    ),
}
"""Conversions of the basic types that are not plain data, by name."""
