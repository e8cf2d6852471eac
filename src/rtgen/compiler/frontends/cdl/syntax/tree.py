"""The syntax tree of CDL before name resolution: names, expressions, types (see `statements`).

Nodes are immutable and compared by identity, so that later passes can store facts about them in
tables. Positions are offsets into the text of the parsed file; `Unit.span` converts them to spans.
"""

from __future__ import annotations

from typing import TypeAlias

from rtgen.compiler.frontends.kit.nodes import Node
from rtgen.facts.tdr import Scalar


class Name(Node):
    """An identifier."""

    text: str
    start: int
    end: int


class ScopedName(Node):
    """`a::b`, or `::a::b` if absolute."""

    parts: tuple[Name, ...]
    absolute: bool
    start: int
    end: int

    def __str__(self) -> str:
        return "::" * self.absolute + "::".join(part.text for part in self.parts)


class TextPart(Node):
    """One of several adjacent string literals: the source text between its quotes."""

    text: str
    start: int
    end: int


class Text(Node):
    """Adjacent string literals. `text` is their concatenation, escapes as written."""

    parts: tuple[TextPart, ...]
    start: int
    end: int

    @property
    def text(self) -> str:
        """The literals joined."""
        return "".join(part.text for part in self.parts)


# Expressions


class Number(Node):
    """A number as written."""

    text: str
    start: int
    end: int


class Character(Node):
    """A character literal: the source text between its quotes."""

    text: str
    start: int
    end: int


class Boolean(Node):
    """`true` or `false`."""

    value: bool
    start: int
    end: int


class Group(Node):
    """An expression in parentheses."""

    inner: Expression
    start: int
    end: int


class Postfix(Node):
    """`operand[index]` and `operand.name`, applied from the left."""

    operand: Expression
    suffixes: tuple[Subscript | Name, ...]
    start: int
    end: int


class Subscript(Node):
    """`[index]` after an expression or a port; `index` is None for `[]`."""

    index: Expression | None
    start: int
    end: int


class Unary(Node):
    """`& * + - ~ !` before an operand."""

    operator: str
    operand: Expression
    start: int
    end: int


class Cast(Node):
    """`(type)operand`."""

    type: TypeName
    operand: Expression
    start: int
    end: int


class Chain(Node):
    """Operands joined by operators of one precedence, applied from the left."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]
    start: int
    end: int


class Conditional(Node):
    """`condition ? yes : no`."""

    condition: Expression
    yes: Expression
    no: Expression
    start: int
    end: int


Expression: TypeAlias = (
    ScopedName
    | Number
    | Character
    | Boolean
    | Text
    | Group
    | Postfix
    | Unary
    | Cast
    | Chain
    | Conditional
)


class CExp(Node):
    """`C_EXP( "text" )`."""

    text: Text
    start: int
    end: int


class Aggregate(Node):
    """`{ a, b, {c} }`."""

    items: tuple[Initialiser, ...]
    start: int
    end: int


class OfComposite(Node):
    """`composite.name`, as the value of an attribute or call port of an inner cell."""

    name: Name
    start: int
    end: int


Initialiser: TypeAlias = Expression | CExp | Aggregate


# Specifiers


class Specifier(Node):
    """A specifier in brackets: its keyword, and its arguments in source order.

    | word | arguments |
    |---|---|
    | `size_is` | `Expression`, or two |
    | `count_is`, `id` | `Expression` |
    | `string` | none, or `Expression` |
    | `send`, `receive` | `ScopedName` |
    | `context` | `Text` |
    | `generate`, `through` | `Name`, `Text` |
    | `in_through`, `out_through` | none, or `Name`, `Text` |
    | `to_through` | `Name`, or `Name`, `Name`, `Text` |
    | `domain`, `class` | `Name`, or `Name`, `Text` |
    | `choice` | `Text`, one or more |
    | `allocator` | `Allocation`, one or more |
    | `restrict` | `Restriction`, one or more |
    | any other | none |
    """

    word: str
    arguments: tuple[SpecifierArgument, ...]
    start: int
    end: int


class Allocation(Node):
    """`port[i].function.parameter = value`, `port.function = value`, `port.function <= value`.

    `operator` is `=` or `<=`.
    """

    path: tuple[Name, ...]
    subscript: Subscript | None
    operator: str
    value: Initialiser
    start: int
    end: int


class Restriction(Node):
    """`port = { regions }` or `port.function = { regions }`."""

    path: tuple[Name, ...]
    regions: tuple[ScopedName, ...]
    start: int
    end: int


SpecifierArgument: TypeAlias = (
    Expression | Name | ScopedName | Text | Allocation | Restriction
)


class Specifiers(Node):
    """A specifier list; `broken`: it contained an invalid specifier, already reported."""

    items: tuple[Specifier, ...]
    broken: bool
    start: int
    end: int


# Types and declarators


class BasicType(Node):
    """A basic type; `sign` is `signed` or `unsigned` if written.

    `plain` distinguishes `char` from `char_t`, which have the same kind.
    """

    kind: Scalar
    plain: bool
    sign: str | None
    start: int
    end: int


class TypedefName(Node):
    """The name of a typedef."""

    name: Name
    start: int
    end: int


class StructSpecifier(Node):
    """`struct tag`, or a struct with its members (which may have no tag)."""

    tag: Name | None
    members: tuple[MemberItem, ...] | None
    start: int
    end: int


class EnumSpecifier(Node):
    """`enum tag`, or an enum with its enumerators; `keyword` is `enum`, `enum8` ..."""

    keyword: str
    tag: Name | None
    enumerators: tuple[Enumerator, ...] | None
    start: int
    end: int


class Enumerator(Node):
    """`name` or `name = value`."""

    name: Name
    value: Expression | None


class DescriptorOf(Node):
    """`Descriptor( signature )`."""

    signature: ScopedName
    start: int
    end: int


TypeSpecifier: TypeAlias = (
    BasicType | TypedefName | StructSpecifier | EnumSpecifier | DescriptorOf
)


class QualifiedType(Node):
    """A type with the qualifiers before it (`const`, `volatile`)."""

    qualifiers: tuple[Name, ...]
    type: TypeSpecifier
    start: int
    end: int


class Pointer(Node):
    """A `*` with the qualifier after it."""

    qualifier: Name | None
    start: int
    end: int


class ArraySuffix(Node):
    """`[size]` or `[]`."""

    size: Expression | None
    start: int
    end: int


class Parameters(Node):
    """`( parameters )`; empty for `()`."""

    items: tuple[Parameter, ...]
    start: int
    end: int


class Declarator(Node):
    """A declarator as in C; `inner` is None for an abstract one."""

    pointers: tuple[Pointer, ...]
    inner: Name | Declarator | None
    suffixes: tuple[ArraySuffix | Parameters, ...]
    start: int
    end: int

    @property
    def name(self) -> Name | None:
        """The declared name."""
        inner = self.inner
        while isinstance(inner, Declarator):
            inner = inner.inner
        return inner


class InitDeclarator(Node):
    """A declarator with its initialiser."""

    declarator: Declarator
    value: Initialiser | None
    start: int
    end: int


class Declaration(Node):
    """`type a = 1, *b` of constants, attributes and variables."""

    type: QualifiedType
    declarators: tuple[InitDeclarator, ...]
    start: int
    end: int


class TypeName(Node):
    """A type in a cast."""

    type: QualifiedType
    declarator: Declarator | None
    start: int
    end: int


class Parameter(Node):
    """A parameter; a valid one has both specifiers and a name."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarator: Declarator | None
    start: int
    end: int


class MemberItem(Node):
    """`type a, b;` of a struct."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarators: tuple[Declarator, ...]
    start: int
    end: int


# Statements


class Typedef(Node):
    """`typedef type a, *b`."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarators: tuple[Declarator, ...]
    start: int
    end: int


class TypeStatement(Node):
    """A declaration of a struct or enum without declarators."""

    type: StructSpecifier | EnumSpecifier
    start: int
    end: int
