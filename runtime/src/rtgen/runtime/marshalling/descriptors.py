"""Descriptors of generated types: repository id and structure, as data.

They are used to check types when two ports are connected, to locate a value that cannot be
marshalled, and to compile codecs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from threading import Lock
from typing import Any, ClassVar, Final, Protocol, Self, TypeAlias, TypeVar

import msgspec
from msgspec.structs import force_setattr, replace

from rtgen.runtime.marshalling.errors import Buffer
from rtgen.runtime.marshalling.numeric import Numeric

_LOCK: Final = Lock()

NEXT: Final = -1
"""Stands for the member id after that of the previous member."""


@cache
def _identity(class_: type[Description]) -> Callable[[Description], object]:
    """Return the function that reads the positional fields of a descriptor."""
    return attrgetter(*class_.__match_args__)


class Description(msgspec.Struct, frozen=True):
    """Base class of descriptors; a copy of a value refers to the same descriptors.

    Keyword-only fields do not count: two descriptors are equal if the positional ones are, and
    `repr` shows only these.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        read = _identity(type(self))
        return read(self) == read(other)

    def __hash__(self) -> int:
        return hash(_identity(type(self))(self))

    def __repr__(self) -> str:
        names: tuple[str, ...] = type(self).__match_args__
        fields = (f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__name__}({', '.join(fields)})"

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self


class PrimitiveDescriptor(Description, frozen=True, gc=False):
    """A basic type, by its IDL name; `null` and `void` are types without values."""

    name: str

    def __str__(self) -> str:
        return self.name


class StringDescriptor(Description, frozen=True, gc=False):
    """`string` (`bound` in octets of UTF-8) or `wstring` (in UTF-16 units)."""

    wide: bool = False
    bound: int | None = None

    def __str__(self) -> str:
        name = "wstring" if self.wide else "string"
        return name if self.bound is None else f"{name}<{self.bound}>"


class FixedDescriptor(Description, frozen=True):
    """`fixed<digits,scale>`."""

    digits: int
    scale: int

    def __str__(self) -> str:
        return f"fixed<{self.digits},{self.scale}>"


class _InPython(Description, frozen=True, kw_only=True):
    """A type of many items; `numeric` is their form in Python."""

    numeric: Numeric = "list"


class SequenceDescriptor(_InPython, frozen=True):
    """`sequence<element>` or `sequence<element,bound>`."""

    element: Descriptor
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"sequence<{self.element}{bound}>"


class ArrayDescriptor(_InPython, frozen=True):
    """An array; dimensions outermost first."""

    element: Descriptor
    dimensions: tuple[int, ...]

    def __str__(self) -> str:
        return str(self.element) + "".join(f"[{n}]" for n in self.dimensions)


class MapDescriptor(Description, frozen=True):
    """`map<key,value>` or `map<key,value,bound>`."""

    key: Descriptor
    value: Descriptor
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"map<{self.key},{self.value}{bound}>"


class _Marshalled(Description, frozen=True, kw_only=True):
    """A type with codecs: `class_` is its Python class or None.

    `representation` is the version of XCDR that `to_cdr` writes, 0 for classic CDR.
    """

    representation: int = 0
    class_: Any = None
    compiled: dict[Any, Any] | None = None

    @property
    def codecs(self) -> dict[Any, Any]:
        """The compiled functions; most types of a module have none."""
        codecs = self.compiled
        if codecs is None:
            with _LOCK:
                codecs = {} if self.compiled is None else self.compiled
                force_setattr(self, "compiled", codecs)
        return codecs


class Named(_Marshalled, frozen=True):
    """A named type."""

    repository_id: str
    name: str

    def __str__(self) -> str:
        return self.name


class _Initialized(Named, frozen=True, kw_only=True):
    """A type with a default, which does not count when types are compared.

    `initial` is a scalar, or the items of a list in a row; None is the implicit value of the type.
    """

    initial: Any = None


class AliasDescriptor(_Initialized, frozen=True):
    """A typedef; types that use it are compared by its target."""

    target: Descriptor

    def __str__(self) -> str:
        return str(self.target)


class EnumDescriptor(_Initialized, frozen=True):
    """An enum: its members in order with their numbers, and its size in bits.

    `initial` is the number with which values start, if it is not that of the first member.
    """

    members: tuple[tuple[str, int], ...]
    bound: int = 32

    @property
    def code(self) -> str:
        """The `struct` code of classic CDR: signed if a number is negative."""
        return "i" if any(number < 0 for _, number in self.members) else "I"


class FlagsDescriptor(Named, frozen=True):
    """A bitmask: its flags with their positions, and its size in bits."""

    members: tuple[tuple[str, int], ...]
    bound: int


class BitfieldDescriptor(msgspec.Struct, frozen=True):
    """A field of a bitset: its width and its lowest bit, the least significant one being 0.

    `signed`: it is in two's complement; `boolean`: its one bit is a boolean.
    """

    name: str
    bits: int
    position: int
    signed: bool = False
    boolean: bool = False
    attribute: str = ""

    def __post_init__(self) -> None:
        if not self.attribute:
            force_setattr(self, "attribute", self.name)

    def packed(self, value: int) -> int:
        """Return the bits of a value. Raises ValueError if it does not fit."""
        lowest, beyond = 0, 1 << self.bits
        if self.signed:
            lowest, beyond = -beyond // 2, beyond // 2
        if not lowest <= value < beyond:
            raise ValueError(f"{value!r} does not fit into {self.bits} bits")
        return value & ((1 << self.bits) - 1)

    def unpacked(self, number: int) -> int:
        """Return the value of the field in the number of its bitset."""
        value = number >> self.position & ((1 << self.bits) - 1)
        if self.boolean:
            return bool(value)
        if self.signed and value >> self.bits - 1:
            value -= 1 << self.bits
        return value


class BitsetDescriptor(Named, frozen=True):
    """A bitset: its named fields, those of its base first, and its size in bits."""

    fields: tuple[BitfieldDescriptor, ...]
    bound: int


class MemberDescriptor(msgspec.Struct, frozen=True, gc=False):
    """A member of a struct: its name in the definition, its type, and its attribute in Python.

    `private` applies to the state of a valuetype.

    `id` is the member id of DDS-XTypes (1.3, 7.3.1.2.1); NEXT stands for the one after that of the
    previous member. It is replaced by the number in the descriptor of the struct, and an empty
    attribute by the name.

    Without `gc`, modules of types are imported with fewer collections. A recursive type stays in
    memory even if nothing refers to it any more.
    """

    name: str
    type: Descriptor
    attribute: str = ""
    id: int = NEXT
    optional: bool = False
    key: bool = False
    must_understand: bool = False
    external: bool = False
    private: bool = False


class StructDescriptor(Named, frozen=True):
    """A struct: its members in wire order, those of its bases first.

    `extensibility` is `final`, `appendable` or `mutable`; `nested`: it is not a topic type.
    `opaque`: only its name was known when it was generated.
    """

    members: tuple[MemberDescriptor, ...]
    extensibility: str = "final"
    nested: bool = False
    opaque: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "members", _numbered(self.members, 0))


class ExceptionDescriptor(Named, frozen=True):
    """A user exception, with the attributes of a struct."""

    members: tuple[MemberDescriptor, ...]

    def __post_init__(self) -> None:
        force_setattr(self, "members", _numbered(self.members, 0))


class _InitializedBranch(Description, frozen=True, kw_only=True, gc=False):
    """A branch with a default, as `_Initialized` has it."""

    initial: Any = None


class BranchDescriptor(_InitializedBranch, frozen=True, gc=False):
    """A branch of a union; `labels` are Python values of the discriminator."""

    labels: tuple[int | str | bool, ...]
    default: bool
    name: str
    type: Descriptor
    attribute: str = ""
    id: int = NEXT
    external: bool = False


class UnionDescriptor(Named, frozen=True):
    """A union: its discriminator (member id 0) and its branches in order."""

    switch: Descriptor
    branches: tuple[BranchDescriptor, ...]
    extensibility: str = "final"
    nested: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "branches", _numbered(self.branches, 1))

    def branch(self, discriminator: int | str | bool) -> BranchDescriptor | None:
        """Return the branch selected by a discriminator, or None."""
        for branch in self.branches:
            if discriminator in branch.labels:
                return branch
        return next((b for b in self.branches if b.default), None)


class InterfaceDescriptor(Named, frozen=True):
    """An interface: signatures of its operations and attributes, those of its bases first.

    `opaque`: only its name was known when it was generated.
    """

    operations: tuple[str, ...] = ()
    bases: tuple[InterfaceDescriptor, ...] = ()
    local: bool = False
    abstract: bool = False
    opaque: bool = False

    def is_a(self, repository_id: str) -> bool:
        """Return whether it is the interface of that id or derives from it."""
        return repository_id in lineage(self)


class ValueDescriptor(Named, frozen=True):
    """A valuetype: its own state, its bases, and its modifier: custom, abstract, truncatable."""

    members: tuple[MemberDescriptor, ...]
    bases: tuple[ValueDescriptor, ...] = ()
    modifier: str = ""

    def concrete_base(self) -> ValueDescriptor | None:
        """Return the base with state; None if there is none."""
        return next((b for b in self.bases if b.modifier != "abstract"), None)

    def all_members(self) -> tuple[MemberDescriptor, ...]:
        """Return the state, that of the base first."""
        base = self.concrete_base()
        return self.members if base is None else base.all_members() + self.members

    def truncates_to(self) -> tuple[str, ...]:
        """Return the ids of the bases to which a value can be truncated, the nearest first."""
        base = self.concrete_base()
        if self.modifier != "truncatable" or base is None:
            return ()
        return (base.repository_id, *base.truncates_to())

    def is_a(self, repository_id: str) -> bool:
        """Return whether it is the valuetype of that id or derives from it."""
        return repository_id in lineage(self)


_Derived = TypeVar("_Derived", InterfaceDescriptor, ValueDescriptor)


def lineage(descriptor: _Derived) -> dict[str, _Derived]:
    """Return the descriptor and all its bases by repository id."""
    classes: dict[str, _Derived] = {}
    waiting = [descriptor]
    while waiting:
        each = waiting.pop()
        if each.repository_id not in classes:
            classes[each.repository_id] = each
            waiting += reversed(each.bases)
    return classes


class BoxDescriptor(Named, frozen=True):
    """A boxed value."""

    target: Descriptor

    def truncates_to(self) -> tuple[str, ...]:
        """Return no ids: boxes cannot be truncated."""
        return ()

    def is_a(self, repository_id: str) -> bool:
        """Return whether it is the box of that id."""
        return self.repository_id == repository_id


class LinkDescriptor(Named, frozen=True, kw_only=True):
    """A reference to a type inside its own definition; equal if name and repository id are."""

    target: Callable[[], Descriptor]


_E = TypeVar("_E", MemberDescriptor, BranchDescriptor)


def _numbered(entries: tuple[_E, ...], first: int) -> tuple[_E, ...]:
    """Return the members with their ids and attributes resolved."""
    for entry in entries:
        if entry.id == NEXT or not entry.attribute:
            break
    else:
        return entries
    numbered = []
    following = first
    for entry in entries:
        number = following if entry.id == NEXT else entry.id
        attribute = entry.attribute or entry.name
        numbered.append(replace(entry, id=number, attribute=attribute))
        following = number + 1
    return tuple(numbered)


def bind(class_: Any, descriptor: EnumDescriptor | FlagsDescriptor) -> None:
    """Set the descriptor of an enum or bitmask, whose class body cannot contain it."""
    class_._descriptor_ = descriptor
    register(class_, descriptor)


def plain(descriptor: Descriptor) -> Descriptor:
    """Resolve typedefs, and the link of a recursive type."""
    while isinstance(descriptor, AliasDescriptor | LinkDescriptor):
        if isinstance(descriptor, AliasDescriptor):
            descriptor = descriptor.target
        else:
            descriptor = descriptor.target()
    return descriptor


Descriptor: TypeAlias = (
    PrimitiveDescriptor
    | AliasDescriptor
    | StringDescriptor
    | FixedDescriptor
    | SequenceDescriptor
    | ArrayDescriptor
    | MapDescriptor
    | EnumDescriptor
    | FlagsDescriptor
    | BitsetDescriptor
    | StructDescriptor
    | ExceptionDescriptor
    | UnionDescriptor
    | InterfaceDescriptor
    | ValueDescriptor
    | BoxDescriptor
    | LinkDescriptor
)

ANY: Final = PrimitiveDescriptor("any")
"""The type `any`."""

NULL: Final = PrimitiveDescriptor("null")
"""The type without values."""

UNKNOWN: Final[dict[type[Description], Any]] = {}
"""Classes of values without a generated type, by class of descriptor; filled by `values`."""

_REGISTERED: dict[str, Named] = {}
_OUTDATED: list[dict[Any, Any]] = []
"""Tables that depend on the registered types."""
_T = TypeVar("_T", bound=dict[Any, Any])


def register(class_: type[Any], descriptor: Named) -> None:
    """Register the class of values of the descriptor.

    Of two types with one repository id, the last one is registered.
    """
    force_setattr(descriptor, "class_", class_)
    if descriptor.repository_id:
        _REGISTERED[descriptor.repository_id] = descriptor
        for table in _OUTDATED:
            table.clear()


def until_registration(table: _T) -> _T:
    """Return the table, which is cleared when a type is registered."""
    _OUTDATED.append(table)
    return table


def registered(repository_id: str) -> Descriptor | None:
    """Return the generated type's descriptor by repository id; None if there is none."""
    descriptor: Any = _REGISTERED.get(repository_id)
    return descriptor  # type: ignore[no-any-return]


def class_of(descriptor: Descriptor) -> Any:
    """Return the class of the descriptor's values; None if there is none."""
    return getattr(descriptor, "class_", None)


class DataType(Protocol):
    """Interface of generated structs and unions, the types of data ports."""

    _descriptor_: ClassVar[Any]

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """Return the value as a CDR body; raises CdrError."""
        ...

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """Return the value of a CDR body; raises CdrError."""
        ...

    def _snapshot_(self) -> Self:
        """Return a copy that shares nothing that can change."""
        ...
