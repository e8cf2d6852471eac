"""Functions that make descriptors of generated types: `idl.struct("RTC::Time", ...)`.

A member is given under its Python attribute: a descriptor, a generated class, or `member` with
further properties.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple, TypeAlias, TypeVar

from msgspec.structs import force_setattr

from rtgen.facts.primitives import Primitive
from rtgen.runtime.marshalling.descriptors import (
    NEXT,
    AliasDescriptor,
    ArrayDescriptor,
    BitfieldDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    MapDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    register,
)
from rtgen.runtime.marshalling.numeric import Numeric

SHORT: Final = PrimitiveDescriptor(Primitive.SHORT)
UNSIGNED_SHORT: Final = PrimitiveDescriptor(Primitive.UNSIGNED_SHORT)
LONG: Final = PrimitiveDescriptor(Primitive.LONG)
UNSIGNED_LONG: Final = PrimitiveDescriptor(Primitive.UNSIGNED_LONG)
LONG_LONG: Final = PrimitiveDescriptor(Primitive.LONG_LONG)
UNSIGNED_LONG_LONG: Final = PrimitiveDescriptor(Primitive.UNSIGNED_LONG_LONG)
INT8: Final = PrimitiveDescriptor(Primitive.INT8)
UINT8: Final = PrimitiveDescriptor(Primitive.UINT8)
FLOAT: Final = PrimitiveDescriptor(Primitive.FLOAT)
DOUBLE: Final = PrimitiveDescriptor(Primitive.DOUBLE)
LONG_DOUBLE: Final = PrimitiveDescriptor(Primitive.LONG_DOUBLE)
CHAR: Final = PrimitiveDescriptor(Primitive.CHAR)
WCHAR: Final = PrimitiveDescriptor(Primitive.WCHAR)
BOOLEAN: Final = PrimitiveDescriptor(Primitive.BOOLEAN)
OCTET: Final = PrimitiveDescriptor(Primitive.OCTET)
ANY: Final = PrimitiveDescriptor(Primitive.ANY)
OBJECT: Final = PrimitiveDescriptor(Primitive.OBJECT)
VALUE_BASE: Final = PrimitiveDescriptor(Primitive.VALUE_BASE)
TYPE_CODE: Final = PrimitiveDescriptor(Primitive.TYPE_CODE)
VOID: Final = PrimitiveDescriptor(Primitive.VOID)
STRING: Final = StringDescriptor()
WSTRING: Final = StringDescriptor(True)

Described: TypeAlias = Any
"""A descriptor, or a class with one."""


class Traits(NamedTuple):
    """Properties that differ from the defaults.

    `representation` is the version of XCDR that `to_cdr` writes, 0 for classic CDR.
    """

    repository_id: str | None = None
    base: Any = None
    extensibility: str = "final"
    nested: bool = False
    opaque: bool = False
    representation: int = 0


traits = Traits
_DEFAULTS = Traits()


def string(bound: int) -> StringDescriptor:
    """Return the descriptor of `string<bound>`."""
    return StringDescriptor(False, bound)


def wstring(bound: int) -> StringDescriptor:
    """Return the descriptor of `wstring<bound>`."""
    return StringDescriptor(True, bound)


def fixed(digits: int, scale: int) -> FixedDescriptor:
    """Return the descriptor of `fixed<digits,scale>`."""
    return FixedDescriptor(digits, scale)


def sequence(
    element: Described, bound: int | None = None, *, numeric: Numeric = "list"
) -> SequenceDescriptor:
    """Return the descriptor of `sequence<element>` or `sequence<element,bound>`."""
    return SequenceDescriptor(_descriptor(element), bound, numeric=numeric)


def array(
    element: Described, *dimensions: int, numeric: Numeric = "list"
) -> ArrayDescriptor:
    """Return the descriptor of an array; dimensions outermost first."""
    return ArrayDescriptor(_descriptor(element), dimensions, numeric=numeric)


def dtype(class_: Any) -> Any:
    """Return the numpy dtype of a generated struct of numbers, with the padding of its layout."""
    from rtgen.runtime.marshalling.structured import dtype_of

    return dtype_of(class_)


def zeros(type_: Any, *shape: int) -> Any:
    """Return a numpy array of zeros, of a numpy scalar or a generated struct of numbers."""
    import numpy

    described = hasattr(type_, "_descriptor_")
    return numpy.zeros(shape, dtype(type_) if described else type_)


def records(class_: Any, *shape: int) -> Any:
    """Return a numpy array of a generated struct of numbers, with the defaults of its members."""
    import numpy

    from rtgen.runtime.marshalling.structured import records_of

    return numpy.full(shape, records_of([class_()], class_._descriptor_))


def map_(key: Described, value: Described, bound: int | None = None) -> MapDescriptor:
    """Return the descriptor of `map<key,value>` or `map<key,value,bound>`."""
    return MapDescriptor(_descriptor(key), _descriptor(value), bound)


def link(
    name: str, target: Callable[[], Described], repository_id: str | None = None
) -> LinkDescriptor:
    """Return a reference to a type inside its own definition, or before it."""
    return LinkDescriptor(
        _id(name, repository_id), name, target=lambda: _descriptor(target())
    )


def member(
    type_: Described,
    *,
    name: str = "",
    member_id: int = NEXT,
    optional: bool = False,
    key: bool = False,
    must_understand: bool = False,
    external: bool = False,
    private: bool = False,
) -> MemberDescriptor:
    """Return a member with properties; `name` is that in the definition, if not the attribute."""
    return MemberDescriptor(
        name,
        _descriptor(type_),
        "",
        member_id,
        optional,
        key,
        must_understand,
        external,
        private,
    )


def struct(
    name: str, traits: Traits = _DEFAULTS, /, **members: Described
) -> StructDescriptor:
    """Return the descriptor of a struct: members by attribute, after those of its base."""
    inherited = () if traits.base is None else traits.base._descriptor_.members
    return StructDescriptor(
        _id(name, traits.repository_id),
        name,
        _numbered(members, inherited),
        traits.extensibility,
        traits.nested,
        traits.opaque,
        representation=traits.representation,
    )


def exception(
    name: str, traits: Traits = _DEFAULTS, /, **members: Described
) -> ExceptionDescriptor:
    """Return the descriptor of a user exception."""
    return ExceptionDescriptor(
        _id(name, traits.repository_id),
        name,
        _numbered(members),
        representation=traits.representation,
    )


def value(
    name: str,
    modifier: str = "",
    bases: tuple[Any, ...] = (),
    repository_id: str | None = None,
    /,
    **state: Described,
) -> ValueDescriptor:
    """Return the descriptor of a valuetype, with its own state, its bases, and its modifier."""
    described = tuple(base._descriptor_ for base in bases)
    return ValueDescriptor(
        _id(name, repository_id), name, _members(state), described, modifier
    )


def box(name: str, type_: Described, repository_id: str | None = None) -> BoxDescriptor:
    """Return the descriptor of a boxed value."""
    return BoxDescriptor(_id(name, repository_id), name, _descriptor(type_))


def alias(
    name: str,
    type_: Described,
    repository_id: str | None = None,
    representation: int = 0,
    initial: Any = None,
) -> AliasDescriptor:
    """Return the descriptor of a typedef; `initial` is its default, of a list its items."""
    return AliasDescriptor(
        _id(name, repository_id),
        name,
        _descriptor(type_),
        representation=representation,
        initial=initial,
    )


def case(
    type_: Described,
    *labels: int | str | bool,
    default: bool = False,
    name: str = "",
    member_id: int = NEXT,
    external: bool = False,
    initial: Any = None,
) -> BranchDescriptor:
    """Return a branch of a union; `labels` are values of the discriminator.

    `initial` is the default of its value, of a list its items.
    """
    described = _descriptor(type_)
    return BranchDescriptor(
        labels, default, name, described, "", member_id, external, initial=initial
    )


def union(
    name: str,
    switch: Described,
    traits: Traits = _DEFAULTS,
    /,
    **cases: BranchDescriptor,
) -> UnionDescriptor:
    """Return the descriptor of a union: the discriminator, and branches by attribute, in order."""
    return UnionDescriptor(
        _id(name, traits.repository_id),
        name,
        _descriptor(switch),
        tuple(_named(branch, attribute) for attribute, branch in cases.items()),
        traits.extensibility,
        traits.nested,
        representation=traits.representation,
    )


def bits(
    width: int,
    position: int,
    *,
    signed: bool = False,
    boolean: bool = False,
    name: str = "",
) -> BitfieldDescriptor:
    """Return a field of a bitset; its lowest bit is at `position`."""
    return BitfieldDescriptor(name, width, position, signed, boolean)


def bitset(
    name: str,
    bound: int,
    repository_id: str | None = None,
    /,
    **fields: BitfieldDescriptor,
) -> BitsetDescriptor:
    """Return the descriptor of a bitset of `bound` bits, with fields by attribute."""
    named = tuple(_named(field, attribute) for attribute, field in fields.items())
    return BitsetDescriptor(_id(name, repository_id), name, named, bound)


def enum(
    class_: Any,
    name: str,
    names: Mapping[str, str] | None = None,
    bound: int = 32,
    repository_id: str | None = None,
    initial: int | None = None,
) -> None:
    """Set the descriptor of an enum, whose class body cannot; `names` differ from Python's.

    `initial` is the member with which values start, by default the first.
    """
    members = tuple(
        ((names or {}).get(attribute, attribute), int(number))
        for attribute, number in class_.__members__.items()
    )
    id_ = _id(name, repository_id)
    _bind(class_, EnumDescriptor(id_, name, members, bound, initial=initial))


def flags(
    class_: Any,
    name: str,
    names: Mapping[str, str] | None = None,
    bound: int = 32,
    repository_id: str | None = None,
) -> None:
    """Set the descriptor of a bitmask of `bound` bits."""
    members = tuple(
        ((names or {}).get(attribute, attribute), int(flag).bit_length() - 1)
        for attribute, flag in class_.__members__.items()
    )
    _bind(class_, FlagsDescriptor(_id(name, repository_id), name, members, bound))


def _bind(class_: Any, descriptor: EnumDescriptor | FlagsDescriptor) -> None:
    class_._descriptor_ = descriptor
    register(class_, descriptor)


def _id(name: str, own: str | None) -> str:
    """Return the repository id, by default that of the name (CORBA 3.3 part 1, 14.7.1)."""
    if own is not None:
        return own
    return f"IDL:{name.replace('::', '/')}:1.0"


def _descriptor(described: Described) -> Descriptor:
    descriptor: Any = getattr(described, "_descriptor_", described)
    return descriptor  # type: ignore[no-any-return]


def _members(members: Mapping[str, Described]) -> tuple[MemberDescriptor, ...]:
    return tuple(
        (
            _named(described, attribute)
            if isinstance(described, MemberDescriptor)
            else MemberDescriptor(attribute, _descriptor(described), attribute)
        )
        for attribute, described in members.items()
    )


def _numbered(
    members: Mapping[str, Described], inherited: tuple[MemberDescriptor, ...] = ()
) -> tuple[MemberDescriptor, ...]:
    """Return the inherited members and these with their ids, reusing existing descriptors."""
    entries = [*inherited]
    following = inherited[-1].id + 1 if inherited else 0
    for attribute, described in members.items():
        if isinstance(described, MemberDescriptor):
            entry = _named(described, attribute)
            if entry.id == NEXT:
                force_setattr(entry, "id", following)
        else:
            type_: Any = getattr(described, "_descriptor_", described)
            entry = MemberDescriptor(attribute, type_, attribute, following)
        following = entry.id + 1
        entries.append(entry)
    return tuple(entries)


_E = TypeVar("_E", MemberDescriptor, BranchDescriptor, BitfieldDescriptor)


def _named(entry: _E, attribute: str) -> _E:
    """Return the entry with its attribute, which is also its name by default."""
    force_setattr(entry, "attribute", attribute)
    if not entry.name:
        force_setattr(entry, "name", attribute)
    return entry
