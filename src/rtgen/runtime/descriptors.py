"""What a generated type says of itself: repository id and structure, as data.

Descriptors serve what happens rarely: the check when two ports are connected, and the search for
the place of a value that could not be marshalled. Codecs do not look at them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, Self, TypeAlias

from rtgen.runtime.cdr import Buffer


@dataclass(frozen=True, slots=True)
class PrimitiveDescriptor:
    """A basic type, by its IDL name."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class StringDescriptor:
    """`string` (`bound` in octets of UTF-8) or `wstring` (in UTF-16 units)."""

    wide: bool = False
    bound: int | None = None

    def __str__(self) -> str:
        name = "wstring" if self.wide else "string"
        return name if self.bound is None else f"{name}<{self.bound}>"


@dataclass(frozen=True, slots=True)
class FixedDescriptor:
    """`fixed<digits,scale>`."""

    digits: int
    scale: int

    def __str__(self) -> str:
        return f"fixed<{self.digits},{self.scale}>"


@dataclass(frozen=True, slots=True)
class SequenceDescriptor:
    """`sequence<element>` or `sequence<element,bound>`."""

    element: Descriptor
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"sequence<{self.element}{bound}>"


@dataclass(frozen=True, slots=True)
class ArrayDescriptor:
    """An array; dimensions outermost first."""

    element: Descriptor
    dimensions: tuple[int, ...]

    def __str__(self) -> str:
        return str(self.element) + "".join(f"[{n}]" for n in self.dimensions)


@dataclass(frozen=True, slots=True)
class MapDescriptor:
    """`map<key,value>` or `map<key,value,bound>`."""

    key: Descriptor
    value: Descriptor
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"map<{self.key},{self.value}{bound}>"


@dataclass(frozen=True, slots=True)
class _Named:
    repository_id: str
    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class EnumDescriptor(_Named):
    """An enum: its members in order, by number."""

    members: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class FlagsDescriptor(_Named):
    """A bitmask: its flags with their positions, and how many bits it has."""

    members: tuple[tuple[str, int], ...]
    bound: int


@dataclass(frozen=True, slots=True)
class StructDescriptor(_Named):
    """A struct: its members in the order of the wire, by their Python names."""

    members: tuple[tuple[str, Descriptor], ...]


@dataclass(frozen=True, slots=True)
class ExceptionDescriptor(_Named):
    """A user exception: as a struct."""

    members: tuple[tuple[str, Descriptor], ...]


@dataclass(frozen=True, slots=True)
class BranchDescriptor:
    """A branch of a union; `labels` are values of the discriminator in Python."""

    labels: tuple[int | str | bool, ...]
    default: bool
    name: str
    type: Descriptor


@dataclass(frozen=True, slots=True)
class UnionDescriptor(_Named):
    """A union: its discriminator and its branches in order."""

    switch: Descriptor
    branches: tuple[BranchDescriptor, ...]

    def branch(self, discriminator: int | str | bool) -> BranchDescriptor | None:
        """The branch that a value of the discriminator selects, or None."""
        for branch in self.branches:
            if discriminator in branch.labels:
                return branch
        return next((b for b in self.branches if b.default), None)


@dataclass(frozen=True, slots=True)
class InterfaceDescriptor(_Named):
    """An interface: the signatures of its operations and attributes, those of its bases first."""

    operations: tuple[str, ...] = ()
    bases: tuple[InterfaceDescriptor, ...] = ()

    def is_a(self, repository_id: str) -> bool:
        """Whether it is the interface of that id or derives from it."""
        own = self.repository_id == repository_id
        return own or any(base.is_a(repository_id) for base in self.bases)


@dataclass(frozen=True, slots=True)
class LinkDescriptor(_Named):
    """A type inside its own definition; equal if the name and the repository id are."""

    target: Callable[[], Descriptor] = field(compare=False, repr=False)


Descriptor: TypeAlias = (
    PrimitiveDescriptor
    | StringDescriptor
    | FixedDescriptor
    | SequenceDescriptor
    | ArrayDescriptor
    | MapDescriptor
    | EnumDescriptor
    | FlagsDescriptor
    | StructDescriptor
    | ExceptionDescriptor
    | UnionDescriptor
    | InterfaceDescriptor
    | LinkDescriptor
)


class DataType(Protocol):
    """What every generated struct and union has: a port can carry it."""

    _descriptor_: ClassVar[Any]

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """The value as a CDR body; raises CdrError."""
        ...

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of a CDR body; raises CdrError."""
        ...

    def _snapshot_(self) -> Self:
        """A copy that shares nothing that can change."""
        ...


def difference(a: Descriptor, b: Descriptor) -> str | None:
    """None if repository id and structure agree, else both types, one beside the other.

    Lines that differ are marked with `!`.
    """
    if a == b:
        return None
    left, right = list(_lines(a)), list(_lines(b))
    if left == right:
        return None
    height = max(len(left), len(right))
    left += [""] * (height - len(left))
    right += [""] * (height - len(right))
    width = max(map(len, left))
    return "\n".join(
        f"{' ' if x == y else '!'} {x.ljust(width)} | {y}".rstrip()
        for x, y in zip(left, right, strict=True)
    )


def _lines(descriptor: Descriptor) -> Iterator[str]:
    """The definition as text, with the structs inside of it taken apart."""
    if isinstance(descriptor, LinkDescriptor):
        descriptor = descriptor.target()
    if isinstance(descriptor, _Named):
        yield f"{descriptor.name}  {descriptor.repository_id}"
    yield from _inside(descriptor, "  ")


def _inside(descriptor: Descriptor, margin: str) -> Iterator[str]:
    match descriptor:
        case StructDescriptor(members=members) | ExceptionDescriptor(members=members):
            for name, type_ in members:
                yield f"{margin}{type_} {name}"
                yield from _inside(type_, margin + "  ")
        case EnumDescriptor(members=enumerators) | FlagsDescriptor(members=enumerators):
            yield margin + ", ".join(
                f"{name} = {number}" for name, number in enumerators
            )
        case UnionDescriptor(switch=switch, branches=branches):
            yield f"{margin}switch ({switch})"
            yield from _inside(switch, margin + "  ")
            for branch in branches:
                labels = [f"case {label!r}" for label in branch.labels]
                labels += ["default"] * branch.default
                yield f"{margin}{', '.join(labels)}: {branch.type} {branch.name}"
                yield from _inside(branch.type, margin + "  ")
        case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
            yield from _inside(element, margin)
        case MapDescriptor(key=key, value=value):
            yield from _inside(key, margin)
            yield from _inside(value, margin)
        case InterfaceDescriptor(operations=operations):
            for operation in operations:
                yield f"{margin}{operation}"
