"""From the descriptor of a type to the tree that its layout is worked out from."""

from __future__ import annotations

from typing import Any

from rtgen.facts.primitives import SCALARS, Primitive
from rtgen.runtime.descriptors import (
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
from rtgen.runtime.marshalling.layout import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Dynamic,
    Field,
    Form,
    Group,
    Node,
    Records,
    Reference,
    Repeat,
    Text,
    TextArray,
    TextSequence,
    fields_of,
    fixed_format,
    minimum_size,
)

_FORMS: dict[str, Form] = {
    Primitive.BOOLEAN: Form.BOOLEAN,
    Primitive.CHAR: Form.CHARACTER,
    Primitive.LONG_DOUBLE: Form.QUAD,
}
ATOMS: dict[str, Atom] = {
    **{name: Atom(*s, _FORMS.get(name, Form.NUMBER)) for name, s in SCALARS.items()},
    Primitive.WCHAR: Atom("3s", 3, 1, Form.WIDE_CHARACTER),
}
"""The basic types; wchar as GIOP 1.2 has it (CORBA 3.3 part 2, 9.3.1.6)."""

TEXTS: dict[str, Text] = {
    Primitive.OCTET: Text.OCTETS,
    Primitive.UINT8: Text.OCTETS,
    Primitive.CHAR: Text.CHARACTERS,
}
"""The basic types of which sequences and arrays are `bytes` or `str`."""

MOST_IN_PLACE = 128
"""A struct of more values has a codec of its own, which those of its holders call."""

MOST_LOOPS_IN_PLACE = 6
"""The same for one with loops in loops: Python nests 20 blocks at most in a function."""


def tree_of(descriptor: Descriptor) -> Node:
    """The tree of a type where it is used. Raises TypeError for one without a layout."""
    match descriptor:
        case AliasDescriptor(target=target):
            return tree_of(target)
        case LinkDescriptor():
            target = plain(descriptor)
            if isinstance(target, StructDescriptor | UnionDescriptor):
                return Call(target, 1)
            return tree_of(target)
        case StructDescriptor():
            return _called_if_large(body_of(descriptor))
        case UnionDescriptor(switch=switch):
            return Call(descriptor, minimum_size(tree_of(switch)))
        case StringDescriptor(wide, bound):
            return TextSequence(Text.WIDE_STRING if wide else Text.STRING, bound)
        case SequenceDescriptor(element, bound):
            text = _text(element)
            if text is not None:
                return TextSequence(text, bound)
            return _sequence(tree_of(element), bound, None)
        case ArrayDescriptor(element, dimensions):
            return _array(element, dimensions)
        case MapDescriptor(key, value, bound):
            keys, values = tree_of(key), tree_of(value)
            least = minimum_size(keys) + minimum_size(values)
            return Repeat(values, max(least, 1), bound, key=keys)
        case FixedDescriptor(digits, scale):
            size = digits // 2 + 1
            return Atom(f"{size}s", size, 1, Form.FIXED, None, digits, scale)
        case EnumDescriptor(code=code):
            return Atom(code, 4, 4, Form.ENUMERATOR, descriptor)
        case FlagsDescriptor(bound=bound):
            return _bits(bound, Form.FLAGS, descriptor)
        case BitsetDescriptor(bound=bound):
            return _bits(bound, Form.BITS, descriptor)
        case ValueDescriptor() | BoxDescriptor():
            return Dynamic(descriptor)
        case InterfaceDescriptor(abstract=True):
            return Dynamic(descriptor, 5)
        case InterfaceDescriptor() | PrimitiveDescriptor("Object"):
            return Reference()
        case PrimitiveDescriptor("any" | "CORBA::TypeCode" | "ValueBase"):
            return Dynamic(descriptor)
        case PrimitiveDescriptor(name) if name in ATOMS:
            return ATOMS[name]
    raise TypeError(f"CDR has no representation of {descriptor}")


def body_of(descriptor: StructDescriptor | ExceptionDescriptor) -> Group:
    """The members of a struct or exception in place, those of its bases first."""
    members = descriptor.members
    return Group(descriptor, tuple((m.attribute, tree_of(m.type)) for m in members))


def is_dynamic(descriptor: Descriptor) -> bool:
    """Whether values of the type hold what is marshalled along its descriptor."""
    return any(_is_dynamic_leaf(part) for part in _parts(descriptor))


def has_headers(descriptor: Descriptor) -> bool:
    """Whether XCDR1 puts headers before members in the type: optional ones, mutable types'."""
    return any(_has_headers(part) for part in _parts(descriptor))


def _is_dynamic_leaf(descriptor: Descriptor) -> bool:
    match descriptor:
        case PrimitiveDescriptor(name):
            return name in ("any", "CORBA::TypeCode", "ValueBase")
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


def _parts(descriptor: Descriptor) -> list[Descriptor]:
    """All types that a type is made of, itself included, each once."""
    found: dict[int, Descriptor] = {}
    waiting = [descriptor]
    while waiting:
        each = plain(waiting.pop())
        if id(each) in found:
            continue
        found[id(each)] = each
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
    return list(found.values())


def _text(element: Descriptor) -> Text | None:
    element = plain(element)
    return TEXTS.get(element.name) if isinstance(element, PrimitiveDescriptor) else None


def _array(element: Descriptor, dimensions: tuple[int, ...]) -> Node:
    text = _text(element)
    if text is not None:
        inner: Node = TextArray(text, dimensions[-1])
        outer = dimensions[:-1]
    else:
        inner, outer = tree_of(element), dimensions
        if isinstance(inner, Atom) and len(inner.code) == 1:
            return AtomArray(inner, dimensions)
    for length in reversed(outer):
        inner = _sequence(inner, None, length)
    return inner


def _sequence(element: Node, bound: int | None, length: int | None) -> Node:
    if isinstance(element, Atom) and len(element.code) == 1 and length is None:
        return AtomSequence(element, bound)
    fields = tuple(fields_of(element))
    atoms = tuple(
        f
        for f in fields
        if isinstance(f, Field) and isinstance(f.node, Atom | AtomArray | TextArray)
    )
    arrays = [f for f in atoms if isinstance(f.node, AtomArray)]
    if len(atoms) == len(fields) and len(arrays) <= 1:
        text, size, align, gapless = fixed_format(atoms)
        if gapless:
            return Records(element, atoms, text, size, align, bound, length)
    return Repeat(element, minimum_size(element), bound, length)


def _called_if_large(body: Group) -> Group | Call:
    """A struct where it is used: in place, or called if that would be much text."""
    if _values(body) > MOST_IN_PLACE or _loops(body) > MOST_LOOPS_IN_PLACE:
        return Call(body.type, minimum_size(body))
    return body


def _values(node: Node) -> int:
    """How many values the text for a tree names."""
    match node:
        case Group(members=members):
            return sum(_values(inner) for _, inner in members)
        case Repeat(element=element, key=key):
            return 1 + _values(element) + (0 if key is None else _values(key))
        case Records(fields=fields):
            return 1 + len(fields)
    return 1


def _loops(node: Node) -> int:
    """How deep loops are nested in the text for a tree."""
    match node:
        case Group(members=members):
            return max((_loops(inner) for _, inner in members), default=0)
        case Repeat(element=element, key=key):
            return 1 + max(_loops(element), 0 if key is None else _loops(key))
    return 0


def _bits(count: int, form: Form, descriptor: Any) -> Atom:
    """The smallest unsigned integer that has so many bits."""
    size = next(n for n in (1, 2, 4, 8) if count <= 8 * n)
    return Atom(" BH I   Q"[size], size, size, form, descriptor, count)
