"""The type table: descriptors of the runtime as nodes, from which a page creates codecs."""

from __future__ import annotations

from typing import Any, Final

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FlagsDescriptor,
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
from rtgen.runtime.marshalling.equality import same
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.ui.protocol.ui import TypeKind, TypeMember, TypeNode

NO_TYPE: Final = -1
"""The number of a type without a codec in a page."""

_BASIC: Final = {
    "boolean": TypeKind.TYPE_BOOLEAN,
    "char": TypeKind.TYPE_CHAR,
    "wchar": TypeKind.TYPE_WCHAR,
    "octet": TypeKind.TYPE_OCTET,
    "uint8": TypeKind.TYPE_OCTET,
    "int8": TypeKind.TYPE_INT8,
    "short": TypeKind.TYPE_SHORT,
    "unsigned short": TypeKind.TYPE_USHORT,
    "long": TypeKind.TYPE_LONG,
    "unsigned long": TypeKind.TYPE_ULONG,
    "long long": TypeKind.TYPE_LONGLONG,
    "unsigned long long": TypeKind.TYPE_ULONGLONG,
    "float": TypeKind.TYPE_FLOAT,
    "double": TypeKind.TYPE_DOUBLE,
}


class _NoNodeError(Exception):
    """The type has no codec in a page."""


class TypeTable:
    """Nodes in the order of their numbers, which never change."""

    def __init__(self) -> None:
        self.nodes: list[TypeNode] = []
        self._numbers: dict[Any, int] = {}
        self._refused: set[int] = set()

    def number(self, descriptor: Descriptor | None) -> int:
        """Return the number of a type, which is added if it is new; NO_TYPE without a codec."""
        if descriptor is None or id(descriptor) in self._refused:
            return NO_TYPE
        count, numbers = len(self.nodes), dict(self._numbers)
        try:
            return self._number(descriptor)
        except _NoNodeError:
            del self.nodes[count:]
            self._numbers = numbers
            self._refused.add(id(descriptor))
            return NO_TYPE

    def _number(self, descriptor: Descriptor, default: Any = None) -> int:
        """Return the number of a type; one with a default has a node of its own."""
        target: Any = plain(descriptor)
        if default is None and _has_default(descriptor):
            default = initial_value(descriptor)
        octets = b"" if default is None else _encoded(target, default)
        key = target, octets
        if key in self._numbers:
            return self._numbers[key]
        number = self._numbers[key] = len(self.nodes)
        node = TypeNode(initial=octets)
        self.nodes.append(node)
        self._fill(node, target)
        return number

    def _fill(self, node: TypeNode, target: Any) -> None:
        node.element = node.key = NO_TYPE
        match target:
            case PrimitiveDescriptor(name) if name in _BASIC:
                node.kind = _BASIC[name]
            case StringDescriptor(wide, bound):
                kinds = TypeKind.TYPE_STRING, TypeKind.TYPE_WSTRING
                node.kind, node.bound = kinds[wide], bound or 0
            case SequenceDescriptor(element, bound):
                node.kind, node.bound = TypeKind.TYPE_SEQUENCE, bound or 0
                node.element = self._number(element)
            case ArrayDescriptor():
                node.kind = TypeKind.TYPE_ARRAY
                inner: Any = target
                dimensions: list[int] = []
                while isinstance(array := plain(inner), ArrayDescriptor):
                    dimensions += array.dimensions
                    inner = array.element
                node.dimensions = dimensions
                node.element = self._number(inner)
            case MapDescriptor(key, value, bound):
                if not isinstance(plain(key), PrimitiveDescriptor | StringDescriptor):
                    raise _NoNodeError
                node.kind, node.bound = TypeKind.TYPE_MAP, bound or 0
                node.key, node.element = self._number(key), self._number(value)
            case EnumDescriptor(name=name, members=members, bound=bound):
                node.kind, node.name, node.bound = TypeKind.TYPE_ENUM, name, bound
                node.members = [_enumerator(*member) for member in members]
            case FlagsDescriptor(name=name, members=members, bound=bound):
                node.kind, node.name, node.bound = TypeKind.TYPE_BITMASK, name, bound
                node.members = [_enumerator(*member) for member in members]
            case StructDescriptor() | ExceptionDescriptor():
                self._struct(node, target)
            case UnionDescriptor():
                self._union(node, target)
            case _:
                raise _NoNodeError

    def _struct(
        self, node: TypeNode, target: StructDescriptor | ExceptionDescriptor
    ) -> None:
        node.kind, node.name = TypeKind.TYPE_STRUCT, target.name
        node.appendable = _is_appendable(target)
        started = None if target.class_ is None else target.class_()
        node.members = [
            TypeMember(
                name=member.name,
                type=self._number(member.type, _own_default(started, member)),
                optional=member.optional,
            )
            for member in target.members
        ]

    def _union(self, node: TypeNode, target: UnionDescriptor) -> None:
        node.kind, node.name = TypeKind.TYPE_UNION, target.name
        node.appendable = _is_appendable(target)
        node.element = self._number(target.switch)
        node.members = [
            TypeMember(
                name=branch.name,
                type=self._number(
                    branch.type,
                    branch.initial and initial_value(branch.type, branch.initial),
                ),
                labels=[_label(label) for label in branch.labels],
                is_default=branch.default,
            )
            for branch in target.branches
        ]


def _has_default(descriptor: Descriptor) -> bool:
    """Return whether a typedef or an enum has a default, or an array inside an array."""
    while isinstance(descriptor, AliasDescriptor):
        if descriptor.initial is not None:
            return True
        descriptor = descriptor.target
    if isinstance(descriptor, ArrayDescriptor):
        inner = isinstance(plain(descriptor.element), ArrayDescriptor)
        return inner and _has_default(descriptor.element)
    return isinstance(descriptor, EnumDescriptor) and descriptor.initial is not None


def _own_default(struct: Any, member: MemberDescriptor) -> Any:
    """Return the value of a member in a new struct, if it is not that of its type."""
    value = getattr(struct, member.attribute, None)
    if value is None or same(value, initial_value(member.type)):
        return None
    return value


def _encoded(target: Any, value: Any) -> bytes:
    """Return a value of any type as a body in XCDR2."""
    encode = compiled("to_cdr", AliasDescriptor("", "", target), Format(2))
    octets: bytes = encode(value, True)
    return octets


def _enumerator(name: str, number: int) -> TypeMember:
    return TypeMember(name=name, type=NO_TYPE, labels=[number])


def _label(label: int | str | bool) -> int:
    """Return a label as a number; that of a character is its code."""
    return ord(label) if isinstance(label, str) else int(label)


def _is_appendable(target: Any) -> bool:
    extensibility = getattr(target, "extensibility", "final")
    if extensibility == "mutable":
        raise _NoNodeError
    return bool(extensibility == "appendable")
