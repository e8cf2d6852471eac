"""Parser callbacks for expressions, and helpers for all callbacks: places, names, selections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from rtgen.compiler.frontends.cdl.syntax import tree
from rtgen.compiler.frontends.cdl.syntax.keywords import WORDS

if TYPE_CHECKING:
    from rtgen.compiler.frontends.kit.lalr import Token


Children: TypeAlias = list[Any]


NAMED = ("IDENT", "TYPE_NAME")


def start_of(node: Any) -> int:
    """Return the start offset of a node or token."""
    start: int = node.start if hasattr(node, "start") else node.start_pos
    return start


def end_of(node: Any) -> int:
    """Return the end offset of a node or token."""
    end: int = node.end if hasattr(node, "end") else node.end_pos
    return end


def name_of(token: Token) -> tree.Name:
    return tree.Name(str(token), token.start_pos, token.end_pos)


def word_of(token: Token) -> str:
    """Return the keyword of a token, even if error recovery replaced it."""
    return WORDS[token.type]


def keyword_of(token: Token) -> tree.Name:
    return tree.Name(word_of(token), token.start_pos, token.end_pos)


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
        return tree.Aggregate(tuple(items), opening.start_pos, closing.end_pos)

    def c_exp(self, children: Children) -> tree.CExp:
        keyword, _, text, end = children
        return tree.CExp(text, keyword.start_pos, end.end_pos)

    def conditional(self, children: Children) -> tree.Conditional:
        condition, yes, _, no = children
        return tree.Conditional(condition, yes, no, condition.start, no.end)

    def chain(self, children: Children) -> tree.Chain:
        pairs = tuple(
            (str(children[i]), children[i + 1]) for i in range(1, len(children), 2)
        )
        return tree.Chain(children[0], pairs, children[0].start, children[-1].end)

    def cast(self, children: Children) -> tree.Cast:
        opening, type_, _, operand = children
        return tree.Cast(type_, operand, opening.start_pos, operand.end)

    def unary_op(self, children: Children) -> tree.Unary:
        operator, operand = children
        return tree.Unary(str(operator), operand, operator.start_pos, operand.end)

    def postfix_chain(self, children: Children) -> tree.Postfix:
        operand, *suffixes = children
        return tree.Postfix(operand, tuple(suffixes), operand.start, suffixes[-1].end)

    def postfix_part(self, children: Children) -> tree.Subscript | tree.Name:
        if len(children) == 2:
            return name_of(children[1])
        return self.subscript(children)

    def group(self, children: Children) -> tree.Group:
        opening, inner, closing = children
        return tree.Group(inner, opening.start_pos, closing.end_pos)

    def scoped_name(self, children: Children) -> tree.ScopedName:
        first = children[0]
        if len(children) == 1:
            name = name_of(first)
            return tree.ScopedName((name,), False, name.start, name.end)
        parts = tuple(name_of(token) for token in children if token.type != "SCOPE")
        return tree.ScopedName(
            parts, first.type == "SCOPE", first.start_pos, parts[-1].end
        )

    def number(self, children: Children) -> tree.Number:
        (token,) = children
        return tree.Number(str(token), token.start_pos, token.end_pos)

    def character(self, children: Children) -> tree.Character:
        (token,) = children
        return tree.Character(token[1:-1], token.start_pos, token.end_pos)

    def boolean(self, children: Children) -> tree.Boolean:
        (token,) = children
        return tree.Boolean(token.type == "TRUE", token.start_pos, token.end_pos)

    def text(self, children: Children) -> tree.Text:
        parts = tuple(
            tree.TextPart(token[1:-1], token.start_pos + 1, token.end_pos - 1)
            for token in children
        )
        return tree.Text(parts, start_of(children[0]), end_of(children[-1]))

    def subscript(self, children: Children) -> tree.Subscript:
        opening, *index, closing = children
        return tree.Subscript(
            index[0] if index else None, opening.start_pos, closing.end_pos
        )
