"""Common parts of a codec's methods: compiled runs, helpers, names, sizes."""

from __future__ import annotations

import builtins
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import count as numbers

from rtgen.compiler.backends.kit.python_text import SKIPPED, WIDTH
from rtgen.compiler.backends.tecs.expressions import expression_text, is_simple
from rtgen.compiler.backends.tecs.values import kinds_text
from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    Item,
    Node,
    String,
    kinds,
    references,
)
from rtgen.compiler.model.c_types import Expression
from rtgen.compiler.typemap.python.names import identifier
from rtgen.compiler.typemap.tecs.python import IMPORTED_NAMES

_LOCALS = (
    *("self", "more", "first", "returned", "budget", "parts", "failure"),
    *("packet", "unpacked", "sop", "eop", "eop_bytes", "value"),
)
_SIMPLE = re.compile(r"[\w.]+|present\(\w+\)")
_MAX_INDENT = 16
"""Maximum indentation of a statement."""

_RESERVED = frozenset((*IMPORTED_NAMES, *_LOCALS, *dir(builtins)))


class Attributes:
    """The attributes of a generated class: compiled runs, arrays, texts, structs.

    `classes` are the names of struct classes, which local names avoid. `records` collects the
    classes that write and read structs.
    """

    def __init__(self, classes: Iterable[str]) -> None:
        self.classes = tuple(classes)
        self.records: list[str] = []
        self._runs: dict[str, str] = {}
        self._others: dict[str, str] = {}

    def record(self, struct: str) -> str:
        """Return the writer and reader of a struct whose size depends on values."""
        name = record_class(struct)
        if name not in self.records:
            self.records.append(name)
        self._others[f"_{struct}"] = f"{name}(codec)"
        return f"self._{struct}"

    def run(self, letters: Iterable[tuple[str, int]]) -> str:
        """Return the compiled run of these letters."""
        text = kinds_text(letters)
        name = self._runs.setdefault(text, f"_run{len(self._runs) + 1}")
        return f"self.{name}"

    def element(self, node: Node) -> str:
        """Return the compiled run of one element of an array."""
        return self.run(kinds(node))

    def items(self, basic: Basic) -> str:
        """Return the arrays of a kind of numbers."""
        name = f"_items_{basic.kind}" if basic.kind != "?" else "_booleans"
        self._others[name] = f'Items(tdr, "{basic.kind}")'
        return f"self.{name}"

    def text(self, node: String) -> str:
        """Return the texts of a kind of units."""
        if not node.is_wide:
            self._others["_text"] = "Text(tdr, codec.encoding)"
            return "self._text"
        self._others[f"_text_{node.kind}"] = f'WideText(tdr, "{node.kind}")'
        return f"self._text_{node.kind}"

    def statements(self) -> list[str]:
        """Return the statements that define the attributes."""
        runs = [f"self.{n} = tdr.struct({kinds})" for kinds, n in self._runs.items()]
        others = [f"self.{n} = {value}" for n, value in sorted(self._others.items())]
        return runs + others


def record_class(struct: str) -> str:
    """Return the class that writes and reads a struct whose size depends on values."""
    return f"{struct}Record"


class Scope:
    """The local names of a method."""

    def __init__(self, items: Iterable[Item], classes: Iterable[str] = ()) -> None:
        self._names: dict[str, str] = {}
        self._taken = {*_RESERVED, *classes}
        for item in items:
            self._names[item.name] = self.new(item.name) if item.name else "returned"
        self.loops = numbers(1)
        """Numbers for the variables of loops."""

    def new(self, name: str) -> str:
        """Return an unused name."""
        name = identifier(name, self._taken)
        self._taken.add(name)
        return name

    def of(self, item: Item) -> str:
        """Return the name of a parameter's or member's value."""
        return self._names[item.name]


class Environment:
    """The values from which the sizes of a message are computed.

    `values` are the expressions of the values by name, by default the names in `scope`; `given`
    those of the request if the message is a reply. A computed size gets a variable of its own.
    """

    def __init__(
        self,
        scope: Scope,
        items: Sequence[Item],
        values: Mapping[str, str] | None = None,
        given: Mapping[str, str] | None = None,
    ) -> None:
        self._scope = scope
        self._statements: list[str] = []
        self._items = {item.name: item for item in items}
        self._values = values or {item.name: scope.of(item) for item in items}
        self._given = given
        self.is_guarded = False

    def statements(self) -> list[str]:
        """Return the statements needed by the expressions returned since the last call."""
        found, self._statements = self._statements, []
        return found

    def count(self, node: Counted) -> str:
        """Return the number of transferred elements."""
        return self._variable(self._text(node.count, self._values))

    def length(self, node: String) -> str | None:
        """Return the size of the sender's buffer; None without one."""
        if node.length is None:
            return None
        return self._variable(self._text(node.length, self._values))

    def capacity(self, node: Counted | String) -> str | None:
        """Return the capacity of the receiver in elements or units; None if unknown."""
        size = node.size if isinstance(node, Counted) else node.length
        if size is None:
            return None
        if self._given is None:
            known = self._values
        elif all(name in self._given for name in references(size)):
            known = self._given
        elif isinstance(node, String):
            known = self._values
        else:
            return None
        text = self._text(size, known)
        if isinstance(node, Counted) and text == self._text(node.count, self._values):
            return None
        return self._variable(text)

    def reserved(self, node: Counted | String) -> str:
        """Return the capacity of the caller's buffer in elements or units."""
        size = node.size if isinstance(node, Counted) else node.length
        assert size is not None
        return self._variable(self._text(size, self._values))

    def _text(self, size: Expression, values: Mapping[str, str]) -> str:
        def names(name: str) -> tuple[str, Item]:
            return values[name], self._items[name]

        self.is_guarded |= not is_simple(size, names)
        return expression_text(size, names)

    def _variable(self, text: str) -> str:
        if _SIMPLE.fullmatch(text):
            return text
        name = self._scope.new("size")
        statement = f"{name} = {text}"
        is_long = len(statement) > WIDTH - _MAX_INDENT
        self._statements.append(f"{statement}{SKIPPED}" if is_long else statement)
        return name
