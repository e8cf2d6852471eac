"""Generates the source text of functions that copy a value."""

from __future__ import annotations

from rtgen.runtime.marshalling.layouts.nodes import (
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Group,
    Member,
    MemberList,
    Node,
    Optional,
    Path,
    Records,
    Repeat,
    Text,
    TextArray,
    TextSequence,
)
from rtgen.runtime.marshalling.numeric import copied, listed
from rtgen.runtime.marshalling.octets import copied_octets
from rtgen.runtime.marshalling.source.references import References
from rtgen.runtime.marshalling.source.text import Body, Locals


class Copier:
    """Generates the body of `_snapshot_`.

    `unset`: members of recursive types may be None, since `@external` ones are until assigned.
    """

    def __init__(self, references: References, unset: bool = False) -> None:
        self._refer = references
        self._unset = unset
        self._locals = Locals(references.namespace)
        self.body = Body(references.namespace)

    def copy(self, node: Node, value: str, path: Path = ()) -> str:
        """Return an expression for a deep copy; immutable values are shared."""
        match node:
            case AtomSequence() | AtomArray() | Records() if node.form != "list":
                other = f"{self._refer.function(copied)}({value})"
                return f"[*{value}] if {value}.__class__ is list else {other}"
            case AtomSequence():
                return self._list(value)
            case AtomArray(dimensions=dimensions):
                return self._list(value, len(dimensions))
            case TextSequence(text=Text.OCTETS) | TextArray(text=Text.OCTETS):
                other = f"{self._refer.function(copied_octets)}({value})"
                return f"{value} if {value}.__class__ is bytes else {other}"
            case Repeat(key=key) if key is not None:
                inner = self._inner(node.element)
                return f"{{key: {inner} for key, item in {value}.items()}}"
            case Records(element=element) | Repeat(element=element):
                inner = self._inner(element)
                return (
                    f"list({value})"
                    if inner == "item"
                    else f"[{inner} for item in {value}]"
                )
            case Delimited(node=inner_node):
                return self.copy(inner_node, value, path)
            case Optional(node=inner_node) | Member(node=inner_node, optional=True):
                made = _Inline(self._refer, self._unset).copy(inner_node, value)
                tested = self._unset and isinstance(inner_node, Call)
                return made if made == value or tested else _unless_none(value, made)
            case Member(node=inner_node):
                return self.copy(inner_node, value, path)
            case Group(type=type_, members=members) | MemberList(
                type=type_, members=members
            ):
                if path:
                    variable = self._locals.name(path)
                    self.body.add(f"{variable} = {value}")
                    value = variable
                copies = [self.copy(n, f"{value}.{m}", (*path, m)) for m, n in members]
                return f"{self._refer.made(type_)}({', '.join(copies)})"
            case Call():
                made = f"{value}._snapshot_()"
                return _unless_none(value, made) if self._unset else made
        return value

    def _list(self, value: str, depth: int = 1) -> str:
        """Return a list with the numbers of a list, or of an object in another form."""
        listing = self._refer.function(listed)
        text, other = f"[*{value}]", f"{listing}({value})"
        if depth > 1:
            text = f"[{self._list('row', depth - 1)} for row in {value}]"
            other = f"{listing}({value}, {depth})"
        return f"{text} if {value}.__class__ is list else {other}"

    def _inner(self, node: Node) -> str:
        """Return the copy of `item`, within a comprehension."""
        return _Inline(self._refer, self._unset).copy(node, "item")


class _Inline(Copier):
    """Generates copies without variables."""

    def copy(self, node: Node, value: str, path: Path = ()) -> str:
        if isinstance(node, Group):
            copies = [
                self.copy(inner, f"{value}.{name}") for name, inner in node.members
            ]
            return f"{self._refer.made(node.type)}({', '.join(copies)})"
        return super().copy(node, value)


def _unless_none(value: str, text: str) -> str:
    return f"None if {value} is None else {text}"
