"""Classes of the types that a model declares, without generated code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import msgspec
from msgspec.structs import force_setattr

from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Case,
    Declaration,
    Enum,
    EnumeratorName,
    FixedType,
    MapType,
    Member,
    Model,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
)
from rtgen.compiler.model.initial import discriminator, selected
from rtgen.facts.primitives import Primitive
from rtgen.runtime.cdr import Aggregated, Enumeration, Flags
from rtgen.runtime.cdr import Bitset as BitsetBase
from rtgen.runtime.cdr import Union as UnionBase
from rtgen.runtime.marshalling.descriptors import (
    NEXT,
    AliasDescriptor,
    ArrayDescriptor,
    BitfieldDescriptor,
    BitsetDescriptor,
    BranchDescriptor,
    DataType,
    Descriptor,
    EnumDescriptor,
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
    plain,
)
from rtgen.runtime.marshalling.dynamic.initial import initial_value

_Field: TypeAlias = tuple[str, Callable[[], Any]]
"""The attribute of a member, and the function that makes its initial value."""


class NoTypeError(Exception):
    """A name is not declared, or its declaration is not a type of data."""


class Types:
    """Descriptors and classes of a model's declarations.

    Names of attributes and classes are numbers, so that names in the file never become code. With
    `own_names`, for rtgen's own files, attributes have the names of the members.
    """

    def __init__(self, model: Model, *, own_names: bool = False) -> None:
        self._model = model
        self._own_names = own_names
        self._descriptors: dict[ScopedName, Descriptor] = {}
        self._under_way: set[ScopedName] = set()

    def named(self, name: ScopedName, title: str = "") -> Descriptor:
        """Return the descriptor of a declaration. Raises NoTypeError."""
        descriptor = self._descriptors.get(name)
        if descriptor is not None:
            return descriptor
        scoped = "::".join(name)
        if name in self._under_way:
            return LinkDescriptor("", scoped, target=lambda: self._descriptors[name])
        try:
            declaration = self._model.find(name)
        except KeyError:
            raise NoTypeError(f"it declares no {title or scoped}") from None
        self._under_way.add(name)
        descriptor = self._descriptors[name] = self._described(declaration, scoped)
        return descriptor

    def request(self, name: str, members: Sequence[Member]) -> type[DataType] | None:
        """Return the class of an operation's request; None without members. Raises NoTypeError."""
        if not members:
            return None
        struct = Struct(
            name=(name,),
            members=tuple(members),
            span=members[0].span,
            file="",
            repository_id="",
        )
        descriptor = self._described(struct, f"{name} request")
        class_: type[DataType] = descriptor.class_  # type: ignore[union-attr]
        return class_

    def _type(self, type_: Type) -> Descriptor:
        match type_:
            case PrimitiveType(kind):
                return PrimitiveDescriptor(kind)
            case StringType(wide, bound):
                return StringDescriptor(wide, bound)
            case SequenceType(element, bound):
                return SequenceDescriptor(self._type(element), bound)
            case MapType(key, value, bound):
                return MapDescriptor(self._type(key), self._type(value), bound)
            case ArrayType(element, dimensions):
                return ArrayDescriptor(self._type(element), dimensions)
            case FixedType(digits, scale):
                return FixedDescriptor(digits, scale)
            case NamedType(name):
                return self.named(name)

    def _described(self, declaration: Declaration, name: str) -> Descriptor:
        match declaration:
            case Struct():
                described = StructDescriptor(
                    "",
                    name,
                    self._members(declaration),
                    declaration.extensibility,
                    declaration.nested,
                )
                inherited = self._model.members(declaration)
                fields = zip(described.members, inherited, strict=True)
                _class(Aggregated, described, [self._field(*field) for field in fields])
                return described
            case Union():
                switch = self._type(declaration.switch)
                cases = enumerate(declaration.cases)
                branches = tuple(self._branch(switch, *each) for each in cases)
                union = UnionDescriptor(
                    "",
                    name,
                    switch,
                    branches,
                    declaration.extensibility,
                    declaration.nested,
                )
                _class(UnionBase, union, self._union_fields(declaration, union))
                return union
            case Enum(members=entries, bound=bound):
                numbers = tuple((entry.name, entry.value) for entry in entries)
                first = declaration.initial.value
                enum = EnumDescriptor("", name, numbers, bound, initial=first)
                return _numbered(Enumeration, enum, lambda number: number)
            case Bitmask(members=entries, bound=bound):
                numbers = tuple((entry.name, entry.value) for entry in entries)
                flags = FlagsDescriptor("", name, numbers, bound)
                return _numbered(Flags, flags, lambda position: 1 << position)
            case Bitset():
                bitset = self._bitset(declaration, name)
                _class(BitsetBase, bitset, self._bit_fields(declaration, bitset))
                return bitset
            case Typedef(type=type_, initial=initial):
                target = self._type(type_)
                return AliasDescriptor(
                    "", name, target, initial=_initial(target, initial)
                )
        raise NoTypeError(f"{name} is not a type of data")

    def _field(self, described: MemberDescriptor, member: Member) -> _Field:
        """Return the field of a member, with the value that it starts with."""
        type_ = described.type
        unset = member.optional or isinstance(type_, LinkDescriptor)
        default = _initial(type_, member.initial)
        make = partial(initial_value, type_, default)
        return described.attribute, (lambda: None) if unset else make

    def _union_fields(self, union: Union, described: UnionDescriptor) -> list[_Field]:
        label = _label(described.switch, discriminator(self._model, union))
        case = selected(self._model, union)
        value = partial(_branch_value, None)
        if case is not None:
            value = partial(_branch_value, described.branches[union.cases.index(case)])
        return [("discriminator", lambda: label), ("value", value)]

    def _bit_fields(self, bitset: Bitset, described: BitsetDescriptor) -> list[_Field]:
        levels = self._model.lineage(bitset)
        named = [f for level in levels for f in level.members if f.name]
        return [
            (entry.attribute, partial(int, field.initial or 0))
            for entry, field in zip(described.fields, named, strict=True)
        ]

    def _members(self, struct: Struct) -> tuple[MemberDescriptor, ...]:
        return tuple(
            MemberDescriptor(
                member.name,
                self._type(member.type),
                member.name if self._own_names else f"m{number}",
                NEXT if member.id is None else member.id,
                member.optional,
                member.key,
                member.must_understand,
                member.external,
            )
            for number, member in enumerate(self._model.members(struct))
        )

    def _branch(self, switch: Descriptor, number: int, case: Case) -> BranchDescriptor:
        type_ = self._type(case.type)
        return BranchDescriptor(
            tuple(_label(switch, label) for label in case.labels),
            case.default,
            case.name,
            type_,
            f"m{number}",
            NEXT if case.id is None else case.id,
            case.external,
            initial=_initial(type_, case.initial),
        )

    def _bitset(self, declaration: Bitset, name: str) -> BitsetDescriptor:
        levels = self._model.lineage(declaration)
        position = 0
        fields: list[BitfieldDescriptor] = []
        for field in (field for level in levels for field in level.members):
            kind = field.type.kind if isinstance(field.type, PrimitiveType) else None
            if field.name is not None:
                fields.append(
                    BitfieldDescriptor(
                        field.name,
                        field.bits,
                        position,
                        kind in _SIGNED,
                        kind is Primitive.BOOLEAN,
                        f"m{len(fields)}",
                    )
                )
            position += field.bits
        return BitsetDescriptor("", name, tuple(fields), position)


_SIGNED = (Primitive.INT8, Primitive.SHORT, Primitive.LONG, Primitive.LONG_LONG)


def _class(base: Any, descriptor: Any, fields: list[_Field]) -> None:
    """Give a descriptor a class with these attributes."""
    msgspec.defstruct(
        "Described",
        [(name, Any, msgspec.field(default_factory=make)) for name, make in fields],
        bases=(base,),
        namespace={"_descriptor_": descriptor},
        frozen=base is BitsetBase,
    )


def _numbered(
    base: Any,
    descriptor: EnumDescriptor | FlagsDescriptor,
    number: Callable[[int], int],
) -> EnumDescriptor | FlagsDescriptor:
    """Give an enum or a bitmask a class."""
    values = {f"m{place}": number(n) for place, (_, n) in enumerate(descriptor.members)}
    class_ = base("Described", values)
    class_._descriptor_ = descriptor
    force_setattr(descriptor, "class_", class_)
    return descriptor


def _branch_value(branch: BranchDescriptor | None) -> Any:
    return None if branch is None else initial_value(branch.type, branch.initial)


def _initial(type_: Descriptor, value: Any) -> Any:
    """Return a default of the model as that of a descriptor."""
    described = plain(type_) if value is not None else None
    if isinstance(value, tuple):
        assert isinstance(described, SequenceDescriptor | ArrayDescriptor)
        return tuple(_initial(described.element, item) for item in value)
    if isinstance(value, EnumeratorName):
        return _label(type_, value)
    return described.class_(value) if isinstance(described, FlagsDescriptor) else value


def _label(switch: Descriptor, label: Any) -> int | str | bool:
    """Return a label in Python; an enumerator is the member of its enum."""
    while isinstance(switch, AliasDescriptor):
        switch = switch.target
    if isinstance(label, EnumeratorName) and isinstance(switch, EnumDescriptor):
        number = dict(switch.members)[label.name[-1]]
        member: int = switch.class_(number)
        return member
    value: int | str | bool = label
    return value
