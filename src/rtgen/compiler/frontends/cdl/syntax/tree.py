"""The syntax tree of CDL before name resolution: names, expressions, types (see `statements`).

Nodes are immutable and compared by identity, so that later passes can store facts about them in
tables. Positions are offsets into the text of the parsed file; `Unit.span` converts them to spans.
"""

from __future__ import annotations

from typing import TypeAlias

from rtgen.compiler.frontends.kit.nodes import Node, Spanned
from rtgen.facts.tdr import Scalar


class Name(Spanned):
    """An identifier."""

    text: str


class ScopedName(Spanned):
    """`a::b`, or `::a::b` if absolute."""

    parts: tuple[Name, ...]
    absolute: bool

    def __str__(self) -> str:
        return "::" * self.absolute + "::".join(part.text for part in self.parts)


class TextPart(Spanned):
    """One of several adjacent string literals: the source text between its quotes."""

    text: str


class Text(Spanned):
    """Adjacent string literals. `text` is their concatenation, escapes as written."""

    parts: tuple[TextPart, ...]

    @property
    def text(self) -> str:
        """The literals joined."""
        return "".join(part.text for part in self.parts)


# Expressions


class Number(Spanned):
    """A number as written."""

    text: str


class Character(Spanned):
    """A character literal: the source text between its quotes."""

    text: str


class Boolean(Spanned):
    """`true` or `false`."""

    value: bool


class Group(Spanned):
    """An expression in parentheses."""

    inner: Expression


class Postfix(Spanned):
    """`operand[index]` and `operand.name`, applied from the left."""

    operand: Expression
    suffixes: tuple[Subscript | Name, ...]


class Subscript(Spanned):
    """`[index]` after an expression or a port; `index` is None for `[]`."""

    index: Expression | None


class Unary(Spanned):
    """`& * + - ~ !` before an operand."""

    operator: str
    operand: Expression


class Cast(Spanned):
    """`(type)operand`."""

    type: TypeName
    operand: Expression


class Chain(Spanned):
    """Operands joined by operators of one precedence, applied from the left."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]


class Conditional(Spanned):
    """`condition ? yes : no`."""

    condition: Expression
    yes: Expression
    no: Expression


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


class CExp(Spanned):
    """`C_EXP( "text" )`."""

    text: Text


class Aggregate(Spanned):
    """`{ a, b, {c} }`."""

    items: tuple[Initialiser, ...]


class OfComposite(Spanned):
    """`composite.name`, as the value of an attribute or call port of an inner cell."""

    name: Name


Initialiser: TypeAlias = Expression | CExp | Aggregate


# Specifiers


class Specifier(Spanned):
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


class Allocation(Spanned):
    """`port[i].function.parameter = value`, `port.function = value`, `port.function <= value`.

    `operator` is `=` or `<=`.
    """

    path: tuple[Name, ...]
    subscript: Subscript | None
    operator: str
    value: Initialiser


class Restriction(Spanned):
    """`port = { regions }` or `port.function = { regions }`."""

    path: tuple[Name, ...]
    regions: tuple[ScopedName, ...]


SpecifierArgument: TypeAlias = (
    Expression | Name | ScopedName | Text | Allocation | Restriction
)


class Specifiers(Spanned):
    """A specifier list; `broken`: it contained an invalid specifier, already reported."""

    items: tuple[Specifier, ...]
    broken: bool


# Types and declarators


class BasicType(Spanned):
    """A basic type; `sign` is `signed` or `unsigned` if written.

    `plain` distinguishes `char` from `char_t`, which have the same kind.
    """

    kind: Scalar
    plain: bool
    sign: str | None


class TypedefName(Spanned):
    """The name of a typedef."""

    name: Name


class StructSpecifier(Spanned):
    """`struct tag`, or a struct with its members (which may have no tag)."""

    tag: Name | None
    members: tuple[MemberItem, ...] | None


class EnumSpecifier(Spanned):
    """`enum tag`, or an enum with its enumerators; `keyword` is `enum`, `enum8` ..."""

    keyword: str
    tag: Name | None
    enumerators: tuple[Enumerator, ...] | None


class Enumerator(Node):
    """`name` or `name = value`."""

    name: Name
    value: Expression | None


class DescriptorOf(Spanned):
    """`Descriptor( signature )`."""

    signature: ScopedName


TypeSpecifier: TypeAlias = (
    BasicType | TypedefName | StructSpecifier | EnumSpecifier | DescriptorOf
)


class QualifiedType(Spanned):
    """A type with the qualifiers before it (`const`, `volatile`)."""

    qualifiers: tuple[Name, ...]
    type: TypeSpecifier


class Pointer(Spanned):
    """A `*` with the qualifier after it."""

    qualifier: Name | None


class ArraySuffix(Spanned):
    """`[size]` or `[]`."""

    size: Expression | None


class Parameters(Spanned):
    """`( parameters )`; empty for `()`."""

    items: tuple[Parameter, ...]


class Declarator(Spanned):
    """A declarator as in C; `inner` is None for an abstract one."""

    pointers: tuple[Pointer, ...]
    inner: Name | Declarator | None
    suffixes: tuple[ArraySuffix | Parameters, ...]

    @property
    def name(self) -> Name | None:
        """The declared name."""
        inner = self.inner
        while isinstance(inner, Declarator):
            inner = inner.inner
        return inner


class InitDeclarator(Spanned):
    """A declarator with its initialiser."""

    declarator: Declarator
    value: Initialiser | None


class Declaration(Spanned):
    """`type a = 1, *b` of constants, attributes and variables."""

    type: QualifiedType
    declarators: tuple[InitDeclarator, ...]


class TypeName(Spanned):
    """A type in a cast."""

    type: QualifiedType
    declarator: Declarator | None


class Parameter(Spanned):
    """A parameter; a valid one has both specifiers and a name."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarator: Declarator | None


class MemberItem(Spanned):
    """`type a, b;` of a struct."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarators: tuple[Declarator, ...]


# Statements


class Typedef(Spanned):
    """`typedef type a, *b`."""

    specifiers: Specifiers | None
    type: QualifiedType
    declarators: tuple[Declarator, ...]


class TypeStatement(Spanned):
    """A declaration of a struct or enum without declarators."""

    type: StructSpecifier | EnumSpecifier
