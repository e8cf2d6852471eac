"""Parser callbacks for expressions, and helpers for all callbacks: places, names, selections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.cdl.syntax.keywords import WORDS

if TYPE_CHECKING:
    from rtgen.compiler.frontends.kit.lalr import Token


Children: TypeAlias = list[Any]


def start_of(node: Any) -> int:
    """Return the start offset of a node or token."""
    start: int = node.start if hasattr(node, "start") else node.start_pos
    return start


def end_of(node: Any) -> int:
    """Return the end offset of a node or token."""
    end: int = node.end if hasattr(node, "end") else node.end_pos
    return end


def name_of(token: Token) -> tree.Name:
    return tree.Name(token.start_pos, token.end_pos, str(token))


def word_of(token: Token) -> str:
    """Return the keyword of a token, even if error recovery replaced it."""
    return WORDS[token.type]


def keyword_of(token: Token) -> tree.Name:
    return tree.Name(token.start_pos, token.end_pos, word_of(token))


def nodes_in(children: Children, *kinds: type) -> tuple[Any, ...]:
    """Return the children that are nodes of that class."""
    return tuple(child for child in children if isinstance(child, kinds))


def first_in(children: Children, *kinds: type) -> Any:
    """Return the first child of that node class, or None."""
    return next((child for child in children if isinstance(child, kinds)), None)


def tokens_in(children: Children, *types: str) -> list[Token]:
    return [child for child in children if getattr(child, "type", None) in types]


def is_token(child: Any, kind: str) -> bool:
    return getattr(child, "type", None) == kind


class ExpressionBuilder:
    """The rules of `cdl.lark` for expressions and initialisers."""

    def aggregate(self, children: Children) -> tree.Aggregate:
        opening, *items, closing = children
        return tree.Aggregate(opening.start_pos, closing.end_pos, tuple(items))

    def c_exp(self, children: Children) -> tree.CExp:
        keyword, _, text, end = children
        return tree.CExp(keyword.start_pos, end.end_pos, text)

    def conditional(self, children: Children) -> tree.Conditional:
        condition, yes, _, no = children
        return tree.Conditional(condition.start, no.end, condition, yes, no)

    def chain(self, children: Children) -> tree.Chain:
        pairs = tuple(
            (str(children[i]), children[i + 1]) for i in range(1, len(children), 2)
        )
        return tree.Chain(children[0].start, children[-1].end, children[0], pairs)

    def cast(self, children: Children) -> tree.Cast:
        opening, type_, _, operand = children
        return tree.Cast(opening.start_pos, operand.end, type_, operand)

    def unary_op(self, children: Children) -> tree.Unary:
        operator, operand = children
        return tree.Unary(operator.start_pos, operand.end, str(operator), operand)

    def postfix_chain(self, children: Children) -> tree.Postfix:
        operand, *suffixes = children
        return tree.Postfix(operand.start, suffixes[-1].end, operand, tuple(suffixes))

    def postfix_part(self, children: Children) -> tree.Subscript | tree.Name:
        if len(children) == 2:
            return name_of(children[1])
        return self.subscript(children)

    def group(self, children: Children) -> tree.Group:
        opening, inner, closing = children
        return tree.Group(opening.start_pos, closing.end_pos, inner)

    def scoped_name(self, children: Children) -> tree.ScopedName:
        first = children[0]
        if len(children) == 1:
            name = name_of(first)
            return tree.ScopedName(name.start, name.end, (name,), False)
        parts = tuple(name_of(token) for token in children if token.type != "SCOPE")
        return tree.ScopedName(
            first.start_pos, parts[-1].end, parts, first.type == "SCOPE"
        )

    def number(self, children: Children) -> tree.Number:
        (token,) = children
        return tree.Number(token.start_pos, token.end_pos, str(token))

    def character(self, children: Children) -> tree.Character:
        (token,) = children
        return tree.Character(token.start_pos, token.end_pos, token[1:-1])

    def boolean(self, children: Children) -> tree.Boolean:
        (token,) = children
        return tree.Boolean(token.start_pos, token.end_pos, token.type == "TRUE")

    def text(self, children: Children) -> tree.Text:
        parts = tuple(
            tree.TextPart(token.start_pos + 1, token.end_pos - 1, token[1:-1])
            for token in children
        )
        return tree.Text(start_of(children[0]), end_of(children[-1]), parts)

    def subscript(self, children: Children) -> tree.Subscript:
        opening, *index, closing = children
        return tree.Subscript(
            opening.start_pos, closing.end_pos, index[0] if index else None
        )
