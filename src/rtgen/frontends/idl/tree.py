"""The syntax tree: what was written, before any name means anything.

Nodes are frozen, and compared by identity, so that later passes can keep facts about them in
tables of their own. Positions are offsets into the text of the unit that was parsed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from rtgen.model import Direction, Primitive


@dataclass(frozen=True, slots=True, eq=False)
class Name:
    """An identifier without its escape underscore."""

    text: str
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class ScopedName:
    """`A::B`, or `::A::B` if absolute."""

    parts: tuple[Name, ...]
    absolute: bool
    start: int
    end: int

    def __str__(self) -> str:
        return ("::" if self.absolute else "") + "::".join(
            part.text for part in self.parts
        )


# Constant expressions


@dataclass(frozen=True, slots=True, eq=False)
class Number:
    """A number as written."""

    text: str
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Text:
    """Adjacent string literals, or one character literal, as written with their quotes."""

    parts: tuple[str, ...]
    character: bool
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Boolean:
    """`TRUE` or `FALSE`."""

    value: bool
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Unary:
    """`-x`, `+x`, `~x`."""

    operator: str
    operand: Expression
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Operands joined by operators of one precedence, applied from the left."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """An expression in parentheses."""

    inner: Expression
    start: int
    end: int


Expression: TypeAlias = Number | Text | Boolean | ScopedName | Unary | Chain | Group


# Annotations


@dataclass(frozen=True, slots=True, eq=False)
class Argument:
    """An argument of an annotation; `name` is None for the only, unnamed one."""

    name: Name | None
    value: Expression


@dataclass(frozen=True, slots=True, eq=False)
class Annotation:
    """`@name(arguments)`; `name` with `::` and without `@`."""

    name: str
    arguments: tuple[Argument, ...]
    start: int
    end: int


# Types


@dataclass(frozen=True, slots=True, eq=False)
class BasicType:
    """A basic type."""

    kind: Primitive
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class TextType:
    """`string` or `wstring`."""

    wide: bool
    bound: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """`sequence<element, bound>`."""

    element: TypeNode
    bound: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Fixed:
    """`fixed<digits, scale>`, or plain `fixed` in a constant."""

    digits: Expression | None
    scale: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Map:
    """`map<key, value, bound>`."""

    key: TypeNode
    value: TypeNode
    bound: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Declarator:
    """A name with the dimensions of an array."""

    name: Name
    dimensions: tuple[Expression, ...]
    start: int
    end: int


# Declarations


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """What stands between braces; [start, end) is between them."""

    items: tuple[Item, ...]
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """An entry of a body or file: annotations and a node, up to its `;`."""

    annotations: tuple[Annotation, ...]
    node: Node
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Module:
    """A module, or one opening of it; template modules are told by `template`."""

    name: Name
    body: Body
    start: int
    template: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Forward:
    """A forward declaration: `keyword` is struct, union, interface, valuetype, component ..."""

    keyword: str
    name: Name
    modifier: str
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """Struct, exception and state members: one type, one or more declarators."""

    type: TypeNode
    declarators: tuple[Declarator, ...]
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Struct:
    """A struct or (by `exception`) an exception."""

    name: Name
    base: ScopedName | None
    body: Body
    start: int
    exception: bool = False

    @property
    def end(self) -> int:
        return self.body.end + 1


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """`case value:`, or `default:` where `value` is None."""

    value: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A branch of a union."""

    labels: tuple[Label, ...]
    type: TypeNode
    declarator: Declarator
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Union:
    """A union."""

    name: Name
    switch: TypeNode
    body: Body
    start: int

    @property
    def end(self) -> int:
        return self.body.end + 1


@dataclass(frozen=True, slots=True, eq=False)
class Enumerator:
    """A member of an enum or bitmask; `value` only where one was (wrongly) written."""

    annotations: tuple[Annotation, ...]
    name: Name
    value: Expression | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Enum:
    """An enum, or (by `mask`) a bitmask. `trailing` is the place of a comma at the end."""

    name: Name
    members: tuple[Enumerator, ...]
    trailing: int | None
    start: int
    end: int
    mask: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Bitfield:
    """`bitfield<bits, type> names;`."""

    bits: Expression
    type: TypeNode | None
    names: tuple[Name, ...]
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Bitset:
    """A bitset."""

    name: Name
    base: ScopedName | None
    body: Body
    start: int

    @property
    def end(self) -> int:
        return self.body.end + 1


@dataclass(frozen=True, slots=True, eq=False)
class Typedef:
    """A typedef with one or more declarators."""

    type: TypeNode
    declarators: tuple[Declarator, ...]
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Const:
    """A constant."""

    type: TypeNode
    name: Name
    value: Expression
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Native:
    """A native type."""

    name: Name
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """A parameter; `direction` is None where it is missing."""

    annotations: tuple[Annotation, ...]
    direction: Direction | None
    type: TypeNode
    declarator: Declarator
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """A list of scoped names, as behind `raises`; its place is that of the clause."""

    names: tuple[ScopedName, ...]
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Operation:
    """An operation, or (by `factory`) a factory or finder; those have no type."""

    name: Name
    type: TypeNode | None
    parameters: tuple[Parameter, ...]
    raises: Names | None
    context: tuple[Text, ...]
    oneway: bool
    start: int
    end: int
    factory: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Attribute:
    """Attributes of one type."""

    type: TypeNode
    names: tuple[Name, ...]
    readonly: bool
    get_raises: Names | None
    set_raises: Names | None
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Interface:
    """An interface; `modifier` is abstract, local or empty."""

    name: Name
    bases: tuple[ScopedName, ...]
    body: Body
    modifier: str
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """State members of a valuetype."""

    public: bool
    member: Member
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Valuetype:
    """A valuetype or eventtype; `modifier` is abstract, custom or empty."""

    keyword: str
    name: Name
    bases: tuple[ScopedName, ...]
    truncatable: bool
    supports: tuple[ScopedName, ...]
    body: Body
    modifier: str
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class ValueBox:
    """`valuetype name type`."""

    name: Name
    type: TypeNode
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class PortItem:
    """`provides`, `uses`, `publishes`, `consumes`, `emits` (or `port`, `mirrorport`) T name."""

    keyword: str
    type: TypeNode
    name: Name
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """A component."""

    name: Name
    base: ScopedName | None
    supports: tuple[ScopedName, ...]
    body: Body
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """A component home."""

    name: Name
    base: ScopedName | None
    supports: tuple[ScopedName, ...]
    manages: ScopedName
    key: ScopedName | None
    body: Body
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Identity:
    """`typeid name "text"` and `typeprefix name "text"`."""

    keyword: str
    name: ScopedName
    text: Text
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Import:
    """`import name`."""

    name: ScopedName | None
    start: int


@dataclass(frozen=True, slots=True, eq=False)
class Unused:
    """A construct that is read only: a porttype, a connector, an annotation's declaration ..."""

    keyword: str
    name: Name | None
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Skipped:
    """What was passed over: a declaration with a syntax error, or an extra semicolon."""

    start: int


TypeNode: TypeAlias = (
    BasicType
    | TextType
    | Sequence
    | Fixed
    | Map
    | ScopedName
    | Struct
    | Union
    | Enum
    | Bitset
)

Node: TypeAlias = (
    Module
    | Forward
    | Struct
    | Union
    | Enum
    | Bitset
    | Typedef
    | Const
    | Native
    | Interface
    | Valuetype
    | ValueBox
    | Component
    | Home
    | Identity
    | Import
    | Unused
    | Skipped
    | Member
    | Case
    | Bitfield
    | Operation
    | Attribute
    | State
    | PortItem
)
