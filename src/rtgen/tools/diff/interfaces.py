"""Compares interfaces, their operations and attributes, and valuetypes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.matching import matching
from rtgen.compiler.model import (
    Attribute,
    Interface,
    Operation,
    Parameter,
    ScopedName,
    Type,
    ValueBox,
    Valuetype,
)
from rtgen.tools.diff.changes import Change, Kind, change
from rtgen.tools.diff.declarations import TypeChanges
from rtgen.tools.diff.items import (
    Fact,
    Group,
    by_name,
    fact_changes,
    is_reordered,
    item_changes,
    part_changes,
    part_items,
)
from rtgen.tools.diff.kinds import interfaces as kinds
from rtgen.tools.diff.kinds import types as type_kinds
from rtgen.tools.diff.member_facts import member_facts
from rtgen.tools.diff.type_expressions import TypeExpressions
from rtgen.tools.diff.versions import Version

Names = dict[ScopedName, ScopedName]

_Item = TypeVar("_Item", Operation, Attribute, Parameter)


_INTERFACES = Group(
    "interface", kinds.INTERFACE_ADDED, kinds.INTERFACE_REMOVED, kinds.INTERFACE_RENAMED
)
_OPERATIONS = Group(
    "operation", kinds.OPERATION_ADDED, kinds.OPERATION_REMOVED, kinds.OPERATION_RENAMED
)
_FACTS = (
    Fact(kinds.INTERFACE_LOCAL, "{name} is {no}local", lambda i: i.local),
    Fact(kinds.INTERFACE_ABSTRACT, "{name} is {no}abstract", lambda i: i.abstract),
)
_PARAMETERS = Group("parameter", kinds.PARAMETER_ADDED, kinds.PARAMETER_REMOVED)
_ATTRIBUTES = Group("attribute", kinds.ATTRIBUTE_ADDED, kinds.ATTRIBUTE_REMOVED)


def compare_interfaces(
    old: Version, new: Version, changes: TypeChanges
) -> Iterator[Change]:
    """Yield the changes of interfaces and valuetypes; adds renamed ones to the `names`."""
    names = changes.names
    before = {n: d for n, d in old.written.items() if isinstance(d, Interface)}
    after = {n: d for n, d in new.written.items() if isinstance(d, Interface)}
    found = matching(before, after, _shape)
    for gone, come in found.renamed:
        names[gone.name] = come.name
    yield from item_changes(_INTERFACES, found, lambda i: i.scoped)
    types = TypeExpressions(old.model, new.model, names)
    for one, other in (*found.pairs, *found.renamed):
        yield from _Interfaces(one, other, types, changes).compare()
    yield from _valuetypes(old, new, types, names)


def _shape(interface: Interface) -> object:
    """Return all of an interface except its name; None without operations and attributes."""
    if not (interface.operations or interface.attributes):
        return None
    return (
        tuple(_operation_shape(o) for o in interface.operations),
        tuple((a.name, str(a.type), a.readonly) for a in interface.attributes),
        interface.bases,
    )


def _operation_shape(operation: Operation) -> tuple[object, ...]:
    return (operation.name, *_signature(operation))


def _signature(operation: Operation) -> tuple[object, ...]:
    parameters = ((p.direction, str(p.type), p.name) for p in operation.parameters)
    return (
        *(str(operation.returns), tuple(parameters)),
        *(operation.raises, operation.oneway),
    )


class _Interfaces:
    def __init__(
        self,
        old: Interface,
        new: Interface,
        types: TypeExpressions,
        changes: TypeChanges,
    ) -> None:
        self._old, self._new = old, new
        self._types, self._names = types, changes.names
        self._between = changes.between

    def compare(self) -> Iterator[Change]:
        old, new, name = self._old, self._new, self._new.scoped
        spans = (old.span, new.span)
        if old.name == new.name and old.repository_id != new.repository_id:
            text = f"{name} has the repository id {new.repository_id}, had {old.repository_id}"
            yield change(kinds.INTERFACE_ID, name, text, *spans)
        if tuple(self._names.get(b, b) for b in old.bases) != new.bases:
            text = f"interface {name} has other bases: {_list(new.bases)}, had {_list(old.bases)}"
            yield change(kinds.INTERFACE_BASES, name, text, *spans)
        yield from fact_changes(_FACTS, old, new, name, spans, "interface")
        yield from self.operations()
        yield from self.attributes()

    def operations(self) -> Iterator[Change]:
        """Yield the changes of operations."""
        found = matching(
            by_name(self._old.operations), by_name(self._new.operations), _signature
        )
        yield from part_items(_OPERATIONS, found, self._old, self._new)
        for one, other in (*found.pairs, *found.renamed):
            yield from self._operation(one, other)
        both = (self._old.operations, self._new.operations)
        if is_reordered(*([o.name for o in each] for each in both)):
            text = f"the operations of {self._new.scoped} are in another order"
            spans = (self._old.span, self._new.span)
            yield change(kinds.OPERATIONS_REORDERED, self._new.scoped, text, *spans)

    def _operation(self, old: Operation, new: Operation) -> Iterator[Change]:
        name, spans = self._sub(new), (old.span, new.span)
        if old.oneway != new.oneway:
            text = f"operation {name} is {'oneway' if new.oneway else 'twoway'} now"
            yield change(kinds.ONEWAY, name, text, *spans)
        yield from self._typed(
            kinds.RESULT_TYPE, old.returns, new.returns, f"{name} returns", name, spans
        )
        before = {"::".join(self._names.get(r, r)) for r in old.raises}
        after = {"::".join(r) for r in new.raises}
        for raised in sorted(after - before):
            text = f"operation {name} raises {raised} now"
            yield change(kinds.RAISES_ADDED, name, text, *spans)
        for raised in sorted(before - after):
            text = f"operation {name} no longer raises {raised}"
            yield change(kinds.RAISES_REMOVED, name, text, *spans)
        if old.context != new.context:
            text = f"operation {name} has another context clause"
            yield change(kinds.CONTEXT, name, text, *spans)
        yield from self._parameters(old, new)

    def _parameters(self, old: Operation, new: Operation) -> Iterator[Change]:
        names = {p.name for p in old.parameters} & {p.name for p in new.parameters}
        renamed = {
            a.name: b.name
            for a, b in zip(old.parameters, new.parameters, strict=False)
            if a.name not in names
            and b.name not in names
            and self._types.compare(a.type, b.type).keeps_octets
            and a.direction is b.direction
        }
        before = {renamed.get(p.name, p.name): p for p in old.parameters}
        after = {p.name: p for p in new.parameters}
        name = self._sub(new)
        kind, spans = kinds.PARAMETERS_REORDERED, (old.span, new.span)
        yield from part_changes(_PARAMETERS, kind, before, after, name, spans)
        for key, parameter in after.items():
            if key in before:
                yield from self._parameter(before[key], parameter, f"{name}({key})")

    def _parameter(self, old: Parameter, new: Parameter, name: str) -> Iterator[Change]:
        spans = (old.span, new.span)
        if old.name != new.name:
            text = f"parameter {name} was called {old.name}"
            yield change(kinds.PARAMETER_RENAMED, name, text, *spans)
        if old.direction is not new.direction:
            text = f"parameter {name} is {new.direction}, was {old.direction}"
            yield change(kinds.PARAMETER_DIRECTION, name, text, *spans)
        yield from self._typed(
            kinds.PARAMETER_TYPE,
            old.type,
            new.type,
            f"parameter {name} has the type",
            name,
            spans,
        )
        for kind, text in member_facts(old, new, f"parameter {name}"):
            yield change(kind, name, text, *spans)

    def attributes(self) -> Iterator[Change]:
        """Yield the changes of attributes."""
        before, after = by_name(self._old.attributes), by_name(self._new.attributes)
        found = matching(before, after)
        yield from part_items(_ATTRIBUTES, found, self._old, self._new)
        for old, new in found.pairs:
            name, spans = self._sub(new), (old.span, new.span)
            yield from self._typed(
                kinds.ATTRIBUTE_TYPE,
                old.type,
                new.type,
                f"attribute {name} has the type",
                name,
                spans,
            )
            if old.readonly != new.readonly:
                word = "readonly" if new.readonly else "writable"
                text = f"attribute {name} is {word} now"
                readonly, writable = kinds.ATTRIBUTE_READONLY, kinds.ATTRIBUTE_WRITABLE
                kind = readonly if new.readonly else writable
                yield change(kind, name, text, *spans)
            if (old.get_raises, old.set_raises) != (new.get_raises, new.set_raises):
                text = f"attribute {name} raises other exceptions"
                yield change(kinds.ATTRIBUTE_RAISES, name, text, *spans)
            for kind, text in member_facts(old, new, f"attribute {name}"):
                yield change(kind, name, text, *spans)

    def _typed(
        self,
        kind: Kind,
        old: Type,
        new: Type,
        words: str,
        name: str,
        spans: tuple[Span, Span],
    ) -> Iterator[Change]:
        verdict = self._types.compare(old, new)
        if verdict.kind is None:
            return
        if verdict.kind is type_kinds.MEMBER_ALIAS:
            kind = kinds.PARAMETER_ALIAS
        broken = verdict.wires
        if verdict.replaced is not None:
            broken |= self._between(verdict.replaced)
        text = f"{words} {new}, was {old}"
        yield change(kind, name, text, *spans, wires=None if broken else ())

    def _sub(self, item: Operation | Attribute | Parameter) -> str:
        return f"{self._new.scoped}.{item.name}"


def _list(names: Sequence[ScopedName]) -> str:
    return ", ".join("::".join(name) for name in names) or "none"


def _valuetypes(
    old: Version,
    new: Version,
    types: TypeExpressions,
    names: Mapping[ScopedName, ScopedName],
) -> Iterator[Change]:
    for name, one in old.written.items():
        other = new.written.get(name)
        spans = (one.span, None if other is None else other.span)
        if isinstance(one, Valuetype | ValueBox) and other is None:
            text = f"valuetype {one.scoped} is removed"
            yield change(type_kinds.TYPE_REMOVED, one.scoped, text, *spans)
        elif isinstance(one, ValueBox) and isinstance(other, ValueBox):
            if types.compare(one.type, other.type).kind is not None:
                text = f"valuetype {other.scoped} boxes {other.type}, did {one.type}"
                yield change(kinds.VALUETYPE_CHANGED, other.scoped, text, *spans)
        elif isinstance(one, Valuetype) and isinstance(other, Valuetype):
            yield from _valuetype(one, other, types)
    for name, other in new.written.items():
        if isinstance(other, Valuetype | ValueBox) and name not in old.written:
            text = f"valuetype {other.scoped} is added"
            yield change(type_kinds.TYPE_ADDED, other.scoped, text, None, other.span)


def _valuetype(
    old: Valuetype, new: Valuetype, types: TypeExpressions
) -> Iterator[Change]:
    spans = (old.span, new.span)
    before = [(m.name, m.public) for m in old.state]
    after = [(m.name, m.public) for m in new.state]
    verdicts = (
        types.compare(a.type, b.type)
        for a, b in zip(old.state, new.state, strict=False)
    )
    if (
        before != after
        or any(v.kind is not None for v in verdicts)
        or old.bases != new.bases
    ):
        text = f"valuetype {new.scoped} has another state"
        yield change(kinds.VALUETYPE_CHANGED, new.scoped, text, *spans)
    if (old.abstract, old.custom, old.truncatable) != (
        new.abstract,
        new.custom,
        new.truncatable,
    ):
        text = f"valuetype {new.scoped} has another modifier"
        yield change(kinds.VALUETYPE_KIND, new.scoped, text, *spans)
    if _facts(old) != _facts(new):
        text = f"valuetype {new.scoped} has other operations, attributes or factories"
        yield change(kinds.VALUETYPE_INTERFACE, new.scoped, text, *spans)


def _facts(valuetype: Valuetype) -> object:
    return (
        [_operation_shape(o) for o in (*valuetype.operations, *valuetype.factories)],
        [(a.name, str(a.type), a.readonly) for a in valuetype.attributes],
        valuetype.supports,
    )
