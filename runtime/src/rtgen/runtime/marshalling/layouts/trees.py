"""Makes the tree of a type from its descriptor, from which the layout is computed."""

from __future__ import annotations

from typing import Any

from msgspec.structs import replace

from rtgen.facts.primitives import SCALARS, Primitive
from rtgen.facts.ros import is_interface
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)
from rtgen.runtime.marshalling.layouts.formats import (
    CLASSIC,
    ROS2,
    Format,
    UnsupportedError,
)
from rtgen.runtime.marshalling.layouts.layout import (
    fields_of,
    fixed_format,
)
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Dynamic,
    Field,
    Form,
    Group,
    Member,
    MemberList,
    Node,
    Optional,
    Parameter,
    Records,
    Reference,
    Repeat,
    Text,
    TextArray,
    TextSequence,
    minimum_size,
)
from rtgen.runtime.marshalling.numeric import Numeric

_FORMS: dict[str, Form] = {
    Primitive.BOOLEAN: Form.BOOLEAN,
    Primitive.CHAR: Form.CHARACTER,
    Primitive.LONG_DOUBLE: Form.QUAD,
}
ATOMS: dict[str, Atom] = {
    **{name: Atom(*s, _FORMS.get(name, Form.NUMBER)) for name, s in SCALARS.items()},
    Primitive.WCHAR: Atom("3s", 3, 1, Form.WIDE_CHARACTER),
}
"""The basic types; wchar as in GIOP 1.2 (CORBA 3.3 part 2, 9.3.1.6)."""

_WORD = Atom("I", 4, 4, Form.WORD)
"""A UTF-16 unit of a wide string in ROS 2."""

TEXTS: dict[str, Text] = {
    Primitive.OCTET: Text.OCTETS,
    Primitive.UINT8: Text.OCTETS,
    Primitive.CHAR: Text.CHARACTERS,
}
"""The basic types of which sequences and arrays are `bytes` or `str`."""

DISCRIMINATOR = "discriminator"
"""The attribute of a union that selects its branch."""

_DYNAMIC = (Primitive.ANY, Primitive.TYPE_CODE, Primitive.VALUE_BASE)

MAX_IN_PLACE = 128
"""Maximum values of a struct in place; a larger one has a codec that enclosing codecs call."""

MAX_LOOPS_IN_PLACE = 6
"""Maximum nesting of loops of a struct in place: Python allows 20 nested blocks in a function."""


def tree_of(descriptor: Descriptor, format_: Format) -> Node:
    """Return the tree of a type in a member or element.

    Raises UnsupportedError.
    """
    return _Trees(format_).of(descriptor)


def body_of(
    descriptor: StructDescriptor | ExceptionDescriptor, format_: Format
) -> Group | MemberList:
    """Return the members of a struct or exception in place, those of its bases first."""
    return _Trees(format_).body(descriptor)


def union_members(
    descriptor: UnionDescriptor, format_: Format
) -> tuple[tuple[str, Member | Parameter], ...]:
    """Return the members of a mutable union: the discriminator, then each branch."""
    trees = _Trees(format_)
    switch = MemberDescriptor(
        DISCRIMINATOR, descriptor.switch, DISCRIMINATOR, 0, key=True
    )
    return (
        (DISCRIMINATOR, trees.headed(switch)),
        *((branch.attribute, trees.headed(branch)) for branch in descriptor.branches),
    )


def ros2_format(descriptor: Descriptor) -> Format:
    """Return the format of a message of ROS 2 on its networks and in bags."""
    is_wide = (isinstance(p, StringDescriptor) and p.wide for p in parts(descriptor))
    return ROS2 if any(is_wide) else CLASSIC


def classic_format(descriptor: Any) -> Format:
    """Return the format of `to_cdr` without a version of XCDR: for messages that of ROS 2."""
    is_message = is_interface(str(descriptor.name).split("::"))
    return ros2_format(descriptor) if is_message else CLASSIC


def has_list(descriptor: Any, format_: Format) -> bool:
    """Return whether values of the type are lists of members with headers."""
    extensibility = getattr(descriptor, "extensibility", "")
    return extensibility == "mutable" and format_.version > 0 and not format_.key


def is_delimited(descriptor: Any, format_: Format) -> bool:
    """Return whether a DHEADER precedes values of the type."""
    extensibility = getattr(descriptor, "extensibility", "final")
    return format_.version == 2 and extensibility != "final" and not format_.key


def key_members(
    descriptor: StructDescriptor | ExceptionDescriptor,
) -> list[MemberDescriptor]:
    """Return the members of the key, by id: those marked, or all if none is (7.2.2.4.7)."""
    marked = [m for m in descriptor.members if m.key] or descriptor.members
    return sorted(marked, key=lambda member: member.id)


class _Trees:
    """The trees of types in a format; structs of any size are `in_place`, or the small ones."""

    def __init__(self, format_: Format, in_place: bool = False) -> None:
        self._format = format_
        self._in_place = in_place
        self._version = format_.version
        self._structs: dict[int, Group | Call] = {}
        """By the descriptor's identity: a struct that many members share has one tree."""

    def of(self, descriptor: Descriptor) -> Node:
        match descriptor:
            case AliasDescriptor(target=target):
                return self.of(target)
            case LinkDescriptor():
                target = plain(descriptor)
                if isinstance(target, StructDescriptor | UnionDescriptor):
                    return Call(target, 1)
                return self.of(target)
            case StructDescriptor():
                if has_list(descriptor, self._format) or is_delimited(
                    descriptor, self._format
                ):
                    return Call(descriptor, 4)
                return self._struct(descriptor)
            case UnionDescriptor(switch=switch):
                return Call(descriptor, minimum_size(self.of(switch)))
            case StringDescriptor(wide=True, bound=bound) if self._format.ros2:
                return AtomSequence(_WORD, bound)
            case StringDescriptor(wide, bound):
                kind = Text.UNITS if self._version else Text.WIDE_STRING
                return TextSequence(kind if wide else Text.STRING, bound)
            case SequenceDescriptor(element, bound, numeric=numeric):
                node = self._sequence(element, bound, numeric)
                return self._delimited(node, element)
            case ArrayDescriptor():
                return self._delimited(self._array(descriptor), _innermost(descriptor))
            case MapDescriptor(key, value, bound):
                keys, values = self.of(key), self.of(value)
                least = minimum_size(keys) + minimum_size(values)
                node = Repeat(values, max(least, 1), bound, key=keys)
                return self._delimited(node, key, value)
            case FixedDescriptor(digits, scale) if not self._version:
                size = digits // 2 + 1
                return Atom(f"{size}s", size, 1, Form.FIXED, None, digits, scale)
            case EnumDescriptor(code=code, bound=bound):
                if not self._version:
                    return Atom(code, 4, 4, Form.ENUMERATOR, descriptor)
                atom = self._bits(bound, Form.ENUMERATOR, descriptor)
                return replace(atom, code=atom.code.lower()) if code == "i" else atom
            case FlagsDescriptor(bound=bound):
                return self._bits(bound, Form.FLAGS, descriptor)
            case BitsetDescriptor(bound=bound):
                return self._bits(bound, Form.BITS, descriptor)
            case PrimitiveDescriptor(Primitive.WCHAR) if self._version:
                return Atom("H", 2, 2, Form.UNIT)
            case PrimitiveDescriptor(name) if name in ATOMS:
                return self._atom(ATOMS[name])
        tree = None if self._version else self._of_corba(descriptor)
        if tree is None:
            name = "XCDR" if self._version else "CDR"
            raise UnsupportedError(f"{name} has no representation of {descriptor}")
        return tree

    def _of_corba(self, descriptor: Descriptor) -> Node | None:
        """Return the node of a type that only CORBA marshals; None for any other."""
        match descriptor:
            case ValueDescriptor() | BoxDescriptor():
                return Dynamic(descriptor)
            case InterfaceDescriptor(abstract=True):
                return Dynamic(descriptor, 5)
            case InterfaceDescriptor() | PrimitiveDescriptor(Primitive.OBJECT):
                return Reference()
            case PrimitiveDescriptor(name) if name in _DYNAMIC:
                return Dynamic(descriptor)
        return None

    def body(
        self, descriptor: StructDescriptor | ExceptionDescriptor
    ) -> Group | MemberList:
        if has_list(descriptor, self._format):
            headed = [(m.attribute, self.headed(m)) for m in descriptor.members]
            return MemberList(descriptor, tuple(headed))
        chosen = key_members(descriptor) if self._format.key else descriptor.members
        return Group(descriptor, tuple((m.attribute, self._member(m)) for m in chosen))

    def headed(
        self, entry: MemberDescriptor | BranchDescriptor, in_list: bool = True
    ) -> Member | Parameter:
        """Return a member with a header of its own."""
        node = self.of(entry.type)
        traits = (False, False, False)
        if isinstance(entry, MemberDescriptor):
            traits = (entry.must_understand, entry.optional, entry.key)
        if self._version == 2:
            return Member(node, entry.id, *traits)
        return Parameter(node, entry.id, *traits, in_list)

    def _struct(self, descriptor: StructDescriptor) -> Group | Call:
        node = self._structs.get(id(descriptor))
        if node is None:
            body = self.body(descriptor)
            assert isinstance(body, Group)
            node = body if self._in_place else _called_if_large(body)
            self._structs[id(descriptor)] = node
        return node

    def _member(self, member: MemberDescriptor) -> Node:
        if not member.optional or not self._version:
            return self.of(member.type)
        if self._version == 1:
            return self.headed(member, in_list=False)
        return Optional(self.of(member.type))

    def _delimited(self, node: Node, *parts: Descriptor) -> Node:
        """Return a collection; in version 2 with a DHEADER if its elements are not primitive."""
        if self._version < 2 or all(map(_is_primitive, parts)):
            return node
        return Delimited(node)

    def _sequence(
        self, element: Descriptor, bound: int | None, numeric: Numeric
    ) -> Node:
        text = _text(element)
        if text is not None:
            return TextSequence(text, bound)
        trees = _Trees(self._format, in_place=True) if numeric == "numpy" else self
        return self._repeated(trees.of(element), bound, None, numeric)

    def _array(self, array: ArrayDescriptor) -> Node:
        element = array.element
        text = _text(element)
        outer = array.dimensions
        if text is not None:
            inner: Node = TextArray(text, outer[-1])
            outer = outer[:-1]
        else:
            target: Any = plain(element)
            rows = isinstance(target, ArrayDescriptor)
            inner = self._array(target) if rows else self.of(element)
            if isinstance(inner, Atom) and len(inner.code) == 1:
                return AtomArray(inner, outer, array.numeric)
        for length in reversed(outer):
            inner = self._repeated(inner, None, length)
        return inner

    def _repeated(
        self,
        element: Node,
        bound: int | None,
        length: int | None,
        numeric: Numeric = "list",
    ) -> Records | Repeat | AtomSequence:
        if isinstance(element, Atom) and len(element.code) == 1 and length is None:
            return AtomSequence(element, bound, numeric)
        fields = tuple(fields_of(element))
        atoms = tuple(
            f
            for f in fields
            if isinstance(f, Field) and isinstance(f.node, Atom | AtomArray | TextArray)
        )
        arrays = [f for f in atoms if isinstance(f.node, AtomArray)]
        if len(atoms) == len(fields) and (len(arrays) <= 1 or numeric == "numpy"):
            fixed = fixed_format(atoms)
            if fixed is not None:
                return Records(element, atoms, *fixed, bound, length, numeric)
        least = minimum_size(element)
        if least == 0 and length is None and not self._version:
            raise UnsupportedError("CDR has no sequence of empty elements")
        return Repeat(element, least, bound, length)

    def _atom(self, atom: Atom) -> Atom:
        widest = self._format.widest
        return atom if atom.align <= widest else replace(atom, align=widest)

    def _bits(self, count: int, form: Form, descriptor: Any) -> Atom:
        """Return the smallest unsigned integer of at least that many bits."""
        size = next(n for n in (1, 2, 4, 8) if count <= 8 * n)
        return self._atom(Atom(" BH I   Q"[size], size, size, form, descriptor, count))


def _is_primitive(descriptor: Descriptor) -> bool:
    """Return whether a collection of such elements has no DHEADER (DDS-XTypes 1.3, 7.4.3.5)."""
    return isinstance(plain(descriptor), PrimitiveDescriptor)


def _innermost(array: ArrayDescriptor) -> Descriptor:
    """Return the element of an array of arrays."""
    element = plain(array.element)
    return _innermost(element) if isinstance(element, ArrayDescriptor) else element


def can_evolve(descriptor: Descriptor) -> bool:
    """Return whether values of other versions can be read: the type has an appendable part."""
    return any(
        getattr(part, "extensibility", "") == "appendable" for part in parts(descriptor)
    )


def unsupported(descriptor: Descriptor, format_: Format) -> tuple[str, str]:
    """Return the path to the first part that the format cannot represent, and a description."""
    trees = _Trees(format_)
    seen: set[int] = set()

    def search(part: Descriptor, path: str) -> tuple[str, str] | None:
        part = plain(part)
        if id(part) in seen:
            return None
        seen.add(id(part))
        match part:
            case SequenceDescriptor(element=inner) | ArrayDescriptor(element=inner):
                return search(inner, path)
            case MapDescriptor(key=key, value=value):
                return search(key, path) or search(value, path)
            case StructDescriptor(members=entries) | UnionDescriptor(branches=entries):
                results = (search(e.type, f"{path}.{e.name}") for e in entries)
                return next(filter(None, results), None)
        try:
            trees.of(part)
        except UnsupportedError as failure:
            return path, str(failure)
        return None

    return search(descriptor, "") or ("", f"{format_} has no representation of it")


def is_dynamic(descriptor: Descriptor) -> bool:
    """Return whether values of the type contain one marshalled by its descriptor."""
    return any(_is_dynamic_leaf(part) for part in parts(descriptor))


def has_headers(descriptor: Descriptor) -> bool:
    """Return whether the type has member headers in XCDR1: optional members, mutable types."""
    return any(_has_headers(part) for part in parts(descriptor))


def _is_dynamic_leaf(descriptor: Descriptor) -> bool:
    match descriptor:
        case PrimitiveDescriptor(name):
            return name in _DYNAMIC
        case InterfaceDescriptor(abstract=abstract):
            return abstract
    return isinstance(descriptor, ValueDescriptor | BoxDescriptor)


def _has_headers(descriptor: Descriptor) -> bool:
    match descriptor:
        case StructDescriptor(extensibility=extensibility, members=members):
            entries: tuple[MemberDescriptor | BranchDescriptor, ...] = members
        case UnionDescriptor(extensibility=extensibility, branches=branches):
            entries = branches
        case ExceptionDescriptor(members=members):
            entries, extensibility = members, "final"
        case _:
            return False
    return extensibility == "mutable" or any(
        getattr(e, "optional", False) or (e.external and _is_link(e.type))
        for e in entries
    )


def _is_link(descriptor: Descriptor) -> bool:
    while isinstance(descriptor, AliasDescriptor):
        descriptor = descriptor.target
    return isinstance(descriptor, LinkDescriptor)


def parts(descriptor: Descriptor) -> list[Descriptor]:
    """Return all types in a type, including itself, each once."""
    descriptors: dict[int, Descriptor] = {}
    waiting = [descriptor]
    while waiting:
        each = plain(waiting.pop())
        if id(each) in descriptors:
            continue
        descriptors[id(each)] = each
        match each:
            case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
                waiting.append(element)
            case MapDescriptor(key=key, value=value):
                waiting += (key, value)
            case StructDescriptor(members=members) | ExceptionDescriptor(
                members=members
            ):
                waiting += (member.type for member in members)
            case UnionDescriptor(branches=branches):
                waiting += (branch.type for branch in branches)
    return list(descriptors.values())


def _text(element: Descriptor) -> Text | None:
    element = plain(element)
    return TEXTS.get(element.name) if isinstance(element, PrimitiveDescriptor) else None


def _called_if_large(body: Group) -> Group | Call:
    """Return a struct as a member or element: in place, or by a call if its code is large."""
    if _values(body) > MAX_IN_PLACE or _loops(body) > MAX_LOOPS_IN_PLACE:
        return Call(body.type, minimum_size(body))
    return body


def _values(node: Node) -> int:
    """Return the number of values in the source text of a tree."""
    match node:
        case Group(members=members):
            return sum(_values(inner) for _, inner in members)
        case Repeat(element=element, key=key):
            return 1 + _values(element) + (0 if key is None else _values(key))
        case Records(fields=fields):
            return 1 + len(fields)
        case Delimited(node=inner) | Optional(node=inner) | Parameter(node=inner):
            return 1 + _values(inner)
    return 1


def _loops(node: Node) -> int:
    """Return the nesting depth of loops in the source text of a tree."""
    match node:
        case Group(members=members):
            return max((_loops(inner) for _, inner in members), default=0)
        case Repeat(element=element, key=key):
            return 1 + max(_loops(element), 0 if key is None else _loops(key))
        case Delimited(node=inner) | Optional(node=inner) | Parameter(node=inner):
            return 1 + _loops(inner)
    return 0
