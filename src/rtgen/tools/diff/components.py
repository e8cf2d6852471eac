"""Compares components (ports, configuration, profile data) and adapters."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.matching import matching
from rtgen.compiler.model import (
    Adapter,
    Component,
    ConfigurationParameter,
    Port,
    PortKind,
    ScopedName,
)
from rtgen.tools.diff.changes import Change, Wire, change
from rtgen.tools.diff.items import (
    Fact,
    Group,
    by_name,
    fact_changes,
    is_reordered,
    item_changes,
    part_items,
)
from rtgen.tools.diff.kinds import components as kinds
from rtgen.tools.diff.kinds import types as type_kinds
from rtgen.tools.diff.member_facts import is_narrower, shown, value_text
from rtgen.tools.diff.type_expressions import ENCODINGS, TypeExpressions
from rtgen.tools.diff.versions import Version

_DATA = (PortKind.INPORT, PortKind.OUTPORT)


def _word(port: Port) -> str:
    return port.kind.word


_COMPONENTS = Group(
    "component", kinds.COMPONENT_ADDED, kinds.COMPONENT_REMOVED, kinds.COMPONENT_RENAMED
)
_PORTS = Group(_word, kinds.PORT_ADDED, kinds.PORT_REMOVED, kinds.PORT_RENAMED)
_PARAMETERS = Group(
    "parameter", kinds.PARAMETER_ADDED, kinds.PARAMETER_REMOVED, kinds.PARAMETER_RENAMED
)
_ADAPTERS = Group("adapter", kinds.ADAPTER_ADDED, kinds.ADAPTER_REMOVED)


_FACTS = (
    Fact(kinds.COMPONENT_PROFILE, "vendor", lambda c: c.vendor),
    Fact(kinds.COMPONENT_PROFILE, "category", lambda c: c.category),
    Fact(kinds.COMPONENT_PROFILE, "version", lambda c: c.version),
    Fact(kinds.COMPONENT_RATE, "rate", lambda c: f"{c.rate:g} Hz"),
    Fact(kinds.COMPONENT_KIND, "kind", lambda c: c.kind),
    Fact(kinds.COMPONENT_KIND, "activity", lambda c: c.activity),
    Fact(kinds.COMPONENT_KIND, "component type", lambda c: c.component_type),
    Fact(kinds.COMPONENT_KIND, "activity_type", lambda c: c.registered_activity),
    Fact(kinds.COMPONENT_KIND, "triggers", lambda c: ", ".join(c.trigger_ports)),
    Fact(kinds.COMPONENT_KIND, "execution", lambda c: c.execution),
    Fact(kinds.COMPONENT_TEXTS, "description", lambda c: c.description),
    Fact(kinds.COMPONENT_BASE, "base", lambda c: "::".join(c.base or ()) or "none"),
    Fact(
        kinds.COMPONENT_BASE,
        "supported interfaces",
        lambda c: ", ".join("::".join(s) for s in c.supports) or "none",
    ),
    Fact(
        lambda old, new: (
            kinds.COMPONENT_INSTANCES_MORE if new > old else kinds.COMPONENT_INSTANCES
        ),
        "{name} allows {now} instances, did {was}",
        lambda c: c.max_instances,
    ),
)
_PORT_FACTS = (Fact(kinds.PORT_UNIT, "unit", lambda p: p.unit or "none"),)
_PARAMETER_FACTS = (
    Fact(kinds.PARAMETER_DEFAULT, "default", lambda p: p.default, value_text),
    Fact(
        lambda old, new: (
            kinds.PARAMETER_NARROWED
            if is_narrower(old, new)
            else kinds.PARAMETER_WIDENED
        ),
        "{name} ranges over {now}, did over {was}",
        lambda p: (p.minimum, p.maximum),
        shown,
    ),
    Fact(kinds.PARAMETER_CONSTRAINT, "constraint", lambda p: p.constraint or "none"),
    Fact(kinds.PARAMETER_UNIT, "unit", lambda p: p.unit or "none"),
    Fact(kinds.PARAMETER_WIDGET, "widget", lambda p: p.widget or "none"),
)


def compare_components(
    old: Version, new: Version, names: dict[ScopedName, ScopedName]
) -> Iterator[Change]:
    """Yield the changes of components and adapters."""
    adapters = {a.name for v in (old, new) for a in v.model.adapters}
    before, after = (
        {
            n: d
            for n, d in v.written.items()
            if isinstance(d, Component) and d.scoped not in adapters
        }
        for v in (old, new)
    )
    found = matching(before, after, _shape)
    yield from item_changes(_COMPONENTS, found, lambda c: c.scoped)
    types = TypeExpressions(old.model, new.model, names)
    for one, other in (*found.pairs, *found.renamed):
        yield from _Components(one, other, types, names).compare()
    yield from _adapters(old, new, names)


def _shape(component: Component) -> object:
    """Return all of a component except its name; None for one without ports."""
    if not component.ports:
        return None
    return (
        *((p.kind, p.name, str(p.type)) for p in component.ports),
        *((c.name, str(c.type)) for c in component.configuration),
    )


class _Components:
    def __init__(
        self,
        old: Component,
        new: Component,
        types: TypeExpressions,
        names: dict[ScopedName, ScopedName],
    ) -> None:
        self._old, self._new = old, new
        self._types, self._names = types, names

    def compare(self) -> Iterator[Change]:
        yield from self._profile()
        yield from self._ports()
        yield from self._configuration()

    def _profile(self) -> Iterator[Change]:
        old, new = self._old, self._new
        spans = (old.span, new.span)
        yield from fact_changes(_FACTS, old, new, new.scoped, spans)

    def _ports(self) -> Iterator[Change]:
        old, new = by_name(self._old.ports), by_name(self._new.ports)
        found = matching(old, new, lambda p: (p.kind, str(p.type), p.unit))
        yield from part_items(_PORTS, found, self._old, self._new)
        for one, other in (*found.pairs, *found.renamed):
            yield from self._port(one, other)
        if is_reordered([*old], [*new]):
            text = f"the ports of {self._new.scoped} are in another order"
            spans = (self._old.span, self._new.span)
            yield change(kinds.PORTS_REORDERED, self._new.scoped, text, *spans)

    def _port(self, old: Port, new: Port) -> Iterator[Change]:
        name, spans = self._sub(new), (old.span, new.span)
        if old.kind is not new.kind:
            text = f"{name} is declared as {_word(new)}, was as {_word(old)}"
            yield change(kinds.PORT_KIND, name, text, *spans)
        verdict = self._types.compare(old.type, new.type)
        if verdict.kind is type_kinds.MEMBER_ALIAS:
            text = f"{name} has the type {new.type}, had {old.type}"
            yield change(type_kinds.MEMBER_ALIAS, name, text, *spans)
        elif verdict.kind is not None:
            data = new.kind in _DATA
            kind = kinds.PORT_TYPE if data else kinds.PORT_INTERFACE
            text = f"{_word(new)} {name} has the type {new.type}, had {old.type}"
            yield change(
                kind, name, text, *spans, wires=ENCODINGS if data else (Wire.GIOP,)
            )
        yield from fact_changes(_PORT_FACTS, old, new, name, spans)
        if new.kind not in _DATA and old.kind is new.kind:
            renamed = old.name != new.name
            if (old.port, old.instance) != (new.port, new.instance) and not renamed:
                now, was = (f"{p.instance} of port {p.port}" for p in (new, old))
                text = f"{name} is {now}, was {was}"
                yield change(kinds.PORT_SERVICE, name, text, *spans)
            if old.type_name != new.type_name:
                text = f"{name} has the type name {new.type_name or new.type}"
                yield change(kinds.PORT_TYPE_NAME, name, text, *spans)

    def _configuration(self) -> Iterator[Change]:
        found = matching(
            by_name(self._old.configuration),
            by_name(self._new.configuration),
            lambda c: (str(c.type), value_text(c.default), c.unit, c.constraint),
        )
        yield from part_items(_PARAMETERS, found, self._old, self._new)
        for one, other in found.pairs:
            yield from self._parameter(one, other)

    def _parameter(
        self, old: ConfigurationParameter, new: ConfigurationParameter
    ) -> Iterator[Change]:
        name, spans = self._sub(new), (old.span, new.span)
        if str(old.type) != str(new.type):
            verdict = self._types.compare(old.type, new.type)
            alias = verdict.kind in (None, type_kinds.MEMBER_ALIAS)
            kind = type_kinds.MEMBER_ALIAS if alias else kinds.PARAMETER_TYPE
            text = f"parameter {name} has the type {new.type}, had {old.type}"
            yield change(kind, name, text, *spans)
        yield from fact_changes(_PARAMETER_FACTS, old, new, name, spans, "parameter")

    def _sub(self, item: Port | ConfigurationParameter) -> str:
        return f"{self._new.scoped}.{item.name}"


def _adapters(
    old: Version, new: Version, names: dict[ScopedName, ScopedName]
) -> Iterator[Change]:
    found = matching(by_name(old.model.adapters), by_name(new.model.adapters))
    yield from item_changes(_ADAPTERS, found, lambda adapter: adapter.name)
    for one, other in found.pairs:
        ends = tuple(names.get(n, n) for n in (one.source, one.target))
        if ends != (other.source, other.target):
            source, target = ("::".join(n) for n in (other.source, other.target))
            text = f"adapter {other.name} leads from {source} to {target}"
            yield change(kinds.ADAPTER_TYPES, other.name, text, one.span, other.span)
        elif _filling(one) != _filling(other):
            text = f"adapter {other.name} copies other members"
            yield change(kinds.ADAPTER_COPIES, other.name, text, one.span, other.span)


def _filling(adapter: Adapter) -> tuple[object, ...]:
    """Return what fills the members of the target."""
    return adapter.copies, adapter.constants, adapter.scales
