"""From the types of the model to the trees that the CDR layout is worked out from."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from rtgen.layouts.cdr import (
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
from rtgen.layouts.representations import Representations, member_types
from rtgen.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Case,
    Declaration,
    Enum,
    ExceptionDecl,
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
from rtgen.model.graphs import in_circles, leading_to

ATOMS: dict[Primitive, Atom] = {
    Primitive.SHORT: Atom("h", 2, 2),
    Primitive.UNSIGNED_SHORT: Atom("H", 2, 2),
    Primitive.LONG: Atom("i", 4, 4),
    Primitive.UNSIGNED_LONG: Atom("I", 4, 4),
    Primitive.LONG_LONG: Atom("q", 8, 8),
    Primitive.UNSIGNED_LONG_LONG: Atom("Q", 8, 8),
    Primitive.INT8: Atom("b", 1, 1),
    Primitive.UINT8: Atom("B", 1, 1),
    Primitive.OCTET: Atom("B", 1, 1),
    Primitive.FLOAT: Atom("f", 4, 4),
    Primitive.DOUBLE: Atom("d", 8, 8),
    Primitive.LONG_DOUBLE: Atom("16s", 16, 8, Form.QUAD),
    Primitive.CHAR: Atom("c", 1, 1, Form.CHARACTER),
    Primitive.WCHAR: Atom("3s", 3, 1, Form.WIDE_CHARACTER),
    Primitive.BOOLEAN: Atom("B", 1, 1, Form.BOOLEAN),
}
"""The basic types: CORBA 3.3 part 2, table 9.1; wchar as GIOP 1.2 has it (9.3.1.6)."""

_DYNAMIC = frozenset((Primitive.ANY, Primitive.TYPE_CODE, Primitive.VALUE_BASE))

_TEXTS = {
    Primitive.OCTET: Text.OCTETS,
    Primitive.UINT8: Text.OCTETS,
    Primitive.CHAR: Text.CHARACTERS,
}


MOST_IN_PLACE = 128
"""A struct of more values has a codec of its own, which those of its holders call."""

MOST_LOOPS_IN_PLACE = 6
"""The same for one with loops in loops: Python nests 20 blocks at most in a function."""

MOST_LOOPS = 12
"""So deep can sequences be nested in each other without a struct or union between."""


class NotMarshalledError(Exception):
    """A type that has no layout in classic CDR, or none here; the message says which and why."""


Rename: TypeAlias = Callable[[Struct | ExceptionDecl], Mapping[str, str]]
"""What the members of a struct are called in the tree, by their names in the definition."""


class CdrTypes:
    """The trees of a model's types. Unions and some structs are calls of their own codecs."""

    def __init__(
        self, model: Model, rename: Rename, representations: Representations
    ) -> None:
        self._model = model
        self._representations = representations
        self._rename = rename
        self._nodes: dict[ScopedName, Node] = {}
        uses = _uses(model)
        self._recursive = frozenset(in_circles(uses))
        self._places = {d.name: i for i, d in enumerate(model.declarations)}
        composites = [d for d in model.declarations if isinstance(d, Struct | Union)]
        dynamic = [d.name for d in composites if self._holds_dynamic(d)]
        headed = [d.name for d in composites if self._holds_headers(d)]
        self._dynamic = leading_to(uses, dynamic)
        self._headed = leading_to(uses, headed)

    def is_recursive(self, name: ScopedName) -> bool:
        """Whether values of the struct or union can contain values of the same type."""
        return name in self._recursive

    def has_own_codec(self, name: ScopedName) -> bool:
        """Whether other codecs call that of the struct: it is recursive, or large.

        Raises NotMarshalledError.
        """
        return name in self._recursive or isinstance(self._named(name), Call)

    def is_unset(self, holder: Declaration, entry: Member | Case) -> bool:
        """Whether a member is None until it is set.

        An `@external` member can be of a type that is recursive, or is defined later only.
        """
        type_ = self._model.unalias(entry.type)
        return (
            entry.external
            and isinstance(type_, NamedType)
            and isinstance(self._model.find(type_.name), Struct | Union)
            and (
                type_.name in self._recursive
                or self._places[type_.name] >= self._places[holder.name]
            )
        )

    def is_dynamic(self, type_: Type) -> bool:
        """Whether values of the type hold what is marshalled along its descriptor."""
        names = _names(self._model, type_)
        return not names.isdisjoint(self._dynamic) or any(
            self._is_dynamic_leaf(t) for t in _leaves(self._model, type_)
        )

    def has_headers(self, type_: Type) -> bool:
        """Whether XCDR1 puts headers before members in the type: optional ones, mutable types'."""
        return not _names(self._model, type_).isdisjoint(self._headed)

    def _holds_dynamic(self, declaration: Struct | Union) -> bool:
        return any(
            self._is_dynamic_leaf(leaf)
            for type_ in member_types(declaration)
            for leaf in _leaves(self._model, type_)
        )

    def _holds_headers(self, declaration: Struct | Union) -> bool:
        extensibility = self._representations.extensibility(declaration)
        entries: Sequence[Member | Case] = (
            declaration.members
            if isinstance(declaration, Struct)
            else declaration.cases
        )
        return extensibility is Extensibility.MUTABLE or any(
            (isinstance(entry, Member) and entry.optional)
            or self.is_unset(declaration, entry)
            for entry in entries
        )

    def _is_dynamic_leaf(self, type_: Type) -> bool:
        if isinstance(type_, PrimitiveType):
            return type_.kind in _DYNAMIC
        if not isinstance(type_, NamedType):
            return False
        declaration = self._model.find(type_.name)
        if isinstance(declaration, Interface):
            return declaration.abstract
        return isinstance(declaration, Valuetype | ValueBox)

    def body(self, declaration: Struct | ExceptionDecl) -> Group:
        """The members of a struct or exception in place, those of its bases first.

        Raises NotMarshalledError.
        """
        inherited: tuple[tuple[str, Node], ...] = ()
        if isinstance(declaration, Struct) and declaration.base is not None:
            base = self._model.find(declaration.base)
            assert isinstance(base, Struct)
            inherited = self.body(base).members
        names = self._rename(declaration)
        own = tuple((names[m.name], self.node(m.type)) for m in declaration.members)
        return Group(declaration.name, inherited + own)

    def node(self, type_: Type) -> Node:
        """The tree of a type. Raises NotMarshalledError."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(Primitive.OBJECT):
                return Reference()
            case PrimitiveType(kind) if kind in _DYNAMIC:
                return Dynamic(type_)
            case PrimitiveType(kind):
                if kind not in ATOMS:
                    raise NotMarshalledError(
                        f"`{kind}` is not marshalled by classic CDR codecs here"
                    )
                return ATOMS[kind]
            case StringType(wide, bound):
                return TextSequence(Text.WIDE_STRING if wide else Text.STRING, bound)
            case FixedType(digits, scale):
                size = digits // 2 + 1
                return Atom(f"{size}s", size, 1, Form.FIXED, None, digits, scale)
            case SequenceType(element, bound):
                text = self._text(element)
                if text is not None:
                    return TextSequence(text, bound)
                return self._sequence(self.node(element), bound, None)
            case ArrayType(element, dimensions):
                return self._array(element, dimensions)
            case MapType(key, value, bound):
                keys, values = self.node(key), self.node(value)
                least = minimum_size(keys) + minimum_size(values)
                return _checked(Repeat(values, max(least, 1), bound, key=keys))
            case NamedType(name):
                return self._named(name)

    def _named(self, name: ScopedName) -> Node:
        declaration = self._model.find(name)
        match declaration:
            case Enum():
                return enum_atom(declaration)
            case Bitmask(bound=bound):
                return _bits(bound, Form.FLAGS, name)
            case Bitset():
                return _bits(bit_count(self._model, declaration), Form.BITS, name)
            case Valuetype(custom=True):
                raise NotMarshalledError(
                    f"`{declaration.scoped}` is custom: its user marshals its state"
                )
            case Valuetype() | ValueBox():
                return Dynamic(NamedType(name))
            case Interface(abstract=True):
                return Dynamic(NamedType(name), 5)
            case Interface(local=True):
                raise NotMarshalledError(
                    f"`{declaration.scoped}` is local: it does not leave its process"
                )
            case Interface():
                return Reference()
            case Union():
                return Call(name, self._switch_size(declaration))
            case Struct() if name in self._recursive:
                return Call(name, 1)
            case Struct():
                if name not in self._nodes:
                    self._nodes[name] = _called_if_large(self.body(declaration))
                return self._nodes[name]
        kind = type(declaration).__name__.lower()
        raise NotMarshalledError(
            f"`{declaration.scoped}` ({kind}) is not marshalled by CDR codecs here"
        )

    def _switch_size(self, union: Union) -> int:
        return minimum_size(self.node(union.switch))

    def _text(self, element: Type) -> Text | None:
        element = self._model.unalias(element)
        return _TEXTS.get(element.kind) if isinstance(element, PrimitiveType) else None

    def _array(self, element: Type, dimensions: tuple[int, ...]) -> Node:
        text = self._text(element)
        if text is not None:
            inner: Node = TextArray(text, dimensions[-1])
            outer = dimensions[:-1]
        else:
            inner, outer = self.node(element), dimensions
            if isinstance(inner, Atom) and len(inner.code) == 1:
                return AtomArray(inner, dimensions)
        for length in reversed(outer):
            inner = self._sequence(inner, None, length)
        return inner

    def _sequence(self, element: Node, bound: int | None, length: int | None) -> Node:
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
        least = minimum_size(element)
        if least == 0 and length is None:
            raise NotMarshalledError(
                "a sequence of empty elements: its count cannot be checked"
            )
        return _checked(Repeat(element, least, bound, length))


def enum_atom(declaration: Enum) -> Atom:
    """Enumerators are their values in four octets, signed where one is negative."""
    negative = any(member.value < 0 for member in declaration.members)
    return Atom("i" if negative else "I", 4, 4, Form.ENUMERATOR, declaration.name)


def _called_if_large(body: Group) -> Group | Call:
    """A struct where it is used: in place, or called if that would be much text."""
    if _values(body) > MOST_IN_PLACE or _loops(body) > MOST_LOOPS_IN_PLACE:
        return Call(body.name, minimum_size(body))
    return body


def _checked(node: Repeat) -> Repeat:
    if _loops(node) > MOST_LOOPS:
        raise NotMarshalledError(
            f"sequences are nested more than {MOST_LOOPS} deep: put a struct between"
        )
    return node


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


def _bits(count: int, form: Form, name: ScopedName) -> Atom:
    """The smallest unsigned integer that has so many bits."""
    size = next(n for n in (1, 2, 4, 8) if count <= 8 * n)
    return Atom(" BH I   Q"[size], size, size, form, name, count)


def bit_count(model: Model, bitset: Bitset) -> int:
    """How many bits a bitset has, with those of its bases."""
    count = sum(field.bits for field in bitset.members)
    if bitset.base is not None:
        base = model.find(bitset.base)
        assert isinstance(base, Bitset)
        count += bit_count(model, base)
    return count


def _uses(model: Model) -> dict[ScopedName, set[ScopedName]]:
    """The named types that structs and unions have parts of."""
    return {
        declaration.name: {
            name for t in member_types(declaration) for name in _names(model, t)
        }
        for declaration in model.declarations
        if isinstance(declaration, Struct | Union)
    }


def _leaves(model: Model, type_: Type) -> list[Type]:
    """The types that a type is made of, down to names and basic types."""
    type_ = model.unalias(type_)
    match type_:
        case SequenceType(element) | ArrayType(element):
            return _leaves(model, element)
        case MapType(key, value):
            return _leaves(model, key) + _leaves(model, value)
    return [type_]


def _names(model: Model, type_: Type) -> set[ScopedName]:
    leaves = _leaves(model, type_)
    return {leaf.name for leaf in leaves if isinstance(leaf, NamedType)}
