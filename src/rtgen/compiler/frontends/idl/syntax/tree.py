"""Syntax tree: the text as written, before names are resolved.

Nodes are immutable and compared by identity, so that later passes can store facts about them in
tables. Positions are offsets into the text of the parsed unit.
"""

from __future__ import annotations

from typing import TypeAlias

from rtgen.compiler.frontends.idl.syntax.expression_tree import Annotation as Annotation
from rtgen.compiler.frontends.idl.syntax.expression_tree import Argument as Argument
from rtgen.compiler.frontends.idl.syntax.expression_tree import Boolean as Boolean
from rtgen.compiler.frontends.idl.syntax.expression_tree import Chain as Chain
from rtgen.compiler.frontends.idl.syntax.expression_tree import Expression as Expression
from rtgen.compiler.frontends.idl.syntax.expression_tree import Group as Group
from rtgen.compiler.frontends.idl.syntax.expression_tree import Name as Name
from rtgen.compiler.frontends.idl.syntax.expression_tree import Number as Number
from rtgen.compiler.frontends.idl.syntax.expression_tree import ScopedName as ScopedName
from rtgen.compiler.frontends.idl.syntax.expression_tree import Text as Text
from rtgen.compiler.frontends.idl.syntax.expression_tree import Unary as Unary
from rtgen.compiler.frontends.idl.syntax.expression_tree import parts_of as parts_of
from rtgen.compiler.frontends.kit.nodes import Node
from rtgen.compiler.model import Direction, Primitive

# Types


class BasicType(Node):
    """A basic type."""

    kind: Primitive
    start: int
    end: int


class TextType(Node):
    """`string` or `wstring`."""

    wide: bool
    bound: Expression | None
    start: int
    end: int


class Sequence(Node):
    """`sequence<element, bound>`."""

    element: TypeNode
    bound: Expression | None
    start: int
    end: int


class Fixed(Node):
    """`fixed<digits, scale>`, or plain `fixed` in a constant."""

    digits: Expression | None
    scale: Expression | None
    start: int
    end: int


class Map(Node):
    """`map<key, value, bound>`."""

    key: TypeNode
    value: TypeNode
    bound: Expression | None
    start: int
    end: int


class Declarator(Node):
    """A name with the dimensions of an array."""

    name: Name
    dimensions: tuple[Expression, ...]
    start: int
    end: int


# Declarations


class Body(Node):
    """The content of braces; [start, end) is the text between them."""

    items: tuple[Item, ...]
    start: int
    end: int


class Item(Node):
    """An entry of a body or file, up to its `;`: annotations and a node."""

    annotations: tuple[Annotation, ...]
    node: AnyNode
    start: int
    end: int


class Module(Node):
    """A module, or one opening of it; `template` marks a template module."""

    name: Name
    body: Body
    start: int
    template: bool = False


class Forward(Node):
    """A forward declaration: `keyword` is struct, union, interface, valuetype, component ..."""

    keyword: str
    name: Name
    modifier: str
    start: int


class Member(Node):
    """Struct, exception and state members: one type, one or more declarators."""

    type: TypeNode
    declarators: tuple[Declarator, ...]
    start: int


class Struct(Node):
    """A struct or (with `exception`) an exception."""

    name: Name
    base: ScopedName | None
    body: Body
    start: int
    exception: bool = False

    @property
    def end(self) -> int:
        return self.body.end + 1


class Label(Node):
    """`case value:`, or `default:` where `value` is None."""

    value: Expression | None
    start: int
    end: int


class Case(Node):
    """A branch of a union."""

    labels: tuple[Label, ...]
    type: TypeNode
    declarator: Declarator
    start: int


class Union(Node):
    """A union."""

    name: Name
    switch: TypeNode
    body: Body
    start: int

    @property
    def end(self) -> int:
        return self.body.end + 1


class Enumerator(Node):
    """A member of an enum or bitmask; `value` only if one was written, which is an error."""

    annotations: tuple[Annotation, ...]
    name: Name
    value: Expression | None
    start: int
    end: int


class Enum(Node):
    """An enum, or (with `mask`) a bitmask. `trailing` is the place of a trailing comma."""

    name: Name
    members: tuple[Enumerator, ...]
    trailing: int | None
    start: int
    end: int
    mask: bool = False


class Bitfield(Node):
    """`bitfield<bits, type> names;`."""

    bits: Expression
    type: TypeNode | None
    names: tuple[Name, ...]
    start: int


class Bitset(Node):
    """A bitset."""

    name: Name
    base: ScopedName | None
    body: Body
    start: int

    @property
    def end(self) -> int:
        return self.body.end + 1


class Typedef(Node):
    """A typedef with one or more declarators."""

    type: TypeNode
    declarators: tuple[Declarator, ...]
    start: int


class Const(Node):
    """A constant."""

    type: TypeNode
    name: Name
    value: Expression
    start: int


class Native(Node):
    """A native type."""

    name: Name
    start: int


class Parameter(Node):
    """A parameter; `direction` is None if missing."""

    annotations: tuple[Annotation, ...]
    direction: Direction | None
    type: TypeNode
    declarator: Declarator
    start: int
    end: int


class Names(Node):
    """A list of scoped names, such as after `raises`; its place is that of the clause."""

    keyword: str
    names: tuple[ScopedName, ...]
    start: int
    end: int


class Operation(Node):
    """An operation, or (with `factory`) a factory or finder, which has no type."""

    name: Name
    type: TypeNode | None
    parameters: tuple[Parameter, ...]
    raises: Names | None
    context: tuple[Text, ...]
    oneway: bool
    start: int
    end: int
    factory: str = ""


class Attribute(Node):
    """Attributes of one type."""

    type: TypeNode
    names: tuple[Name, ...]
    readonly: bool
    get_raises: Names | None
    set_raises: Names | None
    start: int


class Interface(Node):
    """An interface; `modifier` is abstract, local or empty."""

    name: Name
    bases: tuple[ScopedName, ...]
    body: Body
    modifier: str
    start: int


class State(Node):
    """State members of a valuetype."""

    public: bool
    member: Member
    start: int


class Valuetype(Node):
    """A valuetype or eventtype; `modifier` is abstract, custom or empty."""

    keyword: str
    name: Name
    bases: tuple[ScopedName, ...]
    truncatable: bool
    supports: tuple[ScopedName, ...]
    body: Body
    modifier: str
    start: int


class ValueBox(Node):
    """`valuetype name type`."""

    name: Name
    type: TypeNode
    start: int


class PortItem(Node):
    """`provides`, `uses`, `publishes`, `consumes`, `emits` (or `port`, `mirrorport`) T name."""

    keyword: str
    type: TypeNode
    name: Name
    start: int
    end: int


class Component(Node):
    """A component."""

    name: Name
    base: ScopedName | None
    supports: tuple[ScopedName, ...]
    body: Body
    start: int


class Home(Node):
    """A component home."""

    name: Name
    base: ScopedName | None
    supports: tuple[ScopedName, ...]
    manages: ScopedName
    key: ScopedName | None
    body: Body
    start: int


class Identity(Node):
    """`typeid name "text"` and `typeprefix name "text"`."""

    keyword: str
    name: ScopedName
    text: Text
    start: int


class Import(Node):
    """`import name`."""

    name: ScopedName | None
    start: int


class AnnotationDcl(Node):
    """`@annotation name { ... }`, with the names of its members."""

    name: Name
    members: tuple[str, ...]
    start: int
    end: int


class Unused(Node):
    """A construct that is parsed but not supported: porttype, connector, template module ...

    `target` is the module of an alias.
    """

    keyword: str
    name: Name | None
    start: int
    end: int
    target: ScopedName | None = None


class Skipped(Node):
    """Skipped text: a declaration with a syntax error, or an extra semicolon."""

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

AnyNode: TypeAlias = (
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
    | AnnotationDcl
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
