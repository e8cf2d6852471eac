"""Text of a type's schema, with all that it depends on, from its descriptor.

IDL, called `omgidl` in MCAP's registry: self-contained, without preprocessor lines, the type by its
scoped name. For ROS 2 messages their own form (`ros_messages`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    Annotation,
    ArrayType,
    Bitfield,
    Bitmask,
    Bitset,
    Case,
    ConstantValue,
    Declaration,
    Enum,
    Enumerator,
    EnumeratorName,
    Extensibility,
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
from rtgen.compiler.typemap.idl_keywords import FOLDED
from rtgen.facts.primitives import Primitive
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    LinkDescriptor,
    MapDescriptor,
    MemberDescriptor,
    Named,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.tools.recording import ros_messages

ENCODING: Final = "omgidl"
"""Name of IDL as a schema encoding in MCAP's registry."""
ENCODINGS: Final = (ENCODING, *ros_messages.ENCODINGS)

_NO_SPAN = Span("", 1, 1, 1, 1)
_DEFAULT_BITS = 32
_KEYWORDS = frozenset({
    "any", "boolean", "case", "char", "const", "default", "double", "enum", "false",
    "fixed", "float", "long", "module", "octet", "sequence", "short", "string", "struct",
    "switch", "true", "typedef", "union", "unsigned", "wchar", "wstring",
})  # fmt: skip
"""Keywords of IDL that schemas have; Foxglove's parser takes all others as names."""
_NAMES = re.compile(
    rf'"(?:\\.|[^"\\])*"|\b({"|".join(sorted({*FOLDED} - _KEYWORDS))})\b', re.IGNORECASE
)
"""Strings, and names that are keywords of IDL."""


@dataclass(frozen=True, slots=True)
class Schema:
    """The name of a type, and a text that declares it; `encoding` is the text's language."""

    name: str
    text: str
    encoding: str = ENCODING


def schema_of(descriptor: Descriptor) -> Schema:
    """Return the schema of a struct or union. Raises TypeError for a type without IDL."""
    described: Any = plain(descriptor)
    if isinstance(described, StructDescriptor):
        message = ros_messages.message_text(described)
        if message is not None:
            name = ros_messages.message_name(described.name)
            return Schema(name, message, ros_messages.ENCODING)
    declarations = _Declarations()
    declarations.add(described)
    declared = tuple(declarations.found.values())
    text = idl_text(Model(declarations=declared), declared, escape=_spelled)
    return Schema("::".join(map(_spelled, described.name.split("::"))), text)


def _spelled(name: str) -> str:
    """Return a name as readers of schemas take it: they know few keywords, and no escapes."""
    return f"{name}_" if name.lower() in _KEYWORDS else name


def with_escapes(text: str) -> str:
    """Return a schema as IDL: names that are keywords of IDL, but not of schemas, are escaped."""
    return _NAMES.sub(lambda part: f"_{part[1]}" if part[1] else part[0], text)


class _Declarations:
    """Declarations of a type, each after those that it depends on."""

    def __init__(self) -> None:
        self.found: dict[ScopedName, Declaration] = {}
        self._begun: set[ScopedName] = set()

    def add(self, descriptor: Named) -> NamedType:
        """Declare a named type; a link refers to an enclosing declaration."""
        name = _scoped(descriptor)
        is_new = name not in self._begun
        # The typedef inside a recursive type must precede it.
        if is_new or (
            isinstance(descriptor, AliasDescriptor) and name not in self.found
        ):
            self._begun.add(name)
            self.found[name] = self._declaration(descriptor, name)
        return NamedType(name)

    def type(self, descriptor: Descriptor) -> Type:
        """Return the type expression of a member or element."""
        match descriptor:
            case PrimitiveDescriptor(name):
                return PrimitiveType(Primitive(name))
            case StringDescriptor(wide, bound):
                return StringType(wide, bound)
            case SequenceDescriptor(element, bound):
                return SequenceType(self.type(element), bound)
            case MapDescriptor(key, value, bound):
                return MapType(self.type(key), self.type(value), bound)
            case ArrayDescriptor(element, dimensions):
                return ArrayType(self.type(element), dimensions)
            case FixedDescriptor(digits, scale):
                return FixedType(digits, scale)
            case LinkDescriptor():
                target: Any = descriptor.target()
                return self.add(target)
            case _:
                return self.add(descriptor)

    def _declaration(self, descriptor: Named, name: ScopedName) -> Declaration:
        common: dict[str, Any] = {
            "span": _NO_SPAN,
            "name": name,
            "repository_id": "",
            "file": "",
        }
        match descriptor:
            case StructDescriptor():
                members = tuple(self._members(descriptor.members))
                return Struct(
                    **common,
                    members=members,
                    annotations=_of_aggregate(descriptor),
                    extensibility=Extensibility(descriptor.extensibility),
                    nested=descriptor.nested,
                )
            case UnionDescriptor():
                return Union(
                    **common,
                    switch=self.type(descriptor.switch),
                    cases=tuple(self._cases(descriptor)),
                    annotations=_of_aggregate(descriptor),
                    extensibility=Extensibility(descriptor.extensibility),
                    nested=descriptor.nested,
                )
            case EnumDescriptor(members=entries, bound=bound):
                return Enum(
                    **common,
                    members=tuple(_enumerators(entries, "value")),
                    bound=bound,
                    annotations=_bit_bound(bound),
                )
            case FlagsDescriptor(members=entries, bound=bound):
                return Bitmask(
                    **common,
                    members=tuple(_enumerators(entries, "position")),
                    bound=bound,
                    annotations=_bit_bound(bound),
                )
            case BitsetDescriptor():
                return Bitset(**common, members=tuple(_bitfields(descriptor)))
            case AliasDescriptor(target=target):
                return Typedef(**common, type=self.type(target))
        raise TypeError(f"{descriptor} has no IDL by itself")

    def _members(self, members: Iterable[MemberDescriptor]) -> Iterator[Member]:
        following = 0
        for member in members:
            yield Member(
                span=_NO_SPAN,
                name=member.name,
                type=self.type(member.type),
                optional=member.optional,
                key=member.key,
                id=member.id,
                must_understand=member.must_understand,
                external=member.external,
                annotations=tuple(_of_member(member, following)),
            )
            following = member.id + 1

    def _cases(self, union: UnionDescriptor) -> Iterator[Case]:
        following = 1
        for branch in union.branches:
            yield Case(
                span=_NO_SPAN,
                labels=tuple(_label(union, label) for label in branch.labels),
                default=branch.default,
                name=branch.name,
                type=self.type(branch.type),
                id=branch.id,
                external=branch.external,
                annotations=tuple(_of_member(branch, following)),
            )
            following = branch.id + 1


def _scoped(descriptor: Named) -> ScopedName:
    return tuple(descriptor.name.split("::"))


def _one(name: str, value: ConstantValue) -> Annotation:
    return Annotation(name, (("value", value),))


def _of_aggregate(
    descriptor: StructDescriptor | UnionDescriptor,
) -> tuple[Annotation, ...]:
    nested = (Annotation("nested"),) if descriptor.nested else ()
    return (Annotation(descriptor.extensibility), *nested)


def _of_member(
    entry: MemberDescriptor | BranchDescriptor, following: int
) -> Iterator[Annotation]:
    if entry.id != following:
        yield _one("id", entry.id)
    for trait in ("key", "optional", "must_understand", "external"):
        if getattr(entry, trait, False):
            yield Annotation(trait)


def _bit_bound(bound: int) -> tuple[Annotation, ...]:
    return () if bound == _DEFAULT_BITS else (_one("bit_bound", bound),)


def _enumerators(
    entries: Iterable[tuple[str, int]], annotation: str
) -> Iterator[Enumerator]:
    following = 0
    for name, number in entries:
        annotations = () if number == following else (_one(annotation, number),)
        yield Enumerator(
            span=_NO_SPAN, name=name, value=number, annotations=annotations
        )
        following = number + 1


def _bitfields(descriptor: BitsetDescriptor) -> Iterator[Bitfield]:
    position = 0
    for entry in descriptor.fields:
        if gap := entry.position - position:
            yield Bitfield(span=_NO_SPAN, name=None, bits=gap, type=None)
        type_ = None
        if entry.boolean:
            type_ = PrimitiveType(Primitive.BOOLEAN)
        elif entry.signed:
            type_ = PrimitiveType(_signed(entry.bits))
        yield Bitfield(span=_NO_SPAN, name=entry.name, bits=entry.bits, type=type_)
        position = entry.position + entry.bits
    if gap := descriptor.bound - position:
        yield Bitfield(span=_NO_SPAN, name=None, bits=gap, type=None)


def _signed(bits: int) -> Primitive:
    sizes = (8, Primitive.INT8), (16, Primitive.SHORT), (32, Primitive.LONG)
    return next((kind for size, kind in sizes if bits <= size), Primitive.LONG_LONG)


def _label(union: UnionDescriptor, label: int | str | bool) -> ConstantValue:
    switch = plain(union.switch)
    if isinstance(switch, EnumDescriptor):
        name = next(name for name, number in switch.members if number == int(label))
        scope = _scoped(switch)[:-1]
        # By its unscoped name in its own scope: Foxglove's parser does not resolve other forms.
        return EnumeratorName((*(() if scope == _scoped(union)[:-1] else scope), name))
    return label
