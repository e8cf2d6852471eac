"""Properties of a model's types in CDR: which have a codec, and what the codec must handle.

The runtime compiles the codecs from descriptors of the types.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import prod

from rtgen.compiler.layouts.representations import Representations, member_types
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Case,
    Declaration,
    Enum,
    Extensibility,
    FixedType,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.graphs import in_circles, leading_to
from rtgen.facts.primitives import SCALARS

_DYNAMIC = frozenset((Primitive.ANY, Primitive.TYPE_CODE, Primitive.VALUE_BASE))

MAX_LOOPS = 12
"""Maximum nesting of sequences without a struct or union between them."""


class NotMarshalledError(Exception):
    """A type without a (supported) layout in classic CDR; the message has type and reason."""


class CdrTypes:
    """Properties of the types of a model."""

    def __init__(self, model: Model, representations: Representations) -> None:
        self._model = model
        self._representations = representations
        self._octets: dict[Type, int] = {}

    @cached_property
    def _composites(self) -> list[Struct | Union]:
        declarations = self._model.declarations
        return [d for d in declarations if isinstance(d, Struct | Union)]

    @cached_property
    def _uses(self) -> dict[ScopedName, set[ScopedName]]:
        """The named types used by members of structs and unions."""
        return {
            name: {leaf.name for leaf in leaves if isinstance(leaf, NamedType)}
            for name, leaves in self._leaves.items()
        }

    @cached_property
    def _leaves(self) -> dict[ScopedName, set[Type]]:
        """The types of the innermost elements of each struct and union."""
        return {d.name: set(map(self._leaf, member_types(d))) for d in self._composites}

    @cached_property
    def _recursive(self) -> frozenset[ScopedName]:
        return frozenset(in_circles(self._uses))

    @cached_property
    def _places(self) -> dict[ScopedName, int]:
        return {d.name: i for i, d in enumerate(self._model.declarations)}

    @cached_property
    def _dynamic(self) -> set[ScopedName]:
        names = [
            name
            for name, leaves in self._leaves.items()
            if any(map(self._is_dynamic_leaf, leaves))
        ]
        return leading_to(self._uses, names)

    @cached_property
    def _headed(self) -> set[ScopedName]:
        names = [d.name for d in self._composites if self._holds_headers(d)]
        return leading_to(self._uses, names)

    def _leaf(self, type_: Type) -> Type:
        """Return the named or basic type of a type's innermost elements, of maps their values."""
        while type_.__class__ is not PrimitiveType:
            type_ = self._model.unalias(type_)
            match type_:
                case SequenceType(element) | ArrayType(element):
                    type_ = element
                case MapType(value=value):
                    type_ = value
                case _:
                    return type_
        return type_

    def is_recursive(self, name: ScopedName) -> bool:
        """Return whether values of the struct or union can contain values of the same type."""
        return name in self._recursive

    def is_unset(self, holder: Declaration, entry: Member | Case) -> bool:
        """Return whether a member is None until it is assigned."""
        if not entry.external:
            return False
        type_ = self._model.unalias(entry.type)
        return (
            isinstance(type_, NamedType)
            and isinstance(self._model.find(type_.name), Struct | Union)
            and (
                type_.name in self._recursive
                or self._places[type_.name] >= self._places[holder.name]
            )
        )

    def holds_dynamic(self, name: ScopedName) -> bool:
        """Return whether values of the struct or union contain one marshalled by its descriptor."""
        return name in self._dynamic

    def is_dynamic(self, type_: Type) -> bool:
        """Return whether values of the type contain one marshalled by its descriptor."""
        leaf = self._leaf(type_)
        named = isinstance(leaf, NamedType) and leaf.name in self._dynamic
        return named or self._is_dynamic_leaf(leaf)

    def has_headers(self, type_: Type) -> bool:
        """Return whether the type has member headers in XCDR1: optional members, mutable types."""
        leaf = self._leaf(type_)
        return isinstance(leaf, NamedType) and leaf.name in self._headed

    def _holds_headers(self, declaration: Struct | Union) -> bool:
        entries: Sequence[Member | Case] = (
            declaration.members
            if isinstance(declaration, Struct)
            else declaration.cases
        )
        for entry in entries:
            if isinstance(entry, Member) and entry.optional:
                return True
            if entry.external and self.is_unset(declaration, entry):
                return True
        extensibility = self._representations.extensibility(declaration)
        return extensibility is Extensibility.MUTABLE

    def _is_dynamic_leaf(self, type_: Type) -> bool:
        if isinstance(type_, PrimitiveType):
            return type_.kind in _DYNAMIC
        if not isinstance(type_, NamedType):
            return False
        declaration = self._model.find(type_.name)
        if isinstance(declaration, Interface):
            return declaration.abstract
        return isinstance(declaration, Valuetype | ValueBox)

    def check(self, type_: Type) -> int:
        """Return the minimum number of octets of a value. Raises NotMarshalledError."""
        octets = self._octets.get(type_)
        if octets is None:
            octets = self._octets[type_] = self._check(type_)
        return octets

    def _check(self, type_: Type) -> int:
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(Primitive.OBJECT):
                return 8
            case PrimitiveType(Primitive.WCHAR):
                return 3
            case PrimitiveType(kind) if kind in _DYNAMIC:
                return 4
            case PrimitiveType(kind):
                if kind not in SCALARS:
                    raise NotMarshalledError(f"`{kind}` has no representation in CDR")
                return SCALARS[kind].size
            case StringType():
                return 4
            case FixedType(digits):
                return digits // 2 + 1
            case SequenceType(element):
                self._check_loops(type_)
                if self.check(element) == 0:
                    raise NotMarshalledError(
                        "a sequence of empty elements: its count cannot be checked"
                    )
                return 4
            case ArrayType(element, dimensions):
                self._check_loops(type_)
                return prod(dimensions) * self.check(element)
            case MapType(key, value):
                self._check_loops(type_)
                self.check(key)
                self.check(value)
                return 4
            case NamedType(name):
                return self._check_named(name)

    def _check_named(self, name: ScopedName) -> int:
        declaration = self._model.find(name)
        match declaration:
            case Enum():
                return 4
            case Bitmask() | Bitset():
                return 1
            case Valuetype(custom=True):
                raise NotMarshalledError(
                    f"`{declaration.scoped}` is custom: its user marshals its state"
                )
            case Valuetype() | ValueBox():
                return 4
            case Interface(local=True):
                raise NotMarshalledError(
                    f"`{declaration.scoped}` is local: it does not leave its process"
                )
            case Interface(abstract=abstract):
                return 5 if abstract else 8
            case Union():
                return self.check(declaration.switch)
            case Struct() if name in self._recursive:
                return 1
            case Struct():
                return sum(self.check(type_) for type_ in member_types(declaration))
        kind = type(declaration).__name__.lower()
        raise NotMarshalledError(
            f"`{declaration.scoped}` ({kind}) is not marshalled by CDR codecs here"
        )

    def _check_loops(self, type_: Type) -> None:
        if self._loops(type_) > MAX_LOOPS:
            raise NotMarshalledError(
                f"sequences are nested more than {MAX_LOOPS} deep: put a struct between"
            )

    def _loops(self, type_: Type) -> int:
        """Return the nesting depth of loops in the type's codec."""
        type_ = self._model.unalias(type_)
        match type_:
            case SequenceType(element):
                return int(not self._is_fixed(element)) + self._loops(element)
            case ArrayType(element, dimensions):
                loops = 0 if self._is_fixed(element) else len(dimensions)
                return loops + self._loops(element)
            case MapType(_, value):
                return 1 + self._loops(value)
        return 0

    def _is_fixed(self, type_: Type) -> bool:
        """Return whether values have a fixed size, so that sequences of them need no loop."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind):
                return kind in SCALARS or kind is Primitive.WCHAR
            case FixedType():
                return True
            case ArrayType(element):
                return self._is_fixed(element)
            case NamedType(name):
                return isinstance(self._model.find(name), Enum | Bitmask | Bitset)
        return False


def enum_code(declaration: Enum) -> str:
    """Return the `struct` code of enumerators: four octets, signed if one is negative."""
    return "i" if any(member.value < 0 for member in declaration.members) else "I"


def bit_count(model: Model, bitset: Bitset) -> int:
    """Return the number of bits of a bitset, including its bases."""
    levels = model.lineage(bitset)
    return sum(field.bits for each in levels for field in each.members)
