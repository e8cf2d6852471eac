"""The statements that write a message, from its layout."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import msgspec

from rtgen.compiler.backends.tecs.codec_parts import Attributes, Environment, Scope
from rtgen.compiler.backends.tecs.values import packed
from rtgen.compiler.layouts.tdr import (
    Basic,
    Branch,
    Counted,
    Field,
    FixedArray,
    Item,
    Node,
    Part,
    Payload,
    Record,
    Role,
    Run,
    Step,
    String,
    is_fixed,
)
from rtgen.compiler.typemap.tecs.python import struct_class


class Encoder(msgspec.Struct, eq=False):
    """Writes the body of one method.

    `value` returns the expression of an item's value, `condition` that of whether a nullable one is
    present, `constants` the expressions of magics and the id.
    """

    _attributes: Attributes
    _scope: Scope
    _environment: Environment
    _value: Callable[[Item], str]
    _condition: Callable[[Item], str]
    _constants: Mapping[Role, str]
    _units: dict[str, str] = {}

    def body(self, steps: Sequence[Step]) -> list[str]:
        """Return the statements; the last one returns the bytes."""
        if any(isinstance(step, Branch) for step in steps):
            lines = ["parts: list[bytes] = []", *self._appended(steps, False)]
            return [*lines, 'return b"".join(parts)']
        lines, pieces = self._pieces(steps, False)
        if len(pieces) == 1:
            return [*lines, f"return {pieces[0]}"]
        if not pieces:
            return [*lines, 'return b""']
        return [*lines, f'return b"".join(({", ".join(pieces)}))']

    def _appended(self, steps: Sequence[Step], optional: bool) -> list[str]:
        lines: list[str] = []
        for step in steps:
            if isinstance(step, Branch):
                inner = self._appended(step.steps, True)
                if inner:
                    lines.append(f"if {self._condition(step.item)}:")
                    lines += [f"    {line}" for line in inner]
                continue
            before, pieces = self._pieces([step], optional)
            lines += [*before, *(f"parts.append({piece})" for piece in pieces)]
        return lines

    def _pieces(
        self, steps: Sequence[Step], optional: bool
    ) -> tuple[list[str], list[str]]:
        """Return the statements, and the expressions of bytes that use their results."""
        lines: list[str] = []
        pieces: list[str] = []
        for step in steps:
            match step:
                case Run(fields):
                    arguments: list[str] = []
                    for field in fields:
                        if field.role is Role.LENGTH:
                            units = self._prepared(field, optional)
                            lines += [*self._environment.statements(), units]
                        arguments += self._arguments(field, optional)
                    run = self._attributes.run(step.kinds)
                    pieces.append(f"{run}.pack({', '.join(arguments)})")
                case Payload(item) if isinstance(item.node, String):
                    pieces.append(self._units[item.name])
                case Payload(item) | Part(item):
                    pieces.append(self._whole(item.node, self._of(item, optional)))
            lines += self._environment.statements()
        return lines, pieces

    def _of(self, item: Item, optional: bool) -> str:
        """Return the value of an item; `optional`: whether it is known not to be NULL."""
        value = self._value(item)
        narrowed = self._condition(item) == f"{value} is not None"
        return f"present({value})" if optional and not narrowed else value

    def _prepared(self, field: Field, optional: bool) -> str:
        item = field.item
        assert item is not None
        assert isinstance(item.node, String)
        units = self._scope.new(f"{item.name}_units")
        self._units[item.name] = units
        arguments = self._text_arguments(item.node, self._of(item, optional))
        return f"{units} = {self._attributes.text(item.node)}.units({arguments})"

    def _text_arguments(self, node: String, value: str) -> str:
        length = self._environment.length(node)
        return value if length is None else f"{value}, {length}"

    def _arguments(self, field: Field, optional: bool) -> list[str]:
        item = field.item
        if item is None:
            return [self._constants[field.role]]
        match field.role:
            case Role.FLAG:
                value = self._value(item)
                return [f"not {value}" if item.asked else f"{value} is None"]
            case Role.LENGTH:
                assert isinstance(item.node, String)
                units = f"len({self._units[item.name]})"
                if not item.node.is_wide:
                    return [units]
                return [f"{units} // {self._attributes.text(item.node)}.width"]
        return packed(item.node, self._of(item, optional), self._scope.loops)

    def _whole(self, node: Node, value: str) -> str:
        """Return an expression for all bytes of a value."""
        match node:
            case Counted():
                return self._counted(node, value)
            case String():
                text = self._attributes.text(node)
                return f"{text}.whole({self._text_arguments(node, value)})"
            case Record(struct) if not node.fixed:
                return f"{self._attributes.record(struct_class(struct.name))}.write({value})"
            case FixedArray(element, count) if not is_fixed(element):
                return self._joined(element, f"exactly({value}, {count})")
        arguments = packed(node, value, self._scope.loops)
        run = self._attributes.element(node)
        return f"{run}.pack({', '.join(arguments)})"

    def _counted(self, node: Counted, value: str) -> str:
        count = self._environment.count(node)
        capacity = self._environment.capacity(node)
        if node.most is not None:
            if capacity is None:
                count = f"within({count}, {node.most})"
            else:
                capacity = f"within({capacity}, {node.most})"
        if capacity is None:
            values = f"exactly({value}, {count})"
        else:
            helper = "leading_bytes" if node.is_octets else "leading"
            values = f"{helper}({value}, {count}, {capacity})"
        if node.is_octets:
            return values
        if isinstance(node.element, Basic):
            return f"{self._attributes.items(node.element)}.pack({values})"
        return self._joined(node.element, values)

    def _joined(self, element: Node, values: str) -> str:
        each = f"each{next(self._scope.loops)}"
        return f'b"".join([{self._whole(element, each)} for {each} in {values}])'
