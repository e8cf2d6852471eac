"""Values of fixed size: arguments of `pack`, and values from the items of `unpack`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count as numbers

from rtgen.compiler.layouts.tdr import (
    Basic,
    FixedArray,
    Item,
    Node,
    Nothing,
    Octets,
    Record,
    Run,
)
from rtgen.compiler.typemap.tecs.python import member_name, struct_class


def packed(node: Node, value: str, letters: Iterator[int]) -> list[str]:
    """Return the arguments of `pack` for a value; `letters` number the loops."""
    match node:
        case Nothing():
            return []
        case Basic():
            return [_packed_basic(node, value)]
        case Octets(count=count):
            return [f"exactly({value}, {count})"]
        case FixedArray(element, count):
            values = f"exactly({value}, {count})"
            if isinstance(element, Basic) and element.kind not in "bBwW":
                return [f"*{values}"]
            each = f"each{next(letters)}"
            inner = packed(element, each, letters)
            if len(inner) == 1 and not inner[0].startswith("*"):
                return [f"*[{inner[0]} for {each} in {values}]"]
            part = f"part{next(letters)}"
            group = inner[0][1:] if len(inner) == 1 else f"({', '.join(inner)})"
            return [f"*[{part} for {each} in {values} for {part} in {group}]"]
        case Record():
            arguments: list[str] = []
            for item in fields(node):
                path = f"{value}.{member_name(item.name)}"
                arguments += packed(item.node, path, letters)
            return arguments
    raise AssertionError(node)


def _packed_basic(node: Basic, value: str) -> str:
    match node.kind:
        case "b":
            return f"INT8[{value}]"
        case "B":
            return f"UINT8[{value}]"
        case "w" | "W":
            return f"self.tdr.wide({value}, {node.kind == 'w'})"
    return value


def unpacked(node: Node, source: str, start: str) -> str:
    """Return the value from the tuple `source`, whose first part is at index `start`."""
    return _unpacked(node, source, _Index(start), numbers(1))


class _Index:
    """An index: a constant, or a loop's variable and a constant."""

    def __init__(self, text: str) -> None:
        name, _, offset = text.rpartition(" + ")
        self.name = name if name else ("" if text.isdigit() else text)
        self.offset = int(offset) if offset.isdigit() else 0

    def plus(self, count: int) -> _Index:
        """Return the index plus a constant."""
        index = _Index(self.name)
        index.offset = self.offset + count
        return index

    def __str__(self) -> str:
        if not self.name:
            return str(self.offset)
        return f"{self.name} + {self.offset}" if self.offset else self.name


def _unpacked(node: Node, source: str, at: _Index, letters: Iterator[int]) -> str:
    match node:
        case Basic():
            value = f"{source}[{at}]"
            if node.kind in "wW":
                return f"self.tdr.from_wide({value}, {node.kind == 'w'})"
            return value
        case Octets():
            return f"{source}[{at}]"
        case FixedArray(element, count):
            width = places(element)
            end = at.plus(width * count)
            if isinstance(element, Basic | Octets) and not _is_wide(element):
                colon = " : " if at.name else ":"
                return f"list({source}[{at}{colon}{end}])"
            each = f"at{next(letters)}"
            inner = _unpacked(element, source, _Index(each), letters)
            return f"[{inner} for {each} in range({at}, {end}, {width})]"
        case Record(struct, items):
            values: dict[str, str] = {}
            for item in fields(node):
                values[item.name] = _unpacked(item.node, source, at, letters)
                at = at.plus(places(item.node))
            arguments = ", ".join(values.get(i.name, "None") for i in items)
            return f"{struct_class(struct.name)}({arguments})"
    return "None"


def _is_wide(node: Node) -> bool:
    return isinstance(node, Basic) and node.kind in "wW"


def fields(record: Record) -> list[Item]:
    """Return the transferred members of a struct of fixed size, in wire order."""
    runs = (step for step in record.steps if isinstance(step, Run))
    return [f.item for run in runs for f in run.fields if f.item is not None]


def places(node: Node) -> int:
    """Return the number of items of `unpack`."""
    match node:
        case Basic() | Octets():
            return 1
        case FixedArray(element, count):
            return places(element) * count
        case Record():
            return sum(places(item.node) for item in fields(node))
    return 0


def kinds_text(kinds: Iterable[tuple[str, int]]) -> str:
    """Return a string expression for letters that may repeat."""
    parts: list[str] = []
    plain = ""
    for text, times in kinds:
        if times * len(text) <= 12:
            plain += text * times
            continue
        if plain:
            parts.append(f'"{plain}"')
        plain = ""
        parts.append(f'"{text}" * {times}')
    if plain or not parts:
        parts.append(f'"{plain}"')
    return " + ".join(parts)
