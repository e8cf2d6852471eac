"""The statements that read a message, from its layout, with bounds checks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import msgspec

from rtgen.compiler.backends.tecs.codec_parts import Attributes, Environment, Scope
from rtgen.compiler.backends.tecs.values import places, unpacked
from rtgen.compiler.layouts.tdr import (
    Basic,
    Branch,
    Counted,
    Field,
    FixedArray,
    Item,
    Node,
    Octets,
    Part,
    Payload,
    Record,
    Reserve,
    Role,
    Run,
    Step,
    String,
    is_fixed,
)
from rtgen.compiler.typemap.tecs.python import annotation, item_annotation, struct_class

MAGIC_BYTES = {
    "EOP_REPLY_FOLLOWS": "self.awaiting_reply",
    "EOP_NOTHING_FOLLOWS": "self.nothing_follows",
}
"""The attributes of codecs with the bytes of a magic that is read separately."""


class Decoder(msgspec.Struct, eq=False):
    """Writes the body of one method, except for its end.

    `condition` returns the expression of whether a nullable item is present, None if the message
    has a flag for it. `checks` returns the expected values of magics.
    """

    _attributes: Attributes
    _scope: Scope
    _environment: Environment
    _condition: Callable[[Item], str | None]
    _checks: Mapping[Role, str]
    _flags: dict[str, str] = {}
    _counts: dict[str, str] = {}
    needs_budget: bool = False

    def body(self, steps: Sequence[Step], first: str | None = None) -> list[str]:
        """Return the statements; `first` is the variable with the bytes of the first run."""
        lines: list[str] = []
        pending: Item | None = None
        for step in steps:
            if isinstance(step, Run):
                if pending is not None:
                    lines += self._payload(pending, step)
                    pending = None
                else:
                    lines += self._run(step, first)
                first = None
                continue
            if pending is not None:
                lines += self._payload(pending, None)
                pending = None
            match step:
                case Payload(item):
                    pending = item
                case Part(item):
                    value = self._read(item.node)
                    lines += self._environment.statements()
                    lines.append(f"{self._scope.of(item)} = {value}")
                case Branch(item, inner):
                    lines += self._branch(item, inner)
                case Reserve(item):
                    lines += self._reserve(item)
        return lines + (self._payload(pending, None) if pending is not None else [])

    def run_size(self, run: Run) -> str:
        """Return the size of a run in bytes."""
        return f"{self._attributes.run(run.kinds)}.size"

    def _run(self, run: Run, first: str | None) -> list[str]:
        if first is None and [field.role for field in run.fields] == [Role.EOP]:
            expected = self._checks[Role.EOP]
            return [
                f"if (eop_bytes := more(2)) != {MAGIC_BYTES[expected]}:",
                f"    {_complaint(Role.EOP, expected, 'eop_bytes')}",
            ]
        source = first or f"more({self.run_size(run)})"
        return self._unpack(run, "unpack", source)

    def _unpack(self, run: Run, method: str, arguments: str) -> list[str]:
        compiled = self._attributes.run(run.kinds)
        call = f"{compiled}.{method}({arguments})"
        if all(_is_plain(field) for field in run.fields):
            targets = [self._target(field) for field in run.fields]
            comma = "," if len(targets) == 1 else ""
            left = f"({targets[0]},)" if comma else ", ".join(targets)
            lines = [f"{left} = {call}"]
        else:
            lines = [f"unpacked = {call}"]
            at = 0
            for field in run.fields:
                value = f"unpacked[{at}]"
                if field.role is Role.VALUE:
                    assert field.item is not None
                    value = unpacked(field.item.node, "unpacked", str(at))
                    at += places(field.item.node)
                else:
                    at += 1
                lines.append(f"{self._target(field)} = {value}")
        for field in run.fields:
            if field.role in self._checks:
                expected, found = self._checks[field.role], self._target(field)
                lines.append(f"if {found} != {expected}:")
                lines.append(f"    {_complaint(field.role, expected, found)}")
        return lines

    def _target(self, field: Field) -> str:
        item = field.item
        match field.role:
            case Role.VALUE:
                assert item is not None
                return self._scope.of(item)
            case Role.FLAG:
                assert item is not None
                return self._named(self._flags, item, "null")
            case Role.LENGTH:
                assert item is not None
                return self._named(self._counts, item, "count")
        return {Role.SOP: "sop", Role.EOP: "eop"}[field.role]

    def _named(self, names: dict[str, str], item: Item, what: str) -> str:
        if item.name not in names:
            names[item.name] = self._scope.new(f"{item.name}_{what}")
        return names[item.name]

    def flag(self, item: Item) -> str:
        """Return the name of a flag that was read: not 0 for NULL."""
        return self._flags[item.name]

    def _payload(self, item: Item, run: Run | None) -> list[str]:
        """Read elements or units, together with a run after them."""
        node = item.node
        assert isinstance(node, Counted | String)
        self.needs_budget = True
        count = self._named(self._counts, item, "count")
        size = self._scope.new(f"{item.name}_size")
        lines = self._counted(node, count, size)
        lines.append(
            f"packet = more({size}{f' + {self.run_size(run)}' if run else ''})"
        )
        elements = f"packet[:{size}]" if run else "packet"
        target = self._scope.of(item)
        lines.append(f"{target} = {self._elements(node, elements, count)}")
        if run:
            lines += self._unpack(run, "unpack_from", f"packet, {size}")
        return lines

    def _counted(self, node: Counted | String, count: str, size: str) -> list[str]:
        lines = []
        if isinstance(node, Counted):
            lines.append(f"{count} = {self._environment.count(node)}")
        taken = self._taken(node, count, self._width(node))
        return [*self._environment.statements(), *lines, f"{size} = {taken}"]

    def _taken(self, node: Counted | String, count: str, width: str) -> str:
        capacity = self._environment.capacity(node)
        bounds = [capacity] if capacity is not None else []
        if isinstance(node, Counted) and node.most is not None:
            bounds.append(str(node.most))
        bound = f"min({', '.join(bounds)})" if len(bounds) == 2 else "".join(bounds)
        return f"budget.take({count}, {width}{f', {bound}' if bound else ''})"

    def _width(self, node: Counted | String) -> str:
        """Return the size of an element or unit in bytes."""
        if isinstance(node, String):
            return f"{self._attributes.text(node)}.width" if node.is_wide else "1"
        if node.is_octets:
            return "1"
        if isinstance(node.element, Basic):
            return f"{self._attributes.items(node.element)}.width"
        return f"{self._attributes.element(node.element)}.size"

    def _elements(self, node: Counted | String, data: str, count: str) -> str:
        if isinstance(node, String):
            return f"{self._attributes.text(node)}.text({data})"
        if node.is_octets:
            return data
        if isinstance(node.element, Basic):
            method = {"bool": "booleans", "int": "integers"}.get(
                annotation(node.element), "floats"
            )
            items = self._attributes.items(node.element)
            return f"{items}.{method}(packet, {count})"
        run = self._attributes.element(node.element)
        value = unpacked(node.element, "unpacked", "0")
        return f"[{value} for unpacked in {run}.iter_unpack({data})]"

    def _branch(self, item: Item, steps: Sequence[Step]) -> list[str]:
        name = self._scope.of(item)
        lines = [f"{name}: {item_annotation(item)} = None"]
        condition = self._condition(item) or f"not {self._flags[item.name]}"
        body = self.body(steps)
        if body:
            lines += [f"if {condition}:", *(f"    {line}" for line in body)]
        return lines

    def _reserve(self, item: Item) -> list[str]:
        """Reserve memory for the results of the call."""
        self.needs_budget = True
        node = item.node
        assert isinstance(node, Counted | String)
        count = self._environment.reserved(node)
        most = node.most if isinstance(node, Counted) else None
        bound = f", {most}" if most is not None else ""
        width = self._least(node)
        lines = [
            *self._environment.statements(),
            f"budget.take({count}, {width}{bound})",
        ]
        if item.nullable:
            lines = [f"    {line}" for line in lines]
            return [f"if not {self._flags[item.name]}:", *lines]
        return lines

    def _least(self, node: Counted | String) -> str:
        """Return the minimum size of an element in bytes."""
        if isinstance(node, Counted) and not is_fixed(node.element):
            return "4"
        return self._width(node)

    def _read(self, node: Node) -> str:
        """Return an expression that reads a compound value."""
        match node:
            case String():
                self.needs_budget = True
                length = self._environment.length(node)
                bound = "" if length is None else f", {length}"
                return f"{self._attributes.text(node)}.read(more, budget{bound})"
            case Record(struct) if not node.fixed:
                self.needs_budget = True
                return f"{self._attributes.record(struct_class(struct.name))}.read(more, budget)"
            case FixedArray(element, times) if not is_fixed(element):
                return f"[{self._read(element)} for _ in range({times})]"
            case Counted(element):
                self.needs_budget = True
                taken = self._taken(node, self._environment.count(node), "1")
                return f"[{self._read(element)} for _ in range({taken})]"
        raise AssertionError(node)


def _complaint(role: Role, expected: str, found: str) -> str:
    return f'raise self.wrong_mark("{role.name}", {expected}, {found})'


def _is_plain(field: Field) -> bool:
    """Return whether a field is one value of `unpack`, without conversion."""
    if field.role is not Role.VALUE:
        return True
    assert field.item is not None
    node = field.item.node
    return isinstance(node, Octets) or (
        isinstance(node, Basic) and node.kind not in "wW"
    )
