"""Parser callbacks for expressions and annotations, and helpers for all callbacks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from rtgen.compiler.frontends.idl.syntax import tree

if TYPE_CHECKING:
    from rtgen.compiler.frontends.kit.lalr import Token


Children: TypeAlias = list[Any]


def end_of(token: Token) -> int:
    return token.end_pos


def start_of(node: Any) -> int:
    """Return the start offset of a node or token."""
    is_token = isinstance(node, str)
    start: int = node.start_pos if is_token else node.start
    return start


def name_of(token: Token) -> tree.Name:
    return tree.Name(token.removeprefix("_") or "_", token.start_pos, token.end_pos)


def chain_of(children: Children, operator: str) -> tree.Chain:
    first, *rest = children
    pairs = tuple((operator, operand) for operand in rest)
    return tree.Chain(first, pairs, first.start, rest[-1].end)


class ExpressionBuilder:
    """The rules of `idl.lark` for expressions and annotations."""

    def or_chain(self, children: Children) -> tree.Chain:
        return chain_of(children, "|")

    def xor_chain(self, children: Children) -> tree.Chain:
        return chain_of(children, "^")

    def and_chain(self, children: Children) -> tree.Chain:
        return chain_of(children, "&")

    def chain(self, children: Children) -> tree.Chain:
        pairs = tuple(
            (str(children[i]), children[i + 1]) for i in range(1, len(children), 2)
        )
        return tree.Chain(children[0], pairs, children[0].start, children[-1].end)

    def unary_op(self, children: Children) -> tree.Unary:
        operator, operand = children
        return tree.Unary(str(operator), operand, start_of(operator), operand.end)

    def group(self, children: Children) -> tree.Group:
        opening, inner, closing = children
        return tree.Group(inner, start_of(opening), end_of(closing))

    def number(self, children: Children) -> tree.Number:
        (token,) = children
        return tree.Number(str(token), start_of(token), end_of(token))

    def text(self, children: Children) -> tree.Text:
        return tree.Text(
            tuple(map(str, children)),
            children[0].type == "CHARACTER",
            start_of(children[0]),
            end_of(children[-1]),
        )

    def boolean(self, children: Children) -> tree.Boolean:
        (token,) = children
        return tree.Boolean(token.type == "TRUE", start_of(token), end_of(token))

    def scoped_name(self, children: Children) -> tree.ScopedName:
        first = children[0]
        if len(children) == 1:
            name = name_of(first)
            return tree.ScopedName((name,), False, name.start, name.end)
        parts = tuple(name_of(token) for token in children if token.type != "SCOPE")
        return tree.ScopedName(
            parts, first.type == "SCOPE", start_of(first), parts[-1].end
        )

    def annotation(self, children: Children) -> tree.Annotation:
        token = children[0]
        arguments = tuple(c for c in children if isinstance(c, tree.Argument))
        return self._annotation(token, arguments, end_of(children[-1]))

    def annotation_value(self, children: Children) -> tree.Annotation:
        token, _, value, closing = children
        return self._annotation(token, (tree.Argument(None, value),), end_of(closing))

    def _annotation(
        self, token: Token, arguments: tuple[tree.Argument, ...], end: int
    ) -> tree.Annotation:
        name = "".join(token[1:].split()).removeprefix("::")
        return tree.Annotation(name, arguments, start_of(token), end)

    def argument(self, children: Children) -> tree.Argument:
        name, _, value = children
        return tree.Argument(name_of(name), value)

    def annotation_item(self, children: Children) -> tree.Name | None:
        named = len(children) > 2
        return name_of(children[1]) if named else None

    def annotation_dcl(self, children: Children) -> tree.AnnotationDcl:
        members = (c.text for c in children if type(c) is tree.Name)
        return tree.AnnotationDcl(
            name_of(children[1]),
            tuple(members),
            start_of(children[0]),
            end_of(children[-1]),
        )
