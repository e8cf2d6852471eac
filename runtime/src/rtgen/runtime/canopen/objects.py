"""Typed access to the values of an object dictionary: base class of generated `<Module>Objects`.

A generated class has an `Entry` for each object, and is the only table of a device: `descriptions`
returns the content of a `DeviceDescription`, and an instance reads and writes values, by attribute
or by name:

- a device's own values: `self.objects` of its component;
- those of a node by SDO: `self.objects` of its proxy;
- those of a node by the service port of its proxy, from any other component: `over_service`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, Protocol, Self, TypeAlias, TypeVar, cast, overload

from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import (
    Kind,
    ObjectDescription,
    ObjectNumber,
    ObjectValue,
)
from rtgen.runtime.canopen.hooks import Getter, ProxyHooks, Setter

T = TypeVar("T")


class Objects:
    """Values by the names of their objects: `objects.Controlword` and `objects["Controlword"]`.

    Iterating yields the names. Raises KeyError for an unknown name, and the exceptions of reading
    and writing.
    """

    # No clash with objects: identifiers of objects start with a letter.
    __slots__ = ("_get", "_set")

    def __init__(self, get: Getter, set_: Setter) -> None:
        self._get = get
        self._set = set_

    def __getitem__(self, name: str) -> ObjectValue:
        return cast("ObjectValue", self._get(_entry(type(self), name).number))

    def __setitem__(self, name: str, value: ObjectValue) -> None:
        self._set(_entry(type(self), name).number, value)

    def __iter__(self) -> Iterator[str]:
        return iter(_entries(type(self)))


class Entry(Generic[T]):
    """Attribute for an object, with its part of the device's description."""

    __slots__ = ("description", "number")

    def __init__(
        self,
        kind: Kind,
        index: int,
        subindex: int,
        access: str,
        default: ObjectValue | None = None,
        *,
        low: int | float | None = None,
        high: int | float | None = None,
        relative: bool = False,
        mappable: bool = False,
    ) -> None:
        self.number = index, subindex
        self.description = ObjectDescription(
            index, subindex, "", kind, access, default, low, high, relative, mappable
        )

    def __set_name__(self, owner: type[Objects], name: str) -> None:
        self.description = self.description.named(name)

    @overload
    def __get__(self, owner: None, class_: type[Objects]) -> Self: ...

    @overload
    def __get__(self, owner: Objects, class_: type[Objects]) -> T: ...

    def __get__(self, owner: Objects | None, class_: type[Objects]) -> Self | T:
        return self if owner is None else cast("T", owner._get(self.number))

    def __set__(self, owner: Objects, value: T) -> None:
        owner._set(self.number, cast("Any", value))


Boolean: TypeAlias = Entry[bool]
Integer: TypeAlias = Entry[int]
"""Integers, and times in ns: a time of day since 1970 (UTC)."""
Real: TypeAlias = Entry[float]
Text: TypeAlias = Entry[str]
Octets: TypeAlias = Entry[bytes]

O = TypeVar("O", bound=Objects)  # noqa: E741


def descriptions(class_: type[Objects]) -> tuple[ObjectDescription, ...]:
    """Return the objects of a device, in the order of its description."""
    return tuple(entry.description for entry in _entries(class_).values())


class ObjectDictionary(Protocol):
    """The operations of a consumer of the service `CANopen::ObjectDictionary`."""

    def read(self, index: int, subindex: int, /) -> bytes:
        """Return the octets of an object."""

    def write(self, index: int, subindex: int, value: bytes, /) -> None:
        """Set the octets of an object."""


def over_service(class_: type[O], service: ObjectDictionary) -> O:
    """Access the objects of a node by the SDO service of its proxy.

    `service` is a consumer of the proxy's port `sdo`. Raises the exceptions of the service
    (CANopen::SdoAbort, CANopen::BusGone), and ObjectValueError for a value that is invalid for an
    object, or octets that are not a value of it.
    """
    kinds = {
        entry.number: entry.description.kind for entry in _entries(class_).values()
    }

    def get(number: ObjectNumber) -> ObjectValue:
        return values.uploaded(kinds[number], service.read(*number))

    def set_(number: ObjectNumber, value: ObjectValue) -> None:
        service.write(*number, values.encode(kinds[number], value))

    return class_(get, set_)


def over_sdo(class_: type[O], proxy: ProxyHooks) -> O:
    """Access the objects of a node by its proxy. Raises as `read_object` and `write_object`."""
    return class_(
        lambda number: proxy.read_object(*number),
        lambda number, value: proxy.write_object(*number, value),
    )


def _entries(class_: type[Objects]) -> dict[str, Entry[Any]]:
    return {k: v for k, v in vars(class_).items() if isinstance(v, Entry)}


def _entry(class_: type[Objects], name: str) -> Entry[Any]:
    entry = vars(class_).get(name)
    if not isinstance(entry, Entry):
        device = class_.__name__.removesuffix("Objects")
        raise KeyError(f"{device} has no object {name!r}")
    return entry
