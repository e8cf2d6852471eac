"""Nodes of the syntax tree below declarations: names, literals, expressions, annotations.

`tree` exports them, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from rtgen.compiler.frontends.kit.nodes import Node


class Name(Node):
    """An identifier without its escape underscore."""

    text: str
    start: int
    end: int


class ScopedName(Node):
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


class Number(Node):
    """A number as written."""

    text: str
    start: int
    end: int


class Text(Node):
    """Adjacent string literals, or one character literal, as written with their quotes."""

    parts: tuple[str, ...]
    character: bool
    start: int
    end: int


class Boolean(Node):
    """`TRUE` or `FALSE`."""

    value: bool
    start: int
    end: int


class Unary(Node):
    """`-x`, `+x`, `~x`."""

    operator: str
    operand: Expression
    start: int
    end: int


class Chain(Node):
    """Operands joined by operators of one precedence, applied from the left."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]
    start: int
    end: int


class Group(Node):
    """An expression in parentheses."""

    inner: Expression
    start: int
    end: int


Expression: TypeAlias = Number | Text | Boolean | ScopedName | Unary | Chain | Group


def parts_of(expression: Expression) -> Iterator[Expression]:
    """Yield an expression and those inside it."""
    pending = [expression]
    while pending:
        part = pending.pop()
        yield part
        match part:
            case Unary(_, operand):
                pending.append(operand)
            case Group(inner):
                pending.append(inner)
            case Chain(first, rest):
                pending += [first, *(operand for _, operand in rest)]


# Annotations


class Argument(Node):
    """An argument of an annotation; `name` is None for the only, unnamed one."""

    name: Name | None
    value: Expression


class Annotation(Node):
    """`@name(arguments)`; `name` is without `@`, and may contain `::`."""

    name: str
    arguments: tuple[Argument, ...]
    start: int
    end: int
